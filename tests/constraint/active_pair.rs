//! The pairs of bodies that are near each other.

use crate::common::{robot, wave};
use crate::convex_clearance::bodies;
use aghf::constraint::{ActivePair, ActivePairs, AnyConstraint, Bounds, Constraint, Evaluator};
use aghf::geometry::{Convex, Placed, Plane};
use nalgebra::Vector3;

#[test]
fn pairs_are_split_like_rows() {
    let corner = Convex::of_corners(vec![Vector3::zeros()], 0.0);
    let plane = |row: usize| {
        let (sin, cos) = (row as f64).sin_cos();
        Plane::of_half_space(&Placed { convex: &corner, placement: None }, &Vector3::new(cos, sin, 0.0), 0.0, 1e-3)
            .hint()
    };
    let at = |row| ActivePair { row, plane: plane(row) };
    let all = [0, 2, 3, 4, 7].map(at);
    let (first, rest) = ActivePairs::new(&all).split_at(3);
    let (second, third) = rest.split_at(2);
    let known = |pairs: &ActivePairs<'_>| (0..9).filter(|row| pairs.plane(*row).is_some()).collect::<Vec<_>>();
    assert_eq!([first, second, third].map(|pairs| known(&pairs)), [vec![0, 2], vec![0, 1], vec![2]]);
    assert_eq!(third.plane(2), Some((&plane(7), true)));
    assert_eq!(third.independent().split_at(0).1.plane(2), Some((&plane(7), false)));
}

/// The pairs of several constraints have the rows that these have among all.
#[test]
fn pairs_of_a_list_are_those_of_its_rows() {
    let model = robot("kinova_gen3");
    let rows = bodies(&model);
    let bounds = AnyConstraint::Bounds(Bounds::positions(&model));
    let all = [AnyConstraint::Convex(rows.clone()), bounds.clone(), AnyConstraint::Convex(rows.clone())];
    let x = wave(14, 0.4);
    let mut evaluator = Evaluator::new(&model);
    let placed = evaluator.at(&x).expect("lengths agree");
    let pairs_of = |of: &[AnyConstraint]| {
        let (mut g, mut found) = (vec![0.0; of.dim()], Vec::new());
        of.value_of(placed.state(), None, &mut g, Some(&mut found)).expect("its bodies");
        found
    };
    let one = pairs_of(&all[..1]);
    assert!(one.len() > 5);
    let second = one.iter().map(|pair| ActivePair { row: pair.row + rows.dim() + bounds.dim(), ..*pair });
    assert_eq!(pairs_of(&all), one.iter().copied().chain(second).collect::<Vec<_>>());
}
