//! What the robot of a scenario has to keep clear of, and with what shape.

use super::{RobotShape, ScenarioFile};
use crate::constraint::{
    AnyConstraint, Capsule, CollisionSphere, HalfSpace, HalfSpaceClearance, Sphere, SphereClearance,
};
use crate::dynamics::forward_kinematics;
use crate::error::{Error, Result, plain};
use crate::model::Model;
use crate::spatial::Placement;
use nalgebra::Vector3;

/// The largest length, m: far beyond any robot. Squares of distances must not overflow, nor swallow its own size.
const LARGEST_LENGTH: f64 = 1e6;

/// The most balls that cover a robot: among one sphere the search takes 130 MB at degree 16 then.
const MOST_BALLS: f64 = 1e4;

/// The most distances between a ball and an obstacle: each is a row of the constraints, which takes about 10 kB at degree 16.
const MOST_DISTANCES: f64 = 5e4;

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
        let bounded = |x: &[f64]| x.iter().all(|x| x.abs() <= LARGEST_LENGTH);
        for (i, sphere) in file.sphere_obstacles.iter().enumerate() {
            let radius = sphere.radius_m;
            if !(bounded(&sphere.center_m) && bounded(&[radius]) && radius > 0.0) {
                let condition = format!(
                    "a finite centre and a positive radius are needed, no number above {LARGEST_LENGTH} m"
                );
                return refuse(format!("sphere_obstacles[{i}]"), condition);
            }
        }
        let mut half_spaces = Vec::new();
        for (i, half_space) in file.half_spaces.iter().enumerate() {
            let normal = Vector3::from(half_space.normal);
            let length = normal.norm();
            if !(length.is_finite() && length > 0.0 && bounded(&[half_space.offset_m])) {
                let condition = format!(
                    "a finite normal that is not zero and a finite offset of at most {LARGEST_LENGTH} m are needed"
                );
                return refuse(format!("half_spaces[{i}]"), condition);
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
                if !(bounded(&[radius_m, spacing_m]) && radius_m >= 0.0 && spacing_m > 0.0) {
                    let condition = format!(
                        "a radius that is not negative and a positive spacing are needed, no number above {LARGEST_LENGTH} m"
                    );
                    return refuse("robot_shape".to_owned(), condition);
                }
                (Capsule::along_links(model, radius_m), spacing_m)
            }
        };
        let count: f64 = capsules.iter().map(|c| c.pieces(spacing) + 1.0).sum();
        if let RobotShape::SweptLinks { spacing_m, .. } = file.robot_shape
            && count > MOST_BALLS
        {
            let (spacing, count) = (plain(spacing_m), plain(count));
            let condition = format!(
                "it is {spacing}, which takes {count} balls to cover the robot, at most {MOST_BALLS} are allowed"
            );
            return refuse("robot_shape.swept-links.spacing_m".to_owned(), condition);
        }
        let obstacles = file.sphere_obstacles.len() + file.half_spaces.len();
        if count * obstacles as f64 > MOST_DISTANCES {
            let condition = format!(
                "{obstacles} obstacles and {count} balls of the robot have more than {MOST_DISTANCES} distances between them"
            );
            return refuse("sphere_obstacles".to_owned(), condition);
        }
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
