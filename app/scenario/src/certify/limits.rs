//! Limits of joints, and states at the ends and between segments.

use super::{Deviations, LimitRow, Promise};
use crate::{Continuous, Limit, Scenario};
use aghf::certify::{Bernstein, Motion, ORDER, Part, Piece, Polynomial, Range};
use aghf::dynamics::Data;
use aghf::error::Result;
use aghf::scalar::{Ball, TaylorModel};

/// The relative reserve below which a bound is computed accurately, and the two accuracies.
const NEAR: f64 = 0.05;
const COARSE: f64 = 0.02;
const FINE: f64 = 1e-10;

/// The multiple of the bound on the errors that a claim leaves to the arithmetic of another checker.
const OTHER_ERRORS: f64 = 3.0;

/// The largest error, relative to the scale of a row, with which claims are made.
const LARGEST_ERROR: f64 = 1e-3;

/// The kinds of limits.
pub(super) const LIMITS: [(Promise, Limit); 5] = [
    (Promise::Position, Limit::Position),
    (Promise::Velocity, Limit::Velocity),
    (Promise::Acceleration, Limit::Acceleration),
    (Promise::Jerk, Limit::Jerk),
    (Promise::Torque, Limit::Torque),
];

/// The limits that a scenario enforces, without the zero torques of passive joints.
pub(super) fn rows(scenario: &Scenario) -> Vec<LimitRow> {
    let passive = scenario.passive();
    let mut rows = Vec::new();
    for (promise, limit) in LIMITS {
        for joint in 0..scenario.model.dof() {
            if promise == Promise::Torque && passive.contains(&joint) {
                continue;
            }
            if let Some([lower, upper]) = scenario.bound(limit, joint) {
                rows.push(LimitRow {
                    promise,
                    joint,
                    at_least: lower.is_finite().then_some(lower),
                    at_most: upper.is_finite().then_some(upper),
                });
            }
        }
    }
    rows
}

/// The value of a row that is nearest to a bound, or beyond one.
pub(super) struct Nearest {
    /// The proved reserve relative to the scale of the row, less what is left to another arithmetic.
    pub(super) claim: f64,
    /// True if the error is small enough for a claim.
    pub(super) is_known: bool,
    /// A value that is taken, rounded outward, the bound that it is nearest to, and its place.
    pub(super) value: f64,
    pub(super) bound: f64,
    pub(super) place: f64,
}

impl Nearest {
    /// True if the value is beyond the bound by more than what is accepted.
    pub(super) fn is_beyond(&self, row: &LimitRow) -> bool {
        let beyond = (self.value - self.bound).abs();
        let out = match row.at_most {
            Some(most) if most == self.bound => self.value > most,
            _ => self.value < self.bound,
        };
        out && beyond > super::TOLERANCE * row.scale()
    }
}

/// The bases and the scratch for bounds on limits.
pub(super) struct Bounds {
    of_motion: Bernstein,
    of_torques: Bernstein,
    data: Data<TaylorModel<ORDER>>,
}

impl Bounds {
    pub(super) fn new(scenario: &Scenario, motion: &Motion) -> Self {
        Self {
            of_motion: Bernstein::new(motion.degree()),
            of_torques: Bernstein::new(ORDER - 1),
            data: Data::new(&scenario.model),
        }
    }

    /// The nearest values of all rows on a piece.
    pub(super) fn nearest(
        &mut self,
        scenario: &Scenario,
        rows: &[LimitRow],
        piece: &Piece,
    ) -> Result<Vec<Nearest>> {
        let torques: Vec<Polynomial> = if rows.iter().any(|row| row.promise == Promise::Torque) {
            let all = piece.torques(&scenario.model, &mut self.data)?;
            let polynomial = |torque: &TaylorModel<ORDER>| Polynomial {
                coefficients: torque.coefficients().to_vec(),
                radius: torque.radius(),
            };
            all.iter().map(polynomial).collect()
        } else {
            Vec::new()
        };
        let one = |row: &LimitRow| {
            let (basis, all) = match row.promise {
                Promise::Position => (&self.of_motion, &piece.q),
                Promise::Velocity => (&self.of_motion, &piece.v),
                Promise::Acceleration => (&self.of_motion, &piece.a),
                Promise::Jerk => (&self.of_motion, &piece.jerk),
                _ => (&self.of_torques, &torques),
            };
            nearest(row, &all[row.joint], basis)
        };
        Ok(rows.iter().map(one).collect())
    }
}

/// The nearest value of a row whose values are those of a polynomial.
fn nearest(row: &LimitRow, polynomial: &Polynomial, basis: &Bernstein) -> Nearest {
    let scale = row.scale();
    let of = |range: Range| {
        let below = row.at_least.map(|least| {
            let reserve = (range.lower - least) / scale;
            (reserve, range.least_at_most, least, range.places[0])
        });
        let above = row.at_most.map(|most| {
            let reserve = (most - range.upper) / scale;
            (reserve, range.most_at_least, most, range.places[1])
        });
        let sides = [below, above].into_iter().flatten();
        // A reserve that is not a number is none.
        sides.reduce(|a, b| if a.0 <= b.0 || a.0.is_nan() { a } else { b })
    };
    let mut found = of(basis.range(polynomial, COARSE * scale));
    if found.is_some_and(|found| found.0 < NEAR) {
        found = of(basis.range(polynomial, FINE * scale));
    }
    let (reserve, value, bound, place) = found.unwrap_or((f64::INFINITY, 0.0, 0.0, 0.0));
    Nearest {
        is_known: polynomial.radius <= LARGEST_ERROR * scale,
        claim: reserve - OTHER_ERRORS * polynomial.radius / scale - FINE,
        value,
        bound,
        place,
    }
}

/// Bounds on the deviations of a motion from the states of the scenario, and on its jumps, with an allowance for
/// another arithmetic.
pub(super) fn deviations(scenario: &Scenario, motion: &Motion) -> Deviations {
    let file = &scenario.file;
    let claim = |deviations: Vec<Ball>| {
        let magnitudes = deviations.iter().map(Ball::magnitude);
        let largest = magnitudes.fold(0.0, |largest, x| if x <= largest { largest } else { x });
        2.0 * largest + f64::EPSILON
    };
    let at = |segment: usize, x: f64| motion.piece(Part::about_end(segment, x));
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
