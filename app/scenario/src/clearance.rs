//! The distances that a robot keeps.

use super::obstacles::LARGEST_LENGTH;
use aghf::error::{Error, Result, plain};
use aghf::geometry::Margins;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The distances that the robot keeps, in m.
///
/// In JSON: a number for all, or an object with the optional keys `obstacles` and `itself`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a number is needed, or an object with the keys obstacles and itself"
)]
pub enum Clearance {
    /// The same distance from obstacles and between links.
    Same(f64),
    /// A distance each.
    Each(Clearances),
}

/// A distance from obstacles and one between links.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Clearances {
    /// The distance from obstacles, m.
    pub obstacles: f64,
    /// The distance between links, m.
    pub itself: f64,
}

impl Default for Clearance {
    fn default() -> Self {
        Self::Same(0.0)
    }
}

impl Clearance {
    /// The margins of a scene. `path` names the scenario.
    ///
    /// # Errors
    /// A distance is negative, not finite or too large.
    pub(super) fn margins(self, path: &str) -> Result<Margins> {
        let Clearances { obstacles, itself } = match self {
            Self::Same(distance) => Clearances {
                obstacles: distance,
                itself: distance,
            },
            Self::Each(each) => each,
        };
        for distance in [obstacles, itself] {
            if !(0.0..=LARGEST_LENGTH).contains(&distance) {
                let condition = format!(
                    "it is {}, a distance from 0 to {LARGEST_LENGTH} m is needed",
                    plain(distance)
                );
                return Err(Error::input(path, "clearance_m", condition));
            }
        }
        Ok(Margins { obstacles, itself })
    }
}
