//! The joints without a motor, and the residual torque of a motion at these joints.

use crate::{Scenario, ScenarioFile};
use aghf::curve::Curve;
use aghf::error::{Error, Result};
use aghf::model::Model;
use aghf::motion::sample;

/// The key of a scenario.
const KEY: &str = "passive";

/// The largest torque of a passive joint in a success, relative to the largest torque of the motion.
///
/// A polynomial satisfies the equality $u_i = 0$ at as many times as it has free coefficients; the residual between
/// these times decreases with the degree and the number of segments. With this value the forward simulation, in which
/// passive joints have no torque at all, stays near the motion.
pub const PASSIVE_TORQUE_SHARE: f64 = 1e-3;

/// Refuses invalid names of passive joints for `model`, the robot without its locked joints. `path` names the scenario.
pub(crate) fn check_passive(file: &ScenarioFile, model: &Model, path: &str) -> Result<()> {
    let refuse = |key: String, condition: String| Err(Error::input(path, key, condition));
    for (i, name) in file.passive.iter().enumerate() {
        let key = format!("{KEY}[{i}]");
        if file.locked_joints.contains_key(name) {
            let condition = format!("joint '{name}' is locked; a joint that does not move needs no motor");
            return refuse(key, condition);
        }
        if model.joints().iter().all(|joint| joint.name() != name) {
            return refuse(key, model.no_moving_joint(name));
        }
        if file.passive[..i].contains(name) {
            return refuse(key, format!("joint '{name}' is named twice"));
        }
    }
    if file.passive.len() == model.dof() {
        let condition = "every joint that moves is passive, at least one has to have a motor";
        return refuse(KEY.to_owned(), condition.to_owned());
    }
    Ok(())
}

impl Scenario {
    /// The indices of the joints without a motor, ascending. Cost O(N^2).
    #[must_use]
    pub fn passive(&self) -> Vec<usize> {
        (0..self.model.dof()).filter(|i| self.is_passive(*i)).collect()
    }

    /// Returns true if joint `joint` has no motor.
    pub(crate) fn is_passive(&self, joint: usize) -> bool {
        let joint = self.model.joints().get(joint);
        joint.is_some_and(|joint| self.file.passive.iter().any(|name| name == joint.name()))
    }
}

/// The contribution of the torques of these joints to $\int |u|^2 dt$, by the trapezoidal rule on `intervals`
/// intervals.
///
/// # Errors
/// The robot of the curve has another number of joints.
pub fn effort_of_joints(model: &Model, curve: &Curve, joints: &[usize], intervals: usize) -> Result<f64> {
    if joints.is_empty() {
        return Ok(0.0);
    }
    let squares: Vec<f64> =
        sample(model, curve, intervals)?.iter().map(|at| joints.iter().map(|i| at.u[*i] * at.u[*i]).sum()).collect();
    let pairs = squares.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    Ok(pairs.sum::<f64>() * curve.horizon() / intervals as f64)
}
