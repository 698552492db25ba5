//! Links that overlap: always, at zero, and in the named states of an SRDF.

use super::{Finding, Severity};
use aghf::dynamics::forward_kinematics;
use aghf::error::Result;
use aghf::geometry::CollisionGeometry;
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf::urdf::{Follower, GroupState, Srdf};
use aghf_scenario::{IgnoredPair, IgnoredPairs};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A configuration, and the links whose covers overlap there.
#[derive(Clone, Debug, Serialize)]
pub struct State {
    /// `zero`, with the joints clamped into their limits, or the state and the group of an SRDF.
    pub name: String,
    /// The pairs of links that overlap, and may not.
    pub contacts: Vec<Contact>,
}

/// Two links whose covers overlap.
#[derive(Clone, Debug, Serialize)]
pub struct Contact {
    /// The names of the links.
    pub links: [String; 2],
    /// The depth of the overlap of two convex bodies, m.
    pub depth_m: f64,
    /// The sum of the largest distances of the two links from their meshes, m. A depth above it is an overlap of the
    /// shapes.
    pub excess_m: f64,
}

/// The contacts at zero and in the named states, and the findings about them and about pairs that always overlap.
/// `excess` is by links.
pub(super) fn pairs_and_states(
    (model, followers): (&Model, &[Follower]),
    srdf: Option<(&Srdf, &str)>,
    geometry: &CollisionGeometry,
    excess: &BTreeMap<&str, f64>,
    robot: &str,
) -> Result<(Vec<State>, Vec<Finding>)> {
    let disabled = srdf.map_or(&[][..], |(srdf, _)| &srdf.disabled);
    let disabled: BTreeSet<_> = disabled.iter().map(|pair| sorted(&pair.links)).collect();
    let sampled = IgnoredPairs::by_sampling(model, geometry)?.ignored_pairs;
    let mut findings = Vec::from_iter(not_disabled(&sampled, &disabled, srdf.is_some(), robot));
    let sampled = sampled.iter().map(|pair| sorted(&pair.links));
    let ignored: Vec<_> = sampled.chain(disabled).collect();
    let mut configurations = vec![("zero".to_owned(), zero(model))];
    if let Some((srdf, file)) = srdf {
        for state in &srdf.states {
            let (configuration, found) = configuration(state, (model, followers), srdf, file);
            configurations.extend(configuration);
            findings.extend(found);
        }
    }
    let mut states = Vec::new();
    for (name, q) in configurations {
        let contacts = contacts(model, geometry, &ignored, excess, &q)?;
        states.push(State { name, contacts });
    }
    let touching = states.iter().filter(|state| !state.contacts.is_empty());
    findings.extend(Finding::about(
        Severity::Note,
        "state",
        touching.map(|state| state.name.clone()),
        [
            "links overlap there, as listed below, so that a motion from or to it is refused",
            "finer pieces of meshes, \"robot_shape\": {\"collision\": {\"excess_m\": ...}}, where the excess is larger \
             than the depth; \"self_collision\": {\"ignored_pairs\": [...]} where the links may touch, or \"off\"",
        ],
    ));
    Ok((states, findings))
}

/// The finding about pairs of neighbours, and of links that always overlap, that are not disabled. `with_srdf` is true
/// if there is an SRDF.
fn not_disabled(
    sampled: &[IgnoredPair],
    disabled: &BTreeSet<[String; 2]>,
    with_srdf: bool,
    robot: &str,
) -> Option<Finding> {
    let missing = sampled.iter();
    let missing = missing.filter(|pair| !disabled.contains(&sorted(&pair.links)));
    let names = missing.map(|IgnoredPair { links: [a, b], reason }| format!("{a} and {b} ({reason})"));
    let (condition, remedy) = if with_srdf {
        (
            "they are neighbours, or overlap in all samples, and the SRDF does not disable them",
            "disable_collisions in the SRDF where they touch, or \"self_collision\": {\"ignored_pairs\": [...]}, which \
             takes the place of the pairs of the SRDF"
                .to_owned(),
        )
    } else {
        (
            "they are neighbours, or overlap in all samples, and need not keep clear of each other",
            format!("nothing is needed; aghf pairs {robot} lists them"),
        )
    };
    Finding::about(Severity::Note, "pair", names, [condition, &remedy])
}

/// The names of two links in their order.
fn sorted(links: &[String; 2]) -> [String; 2] {
    let mut links = links.clone();
    links.sort_unstable();
    links
}

/// The configuration within the limits that is nearest to zero.
fn zero(model: &Model) -> Vec<f64> {
    let joints = model.joints().iter();
    joints.map(|joint| joint.limits().nearest(0.0)).collect()
}

/// A named state, in which other joints are at zero and mimic joints follow theirs; findings about joints of it that do
/// not fit the robot.
fn configuration(
    state: &GroupState,
    (model, followers): (&Model, &[Follower]),
    srdf: &Srdf,
    file: &str,
) -> (Option<(String, Vec<f64>)>, Vec<Finding>) {
    let name = match state.group.as_str() {
        "" => state.name.clone(),
        group => format!("{} of {group}", state.name),
    };
    let mut known = state.clone();
    known.joints.retain(|(joint, _)| srdf.joint(joint, model).is_ok());
    let unknown = state.joints.iter().filter(|joint| !known.joints.contains(joint));
    let condition = format!("the state '{name}' of the SRDF has it, and the robot does not");
    let remedy = "an SRDF for this robot; the joint is passed over in what follows";
    let names = unknown.map(|(joint, _)| joint.clone());
    let found = Finding::about(Severity::Note, "joint", names, [&condition, remedy]);
    let mut findings = Vec::from_iter(found);
    match srdf.positions(&known, model, file) {
        Err(error) => {
            findings.push(Finding::of_error(error, Severity::Note, "the state in the SRDF"));
            (None, findings)
        }
        Ok(positions) => {
            let mut q = zero(model);
            for (joint, position) in &positions {
                q[*joint] = *position;
            }
            let given = |joint| positions.iter().any(|(other, _)| *other == joint);
            for f in followers.iter().filter(|f| !given(f.joint)) {
                q[f.joint] = f.multiplier * q[f.master] + f.offset;
            }
            (Some((name, q)), findings)
        }
    }
}

/// The pairs of links whose covers overlap at a configuration, but for the ignored ones.
fn contacts(
    model: &Model,
    geometry: &CollisionGeometry,
    ignored: &[[String; 2]],
    excess: &BTreeMap<&str, f64>,
    q: &[f64],
) -> Result<Vec<Contact>> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements)?;
    let trees = geometry.trees();
    let mut found = Vec::new();
    for pair in geometry.tree_pairs(ignored) {
        let [a, b] = pair.map(|i| &trees[i]);
        let gap = geometry.gap_within([a, b], &placements, 0.0)?;
        if gap < 0.0 {
            let link = |tree| geometry.link_of(tree).unwrap_or_default().to_owned();
            let links = sorted(&[link(a), link(b)]);
            let excess = links.iter().filter_map(|link| excess.get(link.as_str()));
            found.push(Contact { excess_m: excess.sum(), depth_m: -gap, links });
        }
    }
    found.sort_by(|a, b| a.links.cmp(&b.links));
    Ok(found)
}
