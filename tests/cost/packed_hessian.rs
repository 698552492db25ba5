//! Hessians at points, packed.

use aghf::cost::PackedHessian;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn random(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
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
        let vector = DVector::from_fn(3 * n, |_, _| rng.random_range(-1.0..1.0));
        let mut product = DVector::zeros(3 * n);
        kept.product(2, &vector, &mut product);
        assert_close!(&product, &(&sum * vector), 1e-14);
    }
}
