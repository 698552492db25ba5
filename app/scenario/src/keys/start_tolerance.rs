//! A start a little outside of the limits of positions, from which the motion returns.

use crate::keys::limits::limits_of_state;
use crate::{Quantity, Scenario, ScenarioFile};
use aghf::constraint::{StageConstraint, TimeWindow};
use aghf::error::{Error, Result, plain};
use aghf::model::Model;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The least distance from its limit at which a joint starts outside of it, rad or m: more than rounding.
const OUTSIDE: f64 = 1e-9;

/// The distance that a joint outside of its limit may go further out than it started, rad or m: more than the reserve
/// that a search keeps from a bound, which it cannot keep at the start.
const FURTHER: f64 = 5e-5;

/// The distance from the limits of positions at which a motion may start, and the time at which it is back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StartTolerance {
    /// The largest distance of a joint from its limit, rad or m; by default 1e-4, that of encoders. 0 accepts none.
    pub position: f64,
    /// The time, s, from which on the joint keeps its limit; until then it goes at most 5e-5 rad or m further out than
    /// it started. By default 0.25, or without the key half of `horizon_s` if that is shorter.
    pub back_s: f64,
}

impl Default for StartTolerance {
    fn default() -> Self {
        Self { position: 1e-4, back_s: 0.25 }
    }
}

impl ScenarioFile {
    /// Completes the tolerance of the start: that by default if a joint starts outside of its limit. Returns the limits
    /// of these joints from the time on at which they are back; `path` names the scenario.
    pub(crate) fn complete_start(&mut self, model: &Model, path: &str) -> Result<Option<Arc<dyn StageConstraint>>> {
        let refuse =
            |key: &str, condition: String| Err(Error::input(path, format!("start_tolerance.{key}"), condition));
        let default = StartTolerance::default();
        let shorter = StartTolerance { back_s: default.back_s.min(0.5 * self.horizon_s), ..default };
        let tolerance = self.start_tolerance.unwrap_or(shorter);
        if !(tolerance.position.is_finite() && tolerance.position >= 0.0) {
            return refuse("position", format!("it is {} and must be at least 0", plain(tolerance.position)));
        }
        if !(tolerance.back_s.is_finite() && tolerance.back_s > 0.0) {
            return refuse("back_s", format!("it is {} and must be positive", plain(tolerance.back_s)));
        }
        let given = self.start_tolerance.replace(tolerance);
        let limit = |of: Quantity, joint: usize| {
            let is_outside = of == Quantity::Position && self.bound_at_start(model, joint).is_some();
            if is_outside { self.enforced_limits.bound(model, of, joint) } else { None }
        };
        let limits = limits_of_state(model.dof(), limit);
        if given.is_none() && (limits.is_empty() || !self.phases.is_empty()) {
            self.start_tolerance = None;
            return Ok(None);
        }
        if tolerance.back_s >= self.horizon_s {
            let (back, horizon) = (plain(tolerance.back_s), plain(self.horizon_s));
            return refuse("back_s", format!("it is {back} s, and horizon_s is {horizon} s"));
        }
        if limits.is_empty() {
            return Ok(None);
        }
        let window = TimeWindow::new(model.clone(), limits, [tolerance.back_s, f64::INFINITY])?;
        Ok(Some(Arc::new(window)))
    }

    /// The bounds on the position of a joint that starts outside of its limit, until it is back: those of the limit,
    /// and its position at the start. `None` if it starts within its limit, or beyond the tolerance.
    fn bound_at_start(&self, model: &Model, joint: usize) -> Option<[f64; 2]> {
        let [lower, upper] = self.enforced_limits.bound(model, Quantity::Position, joint)?;
        let q = *self.q_start.get(joint)?;
        let off = (lower - q).max(q - upper);
        let is_outside = off > OUTSIDE && off <= self.start_tolerance?.position;
        is_outside.then(|| [lower.min(q - FURTHER), upper.max(q + FURTHER)])
    }
}

impl Scenario {
    /// The limit of the position of a joint that starts outside of it, and the time at which the joint is back, s.
    pub(crate) fn bound_when_back(&self, joint: usize) -> Option<([f64; 2], f64)> {
        self.bound_at_start(joint)?;
        Some((self.bound(Quantity::Position, joint)?, self.file.start_tolerance?.back_s))
    }

    /// The distance of a joint from its limit at the start, rad or m, and the time at which it is back, s; `None` if it
    /// starts within its limit.
    fn way_back(&self, joint: usize) -> Option<(f64, f64)> {
        let ([lower, upper], back) = self.bound_when_back(joint)?;
        let q = self.file.q_start[joint];
        Some(((lower - q).max(q - upper), back))
    }

    /// The bounds on the position of a joint that starts outside of its limit, at all times; `None` of another joint.
    pub(crate) fn bound_at_start(&self, joint: usize) -> Option<[f64; 2]> {
        self.file.bound_at_start(&self.model, joint)
    }

    /// Refuses a start from which a joint is not back in time at its velocity limit.
    pub(crate) fn check_way_back(&self) -> Result<()> {
        for (i, joint) in self.model.joints().iter().enumerate() {
            let Some((way, back)) = self.way_back(i) else {
                continue;
            };
            let [_, most] = self.bound(Quantity::Velocity, i).unwrap_or([f64::INFINITY; 2]);
            let least = way / most;
            if least > back {
                let (name, [least, back]) = (joint.name(), [least, back].map(plain));
                let condition =
                    format!("it is {back} s, and joint '{name}' is within its limit after {least} s at least");
                return Err(Error::input(&self.name, "start_tolerance.back_s", condition));
            }
        }
        Ok(())
    }

    /// The joints that start outside of their limits, in words.
    pub(crate) fn notes_on_start(&self) -> impl Iterator<Item = String> + use<'_> {
        self.model.joints().iter().enumerate().filter_map(|(i, joint)| {
            let (way, back) = self.way_back(i)?;
            let (name, unit) = (joint.name(), Quantity::Position.unit(joint.kind()));
            Some(format!(
                "q_start: joint '{name}' is {way:.1e} {unit} outside of its limit, and within it from {back} s on"
            ))
        })
    }
}
