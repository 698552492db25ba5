//! A checker of certificates, in one file. It shares no code with the library that plans motions and writes
//! certificates: URDF, scenario, polynomials, inverse dynamics and distances are read and computed here once more, with
//! the errors of rounding. `proofs/certificate.md` has the statement and its proof.

mod arithmetic;
mod distance;
mod json;
mod motion;
mod robot;
mod scenario;

use arithmetic::{Ball, Bernstein, Tm};
use distance::{Distances, keeps};
use json::{array, get, list, number, option, require, text};
use motion::{Polynomial, cut, deviations, expand, motion};
use robot::Robot;
use scenario::{Limit, limits, not_certified, obstacles, pairs, same_limits, unnamed};
use serde_json::Value;
use twox_hash::XxHash64;

/// A result, or the reason of a refusal.
type Checked<T> = Result<T, String>;

/// The accepted shortfall of a reserve, and the accepted deviations of states and of accelerations.
const TOLERANCE: f64 = 1e-9;

const STATE: f64 = 1e-9;

const ACCELERATION: f64 = 1e-6;

/// Checks a certificate, given the texts of the robot, of the scenario (or of a summary that contains it), of the
/// summary of the solve, whose motion it is about, and of the certificate. Returns what is certified in words.
///
/// # Errors
/// The reason of a refusal.
pub fn check(robot: &str, scenario: &str, run: &str, certificate: &str) -> Checked<String> {
    let parse = |text: &str, what: &str| serde_json::from_str::<Value>(text).map_err(|e| format!("{what}: {e}"));
    let (scenario, run) = (parse(scenario, "scenario")?, parse(run, "summary")?);
    let certificate = parse(certificate, "certificate")?;
    let scenario = scenario.get("provenance").and_then(|p| p.get("scenario")).unwrap_or(&scenario);
    let given = |key: &str| get(&certificate, key);
    require(given("format")? == "aghf-certificate-1", "another format")?;
    require(number(given("tolerance")?)? == TOLERANCE, "another tolerance")?;
    require(*given("robot_xxh64")? == format!("{:016x}", XxHash64::oneshot(0, robot.as_bytes())), "another robot")?;
    let curve = get(&run, "curve")?;
    require(given("joints")? == get(curve, "joints")?, "the joints are not those of the run")?;
    let names: Vec<String> =
        array(given("joints")?)?.iter().map(|n| text(n).map(str::to_owned)).collect::<Checked<_>>()?;
    let motion = motion(given("coefficients")?, get(curve, "coefficients")?, names.len())?;
    let horizon = number(given("horizon_s")?)?;
    require(horizon == number(get(curve, "horizon_s")?)?, "the horizon is not that of the run")?;
    let [shortest, longest] = match option(scenario, "free_horizon") {
        Some(free) => [number(get(free, "shortest_s")?)?, number(get(free, "longest_s")?)?],
        None => [number(get(scenario, "horizon_s")?)?; 2],
    };
    require(shortest <= horizon && horizon <= longest && horizon > 0.0, "the horizon is not that of the scenario")?;
    let robot = Robot::read(robot, scenario, &names)?;
    let missing = not_certified(scenario, &robot, given("not_certified")?)?;
    require(*given("complete")? == missing.is_empty(), "'complete' is wrong")?;
    let limits = limits(scenario, &robot)?;
    same_limits(&limits, array(given("limits")?)?)?;
    let (degree, segments) = (motion[0][0].len() - 1, motion.len());
    let rate = |w: f64| Ball::new(2.0 * segments as f64).over(horizon).over(w);
    // Short intervals about both ends of each segment, where Chebyshev polynomials are exact.
    let short = 1.0 / f64::from(1 << 20);
    let about = |segment: &Vec<Vec<f64>>, x: f64| expand(segment, rate(short), [x, short]);
    let ends: Vec<_> = motion.iter().map(|segment| [about(segment, -1.0), about(segment, 1.0)]).collect();
    deviations(scenario, given("deviations")?, &ends)?;
    let obstacles = obstacles(scenario)?;
    let pairs = pairs(scenario, &certificate, &robot, &obstacles)?;
    let kinds = ["position", "velocity", "acceleration", "jerk", "torque"];
    let mut promises: Vec<&str> = kinds.into_iter().filter(|k| limits.iter().any(|l| l.0 == *k)).collect();
    let first = promises.len();
    let clear = ["obstacles", "self_collision"].into_iter().zip(&pairs).filter(|(_, p)| !p.is_empty());
    let (clear, pairs): (Vec<_>, Vec<_>) = clear.unzip();
    promises.extend(clear);
    require(*given("promises")? == Value::from(promises.clone()), format!("the promises are {promises:?}"))?;

    let bases = [Bernstein::new(degree), Bernstein::new(Tm::new(0.0).c.len() - 1)];
    let intervals = array(given("intervals")?)?;
    let (mut segment, mut from) = (0, -1.0);
    for interval in intervals {
        let entry = |i: usize| interval.get(i).ok_or("an interval has too few entries");
        let (own, begin, end) = (entry(0)?, number(entry(1)?)?, number(entry(2)?)?);
        let claims = list(entry(3)?)?;
        if from == 1.0 {
            (segment, from) = (segment + 1, -1.0);
        }
        let (m, w) = (0.5 * (begin + end), 0.5 * (end - begin));
        let exact = m - w == begin && m + w == end && w > 0.0 && end <= 1.0;
        require(
            *own == segment && segment < segments && begin == from && exact,
            "the intervals do not cover the horizon",
        )?;
        require(
            claims.len() == promises.len() && claims.iter().all(|c| *c >= -TOLERANCE),
            "a reserve is negative or missing",
        )?;
        from = end;
        let place = |what: &str| format!("segment {segment} from {begin} to {end}: {what} is not proved");
        let [q, v, a, jerk] = expand(&motion[segment], rate(w), [m, w]);
        let models = |all: &[Polynomial]| -> Vec<Tm> { all.iter().map(cut).collect() };
        let (places, torques) = (
            models(&q),
            match promises.contains(&"torque") {
                true => robot.torques(&models(&q), &models(&v), &models(&a)),
                false => Vec::new(),
            },
        );
        let torques: Vec<Polynomial> = torques.iter().map(|t| (t.c.to_vec(), t.r)).collect();
        for Limit(promise, joint, bounds) in &limits {
            let claim = promises.iter().zip(&claims).find(|(p, _)| *p == promise).map_or(f64::NAN, |(_, c)| *c);
            let all = [&q, &v, &a, &jerk, &torques];
            let of = kinds.iter().position(|k| k == promise).map(|k| (&bases[usize::from(k == 4)], &all[k][*joint]));
            let (basis, (c, r)) = of.ok_or("a limit is of an unknown kind")?;
            let scale = bounds.iter().filter(|b| b.is_finite()).fold(0.0_f64, |s, b| s.max(b.abs()));
            let room = claim * if scale > 0.0 { scale } else { 1.0 };
            let negative: Vec<f64> = c.iter().map(|c| -c).collect();
            let at_least =
                |c: &[f64], bound: f64| !bound.is_finite() || basis.least(c, *r, bound, 1e-13 * scale) >= bound;
            let kept = at_least(c, bounds[0] + room) && at_least(&negative, room - bounds[1]);
            require(kept, place(&format!("{promise} of joint '{}'", names[*joint])))?;
        }
        if !pairs.is_empty() {
            let (centres, by) = (robot.centres(&places), Distances(&bases[1]));
            for (i, pairs) in pairs.iter().enumerate() {
                require(
                    keeps(claims[first + i], pairs, &robot, &obstacles, &centres, &by),
                    place(promises[first + i]),
                )?;
            }
        }
    }
    require(segment == segments - 1 && from == 1.0, "the intervals do not cover the horizon")?;
    let outcome = if missing.is_empty() { "certified" } else { "certified in part" };
    let count = intervals.len();
    let proved = ["horizon", "ends"].into_iter().chain(promises).collect::<Vec<_>>().join(", ");
    let not = if missing.is_empty() { String::new() } else { format!("; not certified: {}", missing.join(", ")) };
    let assumed = unnamed(scenario, array(given("may_overlap")?)?);
    Ok(format!("{outcome} at all times, by {count} intervals: {proved}{not}{assumed}"))
}
