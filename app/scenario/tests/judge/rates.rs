//! Tables of positions alone.

use crate::intervals::{limited, table};
use crate::robot::{bounds, failed, row, scenario, verdict};
use aghf_scenario::Quantity;
use aghf_scenario::judge::{Check, Outcome, Trajectory, Verdict};
use proptest::prelude::*;
use serde_json::json;

/// A motion from rest with jerks that are constant between switches, its accelerations, velocities and positions.
#[derive(Clone, Debug)]
struct Switched {
    /// The times of the switches and the jerks, or the accelerations if these jump, after them.
    parts: Vec<(f64, f64)>,
    order: i32,
}

impl Switched {
    /// The derivative of this order of the position at a time.
    fn at(&self, t: f64, order: i32) -> f64 {
        let mut before = 0.0;
        let mut sum = 0.0;
        for (time, value) in &self.parts {
            if t >= *time {
                let power = self.order - order;
                let factorial: f64 = (1..=power).map(f64::from).product();
                sum += (value - before) * (t - time).powi(power) / factorial;
            }
            before = *value;
        }
        sum
    }

    fn range(&self, order: i32) -> f64 {
        let ends = self.parts.iter().flat_map(|(t, _)| [t - 1e-12, *t]);
        let many = (0..=4000).map(|k| f64::from(k) / 4000.0);
        let all = ends.chain(many).filter(|t| (0.0..=1.0).contains(t));
        all.map(|t| self.at(t, order).abs()).fold(0.0, f64::max)
    }
}

fn switched(order: i32, largest: f64) -> impl Strategy<Value = Switched> {
    let part = (0.0..1.0f64, prop_oneof![Just(-1.0), Just(0.0), Just(1.0), -1.0..1.0f64]);
    prop::collection::vec(part, 1..6).prop_map(move |mut parts| {
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        parts[0].0 = 0.0;
        let parts = parts.into_iter().map(|(t, value)| (t, largest * value)).collect();
        Switched { parts, order }
    })
}

proptest! {
    #![proptest_config(crate::common::config(48))]

    /// A motion whose limits are exactly those that it reaches is never not valid, however coarse its samples, whether
    /// its accelerations or its jerks jump, and with the rounding of six decimals.
    #[test]
    fn valid_motions_are_never_not_valid(
        motion in prop_oneof![switched(3, 60.0), switched(2, 6.0)],
        rate in prop::sample::select(vec![50.0, 100.0, 1000.0]), is_rounded: bool,
    ) {
        let curve = |t: f64| [0, 1, 2].map(|order| [motion.at(t, order); 3]);
        let end = curve(1.0);
        let mut samples = table(&curve, rate, 1);
        if is_rounded {
            samples.q.iter_mut().flatten().for_each(|q| *q = (*q * 1e6).round() / 1e6);
        }
        let [velocity, acceleration, jerk] = [1, 2, 3].map(|order| motion.range(order.min(motion.order)).max(1e-3));
        let mut limits = json!({ "acceleration": [acceleration, acceleration, acceleration], "position": false,
            "max_velocity": [velocity, velocity, velocity], "torque": false });
        if motion.order == 3 {
            limits["jerk"] = json!([jerk, jerk, jerk]);
        }
        let keys = json!({ "q_start": [0.0, 0.0, 0.0], "q_goal": end[0], "v_goal": end[1], "enforced_limits": limits,
            "continuity": if motion.order == 3 { "acceleration" } else { "velocity" } });
        let scenario = scenario("valid", keys);
        let judgement = verdict(&scenario, &samples);
        let velocity_is_possible = velocity < 5.0;
        prop_assert!(!velocity_is_possible || failed(&judgement).is_empty(), "{:?}", judgement.worst());
    }

    /// One that is beyond a limit on a long way is not valid, if its samples are as close as those of planners.
    #[test]
    fn motions_beyond_a_limit_are_not_valid(
        scale in 1.1..4.0f64, rate in prop::sample::select(vec![50.0, 100.0, 1000.0]),
    ) {
        let curve = |t: f64| {
            let (sin, cos) = (3.0 * t).sin_cos();
            [[scale * (1.0 - cos); 3], [3.0 * scale * sin; 3], [9.0 * scale * cos; 3]]
        };
        let end = curve(1.0);
        let keys = json!({ "q_start": [0.0, 0.0, 0.0], "q_goal": end[0], "v_goal": end[1],
            "enforced_limits": { "acceleration": [9.0, 9.0, 9.0], "jerk": [27.0, 27.0, 27.0], "position": false,
                "max_velocity": [3.0, 3.0, 3.0], "torque": false } });
        let scenario = scenario("beyond", keys);
        let judgement = verdict(&scenario, &table(&curve, rate, 1));
        prop_assert_eq!(judgement.verdict, Verdict::NotValid);
        for check in [Quantity::Velocity, Quantity::Acceleration, Quantity::Jerk].map(Check::Bounds) {
            prop_assert_eq!(row(&judgement, check).outcome, Outcome::Fail, "{:?}", check);
        }
    }
}

/// The motion of degree four is determined by five samples at unequal distances: its start velocity passes, another
/// one fails, and one that the accelerations may explain is not checked.
#[test]
fn rates_at_the_ends_are_known_as_far_as_samples_determine_them() {
    let times = [0.0, 0.1, 0.3, 0.35, 0.7, 0.8, 1.0];
    let cubic = |t: f64| t * (0.5 + t * (0.2 - 0.1 * t));
    let q = times.map(|t| vec![cubic(t); 3]).to_vec();
    let motion = Trajectory { times: times.to_vec(), q, v: None, a: None, u: None };
    for (start, wanted) in [(0.5, Outcome::Pass), (0.49, Outcome::NotChecked), (0.0, Outcome::Fail)] {
        let keys = json!({ "q_start": [0.0, 0.0, 0.0], "q_goal": [0.6, 0.6, 0.6], "v_start": [start, start, start],
            "v_goal": [0.6, 0.6, 0.6] });
        let judgement = verdict(&scenario("ends", keys), &motion);
        assert_eq!(row(&judgement, Check::StartVelocity).outcome, wanted, "{start}");
        assert_eq!(row(&judgement, Check::GoalVelocity).outcome, Outcome::Pass);
    }
    let limits = limited("few");
    let few = Trajectory { times: times[..3].to_vec(), q: motion.q[..3].to_vec(), ..motion };
    let judgement = verdict(&limits, &few);
    assert_eq!(bounds(&judgement, Quantity::Acceleration).outcome, Outcome::NotChecked);
}
