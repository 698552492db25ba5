//! What the dynamics read of the text of a URDF, and what is wrong with that, said in the words of its elements.
//!
//! `urdf-rs` reads the file, but its errors do not name the link or joint, and it passes over words among the three numbers
//! of a vector. So the elements that the dynamics read are looked at first, and `urdf-rs` is given these alone: no mesh,
//! material, sensor or plugin can make a file fail.

use crate::error::{Error, Result};
use roxmltree::{Document, Node};

/// The joint types of URDF.
const JOINT_TYPES: [&str; 7] = [
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
    "floating",
    "planar",
    "spherical",
];

/// What the dynamics read of a link.
const OF_LINKS: [&str; 1] = ["inertial"];
/// What they read of a joint that moves, and, the first three, of one that does not.
const OF_JOINTS: [&str; 6] = ["origin", "parent", "child", "axis", "limit", "mimic"];

/// Checks that `text` is a `robot` element whose links and joints have the attributes that the dynamics need, and that
/// these are numbers where they have to be. Returns that element without all that the dynamics do not read.
pub(super) fn dynamics_only(text: &str, file: &str) -> Result<String> {
    let refuse = |condition: String| {
        Err(Error::input(
            file,
            "robot",
            format!("not a valid URDF: {condition}"),
        ))
    };
    let document = match Document::parse(text) {
        Ok(document) => document,
        Err(error) => return refuse(error.to_string()),
    };
    let root = document.root_element();
    let kind = root.tag_name().name();
    if kind != "robot" {
        return refuse(format!("the root element is '{kind}'"));
    }
    let mut kept = String::new();
    let mut end = root.range().start;
    // Goes on to the end of what is cut.
    let mut cut = |node: Node<'_, '_>| {
        kept.push_str(&text[end..node.range().start]);
        end = node.range().end;
    };
    for node in root.children().filter(Node::is_element) {
        let kind = node.tag_name().name();
        if let Some(element) = node.descendants().find(is_xacro) {
            let name = element.tag_name().name();
            let condition = format!("'xacro:{name}' is not expanded: run xacro on the file first");
            return Err(Error::input(file, "robot", condition));
        }
        let (checked, read) = match kind {
            "link" => (check_link(node), &OF_LINKS[..]),
            "joint" if is_fixed(node) => (check_joint(node), &OF_JOINTS[..3]),
            "joint" => (
                check_joint(node).and_then(|()| check_motion(node)),
                &OF_JOINTS[..],
            ),
            _ => {
                cut(node);
                continue;
            }
        };
        let Some(name) = node.attribute("name") else {
            return refuse(format!("a {kind} has no name"));
        };
        checked.map_err(|condition| Error::input(file, format!("{kind} '{name}'"), condition))?;
        let is_read = |child: &Node<'_, '_>| read.contains(&child.tag_name().name());
        let unread = |child: &Node<'_, '_>| child.is_element() && !is_read(child);
        node.children().filter(unread).for_each(&mut cut);
    }
    kept.push_str(&text[end..root.range().end]);
    Ok(kept)
}

/// Whether this is a command to the macro processor that writes many URDFs.
fn is_xacro(node: &Node<'_, '_>) -> bool {
    (node.tag_name().namespace()).is_some_and(|namespace| namespace.contains("xacro"))
}

fn is_fixed(joint: Node<'_, '_>) -> bool {
    joint.attribute("type") == Some("fixed")
}

/// What is wrong with an element, if anything is.
type Check = std::result::Result<(), String>;

fn check_link(link: Node<'_, '_>) -> Check {
    let Some(inertial) = child(link, "inertial") else {
        return Ok(());
    };
    check_origin(inertial)?;
    check_numbers(required(inertial, "mass")?, &["value"], 1)?;
    let inertia = required(inertial, "inertia")?;
    check_numbers(inertia, &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"], 1)
}

fn check_joint(joint: Node<'_, '_>) -> Check {
    let kind = joint.attribute("type").ok_or("it has no type")?;
    if !JOINT_TYPES.contains(&kind) {
        return Err(format!("there is no joint type '{kind}'"));
    }
    for end in ["parent", "child"] {
        let link = required(joint, end)?;
        link.attribute("link")
            .ok_or(format!("its {end} names no link"))?;
    }
    check_origin(joint)
}

/// What only joints that move have.
fn check_motion(joint: Node<'_, '_>) -> Check {
    if let Some(axis) = child(joint, "axis") {
        check_numbers(axis, &["xyz"], 3)?;
    }
    if let Some(limit) = child(joint, "limit") {
        for name in ["lower", "upper"] {
            if limit.has_attribute(name) {
                check_numbers(limit, &[name], 1)?;
            }
        }
        check_numbers(limit, &["velocity", "effort"], 1)?;
    }
    Ok(())
}

/// An origin need not be there, nor have both parts.
fn check_origin(node: Node<'_, '_>) -> Check {
    let Some(origin) = child(node, "origin") else {
        return Ok(());
    };
    for part in ["xyz", "rpy"] {
        if origin.has_attribute(part) {
            check_numbers(origin, &[part], 3)?;
        }
    }
    Ok(())
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|c| c.has_tag_name(name))
}

fn required<'a, 'input>(
    node: Node<'a, 'input>,
    name: &str,
) -> std::result::Result<Node<'a, 'input>, String> {
    child(node, name).ok_or(format!("it has no {name} element"))
}

/// Checks that each attribute holds `count` numbers and nothing else.
fn check_numbers(node: Node<'_, '_>, attributes: &[&str], count: usize) -> Check {
    let element = node.tag_name().name();
    for name in attributes {
        let Some(text) = node.attribute(*name) else {
            return Err(format!("its {element} has no {name}"));
        };
        let mut words = text.split_whitespace();
        let found = words.clone().count();
        if found != count || words.any(|word| word.parse::<f64>().is_err()) {
            let wanted = if count == 1 {
                "a number".to_owned()
            } else {
                format!("{count} numbers")
            };
            return Err(format!("{name} of its {element} is '{text}', not {wanted}"));
        }
    }
    Ok(())
}
