//! The checks joint by joint.

use super::poses::goal_row;
use super::{Check, Intervals, Row, Trajectory, Worst, joint_name, unit_of};
use crate::{Limit, Scenario};
use aghf::dynamics::{Data, rnea};
use aghf::error::Result;

const POSITION: [&str; 2] = ["rad", "m"];
const VELOCITY: [&str; 2] = ["rad/s", "m/s"];
const ACCELERATION: [&str; 2] = ["rad/s^2", "m/s^2"];
const JERK: [&str; 2] = ["rad/s^3", "m/s^3"];
const TORQUE: [&str; 2] = ["N m", "N"];

/// A difference with the bound zero.
fn difference(value: f64, unit: &'static str, at_s: f64) -> Worst {
    Worst::between(value, [f64::NEG_INFINITY, 0.0], unit, at_s)
}

/// All checks but those of clearances.
pub(super) fn by_joint(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    tolerance: f64,
) -> Result<Vec<Row>> {
    let mut rows = boundary(scenario, trajectory, tolerance)?;
    rows.extend(consistency(scenario, trajectory, tolerance));
    rows.extend(torques(scenario, trajectory, intervals, tolerance)?);
    rows.extend(limits(scenario, intervals, tolerance));
    rows.extend(rates(scenario, trajectory, tolerance));
    Ok(rows)
}

/// Checks the duration and the boundary states.
fn boundary(scenario: &Scenario, trajectory: &Trajectory, tolerance: f64) -> Result<Vec<Row>> {
    let (file, duration) = (&scenario.file, trajectory.duration());
    let bounds = match scenario.horizon_bounds() {
        Some(free) => [free.shortest_s, free.longest_s],
        None => [file.horizon_s; 2],
    };
    let mut horizon = Row::new(Check::Horizon, tolerance);
    let whole = Worst::between(duration, bounds, "s", duration);
    horizon.take(whole, || "duration".to_owned());
    let mut rows = vec![horizon];
    let last = trajectory.times.len() - 1;
    let states = [
        (
            Check::StartPosition,
            POSITION,
            &trajectory.q[0],
            &file.q_start,
            0.0,
        ),
        (
            Check::StartVelocity,
            VELOCITY,
            &trajectory.v[0],
            &file.v_start,
            0.0,
        ),
        (
            Check::GoalPosition,
            POSITION,
            &trajectory.q[last],
            &file.q_goal,
            duration,
        ),
        (
            Check::GoalVelocity,
            VELOCITY,
            &trajectory.v[last],
            &file.v_goal,
            duration,
        ),
    ];
    for (check, units, found, wanted, at_s) in states {
        if check == Check::GoalVelocity && file.free_final_velocity {
            rows.push(Row::not_checked(check, tolerance, "it is free"));
            continue;
        }
        let mut row = Row::new(check, tolerance);
        if check == Check::GoalPosition
            && let Some(row) = goal_row(scenario, found, at_s, tolerance)?
        {
            rows.push(row);
            continue;
        }
        for ((joint, found), wanted) in scenario.model.joints().iter().zip(found).zip(wanted) {
            let off = difference((found - wanted).abs(), unit_of(joint, units), at_s);
            row.take(off, || joint_name(joint));
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Checks that velocities and accelerations are the rates of positions and velocities.
fn consistency(scenario: &Scenario, trajectory: &Trajectory, tolerance: f64) -> Vec<Row> {
    let Trajectory { times, q, v, a, .. } = trajectory;
    let intervals = times.len() - 1;
    // The mean rate of joint i on interval k.
    let mean =
        |of: &[Vec<f64>], k: usize, i: usize| (of[k + 1][i] - of[k][i]) / (times[k + 1] - times[k]);
    let spread = |values: &mut dyn Iterator<Item = f64>| {
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| {
            (least.min(x), most.max(x))
        });
        most - least
    };
    let mut rates = Row::new(Check::VelocityIsRate, tolerance);
    let mut second = Row::new(Check::AccelerationIsRate, tolerance);
    for k in 0..intervals {
        let first = k.saturating_sub(1).min(intervals.saturating_sub(3));
        let last = (first + 2).min(intervals - 1);
        let (interval, at_s) = (times[k + 1] - times[k], times[k] - times[0]);
        for (i, joint) in scenario.model.joints().iter().enumerate() {
            let name = || joint_name(joint);
            let ends = |of: &[Vec<f64>]| 0.5 * (of[k][i] + of[k + 1][i]);
            if trajectory.has_velocities {
                let off = (mean(q, k, i) - ends(v)).abs();
                let explained =
                    0.125 * interval * spread(&mut (first..=last).map(|k| mean(v, k, i)));
                let unit = unit_of(joint, VELOCITY);
                rates.take(difference(beyond(off, explained), unit, at_s), name);
            }
            if trajectory.has_accelerations {
                let off = (mean(v, k, i) - ends(a)).abs();
                // At a jump inside the interval, the acceleration extrapolated from each side.
                let before = (k > 0).then(|| 2.0 * a[k][i] - a[k - 1][i]);
                let after = (k + 1 < intervals).then(|| 2.0 * a[k + 1][i] - a[k + 2][i]);
                let led = [before, after].into_iter().flatten();
                let samples = (first..=last + 1).map(|k| a[k][i]);
                let explained = 0.5 * spread(&mut samples.chain(led));
                let unit = unit_of(joint, ACCELERATION);
                second.take(difference(beyond(off, explained), unit, at_s), name);
            }
        }
    }
    if !trajectory.has_velocities {
        rates = Row::not_checked(Check::VelocityIsRate, tolerance, "v is derived from q");
    }
    if !trajectory.has_accelerations {
        second = Row::not_checked(Check::AccelerationIsRate, tolerance, "a is derived from v");
    }
    vec![rates, second]
}

/// The unexplained part of a difference; NaN stays NaN.
fn beyond(off: f64, explained: f64) -> f64 {
    let left = off - explained;
    if left < 0.0 { 0.0 } else { left }
}

/// Checks the torques against inverse dynamics, against zero and against their limits.
fn torques(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    share: f64,
) -> Result<Vec<Row>> {
    let model = &scenario.model;
    let Trajectory {
        times, q, v, a, u, ..
    } = trajectory;
    let (mut data, mut torque) = (Data::new(model), vec![0.0; model.dof()]);
    let mut inverse = Vec::with_capacity(times.len());
    for k in 0..times.len() {
        rnea(model, &mut data, &q[k], &v[k], &a[k], &mut torque)?;
        inverse.push((times[k] - times[0], torque.clone()));
    }
    let all = inverse.iter().flat_map(|(_, torque)| torque);
    let tolerance = share * all.fold(0.0, |largest: f64, torque| largest.max(torque.abs()));
    let mut dynamics = Row::new(Check::Dynamics, tolerance);
    let mut passive = Row::new(Check::PassiveJoints, tolerance);
    let mut limits = Row::new(Check::TorqueLimits, tolerance);
    let passive_joints = scenario.passive();
    let mut bound = |torque: &[f64], at_s: f64| {
        for (i, joint) in model.joints().iter().enumerate() {
            let (unit, name) = (unit_of(joint, TORQUE), || joint_name(joint));
            if passive_joints.contains(&i) {
                passive.take(difference(torque[i].abs(), unit, at_s), name);
            } else if let Some(bounds) = scenario.bound(Limit::Torque, i) {
                limits.take(Worst::between(torque[i], bounds, unit, at_s), name);
            }
        }
    };
    for (k, (at_s, inverse)) in inverse.iter().enumerate() {
        bound(inverse, *at_s);
        let Some(u) = u else { continue };
        bound(&u[k], *at_s);
        for (i, joint) in model.joints().iter().enumerate() {
            let off = difference((u[k][i] - inverse[i]).abs(), unit_of(joint, TORQUE), *at_s);
            dynamics.take(off, || joint_name(joint));
        }
    }
    for (k, cubics) in intervals.cubics.iter().enumerate() {
        let [q, v, a]: [Vec<f64>; 3] = [
            cubics.iter().map(|c| c.position(0.5)).collect(),
            cubics.iter().map(|c| c.velocity(0.5)).collect(),
            cubics.iter().map(|c| c.acceleration(0.5)).collect(),
        ];
        rnea(model, &mut data, &q, &v, &a, &mut torque)?;
        bound(&torque, intervals.time(k, 0.5));
    }
    if u.is_none() {
        dynamics = Row::not_checked(Check::Dynamics, tolerance, "u is derived");
    }
    if passive_joints.is_empty() {
        passive.note = Some("there are none".to_owned());
    }
    note_unlimited(&mut limits);
    Ok(vec![dynamics, passive, limits])
}

/// Checks the limits of positions and velocities.
fn limits(scenario: &Scenario, intervals: &Intervals, tolerance: f64) -> Vec<Row> {
    let mut position = Row::new(Check::PositionLimits, tolerance);
    let mut velocity = Row::new(Check::VelocityLimits, tolerance);
    for (i, joint) in scenario.model.joints().iter().enumerate() {
        let bound = |limit| scenario.bound(limit, i);
        let name = || joint_name(joint);
        for (k, cubics) in intervals.cubics.iter().enumerate() {
            let cubic = &cubics[i];
            let ends = [Some(0.0), Some(1.0)];
            if let Some(bounds) = bound(Limit::Position) {
                for s in ends.into_iter().chain(cubic.turns()).flatten() {
                    let (q, unit) = (cubic.position(s), unit_of(joint, POSITION));
                    position.take(Worst::between(q, bounds, unit, intervals.time(k, s)), name);
                }
            }
            if let Some(bounds) = bound(Limit::Velocity) {
                for s in ends
                    .into_iter()
                    .chain([cubic.fastest([0.0, 1.0])])
                    .flatten()
                {
                    let (v, unit) = (cubic.velocity(s), unit_of(joint, VELOCITY));
                    velocity.take(Worst::between(v, bounds, unit, intervals.time(k, s)), name);
                }
            }
        }
    }
    note_unlimited(&mut position);
    note_unlimited(&mut velocity);
    vec![position, velocity]
}

/// Checks the limits of accelerations at the samples, and those of jerks by the mean between two samples, which is the
/// jerk at some time between.
fn rates(scenario: &Scenario, trajectory: &Trajectory, tolerance: f64) -> Vec<Row> {
    let mut acceleration = Row::new(Check::AccelerationLimits, tolerance);
    let mut jerk = Row::new(Check::JerkLimits, tolerance);
    let Trajectory { times, a, .. } = trajectory;
    for (i, joint) in scenario.model.joints().iter().enumerate() {
        let name = || joint_name(joint);
        if let Some(bounds) = scenario.bound(Limit::Acceleration, i) {
            for (t, a) in times.iter().zip(a) {
                let worst = Worst::between(a[i], bounds, unit_of(joint, ACCELERATION), *t);
                acceleration.take(worst, name);
            }
        }
        if let Some(bounds) = scenario.bound(Limit::Jerk, i) {
            for (t, a) in times.windows(2).zip(a.windows(2)) {
                let mean = (a[1][i] - a[0][i]) / (t[1] - t[0]);
                jerk.take(
                    Worst::between(mean, bounds, unit_of(joint, JERK), t[0]),
                    name,
                );
            }
        }
    }
    note_unlimited(&mut acceleration);
    note_unlimited(&mut jerk);
    vec![acceleration, jerk]
}

fn note_unlimited(row: &mut Row) {
    if row.worst.is_none() {
        row.note = Some("none is enforced".to_owned());
    }
}
