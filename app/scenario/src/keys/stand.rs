//! A foot on which the robot stands.

use crate::keys::obstacles::{MAX_LENGTH, Pose};
use crate::{Scenario, ScenarioFile};
use aghf::constraint::{FootContact, StandingFoot};
use aghf::curve::Curve;
use aghf::dynamics::{Data, root_wrench};
use aghf::error::{Error, Result, plain};
use aghf::model::Model;
use aghf::motion::sample;
use aghf::spatial::Placement;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A flat foot that stands on the ground, which pushes and does not pull.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stand {
    /// The name of the foot: a link that is fixed to the base.
    pub frame: String,
    /// The pose of the sole in that link: its middle, `x` along its length, `z` up; by default the link itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sole: Option<Pose>,
    /// Half of the length of the sole, m.
    pub half_length_m: f64,
    /// Half of the width of the sole, m.
    pub half_width_m: f64,
    /// The coefficient of friction.
    pub friction: f64,
    /// The largest ratio of the moment about the normal to the normal force, m; by default it has no bound.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torsion: Option<f64>,
}

/// The extremes of the force of the ground on a standing foot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FootLoad {
    /// The least and the largest normal force, N.
    pub normal_force: [f64; 2],
    /// The least and the largest coordinate of the centre of pressure along the sole, m.
    pub along_m: [f64; 2],
    /// The same across the sole.
    pub across_m: [f64; 2],
    /// The largest ratio of the force in the plane of the sole to the normal force.
    pub friction: f64,
    /// The largest ratio of the moment about the normal to the normal force, m.
    pub torsion: f64,
}

impl Stand {
    /// The foot on a robot; `path` names the scenario in errors.
    fn foot(&self, model: &Model, path: &str) -> Result<StandingFoot> {
        let refuse = |key: &str, condition: String| Err(Error::input(path, format!("stand.{key}"), condition));
        let frame = model.frames().iter().find(|frame| frame.name == self.frame);
        let Some(frame) = frame else {
            return refuse("frame", model.no_link(&self.frame));
        };
        if frame.body.is_some() {
            let condition = format!(
                "link '{}' moves; a foot that stands is the root of its robot, which aghf robots ROBOT.urdf --root {0} \
                 writes",
                self.frame
            );
            return refuse("frame", condition);
        }
        let within = match &self.sole {
            None => Placement::identity(),
            Some(pose) => match pose.placement() {
                Ok(placement) => placement,
                Err(condition) => return refuse("sole", condition),
            },
        };
        let sizes = [
            ("half_length_m", Some(self.half_length_m)),
            ("half_width_m", Some(self.half_width_m)),
            ("friction", Some(self.friction)),
            ("torsion", self.torsion),
        ];
        for (key, size) in sizes {
            if let Some(size) = size.filter(|x| !(*x > 0.0 && *x <= MAX_LENGTH)) {
                let condition = format!("it is {} and must be a positive number", plain(size));
                return refuse(key, condition);
            }
        }
        let mass = model.mass() + model.base_inertia().mass;
        let weight = mass * model.gravity().norm();
        if weight == 0.0 {
            return refuse("frame", "the robot has no weight to stand with".to_owned());
        }
        Ok(StandingFoot {
            name: self.frame.clone(),
            sole: frame.placement.compose(&within),
            half_length: self.half_length_m,
            half_width: self.half_width_m,
            friction: self.friction,
            torsion: self.torsion,
            weight,
        })
    }
}

/// The foot of a scenario; `path` names the scenario in errors.
pub(crate) fn standing_foot(file: &ScenarioFile, model: &Model, path: &str) -> Result<Option<StandingFoot>> {
    let stand = file.stand.as_ref();
    stand.map(|stand| stand.foot(model, path)).transpose()
}

impl Scenario {
    /// The foot on which the robot stands; `None` for a base that withstands any force.
    #[must_use]
    pub fn foot(&self) -> Option<&StandingFoot> {
        self.own.foot.as_ref()
    }

    /// The contact of the standing foot in a state $(q, v, a)$; `None` without a foot.
    ///
    /// # Errors
    /// A slice does not have `N` entries.
    pub fn contact(&self, [q, v, a]: [&[f64]; 3]) -> Result<Option<FootContact>> {
        let Some(foot) = self.foot() else {
            return Ok(None);
        };
        let wrench = root_wrench(&self.model, &mut Data::new(&self.model), q, v, a)?;
        Ok(Some(foot.contact(&wrench)))
    }

    /// The extremes along a motion on this number of intervals; `None` without a foot.
    pub(crate) fn foot_load(&self, curve: &Curve, intervals: usize) -> Result<Option<FootLoad>> {
        if self.foot().is_none() {
            return Ok(None);
        }
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let mut load = FootLoad { normal_force: none, along_m: none, across_m: none, friction: 0.0, torsion: 0.0 };
        let widen = |range: &mut [f64; 2], x: f64| *range = [range[0].min(x), range[1].max(x)];
        for row in sample(&self.model, curve, intervals)? {
            if let Some(contact) = self.contact([&row.q, &row.v, &row.a])? {
                let [along, across] = contact.centre_of_pressure;
                widen(&mut load.normal_force, contact.force[2]);
                widen(&mut load.along_m, along);
                widen(&mut load.across_m, across);
                load.friction = load.friction.max(contact.friction);
                load.torsion = load.torsion.max(contact.torsion.abs());
            }
        }
        Ok(Some(load))
    }

    /// Refuses an end at rest, without an acceleration there, in which the weight is not above the sole.
    pub(crate) fn check_balance(&self, key: &str, q: &[f64]) -> Result<()> {
        let still = vec![0.0; q.len()];
        let (Some(foot), Some(contact)) = (self.foot(), self.contact([q, &still, &still])?) else {
            return Ok(());
        };
        let [along, across] = contact.centre_of_pressure;
        if along.abs() <= foot.half_length && across.abs() <= foot.half_width {
            return Ok(());
        }
        let condition = format!(
            "the weight at rest is ({}, {}) m from the middle of the sole, beyond its edges; with \"continuity\": \
             \"velocity\" a motion may begin by falling",
            plain((along * 1e4).round() / 1e4),
            plain((across * 1e4).round() / 1e4)
        );
        Err(Error::input(&self.name, key, condition))
    }
}
