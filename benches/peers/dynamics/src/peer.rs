//! Times of `dynibo`, which has values only.

use crate::{Result, State, time, under_gravity};
use aghf::dynamics::{Data, aba, crba, rnea};
use aghf::model::Model;
use dynibo::Robot;
use nalgebra::DMatrix;
use std::hint::black_box;
use std::path::Path;

/// The gravity of `dynibo`, m/s^2.
const GRAVITY: f64 = 9.80665;

/// Prints the times, after a check that `dynibo` finds what `aghf` does.
pub fn times(urdf: &Path, model: Model, states: &[State], seconds: f64) -> Result<()> {
    let mut robot = Robot::from_urdf(urdf)?;
    let own: Vec<State> = (states.iter()).map(|state| reorder(&model, &robot, state)).collect::<Result<_>>()?;
    check(&under_gravity(model, GRAVITY), &mut robot, states)?;
    let n = robot.joint_count();
    let (mut forces, mut matrix) = (vec![0.0; n], vec![0.0; n * n]);
    let found =
        time(&own, 1, seconds, |[q, v, a, _]| Ok(robot.inverse_dynamics(black_box(q), v, a, &[], &mut forces)?))?;
    println!("rnea single {found:.6}");
    let found = time(&own, 1, seconds, |[q, ..]| Ok(robot.mass_matrix(black_box(q), &mut matrix)?))?;
    println!("crba single {found:.6}");
    let found =
        time(&own, 1, seconds, |[q, v, _, tau]| Ok(robot.forward_dynamics(black_box(q), v, tau, &[], &mut forces)?))?;
    println!("aba single {found:.6}");
    Ok(())
}

/// For each joint of `dynibo` the one of the same name in the model.
fn order(model: &Model, robot: &Robot) -> Result<Vec<usize>> {
    (0..robot.joint_count())
        .map(|i| {
            let name = robot.joint_name(i)?;
            let mut joints = model.joints().iter();
            let found = joints.position(|joint| joint.name() == name);
            found.ok_or_else(|| format!("joint {name} is not in both").into())
        })
        .collect()
}

/// A state in the order of `dynibo`.
fn reorder(model: &Model, robot: &Robot, state: &State) -> Result<State> {
    let order = order(model, robot)?;
    Ok(std::array::from_fn(|part| order.iter().map(|i| state[part][*i]).collect()))
}

/// Fails if the two libraries do not agree.
fn check(model: &Model, robot: &mut Robot, states: &[State]) -> Result<()> {
    let n = model.dof();
    let order = order(model, robot)?;
    let mut data = Data::new(model);
    for state in states {
        let [q, v, a, tau] = state;
        let own = reorder(model, robot, state)?;
        let (mut ours, mut theirs) = (vec![0.0; n], vec![0.0; n]);
        let ordered = |values: &[f64]| -> Vec<f64> { order.iter().map(|i| values[*i]).collect() };
        rnea(model, &mut data, q, v, a, &mut ours)?;
        robot.inverse_dynamics(&own[0], &own[1], &own[2], &[], &mut theirs)?;
        compare("rnea", &ordered(&ours), &theirs)?;
        aba(model, &mut data, q, v, tau, &mut ours)?;
        robot.forward_dynamics(&own[0], &own[1], &own[3], &[], &mut theirs)?;
        compare("aba", &ordered(&ours), &theirs)?;
        let (mut h, mut matrix) = (DMatrix::zeros(n, n), vec![0.0; n * n]);
        crba(model, &mut data, q, &mut h)?;
        robot.mass_matrix(&own[0], &mut matrix)?;
        let h = h.select_rows(&order).select_columns(&order);
        compare("crba", h.as_slice(), &matrix)?;
    }
    Ok(())
}

/// Fails if two results differ by more than rounding.
fn compare(what: &str, ours: &[f64], theirs: &[f64]) -> Result<()> {
    let size = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |a: f64, b| a.max(b.abs()));
    let difference = size(&mut ours.iter().zip(theirs).map(|(a, b)| a - b));
    let relative = difference / size(&mut ours.iter().copied());
    if relative < 1e-8 {
        Ok(())
    } else {
        Err(format!("{what} of dynibo differs by {relative:e}, relative to the largest").into())
    }
}
