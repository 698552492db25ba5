//! The duration, the states at both ends, and rest there.

use super::checks::difference;
use super::intervals::CAUTION;
use super::poses::goal_row;
use super::{Check, Intervals, Outcome, Row, Trajectory, Worst, joint_name};
use crate::{Continuous, Quantity, Scenario};
use aghf::error::Result;

/// Checks the duration and the boundary states.
pub(super) fn boundary(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    tolerance: f64,
) -> Result<Vec<Row>> {
    let (file, duration) = (&scenario.file, trajectory.duration());
    let bounds = file.horizon_bounds();
    let mut horizon = Row::new(Check::Bounds(Quantity::Duration), tolerance);
    let whole = Worst::between(duration, bounds, "s", duration);
    horizon.take(whole, || "duration".to_owned());
    let mut rows = vec![horizon];
    for (end, [positions, velocities], [q, v]) in [
        (End::Start, [Check::StartPosition, Check::StartVelocity], [&file.q_start, &file.v_start]),
        (End::Goal, [Check::GoalPosition, Check::GoalVelocity], [&file.q_goal, &file.v_goal]),
    ] {
        let (k, s) = end.place(intervals);
        let found = intervals.at(0, k, s);
        let set = match end {
            End::Start => None,
            End::Goal => goal_row(scenario, &found, duration, tolerance)?,
        };
        rows.push(set.unwrap_or_else(|| {
            let mut row = Row::new(positions, tolerance);
            state(&mut row, scenario, (&found, q), Quantity::Position, intervals.time(k, s));
            row
        }));
        if velocities == Check::GoalVelocity && file.free_final_velocity {
            let outcome = Outcome::NotApplicable;
            rows.push(Row::without_value(velocities, tolerance, outcome, "it is free"));
            continue;
        }
        let mut row = Row::new(velocities, tolerance);
        state(&mut row, scenario, (&intervals.at(1, k, s), v), Quantity::Velocity, intervals.time(k, s));
        if intervals.is_derived() {
            derived_velocity(&mut row, intervals, end, (&trajectory.q, v));
        }
        rows.push(row);
    }
    Ok(rows)
}

/// An end of a motion.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Start,
    Goal,
}

impl End {
    /// The interval with this end, and the fraction of it.
    fn place(self, intervals: &Intervals) -> (usize, f64) {
        match self {
            Self::Start => (0, 0.0),
            Self::Goal => (intervals.joints.len() - 1, 1.0),
        }
    }
}

/// Takes the differences of a state of all joints from the one of the scenario.
fn state(row: &mut Row, scenario: &Scenario, (found, wanted): (&[f64], &[f64]), of: Quantity, at_s: f64) {
    for ((joint, found), wanted) in scenario.model.joints().iter().zip(found).zip(wanted) {
        let off = difference((found - wanted).abs(), of.unit(joint.kind()), at_s);
        row.take(off, || joint_name(joint));
    }
}

/// The outcome for a velocity at an end that is derived from positions `q`: it passes with its uncertainty, and fails
/// if accelerations as large as those of the three samples at this end do not explain the difference of the mean
/// velocity of its interval, otherwise it is not checked.
fn derived_velocity(row: &mut Row, intervals: &Intervals, end: End, (q, v): (&[Vec<f64>], &[f64])) {
    let (k, s) = end.place(intervals);
    let mut outcome = Outcome::Pass;
    for (i, wanted) in v.iter().enumerate() {
        let off = (intervals.joints[k][i].at(1, s) - wanted).abs();
        let error = intervals.error(1, k, i);
        let mean = |k: usize| (q[k + 1][i] - q[k][i]) / intervals.times[k][1];
        let beside = match end {
            End::Start => 1.min(intervals.joints.len() - 1),
            End::Goal => k.saturating_sub(1),
        };
        let explained = 2.0 * (mean(k) - mean(beside)).abs();
        let found = match off {
            off if off + error <= row.tolerance => Outcome::Pass,
            _ if (mean(k) - wanted).abs() > explained + CAUTION * error + row.tolerance => Outcome::Fail,
            _ => Outcome::NotChecked,
        };
        outcome = outcome.max(found);
    }
    row.outcome = outcome;
    if outcome == Outcome::NotChecked {
        row.note = Some("the positions alone do not determine it".to_owned());
    }
}

/// Checks that accelerations are continuous, and at the ends those that are given, or zero at rest.
pub(super) fn continuity(scenario: &Scenario, trajectory: &Trajectory, intervals: &Intervals, tolerance: f64) -> Row {
    let (check, file) = (Check::Continuity, &scenario.file);
    if file.continuity() == Continuous::Velocity {
        let note = "velocities are continuous between all samples";
        return Row::without_value(check, tolerance, Outcome::Pass, note);
    }
    if trajectory.v.is_some() && trajectory.a.is_none() {
        let note = "the table has no accelerations, and those of cubics jump";
        return Row::without_value(check, tolerance, Outcome::NotChecked, note);
    }
    let mut row = Row::new(check, tolerance);
    row.outcome = Outcome::Pass;
    for (end, wanted) in [End::Start, End::Goal].into_iter().zip(file.accelerations()) {
        let (k, s) = end.place(intervals);
        for (i, (joint, wanted)) in scenario.model.joints().iter().zip(wanted.iter().flatten()).enumerate() {
            let value = (intervals.joints[k][i].at(2, s) - wanted).abs();
            let (at_s, error) = (intervals.time(k, s), intervals.error(2, k, i));
            let off = difference(value, Quantity::Acceleration.unit(joint.kind()), at_s);
            let unsure = if intervals.is_derived() { f64::INFINITY } else { 0.0 };
            row.take_within(off, unsure, || joint_name(joint));
            if intervals.is_derived() && value + error > tolerance {
                row.leave(true, at_s);
            }
        }
    }
    row
}
