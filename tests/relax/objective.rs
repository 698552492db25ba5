//! The objective of the relaxation: its derivatives, and the matrices they are kept in.

use crate::common::{slider, tree};
use aghf::curve::Basis;
use aghf::linalg::BlockTridiagonal;
use aghf::model::{Model, random_tree};
use aghf::relax::{ControlEffort, Derivatives, Grid, Objective, PackedHessian};
use aghf::scalar::{AlgebraOver, Jet};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn random(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

/// The objective over numbers that move twice.
fn second_order(
    model: &Model,
    basis: &Basis,
    coefficients: &DMatrix<f64>,
    moving: [usize; 2],
) -> Jet<Jet<f64, 1>, 1> {
    type Twice = Jet<Jet<f64, 1>, 1>;
    let grid = Grid::new(basis, 7, 1.3).map(<Twice as AlgebraOver<f64>>::lift);
    let mut lifted = coefficients.map(<Twice as AlgebraOver<f64>>::lift);
    let first = basis.free().start * model.dof();
    lifted.as_mut_slice()[first + moving[0]].re.eps[0] += 1.0;
    lifted.as_mut_slice()[first + moving[1]].eps[0].re += 1.0;
    let cost = ControlEffort::<f64, Twice>::new(model);
    Objective::new(&grid, cost, model.dof())
        .value(&lifted)
        .expect("sizes agree")
}

/// Gradient and Hessian of one and of several segments, with and without a free final velocity.
#[test]
fn derivatives_are_those_of_duals() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for (n, seed, segments, degree, free) in
        [(3, 1, 1, 6, false), (4, 2, 1, 5, true), (2, 5, 3, 4, true)]
    {
        let model = tree(n, seed);
        let basis = Basis::new(segments, degree, free);
        let grid = Grid::new(&basis, 7, 1.3);
        let coefficients = random(&mut rng, n, basis.count());
        let mut objective = Objective::new(&grid, ControlEffort::new(&model), n);
        let mut derivatives = Derivatives::new(&grid, n);
        let value = objective
            .derivatives(&coefficients, &mut derivatives)
            .expect("sizes agree");
        let again = objective.value(&coefficients).expect("sizes agree");
        assert!((value - again).abs() <= 1e-13 * value);
        let hessian = derivatives.hessian.to_dense();
        let unknowns = hessian.nrows();
        assert_eq!(unknowns, basis.free().len() * n);
        let (mut by_duals, mut slopes) = (DMatrix::zeros(unknowns, unknowns), vec![0.0; unknowns]);
        for i in 0..unknowns {
            for j in 0..=i {
                let dual = second_order(&model, &basis, &coefficients, [i, j]);
                by_duals[(i, j)] = dual.eps[0].eps[0];
                by_duals[(j, i)] = by_duals[(i, j)];
                slopes[i] = dual.re.eps[0];
            }
        }
        // Sums of some hundred products in another order.
        assert_close!(&derivatives.gradient, &slopes, 1e-12);
        assert_close!(&hessian, &by_duals, 1e-12);
    }
}

/// The metric is the Hessian less what the second derivatives of inverse dynamics contribute: that of a linear problem.
#[test]
fn on_a_linear_robot_metric_and_hessian_are_one() {
    let model = slider(2.0);
    let basis = Basis::new(2, 7, false);
    let grid = Grid::new(&basis, 8, 0.7);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut derivatives = Derivatives::new(&grid, 1);
    Objective::new(&grid, ControlEffort::new(&model), 1)
        .derivatives(&random(&mut rng, 1, basis.count()), &mut derivatives)
        .expect("sizes agree");
    let (hessian, metric) = (
        derivatives.hessian.to_dense(),
        derivatives.metric.to_dense(),
    );
    assert_close!(&hessian, &metric, 1e-14);
    // Second derivatives of bubbles are orthonormal in normalised time: 2 m^2 T^-3 on the diagonal, zero beside it.
    let bubbles = hessian.view((0, 0), (4, 4)).into_owned();
    let expected = DMatrix::identity(4, 4) * (2.0 * 4.0 / 0.7_f64.powi(3));
    assert_close!(&bubbles, &expected, 1e-12);
}

#[test]
fn the_factors_of_a_block_tridiagonal_matrix_solve() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    // One block is larger than a panel of the factorisation.
    let model = random_tree(4, 9).expect("n > 0");
    let basis = Basis::new(3, 16, true);
    let grid = Grid::new(&basis, 20, 1.0);
    let mut derivatives = Derivatives::new(&grid, 4);
    Objective::new(&grid, ControlEffort::new(&model), 4)
        .derivatives(&random(&mut rng, 4, basis.count()), &mut derivatives)
        .expect("sizes agree");
    let metric: BlockTridiagonal<f64> = derivatives.metric;
    let (dense, order) = (metric.to_dense(), metric.order());
    let x = random(&mut rng, order, 1).column(0).into_owned();
    let image = metric.product(&x);
    assert_close!(&image, &(&dense * &x), 1e-13);
    let mut factor = metric.clone();
    assert!(factor.factorise());
    let mut back = image.clone();
    factor.solve(&mut back);
    assert_close!(&(dense * back), &image, 1e-9);
    let mut indefinite = metric.clone();
    indefinite.set_sum(&metric, -2.0, &metric);
    assert!(!indefinite.factorise());
}

#[test]
fn hessians_at_points_are_kept_whole() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    for n in [1, 2, 3] {
        let mut kept = PackedHessian::new(n, 5);
        let half = random(&mut rng, 3 * n, 3 * n);
        let whole = &half + half.transpose();
        kept.set(2, &whole);
        assert_close!(&kept.get(2), &whole, 1e-15);
        let half = random(&mut rng, 2 * n, 2 * n);
        let part = &half + half.transpose();
        kept.add(2, &part);
        let mut sum = whole;
        let mut corner = sum.view_mut((0, 0), (2 * n, 2 * n));
        corner += part;
        assert_close!(&kept.get(2), &sum, 1e-15);
        assert_eq!(kept.get(1), DMatrix::zeros(3 * n, 3 * n));
    }
}
