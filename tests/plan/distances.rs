//! Distances of links: the same answers as by all rows, and no collision on a line that counts as free.

use crate::common::{constraint::in_bodies, tree};
use aghf::constraint::{
    AnyConstraint, Bounds, CollisionSphere, Constraint, Evaluator, SelfClearance, SolidClearance, Sphere,
    SphereClearance,
};
use aghf::geometry::{Shape, Solid};
use aghf::model::Model;
use aghf::plan::Checker;
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The number of balls of a body.
const BALLS: usize = 5;

/// Rows of every kind for balls of this size on each body and on the base.
fn rows(model: &Model, size: f64, rng: &mut ChaCha8Rng) -> Vec<AnyConstraint> {
    let mut balls = Vec::new();
    for body in [None].into_iter().chain((0..model.dof()).map(Some)) {
        balls.extend((0..BALLS).map(|_| CollisionSphere {
            body,
            centre: Vector3::from_fn(|_, _| 0.3 * rng.random::<f64>()),
            radius: size * rng.random::<f64>(),
        }));
    }
    let mut solid = |shape| Solid {
        placement: Placement::new(Matrix3::identity(), Vector3::from_fn(|_, _| 3.0 * rng.random::<f64>() - 1.5)),
        shape,
    };
    let (radius, half_length) = (0.1, 0.2);
    let half_extents = Vector3::new(0.1, 0.05, 0.3);
    let solids = vec![
        solid(Shape::Cuboid { half_extents }),
        solid(Shape::Cylinder { radius, half_length }),
        solid(Shape::Capsule { radius, half_length }),
        Solid::half_space(&Vector3::new(0.1, 0.2, 1.0), -2.0),
    ];
    let spheres = [(); 2].map(|()| Sphere { centre: solid(Shape::HalfSpace).placement.translation, radius });
    let last = balls.len() - BALLS;
    // Every other ball of the first body and those of the last one.
    let pairs = (0..BALLS).step_by(2).flat_map(|i| (last..balls.len()).map(move |j| [i, j]));
    vec![
        AnyConstraint::Bounds(Bounds::positions(model)),
        AnyConstraint::Spheres(SphereClearance { balls: balls.clone(), spheres: spheres.to_vec() }),
        AnyConstraint::Solids(SolidClearance { balls: balls.clone(), solids, names: Vec::new() }),
        AnyConstraint::SelfCollision(SelfClearance { pairs: pairs.collect(), balls: balls.clone() }),
        AnyConstraint::Convex(in_bodies(model, vec![solid(Shape::Cuboid { half_extents })])),
    ]
}

/// The largest row at rest, scaled.
fn worst(model: &Model, rows: &[AnyConstraint], q: &[f64]) -> f64 {
    let mut g = vec![0.0; rows.dim()];
    let mut evaluator = Evaluator::<f64, f64>::new(model);
    let x = [q, &vec![0.0; q.len()]].concat();
    let placed = evaluator.at(&x).expect("its length");
    placed.value(rows, &mut g).expect("its bodies");
    let scaled = g.iter().zip(rows.row_scales()).map(|(g, scale)| g / scale);
    scaled.fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn a_configuration_is_free_if_all_rows_are_kept() {
    let mut counts = [0; 2];
    for seed in 0..40 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let model = tree(2 + seed as usize % 5, seed);
        let rows = rows(&model, 0.1, &mut rng);
        let mut checker = Checker::new(&model, &rows, 0.1).expect("its bodies");
        for _ in 0..50 {
            let q = model.random_configuration(&mut rng);
            let free = worst(&model, &rows, &q) <= 0.0;
            assert_eq!(checker.is_free(&q).expect("its length"), free, "{seed}");
            counts[usize::from(free)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
}

/// Between its checked configurations a line may be off by the motion within the resolution, and no further.
#[test]
fn a_free_line_meets_nothing() {
    let mut counts = [0; 2];
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let model = tree(2 + seed as usize % 5, seed);
        let rows = rows(&model, 0.03, &mut rng);
        let mut checker = Checker::new(&model, &rows, 1e-3).expect("its bodies");
        for _ in 0..20 {
            let [from, to] = [(); 2].map(|()| model.random_configuration(&mut rng));
            if !checker.is_free(&from).expect("its length") {
                continue;
            }
            let off = (0..=400).map(|k| {
                let share = f64::from(k) / 400.0;
                let line = from.iter().zip(&to);
                let q: Vec<f64> = line.map(|(a, b)| a + share * (b - a)).collect();
                worst(&model, &rows, &q)
            });
            let off = off.fold(f64::NEG_INFINITY, f64::max);
            let free = checker.is_line_free(&from, &to).expect("its length");
            assert!(!free || off < 0.01, "{seed}: {off}");
            assert!(free || off > -0.03, "{seed}: {off}");
            counts[usize::from(free)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
}
