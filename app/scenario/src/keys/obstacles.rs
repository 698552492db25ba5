//! The obstacles of a scenario file, and the shape of the robot.

use aghf::error::{Error, Result, plain};
use aghf::geometry::{self, Shape, Solid};
use aghf::model::Model;
use aghf::spatial::Placement;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The largest length, m: far beyond any robot. Squared distances must neither overflow nor lose the size of the
/// obstacle to rounding.
pub(crate) const MAX_LENGTH: f64 = 1e6;

/// The largest deviation of the norm of an orientation from one.
const NOT_UNIT: f64 = 1e-3;

/// An obstacle: a shape at a pose, which the robot keeps clear of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// Name in reports; by default the place in the list, such as `obstacles[2]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The shape.
    pub shape: ObstacleShape,
    /// The pose of the shape.
    pub pose: Pose,
    /// The distance that the robot keeps from it, m; by default that of all obstacles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_m: Option<f64>,
}

/// The shape of an obstacle, about the origin of its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ObstacleShape {
    /// A sphere.
    Sphere {
        /// Radius, m.
        radius_m: f64,
    },
    /// A box.
    Box {
        /// Edge lengths along its own axes, m.
        size_m: [f64; 3],
    },
    /// A cylinder along its own `z` axis.
    Cylinder {
        /// Radius, m.
        radius_m: f64,
        /// Length, m.
        length_m: f64,
    },
    /// All points within a radius of a segment of its own `z` axis.
    Capsule {
        /// Radius, m.
        radius_m: f64,
        /// Length of the segment, without the caps, m.
        length_m: f64,
    },
    /// All points below its own `xy` plane, such as the ground; its `z` axis points to the free side.
    HalfSpace {},
}

/// A position and an orientation in the base frame, or in that of a link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// The position, m.
    pub position_m: [f64; 3],
    /// The unit quaternion that rotates the axes of the base into its own; the identity by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation_xyzw: Option<[f64; 4]>,
}

/// The parts of the robot that keep clear of obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RobotShape {
    /// The origins of all joint frames: the paper's measure.
    JointFrames,
    /// The whole arm: capsules along all links.
    SweptLinks {
        /// Radius of the capsules, m.
        radius_m: f64,
        /// Largest distance between the balls that cover the capsules, m.
        #[serde(default = "default_spacing")]
        spacing_m: f64,
    },
    /// The collision shapes of the URDF, meshes as convex pieces.
    Collision {
        /// The distance by which convex pieces may extend beyond a mesh where dividing them saves enough, m; by default
        /// 0.005.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        excess_m: Option<f64>,
    },
}

impl RobotShape {
    /// The default for a robot: its collision shapes, or the joint frames if it has none.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        match model.collisions() {
            [] => Self::JointFrames,
            _ => Self::Collision { excess_m: None },
        }
    }
}

pub(crate) fn default_spacing() -> f64 {
    0.05
}

/// The pairs of links that may overlap; all others keep clear of each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", try_from = "WrittenPairs")]
pub enum SelfCollision {
    /// All pairs may overlap.
    Off,
    /// A list of pairs of links, in place of those that the SRDF disables and of neighbours.
    IgnoredPairs(Vec<[String; 2]>),
    /// The path of a file with such pairs, as written by [`IgnoredPairs`](crate::IgnoredPairs), relative to the
    /// scenario.
    IgnoredPairsFile(String),
}

/// The JSON form of a [`SelfCollision`].
#[derive(Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "\"off\" or an object with the key ignored_pairs or ignored_pairs_file is needed"
)]
enum WrittenPairs {
    Off(Off),
    List {
        /// Pairs of links that may overlap, in place of those that the SRDF disables and of neighbours.
        #[schemars(with = "Vec<[String; 2]>")]
        ignored_pairs: Vec<Value>,
    },
    File {
        /// The path of a file with such pairs, as written by `aghf pairs`, relative to the scenario.
        ignored_pairs_file: String,
    },
}

/// The word for no pairs.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Off {
    /// All links may overlap.
    Off,
}

impl TryFrom<WrittenPairs> for SelfCollision {
    type Error = String;

    fn try_from(written: WrittenPairs) -> Checked<Self> {
        let pair = |(i, entry): (usize, Value)| {
            let refused = format!("ignored_pairs[{i}] is {entry} and must be a list of the names of two links");
            serde_json::from_value(entry).map_err(|_| refused)
        };
        Ok(match written {
            WrittenPairs::Off(Off::Off) => Self::Off,
            WrittenPairs::List { ignored_pairs } => {
                Self::IgnoredPairs(ignored_pairs.into_iter().enumerate().map(pair).collect::<Checked<_>>()?)
            }
            WrittenPairs::File { ignored_pairs_file } => Self::IgnoredPairsFile(ignored_pairs_file),
        })
    }
}

/// The fault of an obstacle, in words.
type Checked<T> = std::result::Result<T, String>;

impl Obstacle {
    /// The obstacle in space, or its fault.
    pub(crate) fn solid(&self) -> Checked<Solid> {
        Ok(Solid { placement: self.pose.placement()?, shape: self.shape.checked()? })
    }
}

impl ObstacleShape {
    /// The shape, the lengths of which must be positive.
    pub(crate) fn checked(&self) -> Checked<Shape> {
        let round = |radius: f64, length: f64| {
            check_lengths("radius_m", &[radius])?;
            check_lengths("length_m", &[length])?;
            Ok::<_, String>((radius, 0.5 * length))
        };
        Ok(match *self {
            Self::Sphere { radius_m: radius } => {
                check_lengths("radius_m", &[radius])?;
                Shape::Sphere { radius }
            }
            Self::Box { size_m } => {
                check_lengths("size_m", &size_m)?;
                Shape::Cuboid { half_extents: Vector3::from(size_m) * 0.5 }
            }
            Self::Cylinder { radius_m, length_m } => {
                let (radius, half_length) = round(radius_m, length_m)?;
                Shape::Cylinder { radius, half_length }
            }
            Self::Capsule { radius_m, length_m } => {
                let (radius, half_length) = round(radius_m, length_m)?;
                Shape::Capsule { radius, half_length }
            }
            Self::HalfSpace {} => Shape::HalfSpace,
        })
    }
}

impl Pose {
    pub(crate) fn placement(&self) -> Checked<Placement<f64>> {
        if !bounded(&self.position_m) {
            return Err(format!("position_m needs finite numbers, none above {MAX_LENGTH} m"));
        }
        let rotation = (self.orientation_xyzw).map_or(Ok(UnitQuaternion::identity()), unit_quaternion)?;
        let rotation = rotation.to_rotation_matrix().into_inner();
        Ok(Placement::new(rotation, Vector3::from(self.position_m)))
    }
}

/// The obstacles in space; `path` names the scenario in errors.
pub(crate) fn placed(list: &[Obstacle], path: &str) -> Result<Vec<geometry::Obstacle>> {
    let placed = |(i, obstacle): (usize, &Obstacle)| {
        let key = format!("obstacles[{i}]");
        let solid = obstacle.solid();
        let solid = solid.map_err(|condition| Error::input(path, &key, condition))?;
        let name = obstacle.name.clone().unwrap_or(key);
        Ok(geometry::Obstacle { name, solid })
    };
    list.iter().enumerate().map(placed).collect()
}

pub(crate) fn bounded(x: &[f64]) -> bool {
    x.iter().all(|x| x.abs() <= MAX_LENGTH)
}

fn check_lengths(key: &str, lengths: &[f64]) -> Checked<()> {
    let good = |x: &f64| *x > 0.0 && *x <= MAX_LENGTH;
    match lengths.iter().find(|x| !good(x)) {
        None => Ok(()),
        Some(x) => Err(format!("{key} has {}, a positive number of at most {MAX_LENGTH} m is needed", plain(*x))),
    }
}

/// The rotation of a quaternion `x y z w` of norm one up to rounding.
pub(crate) fn unit_quaternion([x, y, z, w]: [f64; 4]) -> Checked<UnitQuaternion<f64>> {
    let quaternion = Quaternion::new(w, x, y, z);
    let length = quaternion.norm();
    if (length - 1.0).abs() <= NOT_UNIT {
        return Ok(UnitQuaternion::new_normalize(quaternion));
    }
    let length = plain(length);
    Err(format!("the orientation x y z w has length {length}, that of a rotation is 1"))
}
