//! A goal that is a set of poses of a frame.

use crate::keys::obstacles::{Pose, bounded};
use crate::solve::custom_terms::worst_row;
use crate::{Scenario, ScenarioFile};
use aghf::constraint::{AnyConstraint, FrameRows, RowLabel};
use aghf::direct::{GoalEnd, GoalSet};
use aghf::error::{Error, Result, plain};
use aghf::model::{Frame, Model};
use aghf::names::instead;
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A set of poses of a frame of the robot, in the base frame or in another frame: at least one of the keys
/// `position_m`, `box`, `orientation_xyzw` and `axis` is needed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// The name of the frame: a link.
    pub frame: String,
    /// The name of the frame in which the poses are: a link; by default the base frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_to: Option<String>,
    /// The position of its origin, m; by default any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_m: Option<[f64; 3]>,
    /// The largest distance from the position, m; zero by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance_m: Option<f64>,
    /// A box, which has the position of its origin, instead of `position_m`.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    pub within: Option<PositionBox>,
    /// The unit quaternion that rotates the axes of the base, or of that frame, into those of the frame; any by
    /// default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation_xyzw: Option<[f64; 4]>,
    /// An axis of the frame and its direction, instead of `orientation_xyzw`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<AxisDirection>,
    /// The largest angle from the orientation or the direction, rad; zero by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance_rad: Option<f64>,
}

/// A box of positions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PositionBox {
    /// The edge lengths along its own axes, m: zero for a plane, a line or a point, `null` for an edge without ends.
    pub size_m: [Option<f64>; 3],
    /// The pose of its centre.
    pub pose: Pose,
}

/// A direction of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisDirection {
    /// The axis in the frame, of any length but zero.
    pub of_frame: [f64; 3],
    /// Its direction in the base frame or the one that the pose is relative to, of any length but zero.
    pub direction: [f64; 3],
}

impl Goal {
    /// The rows of the goal on a robot; `key` names it and `path` the scenario in errors.
    pub(crate) fn rows(&self, model: &Model, key: &str, path: &str) -> Result<Vec<AnyConstraint>> {
        let refuse =
            |key_of_goal: &str, condition: String| Error::input(path, format!("{key}.{key_of_goal}"), condition);
        let frame = model.frames().iter().find(|frame| frame.name == self.frame);
        // The base moves relative to another frame.
        let moves = |frame: &&Frame<f64>| frame.body.is_some() || self.relative_to.is_some();
        let Some(frame) = frame.filter(moves) else {
            return Err(refuse("frame", model.no_moving_link(&self.frame)));
        };
        let reference = match &self.relative_to {
            None => Frame::new("goal", None, Placement::identity()),
            Some(name) => {
                let found = model.frames().iter().find(|frame| frame.name == *name);
                let Some(found) = found.filter(|found| found.body != frame.body) else {
                    let others = model.frames().iter().filter(|other| other.body != frame.body);
                    let condition = format!(
                        "the robot has no link '{name}' that moves against '{}'{}",
                        self.frame,
                        instead(name, others.map(|other| other.name.as_str()))
                    );
                    return Err(refuse("relative_to", condition));
                };
                found.clone()
            }
        };
        let at = |placement: Placement<f64>| {
            let placement = reference.placement.compose(&placement);
            FrameRows::new(frame, Frame::new(&reference.name, reference.body, placement))
        };
        let mut all = Vec::new();
        if let Some(rows) = self.position(&at, &refuse)? {
            all.push(AnyConstraint::Frame(rows));
        }
        if let Some(rows) = self.orientation(&at, &refuse)? {
            all.push(AnyConstraint::Frame(rows));
        }
        if all.is_empty() {
            let condition = "one of the keys position_m, box, orientation_xyzw and axis is needed";
            return Err(Error::input(path, key, condition));
        }
        Ok(all)
    }

    fn position(
        &self,
        at: &impl Fn(Placement<f64>) -> FrameRows,
        refuse: &impl Fn(&str, String) -> Error,
    ) -> Result<Option<FrameRows>> {
        if self.tolerance_m.is_some() && self.position_m.is_none() {
            return Err(refuse("tolerance_m", "it needs position_m".to_owned()));
        }
        let rows = match (self.position_m, &self.within) {
            (Some(_), Some(_)) => {
                return Err(refuse("box", "it excludes position_m".to_owned()));
            }
            (Some(position), None) => {
                if !bounded(&position) {
                    return Err(refuse("position_m", "it needs three finite numbers".to_owned()));
                }
                let rows = at(Placement::new(Matrix3::identity(), Vector3::from(position)));
                match self.tolerance_m {
                    None => rows.at_origin(),
                    Some(by) => (rows.within_distance(by)).map_err(|e| refuse("tolerance_m", e.to_string()))?,
                }
            }
            (None, Some(within)) => {
                let half = within.size_m.map(|size| 0.5 * size.unwrap_or(f64::INFINITY));
                if let Some(size) = half.iter().find(|half| half.is_nan() || **half < 0.0) {
                    let condition = format!("an edge has {} m", plain(2.0 * size));
                    return Err(refuse("box.size_m", condition));
                }
                let pose = within.pose.placement().map_err(|e| refuse("box.pose", e))?;
                let half = Vector3::from(half);
                let rows = at(pose).in_box(&-half, &half);
                rows.map_err(|e| refuse("box.size_m", e.to_string()))?
            }
            (None, None) => return Ok(None),
        };
        Ok(Some(rows))
    }

    fn orientation(
        &self,
        at: &impl Fn(Placement<f64>) -> FrameRows,
        refuse: &impl Fn(&str, String) -> Error,
    ) -> Result<Option<FrameRows>> {
        let rows = match (self.orientation_xyzw, &self.axis) {
            (Some(_), Some(_)) => {
                return Err(refuse("axis", "it excludes orientation_xyzw".to_owned()));
            }
            (Some(_), None) => {
                let pose = Pose { position_m: [0.0; 3], orientation_xyzw: self.orientation_xyzw };
                let pose = pose.placement().map_err(|e| refuse("orientation_xyzw", e))?;
                match self.tolerance_rad {
                    None => Ok(at(pose).oriented()),
                    Some(angle) => at(pose).within_angle(angle),
                }
            }
            (None, Some(AxisDirection { of_frame, direction })) => {
                let rows = at(Placement::identity());
                let both = [of_frame, direction].map(|v| Vector3::from(*v));
                match self.tolerance_rad {
                    None => rows.axis_along(&both[0], &both[1]),
                    Some(angle) => rows.axis_within(&both[0], &both[1], angle),
                }
            }
            (None, None) if self.tolerance_rad.is_some() => {
                let condition = "it needs orientation_xyzw or axis".to_owned();
                return Err(refuse("tolerance_rad", condition));
            }
            (None, None) => return Ok(None),
        };
        let key = if self.axis.is_some() { "axis" } else { "tolerance_rad" };
        rows.map(Some).map_err(|e| refuse(key, e.to_string()))
    }
}

/// The alternatives of the goal, with the first guess as their only end; `None` without a goal. The state at the end is
/// by default that at the start, at rest.
pub(crate) fn goal_set(file: &mut ScenarioFile, model: &Model, path: &str) -> Result<Option<GoalSet>> {
    if file.goal.is_empty() {
        return Ok(None);
    }
    let mut alternatives = Vec::new();
    for (i, goal) in file.goal.iter().enumerate() {
        let key = if file.goal.len() == 1 { "goal".to_owned() } else { format!("goal[{i}]") };
        alternatives.push(goal.rows(model, &key, path)?);
    }
    if file.q_goal.is_empty() {
        file.q_goal.clone_from(&file.q_start);
    }
    if file.v_goal.is_empty() {
        file.v_goal.resize(model.dof(), 0.0);
    }
    Ok(Some(GoalSet { alternatives, ends: vec![GoalEnd { q: file.q_goal.clone(), alternative: 0 }] }))
}

impl Scenario {
    /// The most violated row of the goal at a final configuration, of the alternative that is violated least, and its
    /// violation in m or rad, which is negative inside; `None` if the goal is no set.
    pub(crate) fn off_goal(&self, q: &[f64]) -> Result<Option<(f64, RowLabel)>> {
        let Some(goal) = &self.goal else {
            return Ok(None);
        };
        let x = [q, &vec![0.0; q.len()]].concat();
        let mut least: Option<(f64, RowLabel)> = None;
        for rows in &goal.alternatives {
            let worst = worst_row(rows, &self.model, &x)?;
            if let Some(worst) = worst
                && least.as_ref().is_none_or(|least| worst.0 < least.0)
            {
                least = Some(worst);
            }
        }
        Ok(least)
    }
}
