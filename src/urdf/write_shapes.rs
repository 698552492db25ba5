//! Writing of the shapes of links.

use super::write::{Xml, empty, numbers, roll_pitch_yaw};
use crate::geometry::Shape;
use crate::model::CollisionShape;
use crate::spatial::Placement;
use std::io;

/// Writes a collision element; `origin` is the placement of the shape in the frame of its link.
pub(super) fn write_collision(xml: &mut Xml, origin: &Placement<f64>, shape: &CollisionShape) -> io::Result<()> {
    xml.create_element("collision").write_inner_content(|xml| {
        let pose = [("xyz", numbers(&origin.translation)), ("rpy", numbers(&roll_pitch_yaw(&origin.rotation)))];
        empty(xml, "origin", &pose)?;
        xml.create_element("geometry").write_inner_content(|xml| write_shape(xml, shape))?;
        Ok(())
    })?;
    Ok(())
}

fn write_shape(xml: &mut Xml, shape: &CollisionShape) -> io::Result<()> {
    let round =
        |radius: &f64, half_length: &f64| [("radius", numbers([radius])), ("length", numbers([&(2.0 * half_length)]))];
    match shape {
        CollisionShape::Solid(Shape::Sphere { radius }) => empty(xml, "sphere", &[("radius", numbers([radius]))]),
        CollisionShape::Solid(Shape::Cuboid { half_extents }) => {
            empty(xml, "box", &[("size", numbers(&(half_extents * 2.0)))])
        }
        CollisionShape::Solid(Shape::Cylinder { radius, half_length }) => {
            empty(xml, "cylinder", &round(radius, half_length))
        }
        CollisionShape::Solid(Shape::Capsule { radius, half_length }) => {
            empty(xml, "capsule", &round(radius, half_length))
        }
        CollisionShape::Solid(shape) => {
            let condition = format!("a {} has no element in a URDF", shape.name());
            Err(io::Error::other(condition))
        }
        CollisionShape::Mesh { file, scale } => {
            let attributes = [("filename", file.clone()), ("scale", numbers(scale))];
            empty(xml, "mesh", &attributes)
        }
    }
}
