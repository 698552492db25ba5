//! The URDF elements that are read, with messages for their faults.
//!
//! Visual elements, materials, sensors and plugins are ignored, so that none of them can make a file fail.

use super::shapes::{CollisionElement, read_collisions};
use crate::error::{Error, Result};
use roxmltree::{Document, Error as XmlError, Node};

/// A robot as described in its file.
#[derive(Debug)]
pub(super) struct Robot {
    pub name: String,
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
}

/// A link; zeros without an inertial element.
#[derive(Debug)]
pub(super) struct Link {
    pub name: String,
    /// The frame of the centre of mass.
    pub origin: Pose,
    pub mass: f64,
    /// `ixx ixy ixz iyy iyz izz` about the centre of mass.
    pub inertia: [f64; 6],
    /// The collision elements.
    pub collisions: Vec<CollisionElement>,
}

/// A joint.
#[derive(Debug)]
pub(super) struct Joint {
    pub name: String,
    pub kind: JointType,
    pub origin: Pose,
    pub parent: String,
    pub child: String,
    pub axis: [f64; 3],
    /// `None` without a limit element, or if all its entries are zero.
    pub limit: Option<Limit>,
    /// The joint that a mimic joint follows.
    pub mimics: Option<String>,
    /// The names of those of damping and friction that are not zero.
    pub losses: Vec<&'static str>,
}

/// The joint types of URDF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JointType {
    Revolute,
    Continuous,
    Prismatic,
    Fixed,
    Floating,
    Planar,
    Spherical,
}

/// A translation, and rotations about the fixed axes x, y, z in this order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pose {
    pub xyz: [f64; 3],
    pub rpy: [f64; 3],
}

/// The limits of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    pub lower: f64,
    pub upper: f64,
    pub velocity: f64,
    pub effort: f64,
}

/// Reads the `robot` element in `text`.
///
/// # Errors
/// The text is not such an element, or an attribute that the dynamics need is missing or not a number. The error names
/// `file` and the link or joint.
pub(super) fn read_robot(text: &str, file: &str) -> Result<Robot> {
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
        links: Vec::new(),
        joints: Vec::new(),
    };
    for node in root.children().filter(Node::is_element) {
        let kind = node.tag_name().name();
        if let Some(element) = node.descendants().find(is_xacro) {
            let name = element.tag_name().name();
            let condition = format!("'xacro:{name}' is not expanded: run xacro on the file first");
            return Err(Error::input(file, "robot", condition));
        }
        if !["link", "joint"].contains(&kind) {
            continue;
        }
        let Some(name) = node.attribute("name") else {
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
    let mut read = Link {
        name: name.to_owned(),
        origin: Pose::default(),
        mass: 0.0,
        inertia: [0.0; 6],
        collisions: read_collisions(link)?,
    };
    if let Some(inertial) = child(link, "inertial")? {
        read.origin = read_origin(inertial)?;
        read.mass = number(required(inertial, "mass")?, "value")?;
        let inertia = required(inertial, "inertia")?;
        let entries = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        for (entry, name) in read.inertia.iter_mut().zip(entries) {
            *entry = number(inertia, name)?;
        }
    }
    Ok(read)
}

fn read_joint(joint: Node<'_, '_>, name: &str) -> Read<Joint> {
    let kind = match joint.attribute("type").ok_or("it has no type")? {
        "revolute" => JointType::Revolute,
        "continuous" => JointType::Continuous,
        "prismatic" => JointType::Prismatic,
        "fixed" => JointType::Fixed,
        "floating" => JointType::Floating,
        "planar" => JointType::Planar,
        "spherical" => JointType::Spherical,
        kind => return Err(format!("there is no joint type '{kind}'")),
    };
    let end = |name: &str| -> Read<String> {
        let link = required(joint, name)?.attribute("link");
        Ok(link.ok_or(format!("its {name} names no link"))?.to_owned())
    };
    let mut read = Joint {
        name: name.to_owned(),
        kind,
        origin: Pose::default(),
        parent: end("parent")?,
        child: end("child")?,
        axis: [1.0, 0.0, 0.0],
        limit: None,
        mimics: None,
        losses: Vec::new(),
    };
    read.origin = read_origin(joint)?;
    if kind == JointType::Fixed {
        return Ok(read);
    }
    if let Some(axis) = child(joint, "axis")? {
        read.axis = numbers(axis, "xyz")?;
    }
    if let Some(limit) = child(joint, "limit")? {
        let optional = |name: &str| -> Read<f64> {
            let given = limit.has_attribute(name);
            if given { number(limit, name) } else { Ok(0.0) }
        };
        let limit = Limit {
            lower: optional("lower")?,
            upper: optional("upper")?,
            velocity: number(limit, "velocity")?,
            effort: number(limit, "effort")?,
        };
        let values = [limit.lower, limit.upper, limit.velocity, limit.effort];
        read.limit = values.iter().any(|x| *x != 0.0).then_some(limit);
    }
    if let Some(mimic) = child(joint, "mimic")? {
        let mimics = mimic.attribute("joint").ok_or("its mimic names no joint")?;
        read.mimics = Some(mimics.to_owned());
    }
    if let Some(dynamics) = child(joint, "dynamics")? {
        // They are not read, so they need not be numbers either.
        let is_zero = |text: &str| text.trim().parse() == Ok(0.0);
        let given = |name: &&str| (dynamics.attribute(*name)).is_some_and(|text| !is_zero(text));
        read.losses
            .extend(["damping", "friction"].into_iter().filter(given));
    }
    Ok(read)
}

/// Reads the optional origin of an element, both parts of which are optional.
pub(super) fn read_origin(node: Node<'_, '_>) -> Read<Pose> {
    let mut pose = Pose::default();
    if let Some(origin) = child(node, "origin")? {
        for (part, name) in [(&mut pose.xyz, "xyz"), (&mut pose.rpy, "rpy")] {
            if origin.has_attribute(name) {
                *part = numbers(origin, name)?;
            }
        }
    }
    Ok(pose)
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Read<Option<Node<'a, 'input>>> {
    let mut found = node.children().filter(|c| c.has_tag_name(name));
    let first = found.next();
    if found.next().is_some() {
        return Err(format!("it has several {name} elements"));
    }
    Ok(first)
}

pub(super) fn required<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Read<Node<'a, 'input>> {
    child(node, name)?.ok_or(format!("it has no {name} element"))
}

pub(super) fn number(node: Node<'_, '_>, attribute: &str) -> Read<f64> {
    numbers(node, attribute).map(|[number]| number)
}

/// Reads exactly `COUNT` numbers from an attribute.
pub(super) fn numbers<const COUNT: usize>(
    node: Node<'_, '_>,
    attribute: &str,
) -> Read<[f64; COUNT]> {
    let element = node.tag_name().name();
    let text = (node.attribute(attribute)).ok_or(format!("its {element} has no {attribute}"))?;
    let words: Option<Vec<f64>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
    words
        .and_then(|words| words.try_into().ok())
        .ok_or_else(|| {
            let wanted = match COUNT {
                1 => "a number".to_owned(),
                count => format!("{count} numbers"),
            };
            format!("{attribute} of its {element} is '{text}', not {wanted}")
        })
}
