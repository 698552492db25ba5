//! What the robot of a scenario has to keep clear of, and with what shape.

use super::{RobotShape, ScenarioFile};
use crate::constraint::{
    AnyConstraint, Capsule, CollisionSphere, HalfSpace, HalfSpaceClearance, Sphere, SphereClearance,
};
use crate::dynamics::forward_kinematics;
use crate::error::{Error, Result};
use crate::model::Model;
use crate::spatial::Placement;
use nalgebra::Vector3;

/// The shape of a robot among obstacles.
#[derive(Clone, Debug)]
pub struct Environment {
    capsules: Vec<Capsule>,
    spacing: f64,
    spheres: Vec<Sphere>,
    half_spaces: Vec<HalfSpace>,
}

/// A ball of the robot and an obstacle.
pub(super) struct Overlap {
    /// The obstacle, as in the file: `sphere_obstacles[2]`.
    pub(super) obstacle: String,
    /// The body that carries the ball.
    pub(super) body: Option<usize>,
    /// The depth of the ball in the obstacle, m; negative when it is clear.
    pub(super) depth: f64,
}

impl Environment {
    /// Those of a scenario; `path` names it in errors.
    pub(super) fn new(model: &Model, file: &ScenarioFile, path: &str) -> Result<Self> {
        let refuse = |key: String, condition: String| Err(Error::input(path, key, condition));
        let finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        for (i, sphere) in file.sphere_obstacles.iter().enumerate() {
            let radius = sphere.radius_m;
            if !(finite(&sphere.center_m) && radius.is_finite() && radius > 0.0) {
                let condition = "a finite centre and a positive radius are needed".to_owned();
                return refuse(format!("sphere_obstacles[{i}]"), condition);
            }
        }
        let mut half_spaces = Vec::new();
        for (i, half_space) in file.half_spaces.iter().enumerate() {
            let normal = Vector3::from(half_space.normal);
            let length = normal.norm();
            if !(finite(&[length, half_space.offset_m]) && length > 0.0) {
                let condition = "a finite normal that is not zero and a finite offset are needed";
                return refuse(format!("half_spaces[{i}]"), condition.to_owned());
            }
            half_spaces.push(HalfSpace {
                normal: normal / length,
                offset: half_space.offset_m,
            });
        }
        let (capsules, spacing) = match file.robot_shape {
            RobotShape::JointFrames => (points(model), 1.0),
            RobotShape::SweptLinks {
                radius_m,
                spacing_m,
            } => {
                if !(finite(&[radius_m, spacing_m]) && radius_m >= 0.0 && spacing_m > 0.0) {
                    let condition =
                        "a radius that is not negative and a positive spacing are needed";
                    return refuse("robot_shape".to_owned(), condition.to_owned());
                }
                (Capsule::along_links(model, radius_m), spacing_m)
            }
        };
        let sphere = |s: &super::SphereObstacle| Sphere {
            centre: Vector3::from(s.center_m),
            radius: s.radius_m,
        };
        Ok(Self {
            capsules,
            spacing,
            spheres: file.sphere_obstacles.iter().map(sphere).collect(),
            half_spaces,
        })
    }

    /// The same shape of a robot whose bodies are part of others: of each the one that it is part of, and where it is in that.
    pub(super) fn reduced(mut self, bodies: &[(Option<usize>, Placement<f64>)]) -> Self {
        for capsule in &mut self.capsules {
            let Some((body, placement)) = capsule.body.map(|b| bodies[b]) else {
                continue;
            };
            capsule.body = body;
            capsule.ends =
                (capsule.ends).map(|end| placement.rotation * end + placement.translation);
        }
        self
    }

    /// Tells whether there is nothing to keep clear of.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty() && self.half_spaces.is_empty()
    }

    /// The balls that cover the capsules.
    fn balls(&self) -> Result<Vec<CollisionSphere>> {
        let mut balls: Vec<CollisionSphere> = Vec::new();
        for capsule in &self.capsules {
            // Capsules of one body share the ball at its joint.
            for ball in capsule.balls(self.spacing)? {
                let radius =
                    |b: &&mut CollisionSphere| b.body == ball.body && b.centre == ball.centre;
                match balls.iter_mut().find(radius) {
                    Some(known) => known.radius = known.radius.max(ball.radius),
                    None => balls.push(ball),
                }
            }
        }
        Ok(balls)
    }

    /// The constraints that keep the robot clear: each capsule is covered by balls. Those fixed to the base are none, nothing moves them.
    ///
    /// # Errors
    /// As [`Capsule::balls`].
    pub fn constraints(&self) -> Result<Vec<AnyConstraint>> {
        let mut balls = self.balls()?;
        balls.retain(|ball| ball.body.is_some());
        let mut constraints = Vec::new();
        if !self.spheres.is_empty() {
            constraints.push(AnyConstraint::Spheres(SphereClearance {
                balls: balls.clone(),
                spheres: self.spheres.clone(),
            }));
        }
        constraints.extend(self.half_spaces.iter().map(|half_space| {
            AnyConstraint::HalfSpace(HalfSpaceClearance {
                balls: balls.clone(),
                half_space: *half_space,
            })
        }));
        Ok(constraints)
    }

    /// The deepest overlap of a ball of the constraints and an obstacle with the bodies at `placements`; a negative one is the
    /// smallest distance. `None` without obstacles.
    pub(super) fn deepest(&self, placements: &[Placement<f64>]) -> Result<Option<Overlap>> {
        if self.is_empty() {
            return Ok(None);
        }
        let mut overlaps = Vec::new();
        for ball in self.balls()?.into_iter().map(alone) {
            let mut add = |obstacle: String, clearance: f64| {
                overlaps.push(Overlap {
                    obstacle,
                    body: ball.body,
                    depth: -clearance,
                });
            };
            for (i, sphere) in self.spheres.iter().enumerate() {
                let clearance = ball.clearance(placements, sphere)?;
                add(format!("sphere_obstacles[{i}]"), clearance);
            }
            for (i, half_space) in self.half_spaces.iter().enumerate() {
                let height = ball.height(placements, half_space)?;
                add(format!("half_spaces[{i}]"), height);
            }
        }
        Ok(overlaps
            .into_iter()
            .max_by(|a, b| a.depth.total_cmp(&b.depth)))
    }

    /// The exact distance from the robot to the nearest obstacle with its bodies at `placements`, in m; negative when it
    /// collides, infinite without obstacles.
    ///
    /// # Errors
    /// The placements are those of another robot.
    pub fn clearance(&self, placements: &[Placement<f64>]) -> Result<f64> {
        let mut smallest = f64::INFINITY;
        for capsule in &self.capsules {
            for sphere in &self.spheres {
                smallest = smallest.min(capsule.clearance(placements, sphere)?);
            }
            for half_space in &self.half_spaces {
                smallest = smallest.min(capsule.height(placements, half_space)?);
            }
        }
        Ok(smallest)
    }

    /// The smallest clearance over configurations, in m; `None` without obstacles.
    ///
    /// # Errors
    /// A configuration is that of another robot.
    pub fn smallest_clearance<'q>(
        &self,
        model: &Model,
        configurations: impl Iterator<Item = &'q [f64]>,
    ) -> Result<Option<f64>> {
        if self.is_empty() {
            return Ok(None);
        }
        let mut placements = vec![Placement::identity(); model.dof()];
        let mut smallest = f64::INFINITY;
        for q in configurations {
            forward_kinematics(model, q, &mut placements)?;
            smallest = smallest.min(self.clearance(&placements)?);
        }
        Ok(Some(smallest))
    }
}

/// The origins of all joint frames: the paper's measure.
fn points(model: &Model) -> Vec<Capsule> {
    let frames = CollisionSphere::joint_frames(model);
    frames.into_iter().map(alone).collect()
}

/// A ball as a capsule of length zero.
fn alone(ball: CollisionSphere) -> Capsule {
    Capsule {
        body: ball.body,
        ends: [ball.centre; 2],
        radius: ball.radius,
    }
}
