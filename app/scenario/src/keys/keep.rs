//! Conditions that are kept along the way.

use crate::{Goal, Scenario, ScenarioFile};
use aghf::constraint::{AnyConstraint, Constraint, PointSpeedLimit, StageConstraint, TimeWindow};
use aghf::error::{Error, Result, plain};
use aghf::model::Model;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The shortest time for which a condition is kept, relative to the horizon: within it a motion changes by about as
/// much as a condition may be exceeded.
const MIN_SHARE: f64 = 1e-6;

/// A condition that is kept along the way: a set of poses or a bound on a speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kept {
    /// The set of poses in which a frame stays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<Goal>,
    /// The largest speed of a point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<PointSpeed>,
    /// The time from which on it is kept, s; by default from the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// The time until which it is kept, s; by default until the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_s: Option<f64>,
}

/// The largest speed of a point of a frame in the base frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointSpeed {
    /// The name of the frame: a link.
    pub frame: String,
    /// The point in the frame, m; by default its origin.
    #[serde(default)]
    pub point_m: [f64; 3],
    /// The largest speed, m/s.
    pub most_m_s: f64,
}

/// The rows of all conditions: those that hold throughout, and those between given times.
pub(crate) type KeptRows = (Vec<AnyConstraint>, Vec<Arc<dyn StageConstraint>>);

impl Scenario {
    /// True if something without tolerance is kept throughout, such as a plane or a pose.
    pub(crate) fn keeps_poses_exactly(&self) -> bool {
        let rows = &self.own.constraints;
        (0..rows.dim()).any(|row| rows.row_set(row).is_equality)
    }

    /// The conditions that begin after the end of a motion, in words.
    pub(crate) fn not_reached(&self, end_s: f64) -> impl Iterator<Item = String> {
        let all = self.file.keep.iter().enumerate();
        all.filter_map(move |(i, kept)| {
            let from = kept.from_s.filter(|from| *from > end_s)?;
            let from = plain(from);
            Some(format!("keep[{i}] is not tested: the motion ends at {end_s:.4} s, and it is kept from {from} s on"))
        })
    }
}

/// The rows of all conditions; `path` names the scenario in errors.
pub(crate) fn kept_rows(file: &ScenarioFile, model: &Model, path: &str) -> Result<KeptRows> {
    let (mut state, mut stage) = KeptRows::default();
    for (i, kept) in file.keep.iter().enumerate() {
        let key = format!("keep[{i}]");
        let rows = kept.rows(model, &key, path)?;
        if kept.from_s.is_none() && kept.to_s.is_none() {
            state.extend(rows);
            continue;
        }
        kept.check_times(file, &key, path)?;
        let window = TimeWindow::new(model.clone(), rows, kept.times());
        let window = window.map_err(|e| Error::input(path, key, e.to_string()))?;
        stage.push(Arc::new(window) as Arc<dyn StageConstraint>);
    }
    Ok((state, stage))
}

impl Kept {
    /// The rows of the condition; `key` names it and `path` the scenario in errors.
    pub(crate) fn rows(&self, model: &Model, key: &str, path: &str) -> Result<Vec<AnyConstraint>> {
        match (&self.poses, &self.speed) {
            (Some(poses), None) => poses.rows(model, &format!("{key}.poses"), path),
            (None, Some(speed)) => Ok(vec![speed.row(model, key, path)?]),
            _ => {
                let condition = "one of the keys poses and speed is needed, not both";
                Err(Error::input(path, key, condition))
            }
        }
    }

    /// Refuses times between which the motion has no time, or less than can be resolved.
    fn check_times(&self, file: &ScenarioFile, key: &str, path: &str) -> Result<()> {
        let [_, longest] = file.horizon_bounds();
        let [from, to] = self.times();
        let (begin, end) = (from.max(0.0), to.min(longest));
        let least = MIN_SHARE * longest.min(file.horizon_s);
        if end - begin >= least {
            return Ok(());
        }
        let at =
            |time: Option<f64>, otherwise: &str| time.map_or(otherwise.to_owned(), |time| format!("{} s", plain(time)));
        let (from, to) = (at(self.from_s, "the start"), at(self.to_s, "the end"));
        let condition = format!(
            "it is kept from {from} to {to}, of which the motion, {} s at most, has less than {} s",
            plain(longest),
            plain(least)
        );
        Err(Error::input(path, key, condition))
    }

    /// The times between which it is kept, s.
    #[must_use]
    pub fn times(&self) -> [f64; 2] {
        let [from, to] = [self.from_s, self.to_s];
        [from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY)]
    }
}

impl PointSpeed {
    /// The row of the bound.
    fn row(&self, model: &Model, key: &str, path: &str) -> Result<AnyConstraint> {
        let refuse =
            |element: &str, condition: String| Err(Error::input(path, format!("{key}.speed.{element}"), condition));
        let frame = model.frames().iter().find(|frame| frame.name == self.frame);
        let Some(frame) = frame.filter(|frame| frame.body.is_some()) else {
            return refuse("frame", model.no_moving_link(&self.frame));
        };
        if !self.point_m.iter().all(|x| x.is_finite()) {
            return refuse("point_m", "it needs finite numbers".to_owned());
        }
        if !(self.most_m_s > 0.0 && self.most_m_s.is_finite()) {
            let condition = format!("it is {} and must be a positive number", plain(self.most_m_s));
            return refuse("most_m_s", condition);
        }
        let point = frame.placement.rotation * Vector3::from(self.point_m) + frame.placement.translation;
        Ok(AnyConstraint::Speed(PointSpeedLimit {
            body: frame.body,
            point,
            most: self.most_m_s,
            name: self.frame.clone(),
        }))
    }
}
