//! Ends that violate a constraint are refused before any search.

use crate::common::{assert_refused, point_mass};
use aghf::constraint::{AnyConstraint, Bound, Bounds, Constraints, Side, TorqueLimits};
use aghf::direct::{Direct, DirectSettings};
use aghf::motion::Problem;
use nalgebra::Vector3;
use proptest::prelude::*;

proptest! {
    #![proptest_config(crate::common::config(64))]

    /// A motion along a line below an upper bound: an end above it by more than the search accepts is refused, the
    /// start first, and a final velocity above its bound only if it is given.
    #[test]
    fn an_end_beyond_a_bound_is_refused(ends in proptest::array::uniform2(-1.0..1.0), entry in 0..2_usize) {
        let model = point_mass(&[Vector3::x()]);
        let at = |value: f64| if entry == 0 { vec![value, 0.0] } else { vec![0.0, value] };
        let [start, goal] = ends.map(at);
        let problem = Problem::new(&model, start, goal, 1.0).expect("valid");
        let bound = Bound { entry, side: Side::Upper, value: 0.0 };
        let kept = Constraints {
            state: vec![AnyConstraint::Bounds(Bounds(vec![bound]))],
            torque: TorqueLimits(Vec::new()),
            stage: Default::default(),
        };
        for free_final_velocity in [false, true] {
            let settings = DirectSettings { free_final_velocity, iterations: 1, ..DirectSettings::constrained() };
            let found = Direct::new(&problem).constraints(&kept).settings(settings).solve();
            match ends.map(|end| end > DirectSettings::FEASIBLE) {
                [true, _] => assert_refused(found, "problem: start: it violates"),
                [false, true] if !free_final_velocity => assert_refused(found, "problem: goal: it violates"),
                _ => prop_assert!(found.is_ok()),
            }
        }
    }
}
