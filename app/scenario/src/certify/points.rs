//! States at the ends, between segments and at waypoints.

use super::rows::{EQUALITY, Nearest, Row, Rows, rows_of, values_of};
use super::{Failure, Passage};
use crate::{Continuous, CurveFile, Kept, Quantity, Scenario};
use aghf::certify::{Motion, Part, Piece, Polynomial};
use aghf::constraint::AnyConstraint;
use aghf::error::Result;
use aghf::scalar::{Ball, Zero};

/// The accepted deviation of states at the ends and between segments, and of accelerations there.
const STATE: f64 = 1e-9;
const ACCELERATION: f64 = 1e-6;

/// The states at the ends and between segments that differ from what a scenario promises, velocities that are not the
/// rates of positions, and the horizon if it differs. An allowance is made for another arithmetic.
pub(super) fn broken_ends(scenario: &Scenario, curve: &CurveFile, motion: &Motion) -> Result<Vec<Failure>> {
    let (file, horizon) = (&scenario.file, motion.horizon());
    let largest = |deviations: Vec<Ball>| {
        let magnitudes = deviations.iter().map(Ball::magnitude);
        let largest = magnitudes.fold(0.0, |largest, x| if x <= largest { largest } else { x });
        2.0 * largest + f64::EPSILON
    };
    let at = |segment: usize, x: f64| motion.piece(Part::about(segment, x));
    let last = motion.segments() - 1;
    let (start, end) = (at(0, -1.0), at(last, 1.0));
    let off = |all: &[Polynomial], wanted: &[f64]| {
        let pairs = all.iter().zip(wanted);
        largest(pairs.map(|(p, x)| p.middle() - Ball::constant(*x)).collect())
    };
    let breakpoints: Vec<_> = (1..=last).map(|e| [at(e - 1, 1.0), at(e, -1.0)]).collect();
    let jump = |of: fn(&Piece) -> &Vec<Polynomial>| {
        let pairs = breakpoints.iter().flat_map(|[a, b]| of(a).iter().zip(of(b)));
        largest(pairs.map(|(a, b)| a.middle() - b.middle()).collect())
    };
    let is_smooth = file.continuity() == Continuous::Acceleration;
    let is_free = file.free_final_velocity;
    let [a_start, a_goal] = &file.accelerations();
    let off_given = |all: &[Polynomial], given: &Option<Vec<f64>>| given.as_ref().map_or(0.0, |a| off(all, a));
    let ends = [
        ("start position", true, off(&start.q, &file.q_start), STATE, 0.0),
        ("start velocity", true, off(&start.v, &file.v_start), STATE, 0.0),
        ("start acceleration", a_start.is_some(), off_given(&start.a, a_start), ACCELERATION, 0.0),
        ("goal position", file.goal.is_empty(), off(&end.q, &file.q_goal), STATE, horizon),
        ("goal velocity", !is_free, off(&end.v, &file.v_goal), STATE, horizon),
        ("goal acceleration", a_goal.is_some(), off_given(&end.a, a_goal), ACCELERATION, horizon),
        ("velocity as the rate of the position", true, largest(slip(curve)?), STATE, f64::NAN),
        ("continuity of positions", true, jump(|piece| &piece.q), STATE, f64::NAN),
        ("continuity of velocities", true, jump(|piece| &piece.v), STATE, f64::NAN),
        ("continuity of accelerations", is_smooth, jump(|piece| &piece.a), ACCELERATION, f64::NAN),
    ];
    let failure = |promise: &str, value: f64, bound: f64, at_s: f64| Failure {
        promise: promise.to_owned(),
        place: String::new(),
        at_s,
        value,
        bound,
        is_broken: true,
    };
    // A deviation that is no number breaks its promise.
    let is_within = |value: f64, bound: f64| value <= bound;
    let broken = ends.into_iter().filter(|(_, is_asked, value, bound, _)| *is_asked && !is_within(*value, *bound));
    let mut failures: Vec<_> =
        broken.map(|(promise, _, value, bound, at_s)| failure(promise, value, bound, at_s)).collect();
    let [shortest, longest] = file.horizon_bounds();
    if !(shortest..=longest).contains(&horizon) {
        let bound = if horizon < shortest { shortest } else { longest };
        failures.push(failure("horizon", horizon, bound, horizon));
    }
    for (i, [from, to]) in file.keep.iter().map(Kept::times).enumerate() {
        if !(from < to && from < horizon) {
            let promise = format!("keep[{i}] from {from} to {to} s, at no time of the motion");
            failures.push(failure(&promise, horizon, from, horizon));
        }
    }
    Ok(failures)
}

/// Bounds on the differences of the velocities of a curve from the rates of its positions, per segment and joint.
fn slip(curve: &CurveFile) -> Result<Vec<Ball>> {
    let (joints, segments) = (curve.joints.len(), curve.segments as f64);
    let rates = Motion::new(curve.horizon_s, &curve.positions())?;
    let mut found = Vec::new();
    for (e, segment) in curve.coefficients.iter().enumerate() {
        let velocities = segment.get(joints..).unwrap_or_default();
        for (velocity, rate) in velocities.iter().zip(rates.rates(e)) {
            let scale = Ball::constant(2.0 * segments).divided_by(curve.horizon_s);
            let zero = std::iter::once(Ball::zero());
            let off = velocity.iter().zip(rate.iter().copied().chain(zero));
            let off = off.map(|(v, rate)| Ball::constant((Ball::constant(*v) - rate * scale).magnitude()));
            found.push(off.fold(Ball::zero(), |sum, off| sum + off));
        }
    }
    Ok(found)
}

/// The row with the least reserve at a place of a motion, and its nearest value.
type Worst = (Row, Nearest);

/// The conditions at single places of a motion.
pub(super) struct Points<'a> {
    pub(super) scenario: &'a Scenario,
    pub(super) motion: &'a Motion,
    pub(super) rows: &'a Rows<'a>,
}

impl Points<'_> {
    /// The worst row at the end of the alternative of the goal that has the largest least reserve; `None` if the goal
    /// is no set of poses.
    pub(super) fn goal(&self) -> Result<Option<Worst>> {
        let end = Part::about(self.motion.segments() - 1, 1.0);
        let mut best: Option<Worst> = None;
        for constraints in self.scenario.goal.iter().flat_map(|goal| &goal.alternatives) {
            let worst = self.worst(end, constraints, Vec::new())?;
            let known = best.as_ref().map_or(f64::NEG_INFINITY, |(_, n)| n.claim);
            best = worst.filter(|(_, n)| n.claim > known).or(best);
        }
        Ok(best)
    }

    /// The place of a waypoint at a time and the worst row there.
    pub(super) fn waypoint(&self, k: usize, time: f64) -> Result<(Passage, Option<Worst>)> {
        let (motion, point) = (self.motion, &self.scenario.file.waypoints[k]);
        let place = (time / motion.horizon() * motion.segments() as f64).max(0.0);
        let segment = (place as usize).min(motion.segments() - 1);
        let x = (2.0 * (place - segment as f64) - 1.0).clamp(-1.0, 1.0);
        let part = Part::about(segment, x);
        let piece = motion.piece(part);
        let joints = self.scenario.model.joints().iter();
        let near = |aims: &[f64], all: &[Polynomial], what: &str| -> Vec<_> {
            let rows = joints.clone().zip(aims).map(|(joint, aim)| {
                let place = format!("{what} of joint '{}'", joint.name());
                Row::new(Quantity::Position, place, [aim - EQUALITY, aim + EQUALITY])
            });
            rows.zip(all.iter().map(|p| Polynomial::from(p.middle()))).collect()
        };
        let mut own = Vec::new();
        if let Some(q) = &point.q {
            own.extend(near(q, &piece.q, "position"));
        }
        if point.stop {
            own.extend(near(&vec![0.0; joints.len()], &piece.v, "velocity"));
        }
        let worst = self.worst(part, &self.scenario.waypoints[k].constraints, own)?;
        let reserve = worst.as_ref().map_or(0.0, |(_, nearest)| nearest.claim);
        Ok((Passage(segment, x, reserve), worst))
    }

    /// The worst of the rows of constraints in the middle of a part and of others with their values.
    fn worst(
        &self,
        part: Part,
        constraints: &[AnyConstraint],
        mut all: Vec<(Row, Polynomial)>,
    ) -> Result<Option<Worst>> {
        let (piece, model) = (self.motion.piece(part), &self.scenario.model);
        let state = [&piece.q, &piece.v].map(|all| all.iter().map(Polynomial::middle).collect());
        let values = values_of(constraints, model, state)?;
        let rows = rows_of(Quantity::Frame, constraints, model);
        all.extend(rows.into_iter().zip(values));
        let nearest = all.into_iter().map(|(row, value)| {
            let nearest = self.rows.nearest_of(&row, &value);
            (row, nearest)
        });
        // A claim of NaN is the worst.
        Ok(nearest.reduce(|a, b| if a.1.claim <= b.1.claim || a.1.claim.is_nan() { a } else { b }))
    }
}
