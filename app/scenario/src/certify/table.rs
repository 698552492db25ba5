//! The difference between a certified motion and a table or a message that is made of it.

use crate::judge::Trajectory;
use crate::{CurveFile, Scenario};
use aghf::certify::{Bernstein, Motion, Part, Polynomial};
use aghf::error::{Error, Result, plain};

/// The degrees of the polynomials that controllers put between samples: by positions alone, with velocities, and with
/// accelerations.
const DEGREES: [usize; 3] = [1, 3, 5];

/// The largest difference of the durations of a table and a motion, s: messages have whole nanoseconds.
const SAME_DURATION: f64 = 1e-8;

/// An allowance for rounding, relative to the size of a polynomial: more than that of its coefficients.
const ROUNDING: f64 = 1e-13;

/// The accuracy of a bound, relative to the size of a polynomial.
const ACCURACY: f64 = 1e-12;

/// Bounds on the differences of positions and velocities, rad or m, and per s, at all times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableDifference {
    /// The degree of the polynomials between samples: 1, 3 or 5.
    pub degree: usize,
    /// That of positions.
    pub position: f64,
    /// That of velocities.
    pub velocity: f64,
}

/// The hash of a summary in the text of a table or a message that `aghf sample` or `aghf export` made.
#[must_use]
pub fn named_run(text: &str) -> Option<&str> {
    let (_, rest) = text.split_once(NAME)?;
    rest.get(..64).filter(|hash| hash.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

/// The text before the hash of a summary in tables and messages.
pub const NAME: &str = "run_sha256:";

/// Bounds the difference of the certified motion of a solve from the motions that a controller makes of a table:
/// straight lines between samples, cubics if there are velocities, quintics if there are accelerations. Cost O(N p^2)
/// per sample.
///
/// # Errors
/// The joints or the duration are others.
pub fn table_differences(scenario: &Scenario, curve: &CurveFile, table: &Trajectory) -> Result<Vec<TableDifference>> {
    curve.check_joints(&scenario.model, "table")?;
    let motion = Motion::new(curve.horizon_s, &curve.positions())?;
    let duration = table.duration();
    if (duration - motion.horizon()).abs() > SAME_DURATION {
        let (duration, horizon) = (plain(duration), plain(motion.horizon()));
        let condition = format!("it lasts {duration} s, the motion {horizon} s");
        return Err(Error::input("table", "t", condition));
    }
    let is_known = [true, table.v.is_some(), table.v.is_some() && table.a.is_some()];
    let known = DEGREES.into_iter().zip(is_known).filter(|(_, is_known)| *is_known);
    Ok(known.map(|(degree, _)| difference(&motion, table, degree)).collect())
}

/// The largest differences for polynomials of a degree between samples.
fn difference(motion: &Motion, table: &Trajectory, degree: usize) -> TableDifference {
    let basis = Bernstein::new(motion.degree().max(degree));
    let per_second = motion.segments() as f64 / motion.horizon();
    let largest = |c: Vec<f64>, radius: f64| {
        let size: f64 = c.iter().map(|c| c.abs()).sum();
        let polynomial = Polynomial { coefficients: c, radius: radius + ROUNDING * size };
        let range = basis.range(&polynomial, ACCURACY * size.max(1.0));
        range.upper.max(-range.lower)
    };
    let mut found = [0.0_f64; 2];
    for k in 0..table.times.len() - 1 {
        let [from, to] = [k, k + 1].map(|k| table.times[k] - table.times[0]);
        // In segments from the start.
        let [begin, end] = [from, to].map(|t| t * per_second);
        let mut cuts = vec![begin];
        cuts.extend((0..=motion.segments()).map(|e| e as f64).filter(|e| begin < *e && *e < end));
        cuts.push(end);
        for cut in cuts.windows(2) {
            let middle = 0.5 * (cut[0] + cut[1]);
            let segment = (middle as usize).min(motion.segments() - 1);
            let part = Part { segment, middle: 2.0 * (middle - segment as f64) - 1.0, half: cut[1] - cut[0] };
            let piece = motion.piece(part);
            // The places of the table's own variable, from -1 to 1 over the interval, on this cut.
            let places = [cut[0], cut[1]].map(|x| 2.0 * (x - begin) / (end - begin) - 1.0);
            let half_s = 0.5 * (cut[1] - cut[0]) / per_second;
            for (i, q) in piece.q.iter().enumerate() {
                let own = within(&samples(table, k, i, degree, to - from), places);
                let count = own.len().max(q.coefficients.len());
                let at = |c: &[f64], j: usize| c.get(j).copied().unwrap_or(0.0);
                let off: Vec<f64> = (0..count).map(|j| at(&own, j) - at(&q.coefficients, j)).collect();
                let rate: Vec<f64> = (1..count).map(|j| j as f64 * off[j] / half_s).collect();
                let size: f64 = q.coefficients.iter().map(|c| c.abs()).sum();
                let by_rounding = q.radius + ROUNDING * size;
                found[0] = found[0].max(largest(off, by_rounding));
                found[1] = found[1].max(largest(rate, count as f64 * by_rounding / half_s));
            }
        }
    }
    let [position, velocity] = found;
    TableDifference { degree, position, velocity }
}

/// The coefficients in `x`, from -1 to 1 over an interval of `h` seconds, of the polynomial of this degree through the
/// positions of a joint at both ends, and through velocities and accelerations if the degree is 3 or 5.
fn samples(table: &Trajectory, k: usize, i: usize, degree: usize, h: f64) -> Vec<f64> {
    let both = |of: &[Vec<f64>], scale: f64| [k, k + 1].map(|k| of[k][i] * scale);
    // Sums and differences of the values at both ends, which even and odd powers have.
    let halves = |[a, b]: [f64; 2]| [0.5 * (a + b), 0.5 * (b - a)];
    let [mean, way] = halves(both(&table.q, 1.0));
    let Some(v) = table.v.as_ref().filter(|_| degree > 1) else {
        return vec![mean, way];
    };
    let [speed, turn] = halves(both(v, 0.5 * h));
    let Some(a) = table.a.as_ref().filter(|_| degree > 3) else {
        return vec![mean - 0.5 * turn, 1.5 * way - 0.5 * speed, 0.5 * turn, 0.5 * (speed - way)];
    };
    let [push, jerk] = halves(both(a, 0.25 * h * h));
    // Even: c0 + c2 + c4 is the mean, 2 c2 + 4 c4 the turn, 2 c2 + 12 c4 the push; odd alike.
    let fourth = (push - turn) / 8.0;
    let second = 0.5 * turn - 2.0 * fourth;
    let fifth = (jerk - 3.0 * (speed - way)) / 8.0;
    let third = 0.5 * (speed - way) - 2.0 * fifth;
    let first = way - third - fifth;
    vec![mean - second - fourth, first, second, third, fourth, fifth]
}

/// The coefficients of a polynomial on the part of its interval between two places, with -1 and 1 there.
fn within(c: &[f64], [from, to]: [f64; 2]) -> Vec<f64> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let mut found: Vec<f64> = Vec::new();
    // Horner's scheme: times (middle + half x), plus the next coefficient.
    for c in c.iter().rev() {
        let mut next = vec![0.0; found.len() + 1];
        for (j, f) in found.iter().enumerate() {
            next[j] += middle * f;
            next[j + 1] += half * f;
        }
        next[0] += c;
        found = next;
    }
    found
}
