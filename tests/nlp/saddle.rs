//! Steps of the saddle-point equations against those of the dense matrix.

use crate::common::{config, numbers};
use crate::dense::unit_norm;
use aghf::linalg::BlockTridiagonal;
use aghf::nlp::{Bordered, Kkt, Options, Progress};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The equations with the unit matrix as norm.
fn system(hessian: &DMatrix<f64>, slopes: &DMatrix<f64>, gradient: &[f64], values: &[f64]) -> Kkt {
    let mut kkt = unit_norm(hessian.nrows());
    kkt.hessian.matrix.diagonal[0].copy_from(hessian);
    kkt.gradient.copy_from_slice(gradient);
    for slope in slopes.column_iter() {
        kkt.equalities.push(&kkt.hessian, 0, &slope.into_owned());
    }
    kkt.equalities.values = DVector::from_column_slice(values);
    kkt
}

proptest! {
    #![proptest_config(config(128))]

    /// The step keeps the linearised equalities, the gradient of the Lagrangian with the changed multipliers vanishes,
    /// and the multiple of the norm is zero if and only if the Hessian is positive definite along the equalities.
    #[test]
    fn steps_solve_the_equations(n in 2..7_usize, m in 1..4_usize, x in numbers(36), rows in numbers(24),
                                 b in numbers(12)) {
        let m = m.min(n - 1);
        let half = DMatrix::from_column_slice(n, n, &x[..n * n]);
        let hessian = &half + half.transpose();
        let slopes = DMatrix::from_column_slice(n, m, &rows[..n * m]);
        let svd = slopes.clone().svd(true, false);
        prop_assume!(svd.singular_values.min() > 1e-2);
        let mut kkt = system(&hessian, &slopes, &b[..n], &b[6..6 + m]);
        let mut progress = Progress::default();
        let step = kkt.step(1.0, &mut progress, &Options::default()).expect("a multiple of the norm is enough");
        let multiple = progress.regularisation;
        assert_close!(&(slopes.tr_mul(&step.x) + &kkt.equalities.values), &vec![0.0; m][..], 1e-8);
        let matrix = &hessian + DMatrix::identity(n, n) * multiple;
        let rest = &matrix * &step.x + &slopes * &step.multipliers + &kkt.gradient;
        assert_close!(&rest, &vec![0.0; n][..], 1e-6);
        // Along the equalities.
        let range = svd.u.expect("it was asked for");
        let project = DMatrix::identity(n, n) - &range * range.transpose();
        let along = &project * &hessian * &project + (DMatrix::identity(n, n) - &project) * 1e3;
        let least = along.symmetric_eigenvalues().min();
        prop_assume!(least.abs() > 1e-6);
        prop_assert_eq!(multiple == 0.0, least > 0.0);
    }
}

/// Equalities that follow from others leave the step as it is.
#[test]
fn dependent_equalities() {
    let hessian = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 2.0, 4.0]));
    let mut found = Vec::new();
    for copies in 1..4 {
        let slopes = DMatrix::from_fn(3, copies, |i, _| [1.0, 1.0, 0.0][i]);
        let mut kkt = system(&hessian, &slopes, &[1.0, 0.0, 1.0], &vec![0.5; copies]);
        let step = kkt.step(1.0, &mut Progress::default(), &Options::default());
        found.push(step.expect("it is definite along the equalities").x);
    }
    for step in &found {
        assert_close!(step, &found[0], 1e-6);
    }
}

/// In blocks with a border the step is that of the same matrix in one block.
#[test]
fn steps_in_blocks() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (sizes, shared, border) = ([4, 3, 5], 2, 2);
    for _ in 0..32 {
        let mut random = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0));
        let n = sizes.iter().sum::<usize>();
        let mut matrix = Bordered::with_border(BlockTridiagonal::new(&sizes, shared), border);
        for block in &mut matrix.matrix.diagonal {
            let half: DMatrix<f64> = random(block.nrows(), block.nrows());
            block.copy_from(&(&half + half.transpose() + DMatrix::identity(half.nrows(), half.nrows())));
        }
        for coupling in &mut matrix.matrix.coupling {
            coupling.copy_from(&(0.5 * random(coupling.nrows(), shared)));
        }
        matrix.border.copy_from(&random(n, border));
        matrix.corner.copy_from(&DMatrix::from_diagonal_element(border, border, 3.0));
        let mut dense = DMatrix::zeros(n + border, n + border);
        dense.view_mut((0, 0), (n, n)).copy_from(&matrix.matrix.to_dense());
        dense.view_mut((0, n), (n, border)).copy_from(&matrix.border);
        dense.view_mut((n, 0), (border, n)).copy_from(&matrix.border.transpose());
        dense.view_mut((n, n), (border, border)).copy_from(&matrix.corner);
        let gradient = random(n + border, 1);
        let values = random(4, 1);
        let mut norm = matrix.clone();
        norm.matrix.set_sum(&BlockTridiagonal::new(&sizes, shared), 0.0, &matrix.matrix);
        norm.matrix.diagonal.iter_mut().for_each(DMatrix::fill_with_identity);
        norm.border.fill(0.0);
        norm.corner.fill_with_identity();
        let mut blocks = Kkt::new(norm).expect("the unit matrix is positive definite");
        blocks.hessian = matrix;
        blocks.gradient.copy_from(&gradient.column(0));
        let mut slopes = DMatrix::zeros(n + border, 4);
        // Two equalities of the second block, and one of each other block.
        for (j, block) in [1, 0, 2, 1].into_iter().enumerate() {
            let first: usize = sizes[..block].iter().sum();
            let own = first.saturating_sub(shared)..first + sizes[block];
            for i in own.chain(n..n + border) {
                slopes[(i, j)] = random(1, 1)[0];
            }
            blocks.equalities.push(&blocks.hessian, block, &slopes.column(j).into_owned());
        }
        blocks.equalities.values.clone_from(&values.column(0).into_owned());
        let mut one = system(&dense, &slopes, gradient.as_slice(), values.as_slice());
        let mut regularisation = [0.0; 2];
        let steps = [&mut blocks, &mut one].into_iter().zip(&mut regularisation).map(|(kkt, multiple)| {
            let mut progress = Progress::default();
            let step = kkt.step(1.0, &mut progress, &Options::default()).expect("a multiple of the norm is enough");
            *multiple = progress.regularisation;
            step
        });
        let steps: Vec<_> = steps.collect();
        assert_eq!(regularisation[0], regularisation[1]);
        assert_close!(&steps[0].x, &steps[1].x, 1e-7);
        assert_close!(&steps[0].multipliers, &steps[1].multipliers, 1e-7);
        assert_eq!(blocks.negative_curvature(1.0).is_some(), regularisation[0] > 0.0);
    }
}
