//! Motions of a small robot.

pub use crate::gantry::{FROM, TO, scenario};
use aghf::dynamics::{Data, rnea};
use aghf::model::Model;
use aghf_scenario::judge::{Check, Judgement, Row, Tolerances, Trajectory, Verdict, judge};
use aghf_scenario::{Quantity, Scenario};

/// The motion from rest to rest in 1 s by a polynomial of degree five, with the torques that it takes.
pub fn good(model: &Model, from: [f64; 3], to: [f64; 3], samples: usize) -> Trajectory {
    let times: Vec<f64> = (0..samples).map(|k| k as f64 / (samples - 1) as f64).collect();
    let way = |i: usize| to[i] - from[i];
    let table = |f: &dyn Fn(usize, f64) -> f64| -> Vec<Vec<f64>> {
        times.iter().map(|t| (0..3).map(|i| f(i, *t)).collect()).collect()
    };
    let q = table(&|i, t| from[i] + way(i) * t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t));
    let v = table(&|i, t| way(i) * 30.0 * (t * (1.0 - t)).powi(2));
    let a = table(&|i, t| way(i) * 60.0 * t * (1.0 - t) * (1.0 - 2.0 * t));
    let mut motion = Trajectory { times, q, v: Some(v), a: Some(a), u: None };
    motion.u = torques(model, &motion);
    motion
}

/// The torques of a motion.
pub fn torques(model: &Model, motion: &Trajectory) -> Option<Vec<Vec<f64>>> {
    let Trajectory { q, v, a, .. } = motion;
    let (v, a) = (v.as_ref()?, a.as_ref()?);
    let mut data = Data::new(model);
    let mut torque = |k: usize| {
        let mut u = vec![0.0; 3];
        rnea(model, &mut data, &q[k], &v[k], &a[k], &mut u).expect("three joints");
        u
    };
    Some((0..q.len()).map(&mut torque).collect())
}

pub fn verdict(scenario: &Scenario, trajectory: &Trajectory) -> Judgement {
    judge(scenario, trajectory, Tolerances::default()).expect("it is of this robot")
}

/// The checks that did not pass.
pub fn failed(judgement: &Judgement) -> Vec<Check> {
    let bad = |row: &&Row| !row.outcome.is_good();
    let failed: Vec<Check> = judgement.checks.iter().filter(bad).map(|row| row.check).collect();
    assert_eq!(judgement.verdict == Verdict::NotValid, !failed.is_empty());
    assert_eq!(judgement.valid, judgement.verdict == Verdict::Valid);
    failed
}

pub fn row(judgement: &Judgement, check: Check) -> &Row {
    let row = judgement.checks.iter().find(|row| row.check == check);
    row.expect("every check has a row")
}

/// The row of the bounds of a quantity.
pub fn bounds(judgement: &Judgement, of: Quantity) -> &Row {
    row(judgement, Check::Bounds(of))
}
