//! The `<collision>` elements of a URDF.

use super::elements::{Pose, Read, number, numbers, read_origin, required};
use crate::error::plain;
use crate::geometry::Shape;
use crate::model::CollisionShape;
use nalgebra::Vector3;
use roxmltree::Node;

/// A collision element of a link.
#[derive(Debug)]
pub(super) struct CollisionElement {
    /// The element in messages: its name, or its position among those of the link.
    pub name: String,
    pub origin: Pose,
    pub shape: CollisionShape,
}

/// Reads the collision elements of a link, in their order. An error gives the name of the element, or its position from
/// 1 on.
pub(super) fn read_collisions(link: Node<'_, '_>) -> Read<Vec<CollisionElement>> {
    let found = link.children().filter(|c| c.has_tag_name("collision"));
    let read = |(i, node): (usize, Node<'_, '_>)| {
        let name = match node.attribute("name") {
            Some(name) => format!("collision '{name}'"),
            None => format!("collision {}", i + 1),
        };
        let in_words = |condition: String| format!("{name}: {condition}");
        Ok(CollisionElement {
            origin: read_origin(node).map_err(in_words)?,
            shape: read_geometry(node).map_err(in_words)?,
            name,
        })
    };
    found.enumerate().map(read).collect()
}

pub(super) fn read_geometry(collision: Node<'_, '_>) -> Read<CollisionShape> {
    let geometry = required(collision, "geometry")?;
    let mut shapes = geometry.children().filter(Node::is_element);
    let shape = shapes.next().ok_or("its geometry is empty")?;
    if shapes.next().is_some() {
        return Err("its geometry has several shapes".to_owned());
    }
    let positive = |attribute: &str| {
        let value = number(shape, attribute)?;
        check_positive(shape, attribute, value).map(|()| value)
    };
    Ok(CollisionShape::Solid(match shape.tag_name().name() {
        "sphere" => Shape::Sphere {
            radius: positive("radius")?,
        },
        "box" => {
            let size = numbers::<3>(shape, "size")?;
            (size.iter()).try_for_each(|x| check_positive(shape, "size", *x))?;
            Shape::Cuboid {
                half_extents: Vector3::from(size) * 0.5,
            }
        }
        "cylinder" => Shape::Cylinder {
            radius: positive("radius")?,
            half_length: 0.5 * positive("length")?,
        },
        "capsule" => Shape::Capsule {
            radius: positive("radius")?,
            half_length: 0.5 * positive("length")?,
        },
        "mesh" => return read_mesh(shape),
        other => {
            return Err(format!(
                "its geometry is '{other}', none of sphere, box, cylinder, capsule and mesh"
            ));
        }
    }))
}

fn read_mesh(mesh: Node<'_, '_>) -> Read<CollisionShape> {
    let file = mesh.attribute("filename").unwrap_or_default().trim();
    if file.is_empty() {
        return Err("its mesh has no filename".to_owned());
    }
    let scale = match mesh.has_attribute("scale") {
        true => Vector3::from(numbers(mesh, "scale")?),
        false => Vector3::repeat(1.0),
    };
    // A negative factor is a reflection, which exporters use for the other side of a robot.
    if !scale.iter().all(|x| x.is_finite() && *x != 0.0) {
        return Err("scale of its mesh has a number that is zero or not finite".to_owned());
    }
    Ok(CollisionShape::Mesh {
        file: file.to_owned(),
        scale,
    })
}

fn check_positive(shape: Node<'_, '_>, attribute: &str, value: f64) -> Read<()> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    let (element, value) = (shape.tag_name().name(), plain(value));
    Err(format!(
        "{attribute} of its {element} has {value}, a positive number is needed"
    ))
}
