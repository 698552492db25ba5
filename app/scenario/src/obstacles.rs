//! The obstacles of a scenario file, and the shape of the robot.

use aghf::constraint::{HalfSpace, Sphere};
use aghf::error::{Error, Result, plain};
use aghf::geometry::{Shape, Solid};
use aghf::spatial::Placement;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The largest length, m: far beyond any robot. Squared distances must neither overflow nor lose the size of the
/// obstacle to rounding.
pub(super) const LARGEST_LENGTH: f64 = 1e6;

/// The largest deviation of the norm of an orientation from one.
const NOT_UNIT: f64 = 1e-3;

/// A sphere to keep clear of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereObstacle {
    /// Centre in the base frame, m.
    pub center_m: [f64; 3],
    /// Radius, m.
    pub radius_m: f64,
    /// Name in reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// A half-space to stay in, such as the space above a floor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceObstacle {
    /// A vector in the base frame, of any length, pointing into the free half-space.
    pub normal: [f64; 3],
    /// The position of the boundary along the unit normal, m.
    pub offset_m: f64,
    /// Name in reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// A box to keep clear of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxObstacle {
    /// Centre in the base frame, m.
    pub center_m: [f64; 3],
    /// Edge lengths along its own axes, m.
    pub size_m: [f64; 3],
    /// The unit quaternion that rotates the axes of the base into its own; the identity by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation_xyzw: Option<[f64; 4]>,
    /// Name in reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// A cylinder to keep clear of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderObstacle {
    /// Centre in the base frame, m.
    pub center_m: [f64; 3],
    /// Radius, m.
    pub radius_m: f64,
    /// Length along its own `z` axis, m.
    pub length_m: f64,
    /// The unit quaternion that rotates the axes of the base into its own; the identity by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation_xyzw: Option<[f64; 4]>,
    /// Name in reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// A capsule to keep clear of: all points within a radius of a segment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CapsuleObstacle {
    /// The ends of the segment in the base frame, m.
    pub ends_m: [[f64; 3]; 2],
    /// Radius, m.
    pub radius_m: f64,
    /// Name in reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// The parts of the robot that keep clear of obstacles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RobotShape {
    /// The origins of all joint frames: the paper's measure.
    #[default]
    JointFrames,
    /// The whole arm: capsules along all links.
    SweptLinks {
        /// Radius of the capsules, m.
        radius_m: f64,
        /// Largest distance between the balls that cover the capsules, m.
        #[serde(default = "default_spacing")]
        spacing_m: f64,
    },
    /// The collision shapes of the URDF: spheres as they are, others covered by balls.
    Collision {
        /// The spacing of the balls, m; see [`Shape::cover`] and [`cover_triangles`](aghf::geometry::cover_triangles).
        #[serde(default = "default_spacing")]
        spacing_m: f64,
    },
}

fn default_spacing() -> f64 {
    0.05
}

/// The pairs of links that may overlap; all others keep clear of each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", try_from = "WrittenPairs")]
pub enum SelfCollision {
    /// A list of pairs of links.
    IgnoredPairs(Vec<[String; 2]>),
    /// The path of a file with such pairs, as written by [`IgnoredPairs`](super::IgnoredPairs), relative to the
    /// scenario.
    IgnoredPairsFile(String),
}

/// The JSON form of a [`SelfCollision`].
#[derive(Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(
    deny_unknown_fields,
    expecting = "an object with the key ignored_pairs or ignored_pairs_file"
)]
struct WrittenPairs {
    /// Pairs of links.
    ignored_pairs: Option<Vec<[String; 2]>>,
    /// The path of a file with such pairs, as written by `aghf pairs`, relative to the scenario.
    ignored_pairs_file: Option<String>,
}

impl TryFrom<WrittenPairs> for SelfCollision {
    type Error = &'static str;

    fn try_from(written: WrittenPairs) -> std::result::Result<Self, Self::Error> {
        match (written.ignored_pairs, written.ignored_pairs_file) {
            (Some(pairs), None) => Ok(Self::IgnoredPairs(pairs)),
            (None, Some(file)) => Ok(Self::IgnoredPairsFile(file)),
            _ => Err("one of the keys ignored_pairs and ignored_pairs_file is needed"),
        }
    }
}

/// The fault of an obstacle, in words.
type Checked<T> = std::result::Result<T, String>;

/// An obstacle of a scenario file.
pub(super) trait Obstacle {
    /// The key in a scenario.
    const KEY: &'static str;
    /// The type of the solid.
    type Placed;

    /// The given name.
    fn name(&self) -> Option<&String>;

    /// The solid in space, or the fault of the entry.
    fn placed(&self) -> Checked<Self::Placed>;
}

/// An obstacle in space with its place in the file.
#[derive(Clone, Debug)]
pub(super) struct Named<T> {
    /// Key and number, such as `sphere_obstacles[2]`.
    pub key: String,
    /// The given name.
    pub name: Option<String>,
    /// The solid in space.
    pub placed: T,
}

impl<T> Named<T> {
    /// The given name, or otherwise key and number.
    pub fn name(&self) -> &str {
        self.name.as_ref().unwrap_or(&self.key)
    }
}

impl<T> fmt::Display for Named<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.key)?;
        match &self.name {
            Some(name) => write!(f, " '{name}'"),
            None => Ok(()),
        }
    }
}

/// The obstacles of a list; `path` names the scenario in errors.
pub(super) fn placed<O: Obstacle>(list: &[O], path: &str) -> Result<Vec<Named<O::Placed>>> {
    let named = |(i, obstacle): (usize, &O)| {
        let key = format!("{}[{i}]", O::KEY);
        let placed = obstacle.placed();
        Ok(Named {
            placed: placed.map_err(|condition| Error::input(path, &key, condition))?,
            name: obstacle.name().cloned(),
            key,
        })
    };
    list.iter().enumerate().map(named).collect()
}

impl Obstacle for SphereObstacle {
    const KEY: &'static str = "sphere_obstacles";
    type Placed = Sphere;

    fn name(&self) -> Option<&String> {
        self.name.as_ref()
    }

    fn placed(&self) -> Checked<Sphere> {
        let radius = self.radius_m;
        if bounded(&self.center_m) && bounded(&[radius]) && radius > 0.0 {
            let centre = Vector3::from(self.center_m);
            return Ok(Sphere { centre, radius });
        }
        Err(format!(
            "a finite centre and a positive radius are needed, no number above {LARGEST_LENGTH} m"
        ))
    }
}

impl Obstacle for HalfSpaceObstacle {
    const KEY: &'static str = "half_spaces";
    type Placed = HalfSpace;

    fn name(&self) -> Option<&String> {
        self.name.as_ref()
    }

    fn placed(&self) -> Checked<HalfSpace> {
        let normal = Vector3::from(self.normal);
        let length = normal.norm();
        if length.is_finite() && length > 0.0 && bounded(&[self.offset_m]) {
            return Ok(HalfSpace {
                normal: normal / length,
                offset: self.offset_m,
            });
        }
        Err(format!(
            "a finite normal that is not zero and a finite offset of at most {LARGEST_LENGTH} m are needed"
        ))
    }
}

impl Obstacle for BoxObstacle {
    const KEY: &'static str = "box_obstacles";
    type Placed = Solid;

    fn name(&self) -> Option<&String> {
        self.name.as_ref()
    }

    fn placed(&self) -> Checked<Solid> {
        check_lengths("size_m", &self.size_m)?;
        let half_extents = Vector3::from(self.size_m) * 0.5;
        Ok(Solid {
            placement: placement(self.center_m, self.orientation_xyzw)?,
            shape: Shape::Cuboid { half_extents },
        })
    }
}

impl Obstacle for CylinderObstacle {
    const KEY: &'static str = "cylinder_obstacles";
    type Placed = Solid;

    fn name(&self) -> Option<&String> {
        self.name.as_ref()
    }

    fn placed(&self) -> Checked<Solid> {
        check_lengths("radius_m", &[self.radius_m])?;
        check_lengths("length_m", &[self.length_m])?;
        Ok(Solid {
            placement: placement(self.center_m, self.orientation_xyzw)?,
            shape: Shape::Cylinder {
                radius: self.radius_m,
                half_length: 0.5 * self.length_m,
            },
        })
    }
}

impl Obstacle for CapsuleObstacle {
    const KEY: &'static str = "capsule_obstacles";
    type Placed = Solid;

    fn name(&self) -> Option<&String> {
        self.name.as_ref()
    }

    fn placed(&self) -> Checked<Solid> {
        check_lengths("radius_m", &[self.radius_m])?;
        let [from, to] = self.ends_m.map(Vector3::from);
        let along = to - from;
        let length = along.norm();
        if !bounded(self.ends_m.as_flattened()) || length == 0.0 {
            return Err(format!(
                "ends_m needs two different points, no number above {LARGEST_LENGTH} m"
            ));
        }
        // Against the axis any half turn will do.
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along).unwrap_or_else(|| {
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
        let rotation = turn.to_rotation_matrix().into_inner();
        Ok(Solid {
            placement: Placement::new(rotation, (from + to) * 0.5),
            shape: Shape::Capsule {
                radius: self.radius_m,
                half_length: 0.5 * length,
            },
        })
    }
}

fn bounded(x: &[f64]) -> bool {
    x.iter().all(|x| x.abs() <= LARGEST_LENGTH)
}

fn check_lengths(key: &str, lengths: &[f64]) -> Checked<()> {
    let good = |x: &f64| *x > 0.0 && *x <= LARGEST_LENGTH;
    match lengths.iter().find(|x| !good(x)) {
        None => Ok(()),
        Some(x) => Err(format!(
            "{key} has {}, a positive number of at most {LARGEST_LENGTH} m is needed",
            plain(*x)
        )),
    }
}

/// The pose of an obstacle.
fn placement(center: [f64; 3], orientation: Option<[f64; 4]>) -> Checked<Placement<f64>> {
    if !bounded(&center) {
        return Err(format!(
            "center_m needs finite numbers, none above {LARGEST_LENGTH} m"
        ));
    }
    let rotation = orientation.map_or(Ok(UnitQuaternion::identity()), unit_quaternion)?;
    let rotation = rotation.to_rotation_matrix().into_inner();
    Ok(Placement::new(rotation, Vector3::from(center)))
}

/// The rotation of a quaternion `x y z w` of norm one up to rounding.
pub(super) fn unit_quaternion([x, y, z, w]: [f64; 4]) -> Checked<UnitQuaternion<f64>> {
    let quaternion = Quaternion::new(w, x, y, z);
    let length = quaternion.norm();
    if (length - 1.0).abs() <= NOT_UNIT {
        return Ok(UnitQuaternion::new_normalize(quaternion));
    }
    let length = plain(length);
    Err(format!(
        "the orientation x y z w has length {length}, that of a rotation is 1"
    ))
}
