//! The keys of a scenario that say what the relaxation is to find, beside a motion of least effort from state to state.

use super::{Method, Scenario, ScenarioFile, SolveOptions};
use crate::error::{Error, Result};
use crate::relax::{FreeHorizon, WeightedSquares};
use serde::{Deserialize, Serialize};

/// The weights of a running cost $\sum_i w^u_i u_i^2 + w^v_i v_i^2 + w^a_i a_i^2$.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunningCostWeights {
    /// Of squared torques or forces, one unless said.
    pub torque: PerJoint,
    /// Of squared velocities, zero unless said.
    pub velocity: PerJoint,
    /// Of squared accelerations, zero unless said.
    pub acceleration: PerJoint,
}

impl Default for RunningCostWeights {
    /// The control effort.
    fn default() -> Self {
        Self {
            torque: PerJoint::Same(1.0),
            velocity: PerJoint::Same(0.0),
            acceleration: PerJoint::Same(0.0),
        }
    }
}

impl RunningCostWeights {
    /// The cost of a robot with `dof` joints.
    ///
    /// # Errors
    /// As [`WeightedSquares::new`].
    pub fn weighted(&self, dof: usize) -> Result<WeightedSquares> {
        let [torque, velocity, acceleration] = [&self.torque, &self.velocity, &self.acceleration]
            .map(|weights| match weights {
                PerJoint::Same(weight) => vec![*weight; dof],
                PerJoint::Each(weights) => weights.clone(),
            });
        WeightedSquares::new(dof, torque, velocity, acceleration)
    }
}

/// A number for each joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "a number is needed, or a list with one for each joint"
)]
pub enum PerJoint {
    /// The same for all.
    Same(f64),
    /// One after the other.
    Each(Vec<f64>),
}

/// Between what bounds a horizon is found, and what it costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HorizonBounds {
    /// The shortest there may be.
    pub shortest_s: f64,
    /// The longest.
    pub longest_s: f64,
    /// The price of a second.
    pub weight: f64,
}

impl From<HorizonBounds> for FreeHorizon {
    fn from(bounds: HorizonBounds) -> Self {
        Self {
            shortest: bounds.shortest_s,
            longest: bounds.longest_s,
            weight: bounds.weight,
        }
    }
}

/// Refuses keys of this file that make no sense for a robot with `dof` joints. `path` names the scenario.
pub(super) fn check_objective(file: &ScenarioFile, dof: usize, path: &str) -> Result<()> {
    let named = |error: Error, key: &dyn Fn(&str) -> String| match error {
        Error::Input {
            element, condition, ..
        } => Error::input(path, key(&element), condition),
        other => other,
    };
    if let Some(weights) = &file.running_cost {
        let key = |element: &str| match element {
            "all" => "running_cost".to_owned(),
            _ => format!("running_cost.{element}"),
        };
        weights.weighted(dof).map_err(|error| named(error, &key))?;
    }
    if let Some(bounds) = file.free_horizon {
        let key = |element: &str| match element {
            "free_horizon.weight" => element.to_owned(),
            bound => format!("{bound}_s"),
        };
        let checked = FreeHorizon::from(bounds).check(file.horizon_s);
        checked.map_err(|error| named(error, &key))?;
    }
    Ok(())
}

impl Scenario {
    /// The keys of this scenario that a method does not look at, in words.
    pub(super) fn notes(&self, options: &SolveOptions) -> Vec<String> {
        let mut notes = Vec::new();
        let published = options.method == Method::Flow && !options.flows_to_rest();
        if published && self.file.running_cost.is_some() {
            let note = "running_cost: the published flow minimises the control effort alone";
            notes.push(note.to_owned());
        }
        notes
    }

    /// Refuses what a flow cannot be asked for: what only the relaxation knows, and passive joints unless it goes to rest.
    pub(super) fn check_for_flow(&self, to_rest: bool) -> Result<()> {
        let file = &self.file;
        let keys = [
            ("free_final_velocity", file.free_final_velocity),
            ("free_horizon", file.free_horizon.is_some()),
            ("running cost of one's own", self.own.running_cost.is_some()),
        ];
        if let Some((key, _)) = keys.iter().find(|(_, given)| *given) {
            let condition = "the method 'flow' does not know it, only 'relax' does";
            return Err(Error::input(&self.name, *key, condition));
        }
        if !to_rest && !file.passive.is_empty() {
            let condition =
                "the published flow does not know it; the variants 'duals' and 'two-phases' do";
            return Err(Error::input(&self.name, "passive", condition));
        }
        Ok(())
    }
}
