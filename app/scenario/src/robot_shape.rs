//! The balls that represent a robot.

use super::RobotShape;
use super::obstacles::LARGEST_LENGTH;
use aghf::constraint::{Capsule, CollisionSphere};
use aghf::error::{Error, Result, plain};
use aghf::geometry::{Cover, cover_triangles};
use aghf::model::{Collision, CollisionShape, Model};
use aghf::spatial::Placement;
use aghf::urdf::load_mesh;
use nalgebra::Vector3;
use std::path::Path;

/// The largest number of balls that cover a robot: with one sphere obstacle the search then takes 130 MB at degree 16.
const MOST_BALLS: f64 = 1e4;

/// A ball of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkBall {
    /// The name of the link.
    pub link: String,
    /// The ball in the body that the link is part of.
    pub ball: CollisionSphere,
}

impl LinkBall {
    /// Covers the shapes of the links by balls: spheres as they are, others [covered](aghf::geometry::Shape::cover)
    /// with this spacing, m. Meshes are looked for from `folder`, that of the URDF, and covered by [`cover_triangles`].
    ///
    /// # Errors
    /// The robot has no shapes, a mesh cannot be read, or too many balls are needed; the error names the link.
    pub fn of_model(model: &Model, folder: &Path, spacing: f64) -> Result<Vec<Self>> {
        if model.collisions().is_empty() {
            let condition = "none of its links has a collision element";
            return Err(Error::input(model.name(), "robot", condition));
        }
        let mut balls = Vec::new();
        for collision in model.collisions() {
            let Collision {
                link,
                body,
                placement,
                ..
            } = collision;
            let named = |error: Error| {
                Error::input(model.name(), format!("link '{link}'"), error.to_string())
            };
            let Cover { balls: cover, .. } = cover(collision, folder, spacing).map_err(named)?;
            balls.extend(cover.into_iter().map(|ball| Self {
                link: link.clone(),
                ball: CollisionSphere {
                    body: *body,
                    centre: placement.rotation * ball.centre + placement.translation,
                    radius: ball.radius,
                },
            }));
        }
        Ok(balls)
    }
}

/// The cover of a shape in its own frame.
fn cover(collision: &Collision, folder: &Path, spacing: f64) -> Result<Cover> {
    match &collision.shape {
        CollisionShape::Solid(shape) => shape.cover(spacing),
        CollisionShape::Mesh { file, scale } => {
            cover_triangles(&load_mesh(file, folder, scale)?, spacing)
        }
    }
}

/// The part of the robot that keeps clear of obstacles.
#[derive(Clone, Debug)]
pub(super) enum Body {
    /// Capsules, and the distance between the balls that cover them.
    Capsules {
        /// The capsules.
        capsules: Vec<Capsule>,
        /// The distance.
        spacing: f64,
    },
    /// Balls of links.
    Balls(Vec<LinkBall>),
}

impl Body {
    /// Builds the shape of a scenario's robot; `path` names the scenario in errors. Meshes are looked for from
    /// `folder`.
    pub fn new(model: &Model, shape: RobotShape, folder: &Path, path: &str) -> Result<Self> {
        let bounded = |x: &[f64]| x.iter().all(|x| x.abs() <= LARGEST_LENGTH);
        let refuse = |condition: String| Err(Error::input(path, "robot_shape", condition));
        let body = match shape {
            RobotShape::JointFrames => Self::Capsules {
                capsules: points(model),
                spacing: 1.0,
            },
            RobotShape::SweptLinks {
                radius_m,
                spacing_m,
            } => {
                if !(bounded(&[radius_m, spacing_m]) && radius_m >= 0.0 && spacing_m > 0.0) {
                    return refuse(format!(
                        "a radius that is not negative and a positive spacing are needed, no number above {LARGEST_LENGTH} m"
                    ));
                }
                Self::Capsules {
                    capsules: Capsule::along_links(model, radius_m),
                    spacing: spacing_m,
                }
            }
            RobotShape::Collision { spacing_m } => {
                if !(bounded(&[spacing_m]) && spacing_m > 0.0) {
                    return refuse(format!(
                        "a positive spacing of at most {LARGEST_LENGTH} m is needed"
                    ));
                }
                let balls = LinkBall::of_model(model, folder, spacing_m);
                Self::Balls(balls.map_err(|e| Error::input(path, "robot_shape", e.to_string()))?)
            }
        };
        let spacing = match shape {
            RobotShape::JointFrames => return Ok(body),
            RobotShape::SweptLinks { spacing_m, .. } => ("swept_links", spacing_m),
            RobotShape::Collision { spacing_m } => ("collision", spacing_m),
        };
        let count = body.count();
        if count > MOST_BALLS {
            let (key, [spacing, count]) = (spacing.0, [spacing.1, count].map(plain));
            let condition = format!(
                "it is {spacing}, which takes {count} balls to cover the robot, at most {MOST_BALLS} are allowed"
            );
            let key = format!("robot_shape.{key}.spacing_m");
            return Err(Error::input(path, key, condition));
        }
        Ok(body)
    }

    /// The number of balls; those shared by several capsules count several times.
    pub fn count(&self) -> f64 {
        match self {
            Self::Capsules { capsules, spacing } => {
                capsules.iter().map(|c| c.pieces(*spacing) + 1.0).sum()
            }
            Self::Balls(balls) => balls.len() as f64,
        }
    }

    /// Moves the shape to a reduced robot whose bodies contain those of the full one: per body the one that contains
    /// it, and its placement there.
    pub fn reduced(&mut self, bodies: &[(Option<usize>, Placement<f64>)]) {
        let within = |body: &mut Option<usize>, points: &mut [&mut Vector3<f64>]| {
            if let Some((reduced, placement)) = body.map(|b| bodies[b]) {
                *body = reduced;
                for point in points {
                    **point = placement.rotation * **point + placement.translation;
                }
            }
        };
        match self {
            Self::Capsules { capsules, .. } => {
                for Capsule { body, ends, .. } in capsules {
                    within(body, &mut ends.each_mut());
                }
            }
            Self::Balls(balls) => {
                for LinkBall { ball, .. } in balls {
                    within(&mut ball.body, &mut [&mut ball.centre]);
                }
            }
        }
    }

    /// The balls; those shared by several capsules appear once.
    ///
    /// # Errors
    /// Those of [`Capsule::balls`].
    pub fn balls(&self) -> Result<Vec<CollisionSphere>> {
        let (capsules, spacing) = match self {
            Self::Balls(balls) => return Ok(balls.iter().map(|b| b.ball).collect()),
            Self::Capsules { capsules, spacing } => (capsules, *spacing),
        };
        let mut balls: Vec<CollisionSphere> = Vec::new();
        for capsule in capsules {
            // Capsules of one body share the ball at its joint.
            for ball in capsule.balls(spacing)? {
                let same =
                    |b: &&mut CollisionSphere| b.body == ball.body && b.centre == ball.centre;
                match balls.iter_mut().find(same) {
                    Some(known) => known.radius = known.radius.max(ball.radius),
                    None => balls.push(ball),
                }
            }
        }
        Ok(balls)
    }
}

/// The origins of all joint frames: the paper's measure.
fn points(model: &Model) -> Vec<Capsule> {
    let frames = CollisionSphere::joint_frames(model);
    frames.into_iter().map(alone).collect()
}

/// A ball as a capsule of length zero.
pub(super) fn alone(ball: CollisionSphere) -> Capsule {
    Capsule {
        body: ball.body,
        ends: [ball.centre; 2],
        radius: ball.radius,
    }
}
