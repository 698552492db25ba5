//! Symmetric block-tridiagonal matrices.

use aghf::cost::ControlEffort;
use aghf::curve::{Basis, Continuity};
use aghf::linalg::BlockTridiagonal;
use aghf::model::random_tree;
use aghf::transcription::{Derivatives, Grid, Objective};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn random(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

#[test]
fn the_factors_of_a_block_tridiagonal_matrix_solve() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let of_free_end = Continuity { free_final_velocity: true, free_final_position: true, ..Continuity::default() };
    // One block is larger than a panel of the factorisation.
    let model = random_tree(4, 9).expect("n > 0");
    let basis = Basis::new(3, 16, of_free_end);
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
