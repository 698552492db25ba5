//! A walk: one search, and ordinary scenarios for its phases.

use crate::phases::walk;
use crate::written::load;
use aghf::dynamics::{Data, forward_kinematics, frame_placement, rnea};
use aghf::model::{Joint, Model};
use aghf::motion::{Sample, sample};
use aghf::spatial::Placement;
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge};
use aghf_scenario::{DirectOptions, FlowOptions, Quantity, Scenario, Solve, SolveReport, Verdict};
use nalgebra::Vector3;

/// The value of a joint by its name.
fn of_joint(model: &Model, values: &[f64], name: &str) -> f64 {
    let mut joints = model.joints().iter().map(Joint::name).zip(values);
    *joints.find(|(joint, _)| *joint == name).expect("a joint").1
}

/// The place of a link in the frame of the base.
fn place(model: &Model, q: &[f64], link: &str) -> Placement<f64> {
    let mut bodies = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut bodies).expect("its joints");
    let frame = model.frames().iter().find(|frame| frame.name == link);
    frame_placement(frame.expect("a link"), &bodies).expect("its body")
}

fn samples((scenario, report): &(Scenario, SolveReport)) -> Vec<Sample> {
    sample(&scenario.model, &report.curve, 200).expect("its joints")
}

/// Digit steps 0.2 m forward with its right foot and puts the left one beside it: a minimum, whose phases are valid
/// motions of a robot on one foot by the judge too, which knows nothing of walks.
#[test]
fn digit_steps_and_each_phase_is_an_ordinary_motion() {
    let scenario = load("walk", &walk()).expect("it is good");
    let options = DirectOptions { starts: Some(1), ..DirectOptions::default() };
    let found = Solve::new(&scenario).options(options).run_walk();
    let found = found.expect("it is good");
    assert!(found.is_valid());
    assert_eq!((found.phases.len(), found.landings.len()), (2, 1));
    for (phase, report) in &found.phases {
        assert_eq!(report.summary.verdict, Verdict::Optimal, "{:?}", report.summary.failure);
        assert!((report.curve.horizon() - 1.0).abs() < 1e-12);
        let motion = Trajectory::of_samples(sample(&phase.model, &report.curve, 2000).expect("its joints"));
        let judged = judge(phase, &motion, Tolerances::default()).expect("its joints");
        let failed = judged.checks.iter().filter(|row| !row.outcome.is_good());
        assert_eq!(failed.map(|row| row.check).collect::<Vec<_>>(), []);
        assert!(judged.checks.iter().any(|row| row.check == Check::Bounds(Quantity::Foot)));
        assert!(judged.checks.iter().any(|row| row.check == Check::Waypoints));
    }
    let landing = &found.landings[0];
    assert_eq!(landing.frame, "right_sole");
    assert!(landing.off < 1e-6 && landing.speed < 1e-6, "{landing:?}");
    let [left, right] = [0, 1].map(|k| &found.phases[k]);
    let (before, after) = (samples(left), samples(right));
    let (last, first) = (&before[200], &after[0]);
    for joint in left.0.model.joints() {
        for (a, b) in [(&last.q, &first.q), (&last.v, &first.v)] {
            let [a, b] = [(left, a), (right, b)].map(|((of, _), x)| of_joint(&of.model, x, joint.name()));
            assert_eq!(a, b, "{}", joint.name());
        }
    }
    // The other foot is where the first one was, seen from it.
    let landed = place(&left.0.model, &last.q, "right_sole");
    assert!((landed.translation - Vector3::new(0.2, -0.25, 0.0)).amax() < 1e-6);
    assert!((landed.rotation - nalgebra::Matrix3::identity()).amax() < 1e-6);
    let back = place(&right.0.model, &first.q, "left_toe_roll");
    assert!((back.translation + landed.translation).amax() < 1e-6);
    let ended = place(&right.0.model, &after[200].q, "left_toe_roll");
    assert!((ended.translation - Vector3::new(0.0, 0.25, 0.0)).amax() < 1e-6);
    assert!(after[200].v.iter().all(|v| v.abs() < 1e-9));
    // It is lifted halfway, and never in the ground.
    let heights: Vec<_> = before.iter().map(|at| place(&left.0.model, &at.q, "right_sole").translation.z).collect();
    assert!(heights[100] > 0.05 - 1e-6 && heights.iter().all(|z| *z > -1e-6), "{heights:?}");
}

/// The torques of a phase are those of the robot on its own foot: between the phases they jump, though no joint does.
#[test]
fn torques_jump_where_the_foot_changes() {
    let scenario = load("jump", &walk()).expect("it is good");
    let found = Solve::new(&scenario).run_walk().expect("it is good");
    let torque = |k: usize, at: usize| {
        let (phase, _) = &found.phases[k];
        let Sample { q, v, a, .. } = &samples(&found.phases[k])[at];
        let mut tau = vec![0.0; q.len()];
        rnea(&phase.model, &mut Data::new(&phase.model), q, v, a, &mut tau).expect("its joints");
        of_joint(&phase.model, &tau, "left_knee")
    };
    let [before, after] = [torque(0, 200), torque(1, 0)];
    assert!((before - after).abs() > 1.0, "{before} and {after}");
}

/// Where the horizon is free the walk takes the time of least effort.
#[test]
fn a_free_horizon_is_the_best_one() {
    let mut free = walk();
    free["free_horizon"] = serde_json::json!({ "shortest_s": 1.0, "longest_s": 3.0 });
    let [fixed, free] = [("fixed", walk()), ("free", free)].map(|(name, file)| {
        let scenario = load(name, &file).expect("it is good");
        let found = Solve::new(&scenario).run_walk().expect("it is good");
        assert!(found.is_valid(), "{name}");
        let efforts = found.phases.iter().map(|(_, of)| of.summary.control_effort);
        let horizon = found.phases[0].1.curve.horizon();
        assert_eq!(horizon, found.phases[1].1.curve.horizon());
        (efforts.sum::<f64>(), horizon)
    });
    assert!(free.0 < fixed.0 && free.1 != fixed.1, "{free:?} and {fixed:?}");
}

#[test]
fn a_walk_is_solved_as_one_and_by_the_direct_method() {
    let scenario = load("refused", &walk()).expect("it is good");
    let alone = Solve::new(&scenario).run().expect_err("it has phases");
    assert!(alone.to_string().contains("phases: a walk has a scenario and a report per phase"), "{alone}");
    let flow = Solve::new(&scenario).options(FlowOptions::default()).run_walk();
    let flow = flow.expect_err("it is no flow").to_string();
    assert!(flow.contains("a walk is solved by the method 'direct' alone"), "{flow}");
}
