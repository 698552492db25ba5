//! Obstacles as markers.

use super::messages::{Marker, Markers, Pose};
use aghf::geometry::{Obstacle, Shape};
use aghf::spatial::Placement;
use aghf_scenario::Header;
use nalgebra::{Matrix3, Vector3};

/// The edge and the thickness of the plate that stands for a half-space, m.
const PLATE: [f64; 2] = [10.0, 0.01];

/// The markers of obstacles, one for each but three for a capsule: a cylinder and two spheres.
pub(super) fn markers(obstacles: &[Obstacle], header: &Header) -> Markers {
    let mut markers = Vec::new();
    for Obstacle { name, solid } in obstacles {
        let mut add = |kind: i32, along_z: f64, scale: Vector3<f64>| {
            let shift = Placement::new(Matrix3::identity(), Vector3::z() * along_z);
            let pose = Pose::new(&solid.placement.compose(&shift));
            markers.push(Marker::new(header, name, kind, pose, scale));
        };
        let lengths = solid.shape.half_lengths() * 2.0;
        match solid.shape {
            Shape::Sphere { .. } => add(Marker::SPHERE, 0.0, lengths),
            Shape::Cuboid { .. } => add(Marker::CUBE, 0.0, lengths),
            Shape::Cylinder { .. } => add(Marker::CYLINDER, 0.0, lengths),
            Shape::Capsule { half_length, .. } => {
                add(Marker::CYLINDER, 0.0, lengths);
                for end in [-half_length, half_length] {
                    add(Marker::SPHERE, end, Vector3::repeat(lengths.x));
                }
            }
            Shape::HalfSpace => {
                let [edge, thickness] = PLATE;
                add(Marker::CUBE, -0.5 * thickness, Vector3::new(edge, edge, thickness));
            }
        }
    }
    for (id, marker) in (0..).zip(&mut markers) {
        marker.id = id;
    }
    Markers { markers }
}
