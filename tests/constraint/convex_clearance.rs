//! The clearance of convex bodies.

use crate::common::constraint::in_bodies;
use crate::common::{any_model, config, numbers, robot, wave};
use crate::derivatives::{ValueAlone, contracted};
use crate::solid_clearance::sizes;
use aghf::constraint::{
    ActivePair, ActivePairs, AnyConstraint, Constraint, ConvexClearance, Evaluator, Other, PlacedState, Quantity,
    RowList, Weights,
};
use aghf::geometry::{CollisionGeometry, Convex, Obstacle, Placed, Scene, Shape, Solid, gap, gap_to};
use aghf::model::Model;
use aghf::scalar::{LANES, Lanes, Wide};
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

/// The bodies of a robot and a solid of each shape.
pub fn bodies(model: &Model) -> ConvexClearance {
    let solids = sizes([0.3, 0.2, 0.5, 0.4])
        .map(|shape| Solid { placement: Placement::new(Matrix3::identity(), Vector3::new(0.3, -0.4, 0.2)), shape });
    in_bodies(model, solids.into())
}

/// The rows at a state, and the distances less their margins.
fn rows_and_distances(of: &ConvexClearance, model: &Model, x: &[f64]) -> [Vec<f64>; 2] {
    let mut evaluator = Evaluator::new(model);
    let placed = evaluator.at(x).expect("lengths agree");
    let mut g = vec![0.0; of.dim()];
    placed.value(of, &mut g).expect("its bodies");
    let placements = placed.state().placements;
    let part = |i: usize| {
        let part = &of.parts[i];
        Placed { convex: &part.convex, placement: part.body.map(|body| &placements[body]) }
    };
    let distance = |pair: &aghf::constraint::ConvexPair| {
        let gap = match pair.other {
            Other::Part(j) => gap(&[part(pair.part), part(j)]),
            Other::Solid(k) => gap_to(&part(pair.part), (&of.solids[k].0, of.solids[k].1.as_ref())),
        };
        gap.distance - pair.margin
    };
    [g, of.pairs.iter().map(distance).collect()]
}

/// The rows in lanes, and the pairs that are near.
fn wide(
    of: &ConvexClearance,
    model: &Model,
    x: &[Wide],
    known: Option<ActivePairs<'_, Wide>>,
) -> (Vec<Wide>, Vec<ActivePair<Wide>>) {
    let mut g = vec![Wide::splat(f64::NAN); of.dim()];
    let (mut near, mut evaluator) = (Vec::new(), Evaluator::<f64, Wide>::new(model));
    let placed = evaluator.at(x).expect("lengths agree");
    let at = PlacedState { active_pairs: known, ..*placed.state() };
    of.value_of(&at, None, &mut g, Some(&mut near)).expect("its bodies");
    (g, near)
}

proptest! {
    #![proptest_config(config(24))]

    /// A row that is not at its cutoff is at least what the distance is short of the margin, and by at most a few
    /// millimetres more.
    #[test]
    fn rows_keep_distances(numbers in numbers(14)) {
        let model = robot("kinova_gen3");
        let rows = bodies(&model);
        let [g, distances] = rows_and_distances(&rows, &model, &numbers);
        for (g, distance) in g.iter().zip(&distances) {
            // In an overlap there may be several planes with the largest gap nearby.
            if *distance < 0.0 {
                prop_assert!(*g > 0.0, "{g} {distance}");
                continue;
            }
            let least = (-distance).max(-rows.far);
            prop_assert!((least - 1e-9..=least + 0.006).contains(g), "{g} {distance}");
        }
    }

    /// Gradient and Hessian are those of dual numbers.
    #[test]
    fn derivatives_are_those_of_duals((model, x) in any_model().prop_flat_map(|model| {
        let n = 2 * model.dof();
        (Just(model), numbers(n))
    })) {
        let rows = bodies(&model);
        let (w, c) = (wave(rows.dim(), 0.7), wave(rows.dim(), 1.9));
        let weights = Weights { first_order: &w, gauss_newton: Some(&c) };
        let (gradient, hessian) = contracted(&model, &rows, &x, weights);
        let (by_jets, by_jets2) = contracted(&model, &ValueAlone(rows), &x, weights);
        assert_close!(&gradient, &by_jets, 1e-7);
        assert_close!(&hessian, &by_jets2, 1e-6);
    }

    /// Planes that are known from another state change no row of bodies that are apart, but rows beyond half of the
    /// cutoff count as being at it.
    #[test]
    fn rows_are_the_same_from_known_planes(numbers in numbers(LANES * 7)) {
        let model = robot("kinova_gen3");
        let rows = bodies(&model);
        let state = |by: f64| -> Vec<Wide> {
            let entry = |i: usize| Lanes(std::array::from_fn(|lane| numbers[LANES * i + lane] + by));
            (0..14).map(|i| if i < 7 { entry(i) } else { Wide::splat(0.0) }).collect()
        };
        let (_, known) = wide(&rows, &model, &state(0.0), None);
        for by in [0.0, 1e-3, 0.3] {
            let (g, near) = wide(&rows, &model, &state(by), None);
            prop_assert!(near.is_sorted_by_key(|pair| pair.row));
            let known = ActivePairs::new(&known);
            let (from_known, _) = wide(&rows, &model, &state(by), Some(known));
            let (independent, _) = wide(&rows, &model, &state(by), Some(known.independent()));
            for (row, lane) in (0..g.len()).flat_map(|row| (0..LANES).map(move |lane| (row, lane))) {
                let [a, b, c] = [&g, &from_known, &independent].map(|of| of[row].0[lane]);
                let is_far = b == -rows.far && a < -0.5 * rows.far;
                // Where bodies overlap, only values that do not depend on the way to a state are the same.
                prop_assert!(is_far || ((a > 0.0 || (a - b).abs() < 1e-8) && (a - c).abs() < 1e-8), "{a} {b} {c}");
            }
        }
    }
}

/// Where a given end is nearer to an obstacle than rows are smoothed, they are smoothed less.
#[test]
fn an_end_that_keeps_clear_keeps_its_rows() {
    let model = robot("kinova_gen3");
    let part = Convex::of_corners(
        vec![Vector3::zeros(), Vector3::x() * 0.1, Vector3::y() * 0.1, Vector3::new(0.1, 0.1, 0.0)],
        0.0,
    );
    let mut robot = CollisionGeometry::default();
    robot.add("hand", Some(6), part);
    let x = vec![0.3; 14];
    let mut evaluator = Evaluator::new(&model);
    let placed = evaluator.at(&x).expect("lengths agree");
    let placements = placed.state().placements.to_vec();
    // A box with a face parallel to that of the hand, 0.1 mm from it.
    let at = placements[6].compose(&Placement::new(Matrix3::identity(), Vector3::new(0.05, 0.05, 0.1001)));
    let half_extents = Vector3::repeat(0.1);
    let solid = Solid { placement: at, shape: Shape::Cuboid { half_extents } };
    let scene = Scene::new(robot, vec![Obstacle { name: "box".to_owned(), solid }], None);
    let row = |scene: &Scene| {
        let mut g = [0.0];
        placed.value(&AnyConstraint::of_scene(scene), &mut g).expect("its bodies");
        g[0]
    };
    assert!(row(&scene) > 1e-4);
    let scene = scene.with_ends(vec![placements.clone()]).expect("its bodies");
    assert!(row(&scene) <= 0.0 && row(&scene) > -1e-4, "{}", row(&scene));
    assert!(scene.with_ends(vec![placements[..6].to_vec()]).is_err());
}

#[test]
fn rows_of_a_list_are_those_of_all() {
    let model = robot("kinova_gen3");
    let rows = bodies(&model);
    let x = wave(14, 0.4);
    let [mut all, mut some] = [(); 2].map(|()| vec![f64::NAN; rows.dim()]);
    let mut evaluator = Evaluator::new(&model);
    let placed = evaluator.at(&x).expect("lengths agree");
    placed.value(&rows, &mut all).expect("its bodies");
    let listed: Vec<_> = (0..rows.dim()).step_by(7).collect();
    placed.value_of(&rows, RowList::new(&listed), &mut some).expect("its bodies");
    assert!(listed.iter().all(|row| some[*row] == all[*row]));
}

/// Rows change by no more than the points of both bodies may move.
#[test]
fn rows_change_by_no_more_than_bodies_move() {
    let model = robot("kinova_gen3");
    let rows = bodies(&model);
    let values = |x: &[f64]| {
        let mut g = vec![0.0; rows.dim()];
        let mut evaluator = Evaluator::new(&model);
        let placed = evaluator.at(x).expect("lengths agree");
        placed.value(&rows, &mut g).expect("its bodies");
        (g, placed.state().placements.to_vec())
    };
    let mut most = 0.0_f64;
    for k in 0..40 {
        let x = wave(14, 0.1 * f64::from(k));
        let y: Vec<_> = x.iter().map(|x| x + 0.02 * (9.0 * x).sin()).collect();
        let [(g, from), (h, to)] = [values(&x), values(&y)];
        for (row, (g, h)) in g.iter().zip(&h).enumerate().filter(|(_, (g, h))| **g < 0.0 && **h < 0.0) {
            let gap = rows.row_set(row).distance.expect("each row is a distance");
            let moved = gap.bodies.iter().flatten().map(|(body, r)| {
                let turn = (from[*body].rotation - to[*body].rotation).norm();
                (from[*body].translation - to[*body].translation).norm() + r * turn / 2.0_f64.sqrt()
            });
            let moved: f64 = moved.sum();
            assert!((h - g).abs() <= moved + 1e-9, "row {row}: {g} {h} {moved}");
            most = most.max((h - g).abs() / moved);
        }
    }
    assert!((0.4..=1.0).contains(&most), "{most}");
    assert_eq!(rows.row_set(rows.dim()).distance, None);
}

#[test]
fn rows_are_named_by_links_and_solids() {
    let model = robot("kinova_gen3");
    let rows = bodies(&model);
    let names = [0, rows.dim() - 1].map(|row| rows.label(row, &model));
    assert!(names.iter().all(|label| label.quantity.is_clearance()));
    assert!(names[0].name.ends_with("from 'solid 0'"), "{}", names[0].name);
    assert!(names[1].name.starts_with("distance of link"), "{}", names[1].name);
    assert_eq!(rows.label(rows.dim(), &model).quantity, Quantity::Other);
}
