//! Steps of the condensed equations against those of the dense matrix.

use aghf::linalg::BlockTridiagonal;
use aghf::nlp::{Bordered, Kkt, Options, Progress};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A random symmetric matrix of three blocks with a border of so many columns, and `shift` on its diagonal.
fn random(rng: &mut ChaCha8Rng, columns: usize, shift: f64) -> Bordered {
    let mut number = || rng.random_range(-1.0..1.0);
    let mut matrix = BlockTridiagonal::new(&[3, 4, 3], 2);
    for block in &mut matrix.diagonal {
        let half = DMatrix::from_fn(block.nrows(), block.nrows(), |_, _| number());
        *block = &half + half.transpose();
        for i in 0..block.nrows() {
            block[(i, i)] += shift;
        }
    }
    for block in &mut matrix.coupling {
        block.apply(|entry| *entry = number());
    }
    let half = DMatrix::from_fn(columns, columns, |_, _| number());
    let diagonal = DMatrix::from_diagonal_element(columns, columns, shift);
    Bordered {
        matrix,
        border: DMatrix::from_fn(10, columns, |_, _| number()),
        corner: &half + half.transpose() + diagonal,
    }
}

/// The complete matrix.
fn dense(of: &Bordered) -> DMatrix<f64> {
    let (n, columns) = of.border.shape();
    let mut dense = DMatrix::zeros(n + columns, n + columns);
    let blocks = [
        ((0, 0), of.matrix.to_dense()),
        ((0, n), of.border.clone()),
        ((n, 0), of.border.transpose()),
        ((n, n), of.corner.clone()),
    ];
    for (at, block) in blocks {
        dense.view_mut(at, block.shape()).copy_from(&block);
    }
    dense
}

/// A positive definite norm, a matrix and a gradient.
fn system(rng: &mut ChaCha8Rng, columns: usize, shift: f64) -> (Kkt, DMatrix<f64>, DMatrix<f64>) {
    let (norm, hessian) = (random(rng, columns, 9.0), random(rng, columns, shift));
    let of = (dense(&norm), dense(&hessian));
    let mut kkt = Kkt::new(norm).expect("the norm is positive definite");
    kkt.gradient.apply(|entry| *entry = rng.random_range(-1.0..1.0));
    kkt.hessian = hessian;
    (kkt, of.0, of.1)
}

/// The product and the length are those of the dense matrix, and a norm that is indefinite is refused.
#[test]
fn products() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for columns in [0, 1, 3] {
        let (mut kkt, norm, hessian) = system(&mut rng, columns, 0.0);
        let x = kkt.gradient.clone();
        assert_close!(&kkt.hessian.product(&x), &(&hessian * &x), 1e-14);
        let length = x.dot(&(&norm * &x)).sqrt();
        assert_close!(&[kkt.length(&x)], &[length], 1e-14);
        assert!(Kkt::new(kkt.hessian.clone()).is_none());
    }
    // Positive definite but for the corner.
    let mut norm = random(&mut rng, 1, 9.0);
    norm.corner[(0, 0)] = -1.0;
    assert!(Kkt::new(norm).is_none());
}

/// A step solves the dense equations with the multiple of the norm that it reports: none if the matrix is positive
/// definite, and one for which it is otherwise.
#[test]
fn steps_solve_the_equations() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let scale = 3.0;
    for columns in [0, 1, 3] {
        for shift in [9.0, 0.0, -9.0] {
            let (mut kkt, norm, hessian) = system(&mut rng, columns, shift);
            let mut progress = Progress::default();
            let step = kkt.step(scale, &mut progress, &Options::default());
            let step = step.expect("a multiple of the norm is enough");
            let multiple = progress.regularisation;
            assert_eq!(multiple == 0.0, shift > 0.0, "{shift}: {multiple}");
            let matrix = hessian + norm * (multiple * scale);
            let factor = matrix.cholesky().expect("it is positive definite");
            let exact = -factor.solve(&kkt.gradient);
            assert_close!(&step.x, &exact, 1e-11);
            assert_close!(&[step.slope], &[kkt.gradient.dot(&exact)], 1e-11);
            let decrement = (-step.slope / scale).sqrt();
            assert_close!(&[progress.stationarity], &[decrement], 1e-14);
        }
    }
}

/// The direction of negative curvature has length 1 and nearly the least curvature there is; a positive definite matrix
/// has none.
#[test]
fn negative_curvature() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for columns in [0, 1, 3] {
        let (mut kkt, ..) = system(&mut rng, columns, 9.0);
        assert!(kkt.negative_curvature(1.0).is_none());
        let (mut kkt, norm, hessian) = system(&mut rng, columns, -1.0);
        let direction = kkt.negative_curvature(1.0).expect("it is indefinite");
        assert_close!(&[kkt.length(&direction)], &[1.0], 1e-12);
        // The eigenvalues of the matrix relative to the norm.
        let half = norm.cholesky().expect("it is positive definite").l();
        let half = half.try_inverse().expect("it is regular");
        let least = (&half * &hessian * half.transpose()).symmetric_eigenvalues().min();
        let found = direction.dot(&(&hessian * &direction));
        assert!(found <= 0.9 * least, "{found} {least}");
    }
}

/// Short fractions of steps are followed by a multiple of the norm that long ones take back to zero.
#[test]
fn the_multiple_follows_the_fractions() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (mut kkt, ..) = system(&mut rng, 1, 9.0);
    let options = Options::default();
    let used = |kkt: &mut Kkt, fraction: f64| {
        let mut progress = Progress::default();
        kkt.step(1.0, &mut progress, &options).expect("it is definite");
        kkt.adapt(fraction, progress.regularisation, &options);
        progress.regularisation
    };
    let short: Vec<f64> = (0..4).map(|_| used(&mut kkt, 0.5 * options.short_fraction)).collect();
    assert_eq!(short[0], 0.0);
    assert!(short[1] > 0.0 && short.windows(2).all(|pair| pair[1] > pair[0]), "{short:?}");
    let long: Vec<f64> = (0..20).map(|_| used(&mut kkt, 1.0)).collect();
    assert!(long[0] > 0.0 && long.windows(2).all(|pair| pair[1] <= pair[0]), "{long:?}");
    assert_eq!(long.last(), Some(&0.0));
}
