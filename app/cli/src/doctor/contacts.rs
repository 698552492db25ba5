//! Links that overlap: always, at zero, and in the named states of an SRDF.

use super::{Examination, Finding, Severity};
use aghf::dynamics::forward_kinematics;
use aghf::error::Result;
use aghf::geometry::CollisionGeometry;
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf::urdf::{Follower, Srdf};
use aghf_scenario::IgnoredPairs;
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
    /// The depth of the overlap of two balls, m.
    pub depth_m: f64,
    /// The sum of the largest distances of the two covers from their shapes, m. A depth above it is an overlap of the
    /// shapes.
    pub excess_m: f64,
}

/// A link with the range of its balls.
struct Covered<'a> {
    link: &'a str,
    body: Option<usize>,
    balls: Vec<usize>,
}

/// The pairs that always overlap, and the contacts at zero and in the named states. `excess` is by links.
pub(super) fn pairs_and_states(
    model: &Model,
    followers: &[Follower],
    srdf: Option<(&Srdf, &str)>,
    geometry: &CollisionGeometry,
    excess: &BTreeMap<&str, f64>,
    given: &Examination,
) -> Result<(Vec<State>, Vec<Finding>)> {
    let mut findings = Vec::new();
    let sampled = IgnoredPairs::by_sampling(model, geometry)?.ignored_pairs;
    let sorted = |links: &[String; 2]| {
        let mut links = links.clone();
        links.sort_unstable();
        links
    };
    let disabled: BTreeSet<_> = srdf
        .iter()
        .flat_map(|(srdf, _)| srdf.disabled.iter().map(|pair| sorted(&pair.links)))
        .collect();
    let missing = sampled
        .iter()
        .filter(|pair| !disabled.contains(&sorted(&pair.links)));
    let names =
        missing.map(|pair| format!("{} and {} ({})", pair.links[0], pair.links[1], pair.reason));
    let (condition, mend) = match &given.srdf {
        Some(_) => (
            "they overlap, and the SRDF does not disable them",
            "disable_collisions in the SRDF, or \"self_collision\": {\"ignored_pairs\": [...]}"
                .to_owned(),
        ),
        None => (
            "they overlap, which self-collision must not count",
            format!(
                "aghf pairs {} -o PAIRS.json and \"self_collision\": {{\"ignored_pairs_file\": \"PAIRS.json\"}}",
                given.robot
            ),
        ),
    };
    findings.extend(Finding::about(
        Severity::Note,
        "links",
        names,
        [condition, &mend],
    ));
    let ignored = sampled
        .iter()
        .map(|pair| sorted(&pair.links))
        .chain(disabled.iter().cloned());
    let ignored: BTreeSet<_> = ignored.collect();
    let (configurations, found) = configurations(model, followers, srdf);
    findings.extend(found);
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
            "links overlap there, as listed below, so that a motion from or to it is refused with \"self_collision\"",
            "a finer cover where the excess is larger than the depth; \"ignored_pairs\" where the links may touch",
        ],
    ));
    Ok((states, findings))
}

/// Zero, clamped into the limits, and the named states, in which other joints are at zero and mimic joints follow
/// theirs; findings about states that do not fit the robot.
fn configurations(
    model: &Model,
    followers: &[Follower],
    srdf: Option<(&Srdf, &str)>,
) -> (Vec<(String, Vec<f64>)>, Vec<Finding>) {
    let zero: Vec<f64> = (model.joints().iter())
        .map(|joint| joint.limits().nearest(0.0))
        .collect();
    let (mut all, mut findings) = (vec![("zero".to_owned(), zero.clone())], Vec::new());
    let Some((srdf, file)) = srdf else {
        return (all, findings);
    };
    for state in &srdf.states {
        match srdf.positions(state, model, file) {
            Err(error) => {
                let mend = "the state in the SRDF, or another SRDF";
                findings.push(Finding::of_error(error, Severity::Note, mend));
            }
            Ok(positions) => {
                let mut q = zero.clone();
                for (joint, position) in &positions {
                    q[*joint] = *position;
                }
                let given = |joint| positions.iter().any(|(other, _)| *other == joint);
                for f in followers.iter().filter(|f| !given(f.joint)) {
                    q[f.joint] = f.multiplier * q[f.master] + f.offset;
                }
                all.push((format!("{} of {}", state.name, state.group), q));
            }
        }
    }
    (all, findings)
}

/// The pairs of links whose covers overlap at a configuration, but for the ignored ones.
fn contacts(
    model: &Model,
    geometry: &CollisionGeometry,
    ignored: &BTreeSet<[String; 2]>,
    excess: &BTreeMap<&str, f64>,
    q: &[f64],
) -> Result<Vec<Contact>> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements)?;
    let balls = geometry.placed(&placements)?;
    let mut links: Vec<Covered<'_>> = Vec::new();
    for (i, (link, ball)) in geometry.links.iter().zip(&geometry.balls).enumerate() {
        match links.iter_mut().find(|covered| covered.link == link) {
            Some(covered) => covered.balls.push(i),
            None => links.push(Covered {
                link,
                body: ball.body,
                balls: vec![i],
            }),
        }
    }
    let mut found = Vec::new();
    for (i, a) in links.iter().enumerate() {
        for b in &links[..i] {
            let mut names = [a.link, b.link].map(str::to_owned);
            names.sort_unstable();
            if a.body == b.body || ignored.contains(&names) {
                continue;
            }
            let pairs = a
                .balls
                .iter()
                .flat_map(|i| b.balls.iter().map(move |j| (*i, *j)));
            let gap = pairs
                .map(|(i, j)| balls[i].gap(&balls[j]))
                .fold(f64::INFINITY, f64::min);
            if gap < 0.0 {
                let excess_m = [a.link, b.link]
                    .iter()
                    .filter_map(|link| excess.get(link))
                    .sum();
                found.push(Contact {
                    links: names,
                    depth_m: -gap,
                    excess_m,
                });
            }
        }
    }
    found.sort_by(|a, b| a.links.cmp(&b.links));
    Ok(found)
}
