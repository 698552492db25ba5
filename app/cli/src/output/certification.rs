//! The result of a certification in words.

use super::table::short;
use aghf_scenario::certify::{Certificate, Certification, Failure, Passage, TableDifference};
use aghf_scenario::{Quantity, RobotShape, promise_in_words};

/// Formats the result of a certification of a robot in this shape, which took this time.
#[must_use]
pub fn certification_text(certification: &Certification, shape: RobotShape, seconds: f64) -> String {
    let mut lines: Vec<_> = certification.failures.iter().map(failure_text).collect();
    let Some(certificate) = &certification.certificate else {
        lines.push(format!("not certified ({} s)", short(seconds)));
        return lines.join("\n");
    };
    lines.extend(promise_lines(certificate, shape));
    if let Some(reserve) = certificate.goal {
        lines.push(format!("goal: proved, least reserve {reserve:.2e} m or rad"));
    }
    for (i, Passage(.., reserve)) in certificate.waypoints.iter().enumerate() {
        lines.push(format!("waypoint {i}: proved, least reserve {reserve:.2e} m, rad or their rates"));
    }
    for (key, reason) in certificate.left_out() {
        lines.push(format!("{key}: not certified, {reason}"));
    }
    let verdict = if certificate.complete { "certified" } else { "certified in part" };
    let tube = match certificate.tracking_error {
        0.0 => String::new(),
        tube => format!(", for positions within {tube} of the motion"),
    };
    let intervals = certificate.intervals.len();
    lines.push(format!("{verdict}: all times{tube}, by {intervals} intervals ({} s)", short(seconds)));
    lines.join("\n")
}

/// Formats a bound on the difference of a table with this number of samples from a certified motion.
#[must_use]
pub fn table_difference_text(name: &str, samples: usize, difference: &TableDifference) -> String {
    let between = match difference.degree {
        1 => "straight lines",
        3 => "cubics",
        _ => "quintics",
    };
    format!(
        "{name}: with {between} between its {samples} samples within {:.1e} rad or m and {:.1e} per s of the certified \
         motion at all times",
        difference.position, difference.velocity
    )
}

fn failure_text(failure: &Failure) -> String {
    let (value, bound) = (failure.value, failure.bound);
    let outcome = if failure.is_broken { "broken" } else { "not proved" };
    let place = match failure.place.as_str() {
        "" => String::new(),
        place => format!(" by {place}"),
    };
    let at = if failure.at_s.is_nan() { String::new() } else { format!(" at {:.6} s", failure.at_s) };
    let by = (value - bound).abs();
    format!("{}: {outcome}{place}{at}: {value} where {bound} is allowed, by {by:.1e}", failure.promise)
}

/// The promises that are proved, each with its least reserve over the intervals.
fn promise_lines(certificate: &Certificate, shape: RobotShape) -> impl Iterator<Item = String> {
    let promises = certificate.promises.iter().enumerate();
    promises.map(move |(i, promise)| {
        let reserves = certificate.intervals.iter().map(|interval| interval.3[i]);
        let least = reserves.fold(f64::INFINITY, f64::min);
        let unit = match promise {
            Quantity::Obstacles | Quantity::SelfCollision => "m",
            Quantity::Frame => "m, rad or m/s",
            Quantity::Foot => "of the weight, m or of the ratio of friction",
            _ => "of the limit",
        };
        // Beside a tube no reserve is claimed.
        let reserve = match certificate.tracking_error {
            0.0 => format!(", least reserve {least:.2e} {unit}"),
            _ => String::new(),
        };
        let of = match (promise, shape) {
            (Quantity::Obstacles, RobotShape::JointFrames) => {
                " for the origins of joint frames and a load, not for links"
            }
            _ => "",
        };
        format!("{}: proved{of}{reserve}", promise_in_words(*promise))
    })
}
