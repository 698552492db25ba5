//! The distances that a robot keeps.

use crate::Obstacle;
use crate::keys::obstacles::MAX_LENGTH;
use aghf::error::{Error, Result, plain};
use aghf::geometry::Scene;
use aghf::model::Model;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The distances that the robot keeps, in m.
///
/// In JSON: a number for all, or an object with the optional keys `obstacles`, `itself` and `pairs`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a number is needed, or an object with the keys obstacles, itself and pairs")]
pub enum Clearance {
    /// The same distance from obstacles and between links.
    Same(f64),
    /// A distance each.
    Each(Clearances),
}

/// A distance from obstacles, one between links, and those of some pairs of links.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Clearances {
    /// The distance from obstacles that have none of their own, m.
    pub obstacles: f64,
    /// The distance between links, m.
    pub itself: f64,
    /// Pairs of links with a distance of their own.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<PairClearance>,
}

/// The distance between two links.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairClearance {
    /// The names of the links.
    pub links: [String; 2],
    /// The distance, m.
    pub clearance_m: f64,
}

impl Default for Clearance {
    fn default() -> Self {
        Self::Same(0.0)
    }
}

/// The distances that are kept, checked.
pub(crate) struct Margins<'a> {
    pub(crate) obstacles: Vec<f64>,
    itself: f64,
    pairs: &'a [PairClearance],
}

impl Clearance {
    /// The distances of a scene with these obstacles. `path` names the scenario.
    ///
    /// # Errors
    /// A distance is negative, not finite or too large.
    pub(crate) fn margins<'a>(&'a self, obstacles: &[Obstacle], path: &str) -> Result<Margins<'a>> {
        let (beside, itself, pairs) = match self {
            Self::Same(distance) => (*distance, *distance, &[][..]),
            Self::Each(each) => (each.obstacles, each.itself, each.pairs.as_slice()),
        };
        let check = |key: String, distance: f64| {
            if (0.0..=MAX_LENGTH).contains(&distance) {
                return Ok(());
            }
            let condition = format!("it is {} and must be a distance from 0 to {MAX_LENGTH} m", plain(distance));
            Err(Error::input(path, key, condition))
        };
        for distance in [beside, itself] {
            check("clearance_m".to_owned(), distance)?;
        }
        for (i, pair) in pairs.iter().enumerate() {
            check(pair_key(i, "clearance_m"), pair.clearance_m)?;
        }
        for (i, obstacle) in obstacles.iter().enumerate() {
            let own = obstacle.clearance_m.unwrap_or(beside);
            check(format!("obstacles[{i}].clearance_m"), own)?;
        }
        let own = obstacles.iter().map(|o| o.clearance_m.unwrap_or(beside));
        Ok(Margins { obstacles: own.collect(), itself, pairs })
    }
}

/// The key of a pair in a scenario.
fn pair_key(pair: usize, key: &str) -> String {
    format!("clearance_m.pairs[{pair}].{key}")
}

impl Margins<'_> {
    /// The distance that two links keep, m.
    pub(crate) fn of_links(&self, links: [&str; 2]) -> f64 {
        let [a, b] = links;
        let is_it = |own: [&str; 2]| own == [a, b] || own == [b, a];
        let own = self.pairs.iter();
        let mut own = own.filter(|pair| is_it(pair.links.each_ref().map(String::as_str)));
        own.next().map_or(self.itself, |pair| pair.clearance_m)
    }

    /// The scene with these distances. The pairs of links in `overlapping` keep none.
    ///
    /// # Errors
    /// A pair has a link that the robot lacks, keeps no distance, or is given twice.
    pub(crate) fn of_scene(
        &self,
        scene: Scene,
        overlapping: Option<&[[String; 2]]>,
        robot: &Model,
        path: &str,
    ) -> Result<Scene> {
        for (i, PairClearance { links, .. }) in self.pairs.iter().enumerate() {
            let refuse = |condition: String| Err(Error::input(path, pair_key(i, "links"), condition));
            let [a, b] = links;
            let unknown = |link: &&String| robot.frames().iter().all(|f| f.name != **link);
            if let Some(link) = links.iter().find(unknown) {
                return refuse(robot.no_link(link));
            }
            let is_it = |other: &[String; 2]| other == links || *other == [b.clone(), a.clone()];
            if self.pairs[..i].iter().any(|other| is_it(&other.links)) {
                return refuse(format!("the pair of '{a}' and '{b}' is given twice"));
            }
            if a == b || overlapping.is_none_or(|all| all.iter().any(is_it)) {
                return refuse(format!("'{a}' and '{b}' are not kept clear of each other"));
            }
        }
        Ok(scene.with_margins(|i| self.obstacles[i], |links| self.of_links(links)))
    }
}
