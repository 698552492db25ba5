//! Every promise of a scenario is judged, or listed as not checked.

use crate::robot::{FROM, TO, bounds, good, row, scenario, verdict};
use aghf::Result;
use aghf::constraint::{Constraint, PlacedState};
use aghf::scalar::AlgebraOver;
use aghf_scenario::judge::{Check, Outcome, Verdict};
use aghf_scenario::{Quantity, ScenarioFile};
use serde_json::json;

/// The keys of a scenario: a new one does not compile until it is here, with the check that knows it.
#[test]
fn every_key_has_a_check_or_promises_nothing() {
    let ScenarioFile {
        // Which robot it is.
        robot: _,
        packages: _,
        root: _,
        mount: _,
        gravity: _,
        mimic: _,
        group: _,
        held_state: _,
        locked_joints: _,
        losses: _,
        payload: _,
        // Obstacles and self-collision.
        srdf: _,
        obstacles: _,
        robot_shape: _,
        self_collision: _,
        clearance_m: _,
        // The horizon.
        horizon_s: _,
        free_horizon: _,
        objective: _,
        // The ends.
        q_start: _,
        v_start: _,
        a_start: _,
        start_tolerance: _,
        q_goal: _,
        v_goal: _,
        a_goal: _,
        turns: _,
        goal: _,
        free_final_velocity: _,
        // Continuity, limits, passive joints.
        continuity: _,
        enforced_limits: _,
        passive: _,
        // Kept along the way, waypoints, the standing foot.
        keep: _,
        waypoints: _,
        stand: _,
        // Walks are refused.
        phases: _,
        periodic: _,
        // Of the search and the simulation.
        schema: _,
        flow: _,
        feedback: _,
        success_threshold: _,
    } = scenario("keys", json!({})).file;
}

/// The velocity of the first joint is at most a tenth.
#[derive(Clone, Debug)]
struct Slow;

impl Constraint for Slow {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> Result<()> {
        g[0] = at.x[3] - S::lift(0.1);
        Ok(())
    }
}

/// A constraint of a program is not known, with keys of the same kinds beside it.
#[test]
fn added_constraints_are_listed() {
    let keep = json!([{ "speed": { "frame": "carriage", "most_m_s": 9.0 } },
        { "speed": { "frame": "carriage", "most_m_s": 9.0 }, "from_s": 0.5 }]);
    let mut scenario = scenario("added", json!({ "keep": keep }));
    let motion = good(&scenario.model, FROM, TO, 101);
    assert!(verdict(&scenario, &motion).valid);
    scenario.add_constraint(Slow);
    let judgement = verdict(&scenario, &motion);
    assert_eq!((judgement.verdict, judgement.valid), (Verdict::ValidInPart, false));
    let added = bounds(&judgement, Quantity::Other);
    assert_eq!(added.outcome, Outcome::NotChecked);
    assert!(added.note.as_ref().is_some_and(|note| note.starts_with("1 of a program")));
}

/// An acceleration at rest is not continuous, unless accelerations may jump.
#[test]
fn rest_is_at_rest() {
    for (keys, wanted) in [
        (json!({}), Outcome::Fail),
        (json!({ "continuity": "velocity" }), Outcome::Pass),
        (json!({ "v_start": [0.1, 0.0, 0.0], "v_goal": [0.1, 0.0, 0.0] }), Outcome::Pass),
        (json!({ "v_start": [0.1, 0.0, 0.0] }), Outcome::Fail),
        (json!({ "v_goal": [0.1, 0.0, 0.0] }), Outcome::Fail),
        (json!({ "a_start": [0.0, 1.6, 0.0], "a_goal": [0.0, 1.6, 0.0] }), Outcome::Pass),
        (json!({ "a_start": [0.0, 1.6, 0.0], "a_goal": [0.0, 1.5, 0.0] }), Outcome::Fail),
        (json!({ "a_start": [0.0, 1.6, 0.0], "v_goal": [0.1, 0.0, 0.0] }), Outcome::Pass),
    ] {
        let scenario = scenario("rest", keys);
        let mut motion = good(&scenario.model, FROM, TO, 101);
        // A bump from one end to the other, which rests at both.
        for (k, t) in motion.times.iter().enumerate() {
            let bump = |x: f64| 0.05 * x;
            motion.q[k][1] += bump(16.0 * (t * (1.0 - t)).powi(2));
            motion.v.as_mut().expect("given")[k][1] += bump(32.0 * t * (1.0 - t) * (1.0 - 2.0 * t));
            motion.a.as_mut().expect("given")[k][1] += bump(32.0 * (1.0 - 6.0 * t * (1.0 - t)));
        }
        motion.u = None;
        assert_eq!(row(&verdict(&scenario, &motion), Check::Continuity).outcome, wanted);
    }
}

/// The objective alone leaves the duration open, `free_horizon` bounds it.
#[test]
fn the_horizon_is_that_of_a_certificate() {
    for (keys, wanted) in [
        (json!({ "horizon_s": 0.4 }), Outcome::Fail),
        (json!({ "horizon_s": 0.01, "objective": "least-time" }), Outcome::Pass),
        (
            json!({ "horizon_s": 0.4, "objective": "least-time",
                "free_horizon": { "shortest_s": 0.1, "longest_s": 0.9 } }),
            Outcome::Fail,
        ),
    ] {
        let scenario = scenario("horizon", keys);
        let motion = good(&scenario.model, FROM, TO, 101);
        assert_eq!(bounds(&verdict(&scenario, &motion), Quantity::Duration).outcome, wanted);
    }
}
