//! The order in which the links of a URDF are visited, with checks that they form a tree.

use crate::error::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use urdf_rs::{Joint, Link, Robot};

/// A link in the order from the root to the leaves.
pub(super) struct Visit<'a> {
    /// The link.
    pub link: &'a Link,
    /// The joint that carries it; `None` for the root.
    pub joint: Option<&'a Joint>,
    /// The position of the parent link in the order; zero for the root.
    pub parent: usize,
}

/// Visits the links depth first from the root, the children of a link in the order of their joints' names, like
/// Pinocchio.
pub(super) fn walk<'a>(robot: &'a Robot, file: &str) -> Result<Vec<Visit<'a>>> {
    let refuse = |element: String, condition: &str| Err(Error::input(file, element, condition));
    let mut links = BTreeMap::new();
    for link in &robot.links {
        if links.insert(link.name.as_str(), link).is_some() {
            return refuse(format!("link '{}'", link.name), "the name occurs twice");
        }
    }
    let (children, carried) = children(robot, &links, file)?;
    let root = root(robot, &carried).map_err(|condition| Error::input(file, "robot", condition))?;
    let mut visits = Vec::with_capacity(robot.links.len());
    let mut pending = vec![Visit { link: root, joint: None, parent: 0 }];
    while let Some(visit) = pending.pop() {
        let parent = visits.len();
        let below = children.get(visit.link.name.as_str());
        // The last one pushed is visited next, so the first by name is pushed last.
        for joint in below.into_iter().flatten().rev() {
            pending.push(Visit { link: links[joint.child.link.as_str()], joint: Some(joint), parent });
        }
        visits.push(visit);
    }
    let reached: BTreeSet<&str> = visits.iter().map(|v| v.link.name.as_str()).collect();
    let mut links = robot.links.iter();
    if let Some(link) = links.find(|l| !reached.contains(l.name.as_str())) {
        return refuse(format!("link '{}'", link.name), "it cannot be reached from the root: the links form a loop");
    }
    Ok(visits)
}

/// The joints below each link.
type Children<'a> = BTreeMap<&'a str, Vec<&'a Joint>>;

/// The joints below each link, in the order of their names, and the links that hang on them.
fn children<'a>(
    robot: &'a Robot,
    links: &BTreeMap<&str, &Link>,
    file: &str,
) -> Result<(Children<'a>, BTreeSet<&'a str>)> {
    let (mut names, mut carried) = (BTreeSet::new(), BTreeSet::new());
    let mut children = Children::new();
    for joint in &robot.joints {
        let refuse = |condition: &str| {
            let element = format!("joint '{}'", joint.name);
            Err(Error::input(file, element, condition))
        };
        if !names.insert(joint.name.as_str()) {
            return refuse("the name occurs twice");
        }
        let (parent, child) = (joint.parent.link.as_str(), joint.child.link.as_str());
        if let Some(unknown) = [parent, child].iter().find(|l| !links.contains_key(**l)) {
            return refuse(&format!("there is no link '{unknown}'"));
        }
        if !carried.insert(child) {
            return refuse(&format!("link '{child}' hangs on a second joint: the links form a loop"));
        }
        children.entry(parent).or_default().push(joint);
    }
    for joints in children.values_mut() {
        joints.sort_by(|a, b| a.name.cmp(&b.name));
    }
    Ok((children, carried))
}

/// The link that is not among those which joints carry.
///
/// # Errors
/// There is none, or there are several; in words.
fn root<'a>(robot: &'a Robot, carried: &BTreeSet<&str>) -> std::result::Result<&'a Link, String> {
    let roots = robot.links.iter();
    let mut roots = roots.filter(|l| !carried.contains(l.name.as_str()));
    match (roots.next(), roots.next()) {
        (Some(root), None) => Ok(root),
        (Some(first), Some(second)) => {
            Err(format!("it has several root links: '{}' and '{}'", first.name, second.name))
        }
        (None, _) if robot.links.is_empty() => Err("it has no links".to_owned()),
        (None, _) => Err("it has no root link: the links form a loop".to_owned()),
    }
}
