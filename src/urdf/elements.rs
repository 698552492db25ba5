//! Reading of the elements of a URDF as the types of `urdf-rs`, with messages for their faults.
//!
//! The reader of `urdf-rs` itself cannot be used for files: its errors name neither link nor joint, it passes over
//! words among the numbers of a vector, and a fault of a material or a plugin makes it refuse the file. Visual
//! elements, materials, sensors and plugins are ignored here.

use super::shapes::collision_name;
use crate::error::{Error, Result};
use roxmltree::{Document, Error as XmlError, Node};
use urdf_rs::{
    Axis, Collision, Dynamics, Geometry, Inertia, Inertial, Joint, JointLimit, JointType, Link,
    LinkName, Mass, Mimic, Pose, Robot, Vec3,
};

/// Reads the `robot` element in `text`: links with their inertias and collision elements, and joints. Losses and limits
/// of acceleration and jerk that are not numbers become NaN. `file` names the text in errors.
///
/// # Errors
/// The text is not such an element, or another attribute is missing or not a number. The error names the link or joint.
pub fn read_robot(text: &str, file: &str) -> Result<Robot> {
    let refuse = |condition: String| {
        let condition = format!("not a valid URDF: {condition}");
        Err(Error::input(file, "robot", condition))
    };
    if text.trim_start().starts_with('{') {
        return refuse("it is JSON, such as a scenario, and no XML".to_owned());
    }
    let document = match Document::parse(text) {
        Ok(document) => document,
        Err(error @ (XmlError::UnclosedRootNode | XmlError::NoRootNode)) => {
            let line = 1 + text.trim_end().matches('\n').count();
            return refuse(format!("{error}: the text ends at line {line}"));
        }
        Err(error) => return refuse(error.to_string()),
    };
    let root = document.root_element();
    let kind = root.tag_name().name();
    if kind != "robot" {
        return refuse(format!("the root element is '{kind}'"));
    }
    let mut robot = Robot {
        name: root.attribute("name").unwrap_or_default().to_owned(),
        version: None,
        links: Vec::new(),
        joints: Vec::new(),
        materials: Vec::new(),
    };
    for node in root.children().filter(Node::is_element) {
        let kind = node.tag_name().name();
        if let Some(element) = node.descendants().find(is_xacro) {
            let name = element.tag_name().name();
            let condition = format!(
                "'xacro:{name}' is not expanded: run xacro on the file first, or name it *.xacro"
            );
            return Err(Error::input(file, "robot", condition));
        }
        if !["link", "joint"].contains(&kind) {
            continue;
        }
        let name = node.attribute("name");
        let Some(name) = name.filter(|name| !name.trim().is_empty()) else {
            let line = document.text_pos_at(node.range().start).row;
            return refuse(format!("the {kind} at line {line} has no name"));
        };
        let in_words = |condition| Error::input(file, format!("{kind} '{name}'"), condition);
        if kind == "link" {
            robot.links.push(read_link(node, name).map_err(in_words)?);
        } else {
            robot.joints.push(read_joint(node, name).map_err(in_words)?);
        }
    }
    Ok(robot)
}

/// Returns true for a command of xacro, the macro processor for URDFs.
fn is_xacro(node: &Node<'_, '_>) -> bool {
    (node.tag_name().namespace()).is_some_and(|namespace| namespace.contains("xacro"))
}

/// The content of an element, or its fault.
pub(super) type Read<T> = std::result::Result<T, String>;

fn read_link(link: Node<'_, '_>, name: &str) -> Read<Link> {
    let inertial = match child(link, "inertial")? {
        Some(inertial) => read_inertial(inertial)?,
        None => Inertial::default(),
    };
    let collisions = link.children().filter(|c| c.has_tag_name("collision"));
    let read = |(i, node): (usize, Node<'_, '_>)| {
        let name = node.attribute("name");
        let in_words = |condition| format!("{}: {condition}", collision_name(name, i));
        Ok(Collision {
            name: name.map(str::to_owned),
            origin: read_origin(node).map_err(in_words)?,
            geometry: read_geometry(node).map_err(in_words)?,
        })
    };
    Ok(Link {
        name: name.to_owned(),
        inertial,
        visual: Vec::new(),
        collision: collisions.enumerate().map(read).collect::<Read<_>>()?,
    })
}

fn read_inertial(inertial: Node<'_, '_>) -> Read<Inertial> {
    let origin = read_origin(inertial)?;
    let mass = Mass {
        value: number(required(inertial, "mass")?, "value")?,
    };
    let inertia = required(inertial, "inertia")?;
    let entry = |name| number(inertia, name);
    Ok(Inertial {
        origin,
        mass,
        inertia: Inertia {
            ixx: entry("ixx")?,
            ixy: entry("ixy")?,
            ixz: entry("ixz")?,
            iyy: entry("iyy")?,
            iyz: entry("iyz")?,
            izz: entry("izz")?,
        },
    })
}

/// Reads a joint. Of a fixed one only the origin and the links are read.
fn read_joint(joint: Node<'_, '_>, name: &str) -> Read<Joint> {
    let joint_type = match joint.attribute("type").ok_or("it has no type")? {
        "revolute" => JointType::Revolute,
        "continuous" => JointType::Continuous,
        "prismatic" => JointType::Prismatic,
        "fixed" => JointType::Fixed,
        "floating" => JointType::Floating,
        "planar" => JointType::Planar,
        "spherical" => JointType::Spherical,
        kind => return Err(format!("there is no joint type '{kind}'")),
    };
    let end = |name: &str| -> Read<LinkName> {
        let link = required(joint, name)?.attribute("link");
        let link = link.ok_or(format!("its {name} names no link"))?.to_owned();
        Ok(LinkName { link })
    };
    let mut read = Joint {
        name: name.to_owned(),
        joint_type,
        parent: end("parent")?,
        child: end("child")?,
        origin: read_origin(joint)?,
        axis: Axis::default(),
        limit: JointLimit::default(),
        calibration: None,
        dynamics: None,
        mimic: None,
        safety_controller: None,
    };
    if read.joint_type == JointType::Fixed {
        return Ok(read);
    }
    if let Some(axis) = child(joint, "axis")? {
        read.axis.xyz = Vec3(numbers(axis, "xyz")?);
    }
    if let Some(limit) = child(joint, "limit")? {
        let end = |name| optional(limit, name).map(|end| end.map_or(0.0, |[end]| end));
        read.limit = JointLimit {
            lower: end("lower")?,
            upper: end("upper")?,
            velocity: number(limit, "velocity")?,
            effort: number(limit, "effort")?,
            acceleration: lenient(limit, "acceleration", f64::INFINITY),
            deceleration: lenient(limit, "deceleration", f64::INFINITY),
            jerk: lenient(limit, "jerk", f64::INFINITY),
        };
    }
    if let Some(mimic) = child(joint, "mimic")? {
        let joint = mimic.attribute("joint").ok_or("its mimic names no joint")?;
        read.mimic = Some(Mimic {
            joint: joint.to_owned(),
            multiplier: optional(mimic, "multiplier")?.map(|[number]| number),
            offset: optional(mimic, "offset")?.map(|[number]| number),
        });
    }
    if let Some(dynamics) = child(joint, "dynamics")? {
        read.dynamics = Some(Dynamics {
            damping: lenient(dynamics, "damping", 0.0),
            friction: lenient(dynamics, "friction", 0.0),
        });
    }
    Ok(read)
}

/// A text that need not be a number if it is not used: NaN is noted or refused where it is used.
fn lenient(node: Node<'_, '_>, attribute: &str, default: f64) -> f64 {
    let text = node.attribute(attribute);
    text.map_or(default, |text| text.trim().parse().unwrap_or(f64::NAN))
}

/// Reads the optional origin of an element, both parts of which are optional.
pub(super) fn read_origin(node: Node<'_, '_>) -> Read<Pose> {
    let Some(origin) = child(node, "origin")? else {
        return Ok(Pose::default());
    };
    if origin.has_attribute("quat_xyzw") {
        return Err("quat_xyzw of its origin is not supported: rpy is needed".to_owned());
    }
    let part = |name| optional(origin, name).map(|part| Vec3(part.unwrap_or_default()));
    Ok(Pose {
        xyz: part("xyz")?,
        rpy: part("rpy")?,
    })
}

/// Reads the geometry of a collision or visual element.
pub(super) fn read_geometry(node: Node<'_, '_>) -> Read<Geometry> {
    let geometry = required(node, "geometry")?;
    let mut shapes = geometry.children().filter(Node::is_element);
    let shape = shapes.next().ok_or("its geometry is empty")?;
    if shapes.next().is_some() {
        return Err("its geometry has several shapes".to_owned());
    }
    Ok(match shape.tag_name().name() {
        "sphere" => Geometry::Sphere {
            radius: number(shape, "radius")?,
        },
        "box" => Geometry::Box {
            size: Vec3(numbers(shape, "size")?),
        },
        "cylinder" => Geometry::Cylinder {
            radius: number(shape, "radius")?,
            length: number(shape, "length")?,
        },
        "capsule" => Geometry::Capsule {
            radius: number(shape, "radius")?,
            length: number(shape, "length")?,
        },
        "mesh" => Geometry::Mesh {
            filename: shape.attribute("filename").unwrap_or_default().to_owned(),
            scale: optional(shape, "scale")?.map(Vec3),
        },
        other => {
            return Err(format!(
                "its geometry is '{other}', none of sphere, box, cylinder, capsule and mesh"
            ));
        }
    })
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Read<Option<Node<'a, 'input>>> {
    let mut found = node.children().filter(|c| c.has_tag_name(name));
    let first = found.next();
    if found.next().is_some() {
        return Err(format!("it has several {name} elements"));
    }
    Ok(first)
}

fn required<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Read<Node<'a, 'input>> {
    child(node, name)?.ok_or(format!("it has no {name} element"))
}

pub(super) fn number(node: Node<'_, '_>, attribute: &str) -> Read<f64> {
    numbers(node, attribute).map(|[number]| number)
}

/// Reads exactly `COUNT` numbers from an attribute that may be missing.
fn optional<const COUNT: usize>(node: Node<'_, '_>, attribute: &str) -> Read<Option<[f64; COUNT]>> {
    let given = node.has_attribute(attribute);
    given.then(|| numbers(node, attribute)).transpose()
}

/// Reads exactly `COUNT` numbers from an attribute.
pub(super) fn numbers<const COUNT: usize>(
    node: Node<'_, '_>,
    attribute: &str,
) -> Read<[f64; COUNT]> {
    let element = node.tag_name().name();
    let text = (node.attribute(attribute)).ok_or(format!("its {element} has no {attribute}"))?;
    number_list(node, attribute)
        .ok()
        .and_then(|words| words.try_into().ok())
        .ok_or_else(|| {
            let wanted = match COUNT {
                1 => "a number".to_owned(),
                count => format!("{count} numbers"),
            };
            format!("{attribute} of its {element} is '{text}', not {wanted}")
        })
}

/// Reads any number of numbers from an attribute.
pub(super) fn number_list(node: Node<'_, '_>, attribute: &str) -> Read<Vec<f64>> {
    let element = node.tag_name().name();
    let text = (node.attribute(attribute)).ok_or(format!("its {element} has no {attribute}"))?;
    let words: Option<Vec<f64>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
    words.ok_or_else(|| format!("{attribute} of its {element} is '{text}', not numbers"))
}
