//! A checker of certificates, in one file. It shares no code with the library that plans motions and writes
//! certificates: URDF, scenario, polynomials, inverse dynamics and distances are read and computed here once more, with
//! the errors of rounding. `proofs/certificate.md` has the statement and its proof.

mod arithmetic;
mod distance;
mod intervals;
mod joint;
mod json;
mod motion;
mod robot;
mod rows;
mod scenario;
mod shape;

use intervals::Promised;
use json::{array, entries, get, number, option, require, text};
use motion::{Motion, deviations};
use robot::Robot;
use scenario::{limits, not_certified, same_limits, unnamed, weighs_time};
use serde_json::Value;
use twox_hash::XxHash64;

/// A result, or the reason of a refusal.
type Checked<T> = Result<T, String>;

/// The accepted shortfall of a reserve.
const TOLERANCE: f64 = 1e-9;

/// Checks a certificate, given the texts of the robot, of the scenario (or of a summary that contains it), of the
/// summary of the solve, whose motion it is about, and of the certificate. Returns the certified promises in words.
///
/// # Errors
/// The reason of a refusal.
pub fn check(robot: &str, scenario: &str, run: &str, certificate: &str) -> Checked<String> {
    let parse = |text: &str, what: &str| serde_json::from_str::<Value>(text).map_err(|e| format!("{what}: {e}"));
    let (scenario, run) = (parse(scenario, "scenario")?, parse(run, "summary")?);
    let certificate = parse(certificate, "certificate")?;
    let scenario = scenario.get("provenance").and_then(|p| p.get("scenario")).unwrap_or(&scenario);
    let given = |key: &str| get(&certificate, key);
    require(given("format")? == "aghf-certificate-3", "another format")?;
    require(number(given("tolerance")?)? == TOLERANCE, "another tolerance")?;
    require(*given("robot_xxh64")? == format!("{:016x}", XxHash64::oneshot(0, robot.as_bytes())), "another robot")?;
    let curve = get(&run, "curve")?;
    require(given("joints")? == get(curve, "joints")?, "the joints are not those of the run")?;
    let names: Vec<String> =
        array(given("joints")?)?.iter().map(|n| text(n).map(str::to_owned)).collect::<Checked<_>>()?;
    let horizon = number(given("horizon_s")?)?;
    require(horizon == number(get(curve, "horizon_s")?)?, "the horizon is not that of the run")?;
    let motion = Motion::read(given("coefficients")?, get(curve, "coefficients")?, names.len(), horizon)?;
    let [shortest, longest] = match option(scenario, "free_horizon") {
        Some(free) => [number(get(free, "shortest_s")?)?, number(get(free, "longest_s")?)?],
        None if weighs_time(scenario)? => [0.0, f64::INFINITY],
        None => [number(get(scenario, "horizon_s")?)?; 2],
    };
    require(shortest <= horizon && horizon <= longest && horizon > 0.0, "the horizon is not that of the scenario")?;
    let robot = Robot::read(robot, scenario, &names)?;
    let missing = not_certified(scenario, &robot, given("not_certified")?)?;
    require(*given("complete")? == missing.is_empty(), "'complete' is wrong")?;
    let limits = limits(scenario, &robot)?;
    same_limits(&limits, array(given("limits")?)?)?;
    deviations(scenario, given("deviations")?, &motion)?;
    let promised = Promised::new(scenario, &certificate, robot, limits, motion)?;
    require(*given("promises")? == Value::from(promised.names()), format!("the promises are {:?}", promised.names()))?;
    promised.check_places(&certificate)?;
    let intervals = array(given("intervals")?)?;
    promised.check(intervals)?;
    let outcome = if missing.is_empty() { "certified" } else { "certified in part" };
    let count = intervals.len();
    let at_places = ["goal", "waypoints"].into_iter().filter(|key| !entries(scenario, key).is_empty());
    let proved = ["horizon", "ends"].into_iter().chain(at_places).chain(promised.names());
    let proved = proved.collect::<Vec<_>>().join(", ");
    let not = if missing.is_empty() { String::new() } else { format!("; not certified: {}", missing.join(", ")) };
    let assumed = unnamed(scenario, array(given("may_overlap")?)?);
    let within = match promised.tube {
        0.0 => String::new(),
        tube => format!(" for positions within {tube} of the motion"),
    };
    Ok(format!("{outcome} at all times{within}, by {count} intervals: {proved}{not}{assumed}"))
}
