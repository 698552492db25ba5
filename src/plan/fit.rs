//! The fit of a curve to a path.

use super::{Checker, PlanSettings, between, distance};
use crate::constraint::Constraint;
use crate::curve::{Basis, Curve};
use crate::error::{Error, Result, check_length};
use crate::motion::{Path, Problem, curve_of};
use nalgebra::DMatrix;

/// The number of times that the slope at a breakpoint is halved before it is set to zero.
const HALVINGS: i32 = 4;
/// The number of intervals per segment at whose ends the curve is checked.
const LOOKS: usize = 24;

/// Fits a curve of cubics to a path from start to goal of `problem`, in a basis with at least one segment per line of
/// the path.
///
/// Breakpoints are at the waypoints, and evenly spaced between distant ones. There the curve has the slope from the
/// previous to the next breakpoint, reduced until the curve is as free as the lines of the path: without any slope it
/// is the path itself. At the ends it has the velocities of the problem. Cost: some hundred configurations per segment.
///
/// # Errors
/// There are fewer than two waypoints or more lines than segments, a waypoint does not have `N` entries, or the
/// constraint refers to a joint or body that the robot does not have.
pub fn curve_along<K: Constraint + ?Sized>(
    problem: &Problem<'_>,
    constraint: &K,
    path: &[Vec<f64>],
    basis: Basis,
    settings: &PlanSettings,
) -> Result<Curve> {
    let curve = along(problem, constraint, (path, &[]), basis, settings)?;
    curve_of(problem, &curve)
}

/// Computes the coefficients of the curve of [`curve_along`], with zero slopes at these configurations of the path.
pub(crate) fn along<K: Constraint + ?Sized>(
    problem: &Problem<'_>,
    constraint: &K,
    (path, stops): (&[Vec<f64>], &[&[f64]]),
    basis: Basis,
    settings: &PlanSettings,
) -> Result<Path> {
    let (n, segments) = (problem.model().dof(), basis.segments());
    let refuse = |condition: String| Err(Error::input("path", "waypoints", condition));
    if path.len() < 2 {
        return refuse(format!("there are {}, at least 2 are needed", path.len()));
    }
    if path.len() > segments + 1 {
        let lines = path.len() - 1;
        return refuse(format!("there are {lines} lines between them and {segments} segments of a curve"));
    }
    for waypoint in path {
        check_length("waypoint", n, waypoint.len())?;
    }
    let breakpoints = divide(path, segments);
    let ends = [problem.start(), problem.goal()].map(|state| &state[..n]);
    let mut checker = Checker::new(problem.model(), constraint, settings.resolution)?;
    checker.keep(settings.margin, ends)?;
    let stops = breakpoints.iter().map(|q| stops.contains(&&q[..]));
    let mut halvings: Vec<_> = stops.map(|stop| if stop { HALVINGS + 1 } else { 0 }).collect();
    let share = |halvings: i32| match halvings {
        0..=HALVINGS => 0.5_f64.powi(halvings),
        _ => 0.0,
    };
    loop {
        let slopes: Vec<f64> = halvings.iter().map(|h| share(*h)).collect();
        let coefficients = coefficients(&breakpoints, &slopes, &basis);
        let curve = Path { coefficients, basis: basis.clone() }.between_ends_of(problem);
        let mut shorter = Vec::new();
        for e in 0..segments {
            let times = (1..LOOKS).map(|k| (e as f64 + k as f64 / LOOKS as f64) / segments as f64);
            let configurations: Vec<Vec<f64>> = times
                .map(|time| {
                    let [q, ..] = basis.evaluate(&curve.coefficients, time);
                    q.as_slice().to_vec()
                })
                .collect();
            if !checker.are_free(&configurations)? {
                shorter.extend([e, e + 1]);
            }
        }
        shorter.dedup();
        shorter.retain(|i| (1..segments).contains(i) && slopes[*i] > 0.0);
        if shorter.is_empty() {
            return Ok(curve);
        }
        for i in shorter {
            halvings[i] += 1;
        }
    }
}

/// The coefficients of the curve through breakpoints, at each inner one with this share of the slope from the previous
/// to the next.
fn coefficients(breakpoints: &[Vec<f64>], shares: &[f64], basis: &Basis) -> DMatrix<f64> {
    let (n, segments) = (breakpoints[0].len(), basis.segments());
    let mut coefficients = DMatrix::zeros(n, basis.count());
    for (i, q) in breakpoints.iter().enumerate() {
        for j in 0..n {
            coefficients[(j, basis.value(i))] = q[j];
            if (1..segments).contains(&i) {
                let rise = breakpoints[i + 1][j] - breakpoints[i - 1][j];
                coefficients[(j, basis.slope(i))] = 0.5 * shares[i] * rise * segments as f64;
            }
        }
    }
    coefficients
}

/// The waypoints with additional points on the longest lines, so that there are as many lines as segments.
fn divide(path: &[Vec<f64>], segments: usize) -> Vec<Vec<f64>> {
    let lengths: Vec<f64> = path.windows(2).map(|line| distance(&line[0], &line[1])).collect();
    let mut parts = vec![1_usize; lengths.len()];
    for _ in lengths.len()..segments {
        let part = |i: &usize| lengths[*i] / parts[*i] as f64;
        let longest = (0..parts.len()).max_by(|a, b| part(a).total_cmp(&part(b)));
        parts[longest.unwrap_or(0)] += 1;
    }
    let mut points = vec![path[0].clone()];
    for (line, parts) in path.windows(2).zip(parts) {
        let shares = (1..=parts).map(|k| k as f64 / parts as f64);
        points.extend(shares.map(|share| between(&line[0], &line[1], share)));
    }
    points
}
