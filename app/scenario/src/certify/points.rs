//! States at the ends, between segments and at waypoints.

use super::rows::{EQUALITY, Nearest, Row, Rows, rows_of, values_of};
use super::{Deviations, Failure, Passage, Promise};
use crate::{Continuous, Scenario};
use aghf::certify::{Motion, Part, Piece, Polynomial};
use aghf::constraint::AnyConstraint;
use aghf::error::Result;
use aghf::scalar::Ball;

/// The accepted deviation of states at the ends and between segments, and of accelerations there.
const STATE: f64 = 1e-9;
const ACCELERATION: f64 = 1e-6;

/// Bounds on the deviations of a motion from the states of the scenario, and on its jumps, with an allowance for
/// another arithmetic.
pub(super) fn deviations(scenario: &Scenario, motion: &Motion) -> Deviations {
    let file = &scenario.file;
    let claim = |deviations: Vec<Ball>| {
        let magnitudes = deviations.iter().map(Ball::magnitude);
        let largest = magnitudes.fold(0.0, |largest, x| if x <= largest { largest } else { x });
        2.0 * largest + f64::EPSILON
    };
    let at = |segment: usize, x: f64| motion.piece(Part::about(segment, x));
    let last = motion.segments() - 1;
    let (start, end) = (at(0, -1.0), at(last, 1.0));
    let off = |all: &[Polynomial], wanted: &[f64]| {
        let pairs = all.iter().zip(wanted);
        claim(
            pairs
                .map(|(p, x)| p.middle() - Ball::constant(*x))
                .collect(),
        )
    };
    let breakpoints: Vec<_> = (1..=last).map(|e| [at(e - 1, 1.0), at(e, -1.0)]).collect();
    let jump = |of: fn(&Piece) -> &Vec<Polynomial>| {
        let pairs = breakpoints
            .iter()
            .flat_map(|[a, b]| of(a).iter().zip(of(b)));
        let jumps = pairs.map(|(a, b)| a.middle() - b.middle());
        (last > 0).then(|| claim(jumps.collect()))
    };
    let is_smooth = file.continuity() == Continuous::Acceleration;
    Deviations {
        start_position: Some(off(&start.q, &file.q_start)),
        start_velocity: Some(off(&start.v, &file.v_start)),
        goal_position: file.goal.is_empty().then(|| off(&end.q, &file.q_goal)),
        goal_velocity: (!file.free_final_velocity).then(|| off(&end.v, &file.v_goal)),
        jump_position: jump(|piece| &piece.q),
        jump_velocity: jump(|piece| &piece.v),
        jump_acceleration: is_smooth.then(|| jump(|piece| &piece.a)).flatten(),
    }
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
        for constraints in self
            .scenario
            .goal
            .iter()
            .flat_map(|goal| &goal.alternatives)
        {
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
                Row::new(Promise::Position, place, [aim - EQUALITY, aim + EQUALITY])
            });
            rows.zip(all.iter().map(|p| Polynomial::from(p.middle())))
                .collect()
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
        let rows = rows_of(Promise::Keep, constraints, model);
        all.extend(rows.into_iter().zip(values));
        let nearest = all.into_iter().map(|(row, value)| {
            let nearest = self.rows.nearest_of(&row, &value);
            (row, nearest)
        });
        // A claim of NaN is the worst.
        Ok(nearest.reduce(|a, b| {
            if a.1.claim <= b.1.claim || a.1.claim.is_nan() {
                a
            } else {
                b
            }
        }))
    }
}

/// The states at the ends and between segments that differ from those of a scenario, and the horizon if it differs.
pub(super) fn broken(scenario: &Scenario, horizon: f64, found: &Deviations) -> Vec<Failure> {
    let mut failures = Vec::new();
    let states = [
        ("start position", found.start_position, STATE, 0.0),
        ("start velocity", found.start_velocity, STATE, 0.0),
        ("goal position", found.goal_position, STATE, horizon),
        ("goal velocity", found.goal_velocity, STATE, horizon),
        (
            "continuity of positions",
            found.jump_position,
            STATE,
            f64::NAN,
        ),
        (
            "continuity of velocities",
            found.jump_velocity,
            STATE,
            f64::NAN,
        ),
        (
            "continuity of accelerations",
            found.jump_acceleration,
            ACCELERATION,
            f64::NAN,
        ),
    ];
    for (promise, value, bound, at_s) in states {
        let Some(value) = value else { continue };
        let holds = value <= bound;
        if !holds {
            failures.push(Failure {
                promise: promise.to_owned(),
                place: String::new(),
                at_s,
                value,
                bound,
                is_broken: true,
            });
        }
    }
    let file = &scenario.file;
    let [shortest, longest] = match file.free_horizon {
        Some(free) => [free.shortest_s, free.longest_s],
        None if file.objective.weighs_time() => [0.0, f64::INFINITY],
        None => [file.horizon_s; 2],
    };
    if !(shortest..=longest).contains(&horizon) {
        failures.push(Failure {
            promise: "horizon".to_owned(),
            place: String::new(),
            at_s: horizon,
            value: horizon,
            bound: if horizon < shortest {
                shortest
            } else {
                longest
            },
            is_broken: true,
        });
    }
    failures
}
