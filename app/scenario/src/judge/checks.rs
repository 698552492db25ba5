//! The checks joint by joint.

use super::ends::{boundary, continuity};
use super::intervals::{Bounded, CAUTION, Proof};
use super::rates::means;
use super::torques::torques;
use super::{Check, Intervals, Outcome, Row, Trajectory, Worst, joint_name};
use crate::{Quantity, Scenario, Scope};
use aghf::error::Result;

/// A difference with the bound zero.
pub(super) fn difference(value: f64, unit: &'static str, at_s: f64) -> Worst {
    Worst::between(value, [f64::NEG_INFINITY, 0.0], unit, at_s)
}

/// All checks but those of poses and clearances.
pub(super) fn by_joint(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    tolerance: f64,
) -> Result<Vec<Row>> {
    let mut rows = boundary(scenario, trajectory, intervals, tolerance)?;
    rows.push(continuity(scenario, trajectory, intervals, tolerance));
    rows.extend(consistency(scenario, trajectory, tolerance));
    rows.extend(torques(scenario, trajectory, intervals, tolerance)?);
    for limited in Quantity::JOINT.into_iter().filter_map(|of| Some((of, of.order()?))) {
        rows.push(limits(scenario, trajectory, intervals, limited, tolerance)?);
    }
    Ok(rows)
}

/// Checks that the velocities and accelerations of the table are the rates of its positions and velocities, except for
/// differences that accelerations like those of the neighbouring samples explain: of velocities an eighth of the
/// interval times the range of its accelerations, which is twice that of the samples or less, and of accelerations that
/// range.
///
/// The motion between the samples has all columns of the table, so that its limits hold without these checks. They find
/// the columns of two motions where there are no limits.
fn consistency(scenario: &Scenario, trajectory: &Trajectory, tolerance: f64) -> [Row; 2] {
    let Trajectory { times, q, v, a, .. } = trajectory;
    let mut rows = [(Check::VelocityIsRate, "v"), (Check::AccelerationIsRate, "a")].map(|(check, what)| {
        let note = format!("the table has no {what}");
        Row::without_value(check, tolerance, Outcome::NotApplicable, &note)
    });
    let Some(v) = v else { return rows };
    let intervals = times.len() - 1;
    let mean = |of: &[Vec<f64>], k: usize, i: usize| (of[k + 1][i] - of[k][i]) / (times[k + 1] - times[k]);
    for k in 0..intervals {
        let (first, last) = (k.saturating_sub(1), (k + 1).min(intervals - 1));
        let (interval, at_s) = (times[k + 1] - times[k], times[k] - times[0]);
        for (i, joint) in scenario.model.joints().iter().enumerate() {
            let ends = |of: &[Vec<f64>]| 0.5 * (of[k][i] + of[k + 1][i]);
            let given = |a: &Vec<Vec<f64>>| spread(a[first..=last + 1].iter().map(|a| a[i]));
            let range = a.as_ref().map(given);
            let range = range.unwrap_or_else(|| spread((first..=last).map(|k| mean(v, k, i))));
            let of_velocity = (mean(q, k, i) - ends(v), 0.25 * interval * range, Quantity::Velocity);
            let of_acceleration = |a: &Vec<_>| (mean(v, k, i) - ends(a), range, Quantity::Acceleration);
            let off = [Some(of_velocity), a.as_ref().map(of_acceleration)];
            for (row, off) in rows.iter_mut().zip(off) {
                let Some((off, explained, of)) = off else {
                    continue;
                };
                row.note = None;
                let off = difference(beyond(off.abs(), explained), of.unit(joint.kind()), at_s);
                row.take(off, || joint_name(joint));
            }
        }
    }
    rows
}

/// The range of numbers.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| (least.min(x), most.max(x)));
    most - least
}

/// The unexplained part of a difference; NaN stays NaN.
fn beyond(off: f64, explained: f64) -> f64 {
    let left = off - explained;
    if left < 0.0 { 0.0 } else { left }
}

/// The joints of which a quantity is limited, with the bounds and the scope.
pub(super) fn limits_of(scenario: &Scenario, quantity: Quantity) -> Vec<(usize, [f64; 2], Scope)> {
    let own = scenario.limits().into_iter().filter(|limit| limit.quantity == quantity);
    own.filter_map(|limit| Some((limit.index?, limit.bounds, limit.scope))).collect()
}

/// Checks the limits of a derivative of positions: by its Bernstein coefficients in each interval; the accelerations of
/// the table too; and for positions alone by their divided differences, which any motion through them has.
///
/// Where the acceleration jumps at a sample, as between cubics, the jump over the time between the middles of the two
/// intervals counts as jerk.
fn limits(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    (quantity, order): (Quantity, usize),
    tolerance: f64,
) -> Result<Row> {
    let mut proof = Proof::new(Row::new(Check::Bounds(quantity), tolerance), intervals);
    proof.derived &= order > 0;
    for (i, bounds, scope) in limits_of(scenario, quantity) {
        let Scope::Between(times) = scope else { continue };
        let joint = &scenario.model.joints()[i];
        let (unit, name) = (quantity.unit(joint.kind()), || joint_name(joint));
        let time = |k: usize| trajectory.times[k] - trajectory.times[0];
        if proof.derived {
            let q: Vec<f64> = trajectory.q.iter().map(|q| q[i]).collect();
            for (k, mean) in means(&trajectory.times, &q, order).into_iter().enumerate() {
                let error = intervals.error(order, (k + order / 2).min(intervals.joints.len() - 1), i);
                let worst = Worst::between(mean, bounds, unit, time(k));
                proof.row.take_within(worst, CAUTION * error, name);
            }
        }
        if let (Quantity::Acceleration, Some(a)) = (quantity, &trajectory.a) {
            for (k, a) in a.iter().enumerate() {
                proof.row.take(Worst::between(a[i], bounds, unit, time(k)), name);
            }
        }
        for (k, joints) in intervals.joints.iter().enumerate() {
            let error = if order > 0 { intervals.error(order, k, i) } else { 0.0 };
            let Some(part) = intervals.within(k, times) else { continue };
            proof.cover(k, part, |proof, part| {
                let [[least, most], [from, to]] = joints[i].bounds(order, part);
                let middle = joints[i].at(order, 0.5 * (part[0] + part[1]));
                let of = Bounded {
                    hull: [least - error, most + error],
                    values: [from, middle, to].map(|value| [value, error]),
                };
                Ok(proof.settles(k, part, &of, (bounds, unit), name))
            })?;
            if let (Quantity::Jerk, false, Some(next)) = (quantity, proof.derived, intervals.joints.get(k + 1)) {
                let jump = next[i].at(2, 0.0) - joints[i].at(2, 1.0);
                let between = 0.5 * (intervals.times[k][1] + intervals.times[k + 1][1]);
                let worst = Worst::between(jump / between, bounds, unit, time(k + 1));
                proof.row.take(worst, name);
            }
        }
    }
    if proof.row.worst.is_none() {
        proof.row.note = Some("none is enforced".to_owned());
    }
    Ok(proof.row)
}
