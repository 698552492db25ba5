//! The shapes of collision and visual elements.

use super::elements::Read;
use crate::error::plain;
use crate::geometry::Shape;
use crate::model::CollisionShape;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{PathBuf, absolute};
use urdf_rs::Geometry;

/// A collision element in messages: its name, or its position among those of the link, from 1 on.
pub(super) fn collision_name(name: Option<&str>, index: usize) -> String {
    name.map_or_else(|| format!("collision {}", index + 1), |name| format!("collision '{name}'"))
}

/// Returns true for a point or a line: a sphere, a cylinder or a capsule of radius zero, and a box of zeros.
pub(super) fn has_no_extent(geometry: &Geometry) -> bool {
    match geometry {
        Geometry::Sphere { radius } | Geometry::Cylinder { radius, .. } | Geometry::Capsule { radius, .. } => {
            *radius == 0.0
        }
        Geometry::Box { size } => size.iter().all(|length| *length == 0.0),
        Geometry::Mesh { .. } => false,
    }
}

/// Converts a geometry, the sizes of which must be positive and finite. `packages` are those of
/// [`UrdfOptions`](super::UrdfOptions).
pub(super) fn convert_shape(geometry: &Geometry, packages: &BTreeMap<String, PathBuf>) -> Read<CollisionShape> {
    let positive = |element: &str, attribute: &str, value: f64| {
        if value.is_finite() && value > 0.0 {
            return Ok(value);
        }
        let value = plain(value);
        Err(format!("{attribute} of its {element} has {value}, a positive number is needed"))
    };
    Ok(CollisionShape::Solid(match geometry {
        Geometry::Sphere { radius } => Shape::Sphere { radius: positive("sphere", "radius", *radius)? },
        Geometry::Box { size } => {
            for length in size.iter() {
                positive("box", "size", *length)?;
            }
            Shape::Cuboid { half_extents: Vector3::from(size.0) * 0.5 }
        }
        Geometry::Cylinder { radius, length } => Shape::Cylinder {
            radius: positive("cylinder", "radius", *radius)?,
            half_length: 0.5 * positive("cylinder", "length", *length)?,
        },
        Geometry::Capsule { radius, length } => Shape::Capsule {
            radius: positive("capsule", "radius", *radius)?,
            half_length: 0.5 * positive("capsule", "length", *length)?,
        },
        Geometry::Mesh { filename, scale } => {
            let file = filename.trim();
            if file.is_empty() {
                return Err("its mesh has no filename".to_owned());
            }
            let scale = scale.map_or(Vector3::repeat(1.0), |scale| Vector3::from(scale.0));
            // A negative factor is a reflection, which exporters use for the other side of a robot.
            if !scale.iter().all(|x| x.is_finite() && *x != 0.0) {
                return Err("scale of its mesh has a number that is zero or not finite".to_owned());
            }
            return Ok(CollisionShape::Mesh { file: in_package(file, packages)?, scale });
        }
    }))
}

/// The path of a file in a package whose folder is given, otherwise its name as the URDF has it.
pub(super) fn in_package(file: &str, packages: &BTreeMap<String, PathBuf>) -> Read<String> {
    let found = package_and_path(file).and_then(|(package, path)| Some(packages.get(package)?.join(path)));
    Ok(match found {
        Some(path) => {
            let path = absolute(path).map_err(|e| e.to_string())?;
            path.to_string_lossy().into_owned()
        }
        None => file.to_owned(),
    })
}

/// The package and the path in it that a file name `package://NAME/PATH`, or `package:///NAME/PATH`, consists of.
pub(super) fn package_and_path(file: &str) -> Option<(&str, &str)> {
    let in_package = file.strip_prefix("package://")?;
    in_package.trim_start_matches('/').split_once('/')
}
