//! The document of a certificate.

use crate::Quantity;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// The name and version of the format, which `proofs/certificate_format.md` in the repository defines.
pub(super) const FORMAT: &str = "aghf-certificate-5";

/// A proof that a motion keeps the promises of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// The name and version of the format.
    pub format: String,
    /// The name of the scenario.
    pub scenario: String,
    /// The SHA-256 of the text of the robot, in hexadecimal digits.
    pub robot_sha256: String,
    /// Those of texts of the scenario: as it was given, and in full.
    pub scenario_sha256: Vec<String>,
    /// That of the text of the summary, which has the motion.
    pub run_sha256: String,
    /// Those of the files of meshes, if these are the shape of the robot.
    pub meshes: BTreeMap<String, String>,
    /// The convex pieces of each mesh in the order of the shapes, in the frame of the shape, m.
    pub pieces: Vec<Vec<Piece>>,
    /// True if every promise of the scenario is certified.
    pub complete: bool,
    /// The keys of the scenario, each with its outcome: `proved`, `assumed` of the robot, `no promise`, or
    /// [`LEFT_OUT`] and the reason.
    pub keys: BTreeMap<String, String>,
    /// The largest deviation of the position of a joint from the motion for which the intervals hold, rad or m.
    pub tracking_error: f64,
    /// The least reserve of one of the sets of poses that are the goal; `None` if it is a configuration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<f64>,
    /// The places at which the motion passes the waypoints, in their order.
    pub waypoints: Vec<Passage>,
    /// The promises for which each interval has a reserve.
    #[serde(serialize_with = "names", deserialize_with = "by_names")]
    pub promises: Vec<Quantity>,
    /// The intervals, which cover each segment from -1 to 1 in order.
    pub intervals: Vec<Interval>,
}

/// The beginning of the outcome of a key that has no proof.
pub const LEFT_OUT: &str = "left out: ";

impl Certificate {
    /// The keys without a proof, each with the reason.
    pub fn left_out(&self) -> impl Iterator<Item = (&str, &str)> {
        let all = self.keys.iter();
        all.filter_map(|(key, outcome)| Some((key.as_str(), outcome.strip_prefix(LEFT_OUT)?)))
    }
}

/// The name of a promise in a certificate: that of the key that asks for it, or of the limited quantity.
fn name_of(promise: Quantity) -> &'static str {
    match promise {
        Quantity::Frame => "keep",
        Quantity::Foot => "stand",
        other => other.name(),
    }
}

fn names<S: Serializer>(promises: &[Quantity], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(promises.iter().map(|promise| name_of(*promise)))
}

fn by_names<'d, D: Deserializer<'d>>(from: D) -> Result<Vec<Quantity>, D::Error> {
    let others = [Quantity::Frame, Quantity::Foot, Quantity::Obstacles, Quantity::SelfCollision];
    let named = |name: String| {
        let found = Quantity::JOINT.into_iter().chain(others).find(|promise| name_of(*promise) == name);
        found.ok_or_else(|| D::Error::custom(format!("there is no promise '{name}'")))
    };
    Vec::deserialize(from)?.into_iter().map(named).collect()
}

/// A convex piece of a mesh: its corners, m, and the triangles of its surface as indices of corners.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Piece(pub Vec<[f64; 3]>, pub Vec<[usize; 3]>);

/// An interval of a segment, on which `x` goes from -1 to 1, the reserve of each promise there, and directions that
/// separate shapes of the robot from others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval(pub usize, pub f64, pub f64, pub Vec<f64>, pub Vec<Direction>);

/// A direction from one shape to another. The shapes of the robot are sorted by the names of their links, and the
/// obstacles follow them. Pairs without one are separated in the direction of their centres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Direction(pub usize, pub usize, pub [f64; 3]);

/// A place of the motion: a segment, `x` from -1 to 1, and the least reserve of the conditions there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passage(pub usize, pub f64, pub f64);

/// The result of a certification.
#[derive(Clone, Debug, PartialEq)]
pub struct Certification {
    /// The certificate; `None` if a promise was not proved.
    pub certificate: Option<Certificate>,
    /// The first place of each row that was not proved.
    pub failures: Vec<Failure>,
}

/// A row that is broken, or could not be proved.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// The promise in words.
    pub promise: String,
    /// The joint, or the names of a pair.
    pub place: String,
    /// The time, s.
    pub at_s: f64,
    /// A value, in the unit of the row.
    pub value: f64,
    /// Its bound.
    pub bound: f64,
    /// True if the value is proved to be beyond the bound.
    pub is_broken: bool,
}
