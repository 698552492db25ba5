//! Torques and forces of the joints.

use super::checks::{difference, limits_of};
use super::intervals::{Bounded, Measured, Proof};
use super::{Check, Intervals, Outcome, Row, Trajectory, Worst, joint_name};
use crate::{Quantity, Scenario, Scope};
use aghf::dynamics::{Data, rnea};
use aghf::error::Result;
use aghf::scalar::Zero;

/// Checks the torques against inverse dynamics, against zero and against their limits, and the powers against theirs.
pub(super) fn torques(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    share: f64,
) -> Result<Vec<Row>> {
    let (mut largest, mut power) = (0.0_f64, 0.0_f64);
    at_places(scenario, intervals, |[v, torques], _| {
        largest = torques.iter().fold(largest, |largest, torque| largest.max(torque.abs()));
        let powers = torques.iter().zip(v);
        power = powers.fold(power, |most, (torque, v)| most.max((torque * v).abs()));
    })?;
    let tolerance = share * largest;
    Ok(vec![
        dynamics(scenario, trajectory, tolerance)?,
        passive(scenario, trajectory, intervals, tolerance)?,
        limits(scenario, trajectory, intervals, Quantity::Torque, tolerance)?,
        limits(scenario, trajectory, intervals, Quantity::Power, share * power)?,
    ])
}

/// Passes velocities and torques at the ends and in the middle of every interval on, with the time after the start, s.
fn at_places(scenario: &Scenario, intervals: &Intervals, mut take: impl FnMut([&[f64]; 2], f64)) -> Result<()> {
    let model = &scenario.model;
    let (mut data, mut torques) = (Data::new(model), vec![0.0; model.dof()]);
    for k in 0..intervals.joints.len() {
        for s in [0.0, 0.5, 1.0] {
            let [q, v, a] = [0, 1, 2].map(|order| intervals.at(order, k, s));
            rnea(model, &mut data, &q, &v, &a, &mut torques)?;
            take([&v, &torques], intervals.time(k, s));
        }
    }
    Ok(())
}

/// Compares the torques of the table with those of inverse dynamics from its positions, velocities and accelerations.
fn dynamics(scenario: &Scenario, trajectory: &Trajectory, tolerance: f64) -> Result<Row> {
    let (check, model) = (Check::Dynamics, &scenario.model);
    let Trajectory { times, q, v, a, u } = trajectory;
    let (Some(v), Some(a), Some(u)) = (v, a, u) else {
        let (outcome, what) = match u {
            None => (Outcome::NotApplicable, "u"),
            Some(_) => (Outcome::NotChecked, "a"),
        };
        let note = format!("the table has no {what}");
        return Ok(Row::without_value(check, tolerance, outcome, &note));
    };
    let mut row = Row::new(check, tolerance);
    let (mut data, mut inverse) = (Data::new(model), vec![0.0; model.dof()]);
    for k in 0..times.len() {
        rnea(model, &mut data, &q[k], &v[k], &a[k], &mut inverse)?;
        for (i, joint) in model.joints().iter().enumerate() {
            let off = (u[k][i] - inverse[i]).abs();
            let off = difference(off, Quantity::Torque.unit(joint.kind()), times[k] - times[0]);
            row.take(off, || joint_name(joint));
        }
    }
    Ok(row)
}

/// Compares the torques of passive joints with zero.
fn passive(scenario: &Scenario, trajectory: &Trajectory, intervals: &Intervals, tolerance: f64) -> Result<Row> {
    let mut row = Row::new(Check::Bounds(Quantity::Passive), tolerance);
    let (joints, passive) = (scenario.model.joints(), scenario.passive());
    if passive.is_empty() {
        row.note = Some("there are none".to_owned());
        return Ok(row);
    }
    let mut take = |torques: &[f64], at_s: f64| {
        for i in &passive {
            let off = difference(torques[*i].abs(), Quantity::Torque.unit(joints[*i].kind()), at_s);
            row.take(off, || joint_name(&joints[*i]));
        }
    };
    for (t, u) in trajectory.times.iter().zip(trajectory.u.iter().flatten()) {
        take(u, t - trajectory.times[0]);
    }
    at_places(scenario, intervals, |[_, torques], at_s| take(torques, at_s))?;
    row.note = Some("at the samples and halfway between them".to_owned());
    if intervals.is_derived() {
        row.outcome = Outcome::NotChecked;
        row.note = Some("the positions alone do not determine it".to_owned());
    }
    Ok(row)
}

/// Checks the limits of torques, or of powers, at all times: those of the table, and of inverse dynamics.
fn limits(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    quantity: Quantity,
    tolerance: f64,
) -> Result<Row> {
    let mut row = Row::new(Check::Bounds(quantity), tolerance);
    let model = &scenario.model;
    let limited = limits_of(scenario, quantity);
    if limited.is_empty() {
        row.note = Some("none is enforced".to_owned());
        return Ok(row);
    }
    let unit = |i: usize| quantity.unit(model.joints()[i].kind());
    let is_power = quantity == Quantity::Power;
    let table = trajectory.u.iter().flatten().enumerate();
    for (k, u) in table.filter(|_| !is_power || trajectory.v.is_some()) {
        for (i, bounds, _) in &limited {
            let value = match &trajectory.v {
                Some(v) if is_power => u[*i] * v[k][*i],
                _ => u[*i],
            };
            let worst = Worst::between(value, *bounds, unit(*i), trajectory.times[k] - trajectory.times[0]);
            row.take(worst, || joint_name(&model.joints()[*i]));
        }
    }
    let mut proof = Proof::new(row, intervals);
    let (mut data, mut torques) = (Data::new(model), vec![Zero::zero(); model.dof()]);
    let throughout = [f64::NEG_INFINITY, f64::INFINITY];
    proof.enclose(
        throughout,
        |joint| format!("joint '{joint}'"),
        |[q, v, a]| {
            rnea(model, &mut data, q, v, a, &mut torques)?;
            let measured = |(i, bounds, _): &(usize, [f64; 2], Scope)| Measured {
                of: Bounded::of(&if is_power { torques[*i] * v[*i] } else { torques[*i] }),
                bounds: *bounds,
                unit: unit(*i),
                place: model.joints()[*i].name(),
            };
            Ok(limited.iter().map(measured).collect())
        },
    )?;
    Ok(proof.row)
}
