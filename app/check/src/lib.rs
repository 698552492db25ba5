//! A checker of certificates, in one file. It shares no code with the library that plans motions and writes
//! certificates: URDF, scenario, polynomials, inverse dynamics and distances are read and computed here once more, with
//! the errors of rounding. `proofs/certificate.md` has the statement and its proof.

mod arithmetic;
mod distance;
mod grammar;
mod intervals;
mod joint;
mod json;
mod mesh;
mod motion;
mod robot;
mod rows;
mod scenario;
mod shape;

use grammar::{Grammar, Item, parse};
use intervals::Promised;
use json::{entries, number, option, require, text};
use mesh::{Piece, are_covered, pieces, triangles};
use motion::{Motion, prove_ends};
use robot::Robot;
use scenario::{left_out, limits, weighs_time};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};

pub use mesh::find_mesh;

/// A result, or the reason of a refusal.
type Checked<T> = Result<T, String>;

/// The accepted shortfall of a reserve.
const TOLERANCE: f64 = 1e-9;

/// The promises that a certificate proves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// The promises in words.
    pub text: String,
    /// True if nothing that the scenario promises is left out, and all meshes are read.
    pub is_complete: bool,
}

/// The SHA-256 of a text, in hexadecimal digits.
#[must_use]
pub fn sha256(text: impl AsRef<[u8]>) -> String {
    Sha256::digest(text.as_ref()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Checks a certificate, given the texts of the robot, of the scenario, of the summary of the solve, whose motion it is
/// about, and of the certificate, and the files of meshes by their names in the URDF. The summary may take the place of
/// the scenario, which it contains.
///
/// # Errors
/// The reason of a refusal.
pub fn check(
    [robot, scenario, run, certificate]: [&str; 4],
    meshes: &dyn Fn(&str) -> Option<Vec<u8>>,
) -> Checked<Report> {
    let grammar = Grammar::new()?;
    let read = |text: &str, rule: &str| {
        let value = parse(text).map_err(|fault| format!("{rule}: {fault}"))?;
        grammar.check(Item::Json(&value), rule)?;
        Ok::<_, String>(value)
    };
    let (summary, certificate) = (read(run, "run")?, read(certificate, "certificate")?);
    require(certificate["robot_sha256"] == sha256(robot), "the certificate is of another robot")?;
    require(certificate["run_sha256"] == sha256(run), "the certificate is of another motion")?;
    let scenario = if scenario == run {
        let own = option(&summary["provenance"], "scenario").ok_or("'provenance' is missing")?;
        grammar.check(Item::Json(own), "scenario")?;
        own.clone()
    } else {
        let known = entries(&certificate, "scenario_sha256").contains(&Value::from(sha256(scenario)));
        let scenario = read(scenario, "scenario");
        let in_full = |fault| format!("{fault}; `aghf scenarios FILE` writes a scenario in full");
        require(known, "the certificate is of another scenario").and(scenario).map_err(in_full)?
    };
    let curve = &summary["curve"];
    let names: Vec<String> = entries(curve, "joints").iter().map(|n| text(n).to_owned()).collect();
    let motion = Motion::read(curve, names.len())?;
    let horizon = motion.horizon;
    let [shortest, longest] = match option(&scenario, "free_horizon") {
        Some(free) => [number(&free["shortest_s"]), number(&free["longest_s"])],
        None if weighs_time(&scenario) => [0.0, f64::INFINITY],
        None => [number(&scenario["horizon_s"]); 2],
    };
    require(shortest <= horizon && horizon <= longest, "the horizon is not that of the scenario")?;
    let pieces = pieces(&certificate)?;
    let robot = Robot::read(robot, &grammar, (&scenario, &pieces), &names)?;
    let unread = compare_meshes(&robot, &pieces, &certificate["meshes"], meshes)?;
    let missing = left_out(&scenario, &robot, &certificate["keys"])?;
    require(certificate["complete"] == missing.is_empty(), "'complete' is wrong")?;
    let limits = limits(&scenario, &robot)?;
    prove_ends(&scenario, &motion)?;
    let promised = Promised::new(&scenario, &certificate, robot, limits, motion)?;
    require(
        certificate["promises"] == Value::from(promised.names()),
        format!("the promises are {:?}", promised.names()),
    )?;
    promised.check_places(&certificate)?;
    let intervals = entries(&certificate, "intervals");
    promised.check(intervals)?;
    let is_complete = missing.is_empty() && unread.is_empty();
    let outcome = if is_complete { "certified" } else { "certified in part" };
    let count = intervals.len();
    let at_places = ["goal", "waypoints"].into_iter().filter(|key| !entries(&scenario, key).is_empty());
    let proved = ["horizon", "ends"].into_iter().chain(at_places).chain(promised.names());
    let proved = proved.collect::<Vec<_>>().join(", ");
    let unread = unread.into_iter().map(|name| format!("that the pieces of '{name}' contain this mesh"));
    let missing: Vec<String> = missing.into_iter().chain(unread).collect();
    let not = if is_complete { String::new() } else { format!("; not certified: {}", missing.join(", ")) };
    let within = match promised.tube {
        0.0 => String::new(),
        tube => format!(" for positions within {tube} of the motion"),
    };
    let text = format!("{outcome} at all times{within}, by {count} intervals: {proved}{not}");
    Ok(Report { text, is_complete })
}

/// Checks that the listed meshes are those of the robot and that their pieces contain them. Returns the names of those
/// that cannot be read.
fn compare_meshes(
    robot: &Robot,
    pieces: &[Vec<Piece>],
    listed: &Value,
    files: &dyn Fn(&str) -> Option<Vec<u8>>,
) -> Checked<BTreeSet<String>> {
    let hashes: BTreeMap<&String, &Value> = listed.as_object().into_iter().flatten().collect();
    let own: BTreeSet<&String> = robot.meshes.iter().map(|(name, _)| name).collect();
    require(own.into_iter().eq(hashes.keys().copied()), "the meshes are not those of the robot")?;
    let mut read = BTreeMap::new();
    for (name, hash) in hashes {
        let bytes = files(name);
        let is_same = bytes.as_ref().is_none_or(|bytes| *hash == sha256(bytes));
        require(is_same, format!("'{name}' is another file than that of the certificate"))?;
        read.insert(name, bytes.and_then(|bytes| triangles(name, &bytes)));
    }
    let mut unread = BTreeSet::new();
    for ((name, scale), own) in robot.meshes.iter().zip(pieces) {
        match &read[name] {
            None => drop(unread.insert(name.clone())),
            Some(all) => {
                require(are_covered(all, *scale, own), format!("the pieces of '{name}' do not contain it"))?;
            }
        }
    }
    Ok(unread)
}
