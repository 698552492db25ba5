//! The links of a robot that keep clear of each other.

use crate::keys::json::read_json;
use crate::shapes::never_meeting::never_meet;
use crate::{Scenario, ScenarioFile, SelfCollision};
use aghf::dynamics::forward_kinematics;
use aghf::error::{Error, Result};
use aghf::geometry::{BallTree, CollisionGeometry, Scene};
use aghf::input::read_text;
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf::urdf::{DisabledPair, Srdf};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The number of random configurations at which links are tested.
const CONFIGURATIONS: usize = 10_000;

/// The seed of the random configurations.
const SEED: u64 = 0;

/// The pairs of links of a robot that may overlap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IgnoredPairs {
    /// The name of the robot.
    pub robot: String,
    /// The pairs.
    pub ignored_pairs: Vec<IgnoredPair>,
}

/// Two links that may overlap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IgnoredPair {
    /// Their names.
    pub links: [String; 2],
    /// The reason in words.
    pub reason: String,
}

impl IgnoredPairs {
    /// The pairs that an SRDF disables, with its reasons.
    #[must_use]
    pub fn of_srdf(model: &Model, srdf: &Srdf) -> Self {
        let pair = |DisabledPair { links, reason }: &DisabledPair| IgnoredPair {
            links: links.clone(),
            reason: match reason.as_str() {
                "" => "disabled in the SRDF".to_owned(),
                reason => format!("disabled in the SRDF: {reason}"),
            },
        };
        Self { robot: model.name().to_owned(), ignored_pairs: srdf.disabled.iter().map(pair).collect() }
    }

    /// Finds the pairs that an SRDF disables, and those that [always overlap](always_overlapping); without an SRDF, and
    /// with one that disables none, the pairs [by sampling](Self::by_sampling).
    ///
    /// # Errors
    /// Those of [`always_overlapping`].
    pub fn find(model: &Model, srdf: Option<&Srdf>, robot: &CollisionGeometry) -> Result<Self> {
        let Some(srdf) = srdf.filter(|srdf| !srdf.disabled.is_empty()) else {
            return Self::by_sampling(model, robot);
        };
        let mut found = Self::of_srdf(model, srdf);
        let listed: Vec<_> = found.ignored_pairs.iter().map(|p| p.links.clone()).collect();
        found.ignored_pairs.extend(always_overlapping(model, robot, &listed)?);
        Ok(found)
    }

    /// Finds the pairs by sampling: neighbours, links separated by a single moving joint, and links that
    /// [always overlap](always_overlapping). Pairs on one body are not listed, because they never move relative to each
    /// other.
    ///
    /// # Errors
    /// A ball belongs to a body that the robot does not have.
    pub fn by_sampling(model: &Model, robot: &CollisionGeometry) -> Result<Self> {
        let neighbours = neighbours(model, robot);
        let others = always_overlapping(model, robot, &neighbours)?;
        let neighbour = |links| IgnoredPair { links, reason: "neighbours".to_owned() };
        let mut ignored: Vec<_> = neighbours.into_iter().map(neighbour).collect();
        ignored.extend(others);
        ignored.sort_by(|a, b| a.links.cmp(&b.links));
        Ok(Self { robot: model.name().to_owned(), ignored_pairs: ignored })
    }

    /// Writes the file that [`parse`](Self::parse) reads: readable JSON with one line per pair.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Strings are written without failure.
        let quoted = |text: &str| serde_json::Value::from(text).to_string();
        let line = |pair: &IgnoredPair| {
            let [a, b] = pair.links.each_ref().map(|link| quoted(link));
            let reason = quoted(&pair.reason);
            format!("    {{ \"links\": [{a}, {b}], \"reason\": {reason} }}")
        };
        let lines: Vec<String> = self.ignored_pairs.iter().map(line).collect();
        let (robot, lines) = (quoted(&self.robot), lines.join(",\n"));
        format!("{{\n  \"robot\": {robot},\n  \"ignored_pairs\": [\n{lines}\n  ]\n}}\n")
    }

    /// Parses a text written by [`to_json`](Self::to_json); `file` names it in errors.
    ///
    /// # Errors
    /// Names the file, the key and the fault. The link names are checked when the pairs are used.
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        read_json(text, file)
    }
}

/// The pairs of links on different bodies, without those of `ignored`, that overlap at each of 10 000 random
/// configurations within the joint limits, the same in every run. Cost: that of the pairs which overlap at all
/// configurations before.
///
/// # Errors
/// A ball belongs to a body that the robot does not have.
pub fn always_overlapping(
    model: &Model,
    robot: &CollisionGeometry,
    ignored: &[[String; 2]],
) -> Result<Vec<IgnoredPair>> {
    let links = Links::of(robot);
    links.always_overlapping(model, links.pairs(ignored))
}

impl Scenario {
    /// The pairs of trees of balls of links that keep clear of each other, also those that never meet, each with the
    /// distance that it keeps, m.
    ///
    /// # Errors
    /// A distance is out of range.
    pub(crate) fn kept_apart(&self) -> Result<Vec<([usize; 2], f64)>> {
        let (robot, file) = (self.scene.robot(), &self.file);
        if !self.keeps_links_clear() {
            return Ok(Vec::new());
        }
        let may_overlap = match &file.self_collision {
            Some(SelfCollision::IgnoredPairs(pairs)) => pairs.clone(),
            _ => neighbours(&self.model, robot),
        };
        let margins = file.clearance_m.margins(&file.obstacles, &self.name)?;
        let links = Links::of(robot);
        let kept = |pair| {
            let names = links.names(pair);
            (pair, margins.of_links(names.each_ref().map(String::as_str)))
        };
        Ok(links.pairs(&may_overlap).into_iter().map(kept).collect())
    }
}

/// The pairs of links that are separated by a single moving joint.
pub(crate) fn neighbours(model: &Model, robot: &CollisionGeometry) -> Vec<[String; 2]> {
    let links = Links::of(robot);
    let parent = |body: usize| model.joints()[body].parent();
    let follows = |a: Option<usize>, b: Option<usize>| b.is_some_and(|b| parent(b) == a);
    let mut pairs = links.pairs(&[]);
    pairs.retain(|pair| {
        let [a, b] = pair.map(|i| links.trees[i].body);
        follows(a, b) || follows(b, a)
    });
    pairs.into_iter().map(|pair| links.names(pair)).collect()
}

/// The pairs of links, without those of `ignored`, that are proved to [never meet](never_meet).
///
/// # Errors
/// Those of [`never_meet`].
pub(crate) fn never_meeting(
    model: &Model,
    robot: &CollisionGeometry,
    ignored: &[[String; 2]],
    limited: bool,
    margin: impl Fn([&str; 2]) -> f64,
) -> Result<Vec<[String; 2]>> {
    let links = Links::of(robot);
    let mut found = Vec::new();
    for pair in links.pairs(ignored) {
        let names = links.names(pair);
        let margin = margin(names.each_ref().map(String::as_str));
        if never_meet(model, (pair.map(|i| &links.trees[i]), &robot.parts), limited, margin)? {
            found.push(names);
        }
    }
    Ok(found)
}

/// The links with balls.
struct Links<'a> {
    robot: &'a CollisionGeometry,
    trees: Vec<BallTree>,
}

impl<'a> Links<'a> {
    fn of(robot: &'a CollisionGeometry) -> Self {
        let trees = robot.trees();
        Self { robot, trees }
    }

    /// The names of the links of two trees, sorted.
    fn names(&self, pair: [usize; 2]) -> [String; 2] {
        let link = |i: usize| self.robot.link_of(&self.trees[i]);
        let mut names = pair.map(|i| link(i).unwrap_or_default().to_owned());
        names.sort_unstable();
        names
    }

    /// The pairs of trees on different bodies, without those of `ignored`.
    fn pairs(&self, ignored: &[[String; 2]]) -> Vec<[usize; 2]> {
        self.robot.tree_pairs(ignored)
    }

    fn always_overlapping(&self, model: &Model, mut pairs: Vec<[usize; 2]>) -> Result<Vec<IgnoredPair>> {
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        let mut placements = vec![Placement::identity(); model.dof()];
        for _ in 0..CONFIGURATIONS {
            if pairs.is_empty() {
                break;
            }
            let q = model.random_configuration(&mut rng);
            forward_kinematics(model, &q, &mut placements)?;
            let mut still = Vec::new();
            for pair in pairs {
                if self.robot.overlap(pair.map(|i| &self.trees[i]), &placements)? {
                    still.push(pair);
                }
            }
            pairs = still;
        }
        let reason = format!("overlap at each of {CONFIGURATIONS} random configurations");
        let ignored = pairs.into_iter().map(|pair| IgnoredPair { links: self.names(pair), reason: reason.clone() });
        Ok(ignored.collect())
    }
}

/// Replaces the path of a file by the pairs in it, so that the scenario depends on no other file. `folder` is that of
/// the scenario.
pub(crate) fn in_full(given: SelfCollision, folder: &Path) -> Result<SelfCollision> {
    let SelfCollision::IgnoredPairsFile(name) = given else {
        return Ok(given);
    };
    let path = folder.join(name);
    let pairs = IgnoredPairs::parse(&read_text(&path)?, &path.display().to_string())?;
    let links = pairs.ignored_pairs.into_iter().map(|pair| pair.links);
    Ok(SelfCollision::IgnoredPairs(links.collect()))
}

/// Adds pairs of links that always overlap to those that a file lets overlap, by default neighbours, so that the file
/// has all pairs that may overlap.
pub(crate) fn name_overlapping(file: &mut ScenarioFile, model: &Model, scene: &Scene, overlapping: &[IgnoredPair]) {
    if overlapping.is_empty() {
        return;
    }
    let named = match file.self_collision.take() {
        Some(SelfCollision::IgnoredPairs(pairs)) => pairs,
        _ => neighbours(model, scene.robot()),
    };
    let overlapping = overlapping.iter().map(|pair| pair.links.clone());
    let all = named.into_iter().chain(overlapping).collect();
    file.self_collision = Some(SelfCollision::IgnoredPairs(all));
}

/// Refuses links that the robot does not have. `path` names the scenario.
pub(crate) fn check_links(pairs: &[[String; 2]], model: &Model, path: &str) -> Result<()> {
    for (i, pair) in pairs.iter().enumerate() {
        let unknown = |link: &&String| model.frames().iter().all(|frame| frame.name != **link);
        if let Some(link) = pair.iter().find(unknown) {
            let key = format!("self_collision.ignored_pairs[{i}]");
            return Err(Error::input(path, key, model.no_link(link)));
        }
    }
    Ok(())
}
