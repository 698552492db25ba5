//! The phases of a motion, as constraints.

use crate::common::assert_refused;
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, Constraints, Phase, Side, StageConstraints, StandingFoot, TorqueLimits,
};
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf::urdf::builtin_robot;

fn foot(weight: f64) -> StandingFoot {
    StandingFoot {
        name: "foot".to_owned(),
        sole: Placement::identity(),
        half_length: 0.1,
        half_width: 0.05,
        friction: 0.7,
        torsion: None,
        weight,
    }
}

fn robot() -> Model {
    builtin_robot("pendulum_2").expect("it is built in")
}

fn phase() -> Phase {
    Phase { model: robot(), order: vec![1, 0], foot: foot(10.0), rows: 1..2 }
}

fn constraints(phases: Vec<Phase>, foot: Option<StandingFoot>) -> Constraints<Vec<AnyConstraint>> {
    let bounds = [Side::Lower, Side::Upper].map(|side| Bound { entry: 0, side, value: 1.0 });
    Constraints {
        state: vec![AnyConstraint::Bounds(Bounds(bounds.to_vec()))],
        torque: TorqueLimits(Vec::new()),
        stage: StageConstraints { foot, phases, ..StageConstraints::default() },
    }
}

#[test]
fn phases_that_are_not_those_of_a_motion_are_refused() {
    let check = |of: Phase| constraints(vec![phase(), of], Some(foot(10.0))).check(&robot());
    check(phase()).expect("they are good");
    let none = constraints(vec![phase()], None).check(&robot());
    assert_refused(none, "constraints: phases: no foot stands");
    for (of, words) in [
        (Phase { order: vec![0, 0], ..phase() }, "its joints are not those of the motion"),
        (Phase { order: vec![0], ..phase() }, "its joints are not those of the motion"),
        (Phase { foot: StandingFoot { torsion: Some(0.1), ..foot(10.0) }, ..phase() }, "more or fewer bounds"),
        (Phase { foot: foot(10.1), ..phase() }, "its robot weighs 10.1 N, the first one 10 N"),
        (Phase { rows: 1..3, ..phase() }, "it has rows 1 to 3 of 2"),
    ] {
        assert_refused(check(of), words);
    }
}
