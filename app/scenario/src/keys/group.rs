//! The joints of a group, which are planned, and the others, which are held.

use crate::{RobotShape, ScenarioFile, SelfCollision};
use aghf::error::{Error, Result};
use aghf::model::{Model, Reduced};
use aghf::names::instead;
use aghf::urdf::{Follower, LoadNote, LoadReport, Mimic, RobotSource, Srdf, followers};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Locks the joints outside of the group that a file names, lets the links overlap that the SRDF disables unless
/// `self_collision` is given, and takes the group and the SRDF out of the file, so that the scenario depends on no
/// other.
///
/// A joint is held where `locked_joints` has it, otherwise in the named state, otherwise, for a mimic joint, at the
/// position that its master gives it, otherwise at the position that is closest to zero. `robot` has all joints that
/// move, mimic joints among them, and the notes of reading it, to which those on the SRDF are added; `folder` is that
/// of the scenario, called `path`.
///
/// # Errors
/// A key without the others, a group or a state that is not there or does not fit the robot, a joint of several degrees
/// of freedom in the group, or a mimic joint that would have to follow one that is planned.
pub(crate) fn hold_others(
    file: &mut ScenarioFile,
    (robot, notes): (&Model, &mut LoadReport),
    source: &RobotSource,
    folder: &Path,
    path: &str,
) -> Result<()> {
    let (group, srdf, state) = (file.group.take(), file.srdf.take(), file.held_state.take());
    if group.is_none() && state.is_some() {
        let condition = "it is given without a group";
        return Err(Error::input(path, "held_state", condition));
    }
    let Some(srdf) = srdf else {
        let condition = "the group is in an SRDF, which is not given";
        return match group {
            Some(_) => Err(Error::input(path, "srdf", condition)),
            None => Ok(()),
        };
    };
    let srdf_path = folder.join(srdf);
    let srdf_name = srdf_path.display().to_string();
    let of_key = |key: &'static str| move |e: Error| Error::input(path, key, e.to_string());
    let srdf = Srdf::load(&srdf_path, robot).map_err(of_key("srdf"))?;
    let unknown = srdf.unknown_links.iter().cloned();
    notes.extend(unknown.map(|link| LoadNote::UnknownLink { link }));
    let shape = file.robot_shape.unwrap_or_else(|| RobotShape::of(robot));
    if file.self_collision.is_none() && matches!(shape, RobotShape::Collision { .. }) {
        let links: Vec<_> = srdf.disabled.iter().map(|p| p.links.clone()).collect();
        if !links.is_empty() {
            file.self_collision = Some(SelfCollision::IgnoredPairs(links));
        }
    }
    let Some(group) = group else { return Ok(()) };
    let names = srdf.names_of_group(&group, robot, &srdf_name);
    check_held(&names.map_err(of_key("group"))?, notes, path)?;
    let group = srdf.joints_of_group(&group, robot, &srdf_name).map_err(of_key("group"))?;
    let followers = source.elements().and_then(|r| followers(&r, robot, &source.name()));
    let followers = followers.map_err(of_key("robot"))?;
    let given = |i: usize| file.locked_joints.get(robot.joints()[i].name()).copied();
    let held = |i: usize| !group.contains(&i) || given(i).is_some();
    if file.mimic == Mimic::Refuse {
        let free = |f: &&Follower| !held(f.joint) || !held(f.master) && given(f.joint).is_none();
        if let Some(follower) = followers.iter().find(free) {
            return Err(cannot_follow(follower, robot, path));
        }
    }
    let of_state = match &state {
        None => BTreeMap::new(),
        Some(name) => state_positions(&srdf, name, robot, &srdf_name).map_err(of_key("held_state"))?,
    };
    let known = |i: usize| given(i).or_else(|| of_state.get(&i).copied());
    let held: Vec<usize> = (0..robot.dof()).filter(|i| held(*i)).collect();
    let positions = held_positions(robot, &held, &followers, known);
    file.locked_joints.extend(positions);
    if !followers.is_empty() {
        // No joint that follows another one is left among them.
        file.mimic = Mimic::Independent;
    }
    Ok(())
}

/// Refuses a group with a joint that is held as it has several degrees of freedom.
fn check_held(group: &BTreeSet<String>, notes: &LoadReport, path: &str) -> Result<()> {
    for note in notes {
        if let LoadNote::Held { joint, kind } = note
            && group.contains(joint)
        {
            let condition = format!(
                "it has the joint '{joint}', which is {kind}, and only joints with one axis can be planned: a group \
                 without it holds it"
            );
            return Err(Error::input(path, "group", condition));
        }
    }
    Ok(())
}

/// The positions of the joints that are held, by name: the known ones, those to which a held master takes its
/// followers, and otherwise those nearest to zero.
fn held_positions(
    robot: &Model,
    held: &[usize],
    followers: &[Follower],
    known: impl Fn(usize) -> Option<f64>,
) -> Vec<(String, f64)> {
    let free = |i: usize| known(i).unwrap_or_else(|| robot.joints()[i].limits().nearest(0.0));
    let position = |i: usize| {
        let mut of_held = followers.iter().filter(|f| held.contains(&f.master));
        match (known(i), of_held.find(|f| f.joint == i)) {
            (None, Some(f)) => f.multiplier * free(f.master) + f.offset,
            _ => free(i),
        }
    };
    let named = |i: &usize| (robot.joints()[*i].name().to_owned(), position(*i));
    held.iter().map(named).collect()
}

/// The error for a mimic joint that moves, or whose master does.
fn cannot_follow(follower: &Follower, robot: &Model, path: &str) -> Error {
    let [joint, master] = [follower.joint, follower.master].map(|i| robot.joints()[i].name());
    let condition = format!(
        "joint '{joint}' mimics '{master}', and they cannot move together: a group without both, \"locked_joints\": \
         {{\"{joint}\": POSITION}}, or \"mimic\": \"independent\", which lets it move by itself"
    );
    Error::input(path, "group", condition)
}

/// The positions of joints in the states of this name, one for each of several groups.
fn state_positions(srdf: &Srdf, name: &str, robot: &Model, srdf_name: &str) -> Result<BTreeMap<usize, f64>> {
    let mut positions = BTreeMap::new();
    let mut states = srdf.states.iter().filter(|state| state.name == name).peekable();
    if states.peek().is_none() {
        let element = format!("group_state '{name}'");
        let names = instead(name, srdf.states.iter().map(|state| state.name.as_str()));
        let condition = format!("there is no such state{names}");
        return Err(Error::input(srdf_name, element, condition));
    }
    for state in states {
        positions.extend(srdf.positions(state, robot, srdf_name)?);
    }
    Ok(positions)
}

/// The robot with these joints locked; `None` without any. `path` names the scenario in errors.
pub(crate) fn lock(robot: &Model, joints: &BTreeMap<String, f64>, path: &str) -> Result<Option<Reduced>> {
    if joints.is_empty() {
        return Ok(None);
    }
    let mut locked = Vec::with_capacity(joints.len());
    for (name, position) in joints {
        let Some(i) = robot.joints().iter().position(|j| j.name() == name) else {
            let key = format!("locked_joints.{name}");
            return Err(Error::input(path, key, robot.no_moving_joint(name)));
        };
        locked.push((i, *position));
    }
    let named = |error: Error| match error {
        Error::Input { element, condition, .. } => {
            Error::input(path, "locked_joints", format!("{element}: {condition}"))
        }
        other => other,
    };
    robot.reduced(&locked).map(Some).map_err(named)
}
