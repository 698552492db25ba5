//! Messages of ROS 2. They are serialised by their fields, whose order is that of the definitions in
//! [`schemas`](super::schemas).

use aghf::spatial::Placement;
use aghf_scenario::{Header, JointTrajectory};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use serde::Serialize;

/// A message.
pub(super) trait Message: Serialize {
    /// The package and the name of its type.
    const TYPE: [&'static str; 2];
}

impl Message for JointTrajectory {
    const TYPE: [&'static str; 2] = ["trajectory_msgs", "JointTrajectory"];
}

#[derive(Serialize)]
pub(super) struct Text {
    pub data: String,
}

impl Message for Text {
    const TYPE: [&'static str; 2] = ["std_msgs", "String"];
}

#[derive(Serialize)]
pub(super) struct JointState {
    pub header: Header,
    pub name: Vec<String>,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub effort: Vec<f64>,
}

impl Message for JointState {
    const TYPE: [&'static str; 2] = ["sensor_msgs", "JointState"];
}

#[derive(Serialize)]
pub(super) struct Transforms {
    pub transforms: Vec<TransformStamped>,
}

impl Message for Transforms {
    const TYPE: [&'static str; 2] = ["tf2_msgs", "TFMessage"];
}

#[derive(Serialize)]
pub(super) struct TransformStamped {
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Pose,
}

/// A `geometry_msgs/Transform` or `Pose`: a position and a unit quaternion `x y z w`.
#[derive(Serialize)]
pub(super) struct Pose {
    pub position: [f64; 3],
    pub orientation: [f64; 4],
}

impl Pose {
    pub fn new(placement: &Placement<f64>) -> Self {
        let rotation = Rotation3::from_matrix_unchecked(placement.rotation);
        let turn = UnitQuaternion::from_rotation_matrix(&rotation);
        Self { position: placement.translation.into(), orientation: turn.coords.into() }
    }
}

#[derive(Serialize)]
pub(super) struct Markers {
    pub markers: Vec<Marker>,
}

impl Message for Markers {
    const TYPE: [&'static str; 2] = ["visualization_msgs", "MarkerArray"];
}

#[derive(Serialize)]
pub(super) struct Marker {
    pub header: Header,
    pub ns: String,
    pub id: i32,
    pub kind: i32,
    pub action: i32,
    pub pose: Pose,
    pub scale: [f64; 3],
    pub color: [f32; 4],
    pub lifetime: [i32; 2],
    pub frame_locked: bool,
    /// Points, colours and the fields of texts and meshes: none.
    rest: Rest,
}

/// The fields that belong to other kinds of markers.
#[derive(Default, Serialize)]
struct Rest {
    points: Vec<[f64; 3]>,
    colors: Vec<[f32; 4]>,
    texture_resource: String,
    texture: (Header, String, Vec<u8>),
    uv_coordinates: Vec<[f32; 2]>,
    text: String,
    mesh_resource: String,
    mesh_file: (String, Vec<u8>),
    mesh_use_embedded_materials: bool,
}

impl Marker {
    pub const CUBE: i32 = 1;
    pub const SPHERE: i32 = 2;
    pub const CYLINDER: i32 = 3;

    /// A marker of one of these kinds with edges or diameters `scale`, m.
    pub fn new(header: &Header, name: &str, kind: i32, pose: Pose, scale: Vector3<f64>) -> Self {
        Self {
            header: header.clone(),
            ns: name.to_owned(),
            id: 0,
            kind,
            action: 0,
            pose,
            scale: scale.into(),
            color: [0.8, 0.45, 0.2, 0.7],
            lifetime: [0; 2],
            frame_locked: false,
            rest: Rest::default(),
        }
    }
}
