//! Reading of the elements of a URDF as the types of `urdf-rs`, with messages for their faults.
//!
//! The reader of `urdf-rs` itself cannot be used for files: its errors name neither link nor joint, it passes over
//! words among the numbers of a vector, and a fault of a material or a plugin makes it refuse the file. Visual
//! elements, materials, sensors and plugins are ignored here.

use super::shapes::collision_name;
use super::xml::{child, elements, mended, named, number, numbers, optional, required};
use super::{LoadNote, LoadReport};
use crate::error::{Error, Result};
use roxmltree::{Document, Error as XmlError, Node};
use urdf_rs::{
    Axis, Collision, Dynamics, Geometry, Inertia, Inertial, Joint, JointLimit, JointType, Link, LinkName, Mass, Mimic,
    Pose, Robot, SafetyController, Vec3,
};

/// A robot as far as the text of its URDF can be read.
#[derive(Debug)]
pub struct Elements {
    /// The robot. An empty link or a fixed joint at the origin of its parent stands in for one with a fault.
    pub robot: Robot,
    /// The notes on what was left out or completed.
    pub notes: LoadReport,
    /// The faults of links and joints, in the order of the text.
    pub faults: Vec<Error>,
}

/// Reads the `robot` element in `text`: links with their inertias and collision elements, and joints. Losses and limits
/// of acceleration and jerk that are not numbers become NaN. Elements and attributes with a prefix are left out,
/// whether it is declared or not. `file` names the text in errors.
///
/// # Errors
/// The text is not such an element, or another attribute is missing or not a number. The error names the link or joint.
pub fn read_robot(text: &str, file: &str) -> Result<Robot> {
    Ok(Elements::read(text, file)?.whole()?.0)
}

impl Elements {
    /// Reads as [`read_robot`] does, past the faults of links and joints.
    ///
    /// # Errors
    /// The text is no `robot` element, or has a command of xacro.
    pub fn read(text: &str, file: &str) -> Result<Self> {
        if text.trim_start().starts_with('{') {
            let condition = "this is JSON, perhaps a scenario, not XML";
            return Err(invalid(file, condition.to_owned()));
        }
        let (text, notes) = mended(text);
        let document = parsed(&text).map_err(|condition| invalid(file, condition))?;
        let root = document.root_element();
        let mut all = Self {
            robot: Robot {
                name: root.attribute("name").unwrap_or_default().to_owned(),
                version: None,
                links: Vec::new(),
                joints: Vec::new(),
                materials: Vec::new(),
            },
            notes,
            faults: Vec::new(),
        };
        if let Some(element) = root.descendants().find(is_xacro) {
            let name = element.tag_name().name();
            let condition = format!("'xacro:{name}' is not expanded: run xacro on the file first, or name it *.xacro");
            return Err(Error::input(file, "robot", condition));
        }
        for node in elements(root) {
            let kind = node.tag_name().name();
            if !["link", "joint"].contains(&kind) {
                continue;
            }
            match node.attribute("name").filter(|name| !name.trim().is_empty()) {
                Some(name) => all.add(node, (kind, name), file),
                None => {
                    let line = document.text_pos_at(node.range().start).row;
                    let condition = format!("the {kind} at line {line} has no name");
                    all.faults.push(invalid(file, condition));
                }
            }
        }
        Ok(all)
    }

    /// The robot and the notes of a text without faults.
    ///
    /// # Errors
    /// The first fault.
    pub fn whole(self) -> Result<(Robot, LoadReport)> {
        match self.faults.into_iter().next() {
            Some(fault) => Err(fault),
            None => Ok((self.robot, self.notes)),
        }
    }

    /// Adds a link or a joint.
    fn add(&mut self, node: Node<'_, '_>, (kind, name): (&str, &str), file: &str) {
        let mut notes = LoadReport::new();
        let fault = if kind == "link" {
            let read = read_link(node, name, &mut notes);
            let (link, fault) = read.map_or_else(|f| (empty_link(name), Some(f)), |l| (l, None));
            self.robot.links.push(link);
            fault
        } else {
            match read_joint(node, name, &mut notes) {
                Ok(joint) => {
                    self.robot.joints.push(joint);
                    None
                }
                Err(fault) => {
                    self.robot.joints.extend(fixed_joint(node, name));
                    Some(fault)
                }
            }
        };
        match fault {
            None => self.notes.append(&mut notes),
            Some(fault) => {
                let element = format!("{kind} '{name}'");
                self.faults.push(Error::input(file, element, fault));
            }
        }
    }
}

fn invalid(file: &str, condition: String) -> Error {
    Error::input(file, "robot", format!("not a valid URDF: {condition}"))
}

/// The XML of a robot, or its fault.
fn parsed(text: &str) -> Read<Document<'_>> {
    let document = Document::parse(text).map_err(|error| match error {
        XmlError::UnclosedRootNode | XmlError::NoRootNode => {
            let line = 1 + text.trim_end().matches('\n').count();
            format!("{error}: the text ends at line {line}")
        }
        error => error.to_string(),
    })?;
    match document.root_element().tag_name().name() {
        "robot" => Ok(document),
        kind => Err(format!("the root element is '{kind}'")),
    }
}

/// Returns true for a command of xacro, the macro processor for URDFs.
fn is_xacro(node: &Node<'_, '_>) -> bool {
    (node.tag_name().namespace()).is_some_and(|namespace| namespace.contains("xacro"))
}

/// The content of an element, or its fault.
pub(super) type Read<T> = std::result::Result<T, String>;

/// A link without mass and shapes.
fn empty_link(name: &str) -> Link {
    Link { name: name.to_owned(), inertial: Inertial::default(), visual: Vec::new(), collision: Vec::new() }
}

fn read_link(link: Node<'_, '_>, name: &str, notes: &mut LoadReport) -> Read<Link> {
    let inertial = match child(link, "inertial")? {
        Some(inertial) => read_inertial(inertial, name, notes)?,
        None => Inertial::default(),
    };
    let read = |(i, node): (usize, Node<'_, '_>)| {
        let name = node.attribute("name");
        let in_words = |condition| format!("{}: {condition}", collision_name(name, i));
        Ok(Collision {
            name: name.map(str::to_owned),
            origin: read_origin(node).map_err(in_words)?,
            geometry: read_geometry(node).map_err(in_words)?,
        })
    };
    let collisions = named(link, "collision").enumerate();
    Ok(Link { inertial, collision: collisions.map(read).collect::<Read<_>>()?, ..empty_link(name) })
}

/// Reads the inertia of the link of this name. One without moments of inertia is that of a point mass.
fn read_inertial(inertial: Node<'_, '_>, link: &str, notes: &mut LoadReport) -> Read<Inertial> {
    let origin = read_origin(inertial)?;
    let mass = Mass { value: number(required(inertial, "mass")?, "value")? };
    let Some(inertia) = child(inertial, "inertia")? else {
        notes.push(LoadNote::PointMass { link: link.to_owned() });
        return Ok(Inertial { origin, mass, ..Inertial::default() });
    };
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

/// A fixed joint between the links of a joint.
fn fixed_joint(joint: Node<'_, '_>, name: &str) -> Read<Joint> {
    let end = |name: &str| -> Read<LinkName> {
        let link = required(joint, name)?.attribute("link");
        let link = link.ok_or(format!("its {name} names no link"))?.to_owned();
        Ok(LinkName { link })
    };
    Ok(Joint {
        name: name.to_owned(),
        joint_type: JointType::Fixed,
        parent: end("parent")?,
        child: end("child")?,
        origin: Pose::default(),
        axis: Axis::default(),
        limit: JointLimit::default(),
        calibration: None,
        dynamics: None,
        mimic: None,
        safety_controller: None,
    })
}

/// Reads a joint. Of a fixed one only the origin and the links are read.
fn read_joint(joint: Node<'_, '_>, name: &str, notes: &mut LoadReport) -> Read<Joint> {
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
    let mut read = fixed_joint(joint, name)?;
    read.joint_type = joint_type;
    read.origin = read_origin(joint)?;
    if read.joint_type == JointType::Fixed {
        return Ok(read);
    }
    let mut axes = named(joint, "axis");
    if let Some(axis) = axes.next() {
        read.axis.xyz = Vec3(numbers(axis, "xyz")?);
    }
    if axes.next().is_some() {
        notes.push(LoadNote::SeveralAxes { joint: name.to_owned() });
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
        read.dynamics =
            Some(Dynamics { damping: lenient(dynamics, "damping", 0.0), friction: lenient(dynamics, "friction", 0.0) });
    }
    if let Some(safety) = child(joint, "safety_controller")? {
        read.safety_controller = Some(SafetyController {
            soft_lower_limit: lenient(safety, "soft_lower_limit", f64::NEG_INFINITY),
            soft_upper_limit: lenient(safety, "soft_upper_limit", f64::INFINITY),
            k_position: lenient(safety, "k_position", 0.0),
            k_velocity: lenient(safety, "k_velocity", 0.0),
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
    Ok(Pose { xyz: part("xyz")?, rpy: part("rpy")? })
}

/// Reads the geometry of a collision or visual element.
pub(super) fn read_geometry(node: Node<'_, '_>) -> Read<Geometry> {
    let geometry = required(node, "geometry")?;
    let mut shapes = elements(geometry);
    let shape = shapes.next().ok_or("its geometry is empty")?;
    if shapes.next().is_some() {
        return Err("its geometry has several shapes".to_owned());
    }
    Ok(match shape.tag_name().name() {
        "sphere" => Geometry::Sphere { radius: number(shape, "radius")? },
        "box" => Geometry::Box { size: Vec3(numbers(shape, "size")?) },
        "cylinder" => Geometry::Cylinder { radius: number(shape, "radius")?, length: number(shape, "length")? },
        "capsule" => Geometry::Capsule { radius: number(shape, "radius")?, length: number(shape, "length")? },
        "mesh" => Geometry::Mesh {
            filename: shape.attribute("filename").unwrap_or_default().to_owned(),
            scale: optional(shape, "scale")?.map(Vec3),
        },
        other => {
            return Err(format!("its geometry is '{other}', none of sphere, box, cylinder, capsule and mesh"));
        }
    })
}
