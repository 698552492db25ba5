//! A start a little outside of the limits of positions, from which the motion returns.

use crate::{Quantity, Scenario, ScenarioFile, Scope};
use aghf::constraint::{AnyConstraint, Bound, Bounds, Side, StageConstraint, TimeWindow};
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
        let outside: Vec<_> = (0..model.dof()).filter(|joint| self.bound_at_start(model, *joint).is_some()).collect();
        if given.is_none() && (outside.is_empty() || !self.phases.is_empty()) {
            self.start_tolerance = None;
            return Ok(None);
        }
        if tolerance.back_s >= self.horizon_s {
            let (back, horizon) = (plain(tolerance.back_s), plain(self.horizon_s));
            return refuse("back_s", format!("it is {back} s, and horizon_s is {horizon} s"));
        }
        if outside.is_empty() {
            return Ok(None);
        }
        let sides = outside.into_iter().flat_map(|entry| {
            let bounds = self.enforced_limits.bound(model, Quantity::Position, entry).into_iter().flatten();
            let sides = [Side::Lower, Side::Upper].into_iter().zip(bounds);
            sides.map(move |(side, value)| Bound { entry, side, value })
        });
        let rows = vec![AnyConstraint::Bounds(Bounds(sides.filter(|bound| bound.value.is_finite()).collect()))];
        let window = TimeWindow::new(model.clone(), rows, [tolerance.back_s, f64::INFINITY])?;
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
    /// The limit of the position of a joint that starts outside of it, with the times from when it is back.
    pub(crate) fn bound_when_back(&self, joint: usize) -> Option<([f64; 2], Scope)> {
        self.bound_at_start(joint)?;
        let own = self.file.enforced_limits.bound(&self.model, Quantity::Position, joint)?;
        Some((own, Scope::Between([self.file.start_tolerance?.back_s, f64::INFINITY])))
    }

    /// The bounds on the position of a joint that starts outside of its limit, at all times; `None` of another joint.
    pub(crate) fn bound_at_start(&self, joint: usize) -> Option<[f64; 2]> {
        self.file.bound_at_start(&self.model, joint)
    }

    /// Refuses a start from which a joint is not back in time at its velocity limit.
    pub(crate) fn check_way_back(&self) -> Result<()> {
        for (i, joint) in self.model.joints().iter().enumerate() {
            let (Some(([lower, upper], _)), Some(start)) = (self.bound_when_back(i), self.file.start_tolerance) else {
                continue;
            };
            let q = self.file.q_start[i];
            let [_, most] = self.bound(Quantity::Velocity, i).unwrap_or([f64::INFINITY; 2]);
            let least = (lower - q).max(q - upper) / most;
            if least > start.back_s {
                let (name, [least, back]) = (joint.name(), [least, start.back_s].map(plain));
                let condition =
                    format!("it is {back} s, and joint '{name}' is within its limit after {least} s at least");
                return Err(Error::input(&self.name, "start_tolerance.back_s", condition));
            }
        }
        Ok(())
    }

    /// The joints that start outside of their limits, in words.
    pub(crate) fn notes_on_start(&self) -> impl Iterator<Item = String> + use<'_> {
        let joints = self.model.joints().iter().zip(&self.file.q_start).enumerate();
        joints.filter_map(|(i, (joint, q))| {
            let ([lower, upper], scope) = self.bound_when_back(i)?;
            let Scope::Between([back, _]) = scope else { return None };
            let (name, unit, off) = (joint.name(), Quantity::Position.unit(joint.kind()), (lower - q).max(q - upper));
            Some(format!(
                "q_start: joint '{name}' is {off:.1e} {unit} outside of its limit, and within it from {back} s on"
            ))
        })
    }
}
