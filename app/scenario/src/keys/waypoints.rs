//! Points on the way.

use crate::{Goal, Scenario, ScenarioFile};
use aghf::direct::Waypoint;
use aghf::error::{Error, Result, check_length};
use aghf::model::Model;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A point on the way: a configuration, or a set of poses of a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointOnTheWay {
    /// The configuration, `N` entries.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub q: Option<Vec<f64>>,
    /// A set of poses of a frame instead of `q`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<Goal>,
    /// True if all joints are at rest there.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stop: bool,
    /// The time, s, on a horizon that is fixed; an unknown by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
}

/// The waypoints of a scenario file, those that are poses with the first guess of the end as their only guess; `path`
/// names the scenario in errors.
pub(crate) fn waypoints(file: &ScenarioFile, model: &Model, path: &str) -> Result<Vec<Waypoint>> {
    let (mut all, mut before) = (Vec::new(), 0.0);
    for (k, point) in file.waypoints.iter().enumerate() {
        let key = format!("waypoints[{k}]");
        let of_key = |e: Error| Error::input(path, &key, e.to_string());
        let (q, constraints) = match (&point.q, &point.poses) {
            (Some(q), None) => (q.clone(), Vec::new()),
            (None, Some(poses)) => {
                let rows = poses.rows(model, &format!("{key}.poses"), path)?;
                (file.q_start.clone(), rows)
            }
            _ => {
                let condition = "one of the keys q and poses is needed, not both";
                return Err(Error::input(path, key, condition));
            }
        };
        check_length("q", model.dof(), q.len()).map_err(of_key)?;
        if let Some(time) = point.time_s {
            let checked = check_time(file, before, time);
            checked.map_err(|condition| Error::input(path, &key, condition))?;
            before = time;
        }
        all.push(Waypoint {
            constraints,
            stop: point.stop,
            share: point.time_s.map(|time| time / file.horizon_s),
            ..Waypoint::new(q)
        });
    }
    Ok(all)
}

/// Refuses the time of a waypoint on a horizon that is free, or not after the one `before` and before the end.
fn check_time(file: &ScenarioFile, before: f64, time: f64) -> std::result::Result<(), String> {
    let horizon = file.horizon_s;
    if file.has_free_horizon() {
        return Err("it has a time, which needs a horizon that is fixed".to_owned());
    }
    if time > before && time < horizon {
        return Ok(());
    }
    let range = format!("after {before} s and before {horizon} s");
    Err(format!("it has the time {time} s, which is not {range}"))
}

impl Scenario {
    /// The waypoints with the configurations from which searches start, those on the shortest way from the first
    /// configuration of the previous point to the next known configuration first.
    ///
    /// # Errors
    /// A configuration is beyond a limit or in collision, or none is found for a set of poses.
    pub fn waypoints_with_guesses(&self) -> Result<Vec<Waypoint>> {
        let mut all = self.waypoints.clone();
        let mut before = self.file.q_start.clone();
        let points = self.sets_on_the_way();
        for (k, ((key, poses), waypoint)) in points.into_iter().zip(&mut all).enumerate() {
            if let Some(poses) = &poses {
                let near = (&before[..], &before[..]);
                let found = self.ends_of(poses, &waypoint.constraints, near, Some(&key))?;
                let found = found.map_err(|condition| Error::input(&self.name, key, condition));
                waypoint.guesses = found?;
                let after = self.after(k);
                let way = |q: &Vec<f64>| {
                    let squares = |to: &[f64]| q.iter().zip(to).map(|(a, b)| (a - b).powi(2)).sum();
                    [squares(&before), squares(after)].map(f64::sqrt).iter().sum::<f64>()
                };
                waypoint.guesses.sort_by(|a, b| way(a).total_cmp(&way(b)));
            } else {
                self.check_on_the_way(&key, &waypoint.guesses[0])?;
            }
            before.clone_from(&waypoint.guesses[0]);
        }
        Ok(all)
    }

    /// The first configuration that is known after a waypoint, that of the goal at the latest.
    fn after(&self, waypoint: usize) -> &[f64] {
        let later = self.file.waypoints.iter().skip(waypoint + 1);
        let mut known = later.filter_map(|point| point.q.as_deref());
        known.next().unwrap_or(&self.file.q_goal)
    }

    /// The final configuration, unless the goal is a set.
    pub(crate) fn known_goal(&self) -> Option<&[f64]> {
        let known = self.goal.is_none() && self.period.is_none();
        known.then_some(&self.file.q_goal)
    }

    /// Returns true if all waypoints that are configurations, and the final one, are the start.
    pub(crate) fn is_at(&self, goal: Option<&[f64]>) -> bool {
        (0..self.model.dof()).all(|joint| self.way_of(joint, goal) == 0.0)
    }

    /// The distance that a joint covers from the start through all waypoints that are configurations to a final one, if
    /// that is known, rad or m.
    pub(crate) fn way_of(&self, joint: usize, goal: Option<&[f64]>) -> f64 {
        let file = &self.file;
        let points = file.waypoints.iter().filter_map(|point| point.q.as_deref());
        let (mut before, mut way) = (file.q_start[joint], 0.0);
        for q in points.chain(goal) {
            way += (q[joint] - before).abs();
            before = q[joint];
        }
        way
    }
}
