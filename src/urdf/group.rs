//! Groups of joints and their named states from an SRDF.

use super::Srdf;
use super::elements::Read;
use super::xml::{elements, named, number_list};
use crate::error::{Error, Result};
use crate::model::Model;
use roxmltree::Node;
use std::collections::BTreeSet;

/// The joint between the world and the base in the SRDFs of Pinocchio.
const ROOT: &str = "root_joint";

/// A named set of joints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// Its members.
    pub members: Vec<GroupMember>,
}

/// A member of a [`Group`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GroupMember {
    /// A joint.
    Joint(String),
    /// The joint that carries a link.
    Link(String),
    /// The joints between two links.
    Chain {
        /// The first link.
        base: String,
        /// The last link.
        tip: String,
    },
    /// The joints of another group.
    Group(String),
}

/// Positions of the joints of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupState {
    /// Its name.
    pub name: String,
    /// The name of the group; empty if it names none.
    pub group: String,
    /// The names of joints with their positions, rad or m, of which one with several degrees of freedom has several.
    pub joints: Vec<(String, Vec<f64>)>,
}

/// Reads an element `group`. It has the names alone, which are looked up when the group is used: an SRDF may be for
/// several variants of a robot.
pub(super) fn read_group(node: Node<'_, '_>) -> Read<Group> {
    let mut members = Vec::new();
    for member in elements(node) {
        let kind = member.tag_name().name();
        let named = |name| attribute(member, name).map(str::to_owned);
        members.push(match kind {
            "joint" => GroupMember::Joint(named("name")?),
            "link" => GroupMember::Link(named("name")?),
            "group" => GroupMember::Group(named("name")?),
            "chain" => GroupMember::Chain { base: named("base_link")?, tip: named("tip_link")? },
            // Passive joints and comments of tools.
            _ => continue,
        });
    }
    Ok(Group { name: attribute(node, "name")?.to_owned(), members })
}

/// Reads an element `group_state`.
pub(super) fn read_state(node: Node<'_, '_>) -> Read<GroupState> {
    let mut joints = Vec::new();
    for joint in named(node, "joint") {
        let positions = number_list(joint, "value")?;
        joints.push((attribute(joint, "name")?.to_owned(), positions));
    }
    Ok(GroupState {
        name: attribute(node, "name")?.to_owned(),
        group: node.attribute("group").unwrap_or_default().to_owned(),
        joints,
    })
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Read<&'a str> {
    let found = node.attribute(name);
    found.ok_or_else(|| format!("its {} has no {name}", node.tag_name().name()))
}

impl Srdf {
    /// The moving joints of the group of this name, in the order of the model; `file` names the SRDF in errors.
    ///
    /// # Errors
    /// There is no such group, it is a part of itself, the robot lacks a joint or link of it, or nothing in it moves.
    pub fn joints_of_group(&self, name: &str, model: &Model, file: &str) -> Result<Vec<usize>> {
        let names = self.names_of_group(name, model, file)?;
        let joints = model.joints().iter().enumerate();
        let joints = joints.filter(|(_, joint)| names.contains(joint.name()));
        let joints: Vec<usize> = joints.map(|(i, _)| i).collect();
        if joints.is_empty() {
            let condition = "it has no joint that moves";
            return Err(Error::input(file, format!("group '{name}'"), condition));
        }
        Ok(joints)
    }

    /// The names of all joints of the group of this name, fixed ones and those that are held among them; `file` names
    /// the SRDF in errors.
    ///
    /// # Errors
    /// There is no such group, it is a part of itself, or the robot lacks a joint or link of it.
    pub fn names_of_group(&self, name: &str, model: &Model, file: &str) -> Result<BTreeSet<String>> {
        let mut names = BTreeSet::new();
        self.add_group(name, model, &mut Vec::new(), &mut names)
            .map_err(|(group, condition)| Error::input(file, format!("group '{group}'"), condition))?;
        Ok(names)
    }

    /// Adds the joints of a group that is part of those in `within`. An error is of the named group.
    fn add_group<'a>(
        &'a self,
        name: &'a str,
        model: &Model,
        within: &mut Vec<&'a str>,
        joints: &mut BTreeSet<String>,
    ) -> std::result::Result<(), (&'a str, String)> {
        let refuse = |condition: String| Err((name, condition));
        if within.contains(&name) {
            return refuse("it is a part of itself".to_owned());
        }
        let Some(group) = self.groups.iter().find(|group| group.name == name) else {
            let all: Vec<_> = self.groups.iter().map(|g| format!("'{}'", g.name)).collect();
            return refuse(match all.as_slice() {
                [] => "the SRDF has no groups".to_owned(),
                all => format!("there is no such group, but {}", all.join(", ")),
            });
        };
        within.push(name);
        for member in &group.members {
            let added = match member {
                GroupMember::Group(inner) => {
                    self.add_group(inner, model, within, joints)?;
                    continue;
                }
                GroupMember::Joint(joint) => self.joint(joint, model).map(|_| vec![joint.to_owned()]),
                GroupMember::Link(link) => frame(link, model).map(|i| Vec::from_iter(carrier(i, model))),
                GroupMember::Chain { base, tip } => chain(base, tip, model),
            };
            joints.extend(added.map_err(|condition| (name, condition))?);
        }
        within.pop();
        Ok(())
    }

    /// The number of the moving joint of this name; `None` for a fixed one, and for those between the world and the
    /// base: virtual joints, and `root_joint`, as Pinocchio calls it.
    ///
    /// # Errors
    /// The robot has no such joint; the error is the reason in words.
    pub fn joint(&self, name: &str, model: &Model) -> std::result::Result<Option<usize>, String> {
        if let Some(i) = model.joints().iter().position(|j| j.name() == name) {
            return Ok(Some(i));
        }
        let mut carriers = model.frames().iter().filter_map(|f| f.carrier.as_ref());
        let to_world = name == ROOT || self.virtual_joints.iter().any(|joint| joint == name);
        if to_world || carriers.any(|carrier| carrier.joint == name) {
            Ok(None)
        } else {
            Err(model.no_moving_joint(name))
        }
    }

    /// The positions of moving joints in a state, with their numbers; `file` names the SRDF in errors.
    ///
    /// # Errors
    /// The robot lacks a joint of it, or the state has several numbers for one of its joints.
    pub fn positions(&self, state: &GroupState, model: &Model, file: &str) -> Result<Vec<(usize, f64)>> {
        let refuse = |condition: String| {
            let element = format!("group_state '{}' of '{}'", state.name, state.group);
            Error::input(file, element, condition)
        };
        let mut found = Vec::new();
        for (name, positions) in &state.joints {
            let Some(i) = self.joint(name, model).map_err(refuse)? else {
                continue;
            };
            let [position] = positions.as_slice() else {
                let condition = format!("joint '{name}' has {} numbers, one is needed", positions.len());
                return Err(refuse(condition));
            };
            found.push((i, *position));
        }
        Ok(found)
    }
}

/// The index of the frame of a link.
fn frame(link: &str, model: &Model) -> Read<usize> {
    let found = model.frames().iter().position(|frame| frame.name == link);
    found.ok_or_else(|| model.no_link(link))
}

/// The joint that carries the link of a frame.
fn carrier(frame: usize, model: &Model) -> Option<String> {
    let carrier = model.frames()[frame].carrier.as_ref()?;
    Some(carrier.joint.clone())
}

/// The joints on the way from a link to another: those above one of them and not above both.
fn chain(base: &str, tip: &str, model: &Model) -> Read<Vec<String>> {
    let above = |link: &str| -> Read<BTreeSet<String>> {
        let mut at = Some(frame(link, model)?);
        let mut joints = BTreeSet::new();
        while let Some(frame) = at {
            joints.extend(carrier(frame, model));
            at = model.frames()[frame].carrier.as_ref().and_then(|carrier| carrier.parent);
        }
        Ok(joints)
    };
    let (base, tip) = (above(base)?, above(tip)?);
    Ok(base.symmetric_difference(&tip).cloned().collect())
}
