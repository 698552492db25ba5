//! Nothing is valid that the motion between the samples breaks, whatever its table.

use crate::robot::{bounds, row, scenario, verdict};
use aghf::dynamics::{Data, rnea};
use aghf::model::Model;
use aghf_scenario::judge::{Check, Hermite, Judgement, Outcome, Trajectory, Verdict};
use aghf_scenario::{Quantity, Scenario};
use proptest::prelude::*;
use serde_json::json;

/// A motion by its positions, velocities and accelerations at a time.
pub type Curve<'a> = &'a dyn Fn(f64) -> [[f64; 3]; 3];

/// A table with some of these columns at a rate, Hz, over a second.
pub fn table(curve: Curve<'_>, rate: f64, columns: usize) -> Trajectory {
    let times: Vec<f64> = (0..=rate as usize).map(|k| k as f64 / rate).collect();
    let all = |i: usize| times.iter().map(|t| curve(*t)[i].to_vec()).collect::<Vec<_>>();
    let [v, a] = [1, 2].map(|i| (columns > i).then(|| all(i)));
    Trajectory { q: all(0), v, a, u: None, times }
}

/// The limits of the joints of the scenario below: velocities, accelerations, jerks.
const LIMITS: [f64; 3] = [3.0, 12.0, 150.0];

pub fn limited(test: &str) -> Scenario {
    let [velocity, acceleration, jerk] = LIMITS.map(|limit| [limit; 3]);
    let limits = json!({ "max_velocity": velocity, "acceleration": acceleration, "jerk": jerk });
    let keys = json!({ "q_start": [0.0, 0.0, 0.0], "q_goal": [1.0, 1.0, 1.0], "enforced_limits": limits });
    scenario(test, keys)
}

/// The polynomials that a table with velocities means.
fn polynomials(table: &Trajectory) -> Vec<Vec<Hermite>> {
    let v = table.v.as_ref().expect("given");
    let joint = |k: usize, i: usize| {
        let ends = [k, k + 1];
        let a = ends.map(|k| table.a.as_ref().map(|a| a[k][i]));
        let interval = table.times[k + 1] - table.times[k];
        Hermite::new(ends.map(|k| table.q[k][i]), ends.map(|k| v[k][i]), a, interval)
    };
    (0..table.times.len() - 1).map(|k| (0..3).map(|i| joint(k, i)).collect()).collect()
}

/// The largest excess over the bounds of velocities, accelerations, jerks and torques by many evaluations.
fn dense(model: &Model, table: &Trajectory, bounds: [f64; 4]) -> [f64; 4] {
    let (mut worst, mut data, mut tau) = ([f64::NEG_INFINITY; 4], Data::new(model), vec![0.0; 3]);
    for joints in polynomials(table) {
        for step in 0..=40 {
            let s = f64::from(step) / 40.0;
            let [q, v, a, jerk] =
                [0, 1, 2, 3].map(|order| joints.iter().map(|joint| joint.at(order, s)).collect::<Vec<_>>());
            rnea(model, &mut data, &q, &v, &a, &mut tau).expect("three joints");
            for (worst, (all, bound)) in worst.iter_mut().zip([&v, &a, &jerk, &tau].into_iter().zip(bounds)) {
                *worst = all.iter().fold(*worst, |worst, x| worst.max(x.abs() - bound));
            }
        }
    }
    worst
}

/// The polynomial of degree five from rest to rest, by 1 rad or m in a second.
fn smooth(t: f64) -> [[f64; 3]; 3] {
    [
        [t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t); 3],
        [30.0 * (t * (1.0 - t)).powi(2); 3],
        [60.0 * t * (1.0 - t) * (1.0 - 2.0 * t); 3],
    ]
}

/// Checks of limits and torques that do not pass.
fn left(judgement: &Judgement) -> Vec<(Check, Outcome)> {
    let rows = judgement.checks.iter().filter(|row| row.outcome > Outcome::Pass);
    rows.map(|row| (row.check, row.outcome)).collect()
}

/// Wiggles of random period, amplitude and columns on a smooth motion.
fn wiggled(columns: usize, rate: f64, period: usize, by: [f64; 3], joint: usize) -> Trajectory {
    let mut table = table(&smooth, rate, columns);
    let count = table.times.len();
    let all = [Some(&mut table.q), table.v.as_mut(), table.a.as_mut()];
    for (of, by) in all.into_iter().zip(by) {
        let Some(of) = of else { continue };
        for (k, row) in of.iter_mut().enumerate().take(count - 1).skip(1) {
            row[joint] += if (k / period).is_multiple_of(2) { by } else { -by };
        }
    }
    table
}

proptest! {
    #![proptest_config(crate::common::config(96))]

    /// A table whose motion breaks a limit at some time is not valid, nor valid in part: velocities and accelerations
    /// that alternate from sample to sample, within what samples alone would show.
    #[test]
    fn what_breaks_a_limit_between_samples_is_not_valid(
        with_accelerations: bool, rate in 50.0..2000.0f64, period in 1..4usize, joint in 0..3usize,
        by in [-7.0..-2.0f64, -4.0..0.0f64, -2.0..1.5f64],
    ) {
        let columns = if with_accelerations { 3 } else { 2 };
        let by = by.map(|exponent| 10.0_f64.powf(exponent));
        let motion = wiggled(columns, rate.round(), period, by, joint);
        let scenario = limited("between_samples");
        let found = dense(&scenario.model, &motion, [3.0, 12.0, 150.0, 100.0]);
        let judgement = verdict(&scenario, &motion);
        let checks = [Quantity::Velocity, Quantity::Acceleration, Quantity::Jerk].map(Check::Bounds);
        for (check, excess) in checks.into_iter().zip(found) {
            let row = row(&judgement, check);
            if excess > 1e-3 {
                prop_assert_eq!(row.outcome, Outcome::Fail, "{:?} {}", check, excess);
                prop_assert_eq!(judgement.verdict, Verdict::NotValid);
            }
            if excess < -1e-2 && columns == 3 {
                prop_assert_eq!(row.outcome, Outcome::Pass, "{:?} {}", check, excess);
            }
        }
    }

    /// A zigzag of positions alone is never valid if a motion through it has accelerations or jerks beyond the limits.
    #[test]
    fn zigzags_of_positions_are_not_valid(
        rate in 50.0..2000.0f64, period in 1..4usize, joint in 0..3usize, exponent in -6.0..-2.0f64,
    ) {
        let (rate, by) = (rate.round(), 10.0_f64.powf(exponent));
        let motion = wiggled(1, rate, period, [by, 0.0, 0.0], joint);
        let judgement = verdict(&limited("zigzag"), &motion);
        // The second and third differences of a zigzag, beside accelerations of up to 6 and jerks of up to 60.
        let beyond = 2.0 * by * rate.powi(2) > LIMITS[1] + 6.0 || 2.0 * by * rate.powi(3) > LIMITS[2] + 60.0;
        prop_assert!(!(beyond && judgement.valid), "{:?}", left(&judgement));
    }
}

/// A motion that jumps from one acceleration to the other halfway, with a row there, keeps the limits that it reaches,
/// with the acceleration of either side and without accelerations; not where accelerations are continuous.
#[test]
fn jumps_at_samples_are_jumps() {
    let bang = |t: f64| {
        let (early, late) = (t < 0.5, 1.0 - t);
        let q = if early { 2.0 * t * t } else { 1.0 - 2.0 * late * late };
        [[q; 3], [if early { 4.0 * t } else { 4.0 * late }; 3], [if early { 4.0 } else { -4.0 }; 3]]
    };
    let keys = json!({ "q_start": [0.0, 0.0, 0.0], "q_goal": [1.0, 1.0, 1.0], "continuity": "velocity",
        "enforced_limits": { "max_velocity": [2.0, 2.0, 2.0], "acceleration": [4.0, 4.0, 4.0] } });
    let jumping = scenario("jumping", keys.clone());
    for sign in [-1.0, 1.0] {
        let mut motion = table(&bang, 100.0, 3);
        motion.a.as_mut().expect("given")[50] = vec![4.0 * sign; 3];
        let judgement = verdict(&jumping, &motion);
        assert!(judgement.valid, "{:?}", judgement.worst());
        assert!(judgement.between_samples.contains("3 intervals of a joint"), "{}", judgement.between_samples);
        motion.a = None;
        assert!(verdict(&jumping, &motion).valid);
    }
    let mut keys = keys;
    keys["continuity"] = json!("acceleration");
    let judgement = verdict(&scenario("continuous", keys), &table(&bang, 100.0, 3));
    assert_eq!(bounds(&judgement, Quantity::Acceleration).outcome, Outcome::Fail);
    assert_eq!(row(&judgement, Check::Continuity).outcome, Outcome::Fail);
}

/// Of cubics the jumps of the acceleration count as jerks.
#[test]
fn jumps_between_cubics_are_jerks() {
    let scenario = limited("cubics");
    // The acceleration rises by 1 at a jerk of 100 in each interval and falls back at the sample.
    let saw = |t: f64| [[t * t * t * 100.0 / 6.0; 3], [50.0 * t * t; 3], [0.0; 3]];
    let mut motion = table(&saw, 100.0, 2);
    let (mut q, mut v) = (0.0, 0.0);
    for k in 0..motion.times.len() {
        motion.q[k] = vec![q; 3];
        motion.v.as_mut().expect("given")[k] = vec![v; 3];
        let h = 0.01;
        q += v * h - 0.5 * 0.5 * h * h + 100.0 * h * h * h / 6.0;
        v += -0.5 * h + 50.0 * h * h;
    }
    let jerk = bounds(&verdict(&scenario, &motion), Quantity::Jerk).clone();
    assert_eq!(jerk.outcome, Outcome::Pass);
    let steep = jerk.worst.expect("it is limited").value.abs();
    assert!((steep - 100.0).abs() < 1e-6, "{steep}");
    let mut late = motion;
    // Another jump by 2 at one sample: 300 in the mean time of two halves.
    for k in 50..late.times.len() {
        let t = late.times[k] - 0.5;
        late.q[k].iter_mut().for_each(|q| *q -= t * t);
        late.v.as_mut().expect("given")[k].iter_mut().for_each(|v| *v -= 2.0 * t);
    }
    assert_eq!(bounds(&verdict(&scenario, &late), Quantity::Jerk).outcome, Outcome::Fail);
}
