//! The parts of MoveIt's planning scenes and requests that are read, in the YAML form of these messages.

use super::fields::check_fields;
use crate::keys::yaml::{of_value, yaml_value};
use aghf::error::{Error, Result};
use aghf::input::read_text;
use nalgebra::Vector3;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// A message that is a file of its own.
pub(super) trait Message: DeserializeOwned {
    /// Its type and, in words, its contents.
    const TYPE: &str;
    const WHAT: &str;

    /// Reads it from a YAML file, and refuses fields that are not read.
    fn load(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let value = yaml_value(&read_text(path)?, &file, Self::WHAT)?;
        check_fields(&value, Self::TYPE, [&file, ""])?;
        of_value(value, &file, Self::WHAT)
    }
}

impl Message for Scene {
    const TYPE: &str = "moveit_msgs/PlanningScene";
    const WHAT: &str = "scene";
}

impl Message for Request {
    const TYPE: &str = "moveit_msgs/MotionPlanRequest";
    const WHAT: &str = "request";
}

/// A planning scene: `moveit_msgs/PlanningScene`.
#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    pub world: World,
    #[serde(default)]
    pub robot_state: RobotState,
    #[serde(default)]
    pub allowed_collision_matrix: AllowedCollisions,
    #[serde(default)]
    pub fixed_frame_transforms: Vec<FixedFrame>,
}

/// The pose of a frame in the scene: `geometry_msgs/TransformStamped`.
#[derive(Debug, Deserialize)]
pub(super) struct FixedFrame {
    pub transform: Transform,
}

/// The pairs that may overlap: `moveit_msgs/AllowedCollisionMatrix`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct AllowedCollisions {
    #[serde(default)]
    entry_names: Vec<String>,
    #[serde(default)]
    entry_values: Vec<Entries>,
}

/// A row of that matrix, as in the message or as a list.
#[derive(Debug, Deserialize)]
#[serde(untagged, deny_unknown_fields, expecting = "a list of true and false is needed, or the key enabled with one")]
enum Entries {
    List(Vec<bool>),
    Message { enabled: Vec<bool> },
}

impl AllowedCollisions {
    /// The pairs of names that may overlap, each once; `file` names the scene in errors.
    pub fn pairs(&self, file: &str) -> Result<Vec<[String; 2]>> {
        let names = &self.entry_names;
        let refuse = |element: String, found: usize| {
            let condition = format!("it has {found} entries for {} names", names.len());
            Err(Error::input(file, element, condition))
        };
        let key = "allowed_collision_matrix.entry_values";
        if self.entry_values.len() != names.len() {
            return refuse(key.to_owned(), self.entry_values.len());
        }
        let mut pairs = Vec::new();
        for (i, row) in self.entry_values.iter().enumerate() {
            let (Entries::List(row) | Entries::Message { enabled: row }) = row;
            if row.len() != names.len() {
                return refuse(format!("{key}[{i}]"), row.len());
            }
            let allowed = (i + 1..names.len()).filter(|j| row[*j]);
            pairs.extend(allowed.map(|j| [names[i].clone(), names[j].clone()]));
        }
        Ok(pairs)
    }
}

/// The obstacles.
#[derive(Debug, Deserialize)]
pub(super) struct World {
    pub collision_objects: Vec<CollisionObject>,
}

/// An obstacle of several parts.
#[derive(Debug, Deserialize)]
pub(super) struct CollisionObject {
    #[serde(default)]
    pub header: Header,
    pub id: String,
    #[serde(default)]
    pub pose: Option<Pose>,
    #[serde(default)]
    pub primitives: Vec<Primitive>,
    #[serde(default)]
    pub primitive_poses: Vec<Pose>,
}

/// A shape: `shape_msgs/SolidPrimitive`.
#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    #[serde(rename = "type")]
    pub kind: Kind,
    pub dimensions: Vec<f64>,
}

/// The kind of a shape, by name or by number.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "the name or the number of a shape is needed")]
pub(super) enum Kind {
    Name(String),
    Number(u8),
}

impl Kind {
    /// The name of the kind, also if the message has its number.
    pub fn name(&self) -> String {
        match self {
            Self::Name(name) => name.to_lowercase(),
            Self::Number(number) => match number {
                1 => "box".to_owned(),
                2 => "sphere".to_owned(),
                3 => "cylinder".to_owned(),
                4 => "cone".to_owned(),
                other => format!("shape {other}"),
            },
        }
    }
}

/// The pose of a shape.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Pose {
    pub position: Position,
    pub orientation: Orientation,
}

/// A point.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, deny_unknown_fields, expecting = "a list or the keys x y z are needed")]
pub(super) enum Position {
    List([f64; 3]),
    Keys { x: f64, y: f64, z: f64 },
}

impl From<Position> for Vector3<f64> {
    fn from(position: Position) -> Self {
        match position {
            Position::List(list) => list.into(),
            Position::Keys { x, y, z } => Self::new(x, y, z),
        }
    }
}

/// A quaternion.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, deny_unknown_fields, expecting = "a list or the keys x y z w are needed")]
pub(super) enum Orientation {
    List([f64; 4]),
    Keys { x: f64, y: f64, z: f64, w: f64 },
}

impl From<Orientation> for [f64; 4] {
    fn from(orientation: Orientation) -> Self {
        match orientation {
            Orientation::List(list) => list,
            Orientation::Keys { x, y, z, w } => [x, y, z, w],
        }
    }
}

/// The state of a robot: `moveit_msgs/RobotState`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct RobotState {
    #[serde(default)]
    pub joint_state: JointState,
    #[serde(default)]
    pub multi_dof_joint_state: MultiDofJointState,
}

/// The positions and velocities of joints; there may be no velocities.
#[derive(Debug, Default, Deserialize)]
pub(super) struct JointState {
    #[serde(default)]
    pub name: Vec<String>,
    #[serde(default)]
    pub position: Vec<f64>,
    #[serde(default)]
    pub velocity: Vec<f64>,
}

/// The poses of joints with several degrees of freedom, such as a floating base.
#[derive(Debug, Default, Deserialize)]
pub(super) struct MultiDofJointState {
    #[serde(default)]
    pub transforms: Vec<Transform>,
}

/// The pose of a frame.
#[derive(Debug, Deserialize)]
pub(super) struct Transform {
    pub translation: Position,
    pub rotation: Orientation,
}

impl Transform {
    /// Returns true if it moves and turns nothing.
    pub fn is_identity(&self) -> bool {
        let translation: Vector3<f64> = self.translation.into();
        let [x, y, z, _]: [f64; 4] = self.rotation.into();
        translation.iter().chain(&[x, y, z]).all(|x| *x == 0.0)
    }
}

/// A planning request: `moveit_msgs/MotionPlanRequest`.
#[derive(Debug, Deserialize)]
pub(super) struct Request {
    #[serde(default)]
    pub group_name: String,
    pub start_state: RobotState,
    /// Any of these.
    pub goal_constraints: Vec<Constraints>,
    #[serde(default)]
    pub path_constraints: Option<Constraints>,
    /// Shares of the limits; zero counts as one.
    #[serde(default)]
    pub max_velocity_scaling_factor: f64,
    #[serde(default)]
    pub max_acceleration_scaling_factor: f64,
    /// Until ROS 2 Humble under the other name.
    #[serde(default, alias = "cartesian_speed_end_effector_link")]
    pub cartesian_speed_limited_link: String,
    /// The largest speed of that link, m/s; none at zero or below.
    #[serde(default)]
    pub max_cartesian_speed: f64,
}

/// All of several conditions: `moveit_msgs/Constraints`.
#[derive(Debug, Deserialize)]
pub(super) struct Constraints {
    #[serde(default)]
    pub joint_constraints: Vec<JointConstraint>,
    #[serde(default)]
    pub position_constraints: Vec<PositionConstraint>,
    #[serde(default)]
    pub orientation_constraints: Vec<OrientationConstraint>,
}

impl Constraints {
    /// Returns true if there is a position or an orientation of a link.
    pub fn has_poses(&self) -> bool {
        !(self.position_constraints.is_empty() && self.orientation_constraints.is_empty())
    }
}

/// The frame of a message.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Header {
    #[serde(default)]
    pub frame_id: String,
}

/// A region in which the origin of a link is: `moveit_msgs/PositionConstraint`.
#[derive(Debug, Deserialize)]
pub(super) struct PositionConstraint {
    #[serde(default)]
    pub header: Header,
    pub link_name: String,
    #[serde(default)]
    pub target_point_offset: Option<Position>,
    pub constraint_region: Region,
}

/// A volume: `moveit_msgs/BoundingVolume`.
#[derive(Debug, Deserialize)]
pub(super) struct Region {
    #[serde(default)]
    pub primitives: Vec<Primitive>,
    #[serde(default)]
    pub primitive_poses: Vec<Pose>,
}

/// An orientation of a link with tolerances about its axes: `moveit_msgs/OrientationConstraint`.
#[derive(Debug, Deserialize)]
pub(super) struct OrientationConstraint {
    #[serde(default)]
    pub header: Header,
    pub orientation: Orientation,
    pub link_name: String,
    pub absolute_x_axis_tolerance: f64,
    pub absolute_y_axis_tolerance: f64,
    pub absolute_z_axis_tolerance: f64,
    /// The angles of which these are tolerances: 0 of Euler, 1 of a rotation vector.
    #[serde(default)]
    pub parameterization: u8,
}

/// The position of a joint at the goal.
#[derive(Debug, Deserialize)]
pub(super) struct JointConstraint {
    pub joint_name: String,
    pub position: f64,
}
