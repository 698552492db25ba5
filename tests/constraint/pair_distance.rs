//! Rows as functions of a distance, and single rows.

use crate::common::constraint::Held;
use crate::common::{robot, wave};
use aghf::constraint::{
    AnyConstraint, Bounds, CollisionSphere, Constraint, Evaluator, PairDistance, RowList, SelfClearance,
    SolidClearance, Sphere, SphereClearance,
};
use aghf::geometry::{Shape, Solid};
use aghf::model::Model;
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Parts = (Vec<AnyConstraint>, (Held, SphereClearance));

/// Clearances of each kind, and others.
fn parts(model: &Model) -> Parts {
    let mut balls = CollisionSphere::joint_frames(model);
    for (i, ball) in balls.iter_mut().enumerate() {
        ball.centre += Vector3::new(0.02, -0.03, 0.01 * i as f64);
        ball.radius = 0.03 + 0.01 * i as f64;
    }
    let on_base = CollisionSphere { body: None, centre: Vector3::zeros(), radius: 0.1 };
    let spheres = [0.3, 0.7].map(|z| Sphere { centre: Vector3::new(0.4, 0.1, z), radius: 0.1 });
    let spheres = SphereClearance { balls: balls.clone(), spheres: spheres.to_vec() };
    let cuboid = Solid {
        placement: Placement::new(Matrix3::identity(), Vector3::new(0.3, 0.5, 0.2)),
        shape: Shape::Cuboid { half_extents: Vector3::new(0.1, 0.2, 0.05) },
    };
    let solids = SolidClearance {
        balls: balls.clone(),
        solids: vec![Solid::half_space(&Vector3::z(), -0.5), cuboid],
        names: Vec::new(),
    };
    let mut all = vec![on_base];
    all.extend(balls);
    let pairs = (1..all.len()).flat_map(|j| (0..j).map(move |i| [i, j]));
    let between = SelfClearance { pairs: pairs.collect(), balls: all };
    let list = vec![
        AnyConstraint::Bounds(Bounds::positions(model)),
        AnyConstraint::Solids(solids),
        AnyConstraint::SelfCollision(between),
    ];
    (list, (Held(0.09), spheres))
}

/// The rows and the places of the bodies at a state.
fn at(model: &Model, parts: &Parts, x: &[f64]) -> (Vec<f64>, Vec<Placement<f64>>) {
    let mut evaluator = Evaluator::new(model);
    let placed = evaluator.at(x).expect("valid");
    let mut g = vec![0.0; parts.dim()];
    placed.value(parts, &mut g).expect("valid");
    (g, placed.state().placements.to_vec())
}

/// The scaled rows of clearances have the distances of their gaps, which change by no more than the bodies move; other
/// rows have none.
#[test]
fn gaps_change_by_no_more_than_bodies_move() {
    let model = robot("kinova_gen3");
    let parts = parts(&model);
    let scales = parts.row_scales();
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let (mut most, mut gaps) = (0.0_f64, 0);
    for _ in 0..200 {
        let x: Vec<f64> = (0..14).map(|_| rng.random_range(-2.0..2.0)).collect();
        let size = rng.random_range(0.0..0.5);
        let y = x.iter().map(|x| x + size * rng.random_range(-1.0..1.0));
        let y: Vec<f64> = y.collect();
        let [(g, from), (h, to)] = [&x, &y].map(|x| at(&model, &parts, x));
        for row in 0..parts.dim() {
            let Some(gap) = parts.row_set(row).distance else { continue };
            gaps += 1;
            let [before, after] = [g[row], h[row]].map(|g| gap.distance(g / scales[row]));
            assert!((gap.value(before) - g[row] / scales[row]).abs() < 1e-12);
            let moved = |(body, r): (usize, f64)| {
                let turn = (from[body].rotation - to[body].rotation).norm();
                let step = (from[body].translation - to[body].translation).norm();
                step + r * turn / 2.0_f64.sqrt()
            };
            let moved: f64 = gap.bodies.iter().flatten().copied().map(moved).sum();
            let changed = (after - before).abs();
            assert!(changed <= moved + 1e-12, "row {row}: {changed} {moved}");
            most = most.max(changed / moved);
        }
    }
    // The bound is attained, so that it is not one of something else.
    assert!(most > 0.9 && gaps > 0, "{most}");
    assert_eq!(parts.row_set(0).distance, None);
    let first = parts.dim() - parts.1.1.dim();
    let squared = parts.row_set(first).distance.and_then(|gap: PairDistance| gap.squared);
    assert!(squared.is_some_and(|reach| (reach - 0.13).abs() < 1e-12), "{squared:?}");
    assert_eq!(parts.row_set(parts.dim()).distance, None);
}

/// Single rows are those of all, to the last bit.
#[test]
fn some_rows_are_those_of_all() {
    let model = robot("kinova_gen3");
    let parts = parts(&model);
    let x = wave(14, 0.3);
    let (all, _) = at(&model, &parts, &x);
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for share in [0.0, 0.1, 0.5, 1.0] {
        let rows = (0..parts.dim()).filter(|_| rng.random_range(0.0..1.0) < share);
        let rows: Vec<usize> = rows.collect();
        let mut evaluator = Evaluator::new(&model);
        let placed = evaluator.at(&x).expect("valid");
        let mut g = vec![f64::NAN; parts.dim()];
        let list = RowList::new(&rows);
        placed.value_of(&parts, list, &mut g).expect("valid");
        for row in &rows {
            assert_eq!(g[*row], all[*row], "row {row}");
        }
        let clearances = parts.0[0].dim()..parts.0.dim();
        let others = clearances.filter(|row| rows.binary_search(row).is_err());
        assert!(others.into_iter().all(|row| g[row].is_nan()));
    }
}
