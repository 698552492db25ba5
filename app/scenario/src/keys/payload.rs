//! A body that the robot of a scenario carries.

use crate::keys::obstacles::{ObstacleShape, Pose};
use aghf::error::{Error, Result, plain};
use aghf::geometry::Shape;
use aghf::model::{Collision, CollisionShape, Model};
use aghf::spatial::{Inertia, Placement};
use aghf::urdf::impossible_inertia;
use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The largest number: far beyond any load, in kg, m and kg m^2. Products of several must not overflow.
const MAX_NUMBER: f64 = 1e6;

/// A body that a link of the robot carries, such as a tool or a grasped object. It moves with the link, and its shape
/// is one of the link's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// The name of the link.
    pub link: String,
    /// The mass, kg.
    pub mass_kg: f64,
    /// The centre of mass in the frame of the link, m; its origin by default.
    #[serde(default)]
    pub center_m: [f64; 3],
    /// `ixx, ixy, ixz, iyy, iyz, izz` about the centre of mass, along the axes of the link; those of a point mass by
    /// default.
    #[serde(default)]
    pub inertia_kg_m2: [f64; 6],
    /// The shape, as of an obstacle but no half-space; none by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<ObstacleShape>,
    /// The pose of the shape in the frame of the link; by default at the centre of mass, along the axes of the link.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape_pose: Option<Pose>,
}

impl Payload {
    /// Adds the payload to the link of a robot, and returns its shape; `path` names the scenario in errors.
    pub(crate) fn attach(&self, robot: &mut Model, path: &str) -> Result<Option<Collision>> {
        let refuse = |key: &str, condition: String| Error::input(path, format!("payload.{key}"), condition);
        let found = robot.frames().iter().find(|frame| frame.name == self.link);
        let Some((body, frame)) = found.and_then(|frame| Some((frame.body?, frame.placement))) else {
            return Err(refuse("link", robot.no_moving_link(&self.link)));
        };
        robot.inertias_mut()[body] += self.inertia(&refuse)?.placed(&frame);
        self.collision(robot, path)
    }

    /// The shape on the link of a robot; `path` names the scenario in errors.
    pub(crate) fn collision(&self, robot: &Model, path: &str) -> Result<Option<Collision>> {
        let refuse = |key: &str, condition: String| Error::input(path, format!("payload.{key}"), condition);
        let Some(shape) = self.shape else {
            return match self.shape_pose {
                None => Ok(None),
                Some(_) => Err(refuse("shape_pose", "there is no shape".to_owned())),
            };
        };
        let shape = match shape.checked().map_err(|e| refuse("shape", e))? {
            Shape::HalfSpace => {
                return Err(refuse("shape", "a payload cannot be a half-space".to_owned()));
            }
            shape => CollisionShape::Solid(shape),
        };
        let placement = match &self.shape_pose {
            Some(pose) => pose.placement().map_err(|e| refuse("shape_pose", e))?,
            None => Placement::new(Matrix3::identity(), Vector3::from(self.center_m)),
        };
        Ok(Some(Collision::at_link(robot, &self.link, &placement, shape)?))
    }

    /// The inertia in the frame of the link; `refuse` makes an error for a key.
    fn inertia(&self, refuse: &impl Fn(&str, String) -> Error) -> Result<Inertia<f64>> {
        if !(self.mass_kg > 0.0 && self.mass_kg <= MAX_NUMBER) {
            let mass = plain(self.mass_kg);
            return Err(refuse(
                "mass_kg",
                format!("it is {mass} and must be a positive number of at most {MAX_NUMBER}"),
            ));
        }
        for (key, numbers) in [("center_m", &self.center_m[..]), ("inertia_kg_m2", &self.inertia_kg_m2)] {
            if !numbers.iter().all(|x| x.abs() <= MAX_NUMBER) {
                let condition = format!("a number is not finite, or above {MAX_NUMBER}");
                return Err(refuse(key, condition));
            }
        }
        let [ixx, ixy, ixz, iyy, iyz, izz] = self.inertia_kg_m2;
        let rotational = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
        if let Some(condition) = impossible_inertia(self.mass_kg, &rotational) {
            return Err(refuse("inertia_kg_m2", condition));
        }
        Ok(Inertia::from_com(self.mass_kg, Vector3::from(self.center_m), rotational))
    }
}
