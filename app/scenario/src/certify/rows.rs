//! Rows: quantities of a motion with their bounds.

use super::TOLERANCE;
use crate::{Promise, Quantity, Scenario, Scope};
use aghf::certify::{Bernstein, Motion, ORDER, Part, Piece, Polynomial, Range};
use aghf::constraint::{AnyConstraint, Constraint, PlacedState, RowSet};
use aghf::dynamics::{Data, forward_kinematics};
use aghf::error::Result;
use aghf::model::Model;
use aghf::scalar::{TaylorModel, Zero};
use aghf::spatial::Placement;

/// The relative reserve below which a bound is computed accurately, and the two accuracies.
const NEAR: f64 = 0.05;
const COARSE: f64 = 0.02;
const FINE: f64 = 1e-10;

/// The multiple of the bound on the errors by which a claim allows for the arithmetic of another checker.
pub(super) const OTHER_ERRORS: f64 = 3.0;

/// The largest error, relative to the scale of a row, with which claims are made.
const MAX_ERROR: f64 = 1e-3;

/// The largest deviation of a row that is zero, in its unit. Of two rows across a direction both are small enough for
/// the 1e-6 by which the checkers bound the sine of the angle from it.
pub(super) const EQUALITY: f64 = 0.7e-6;

/// A quantity with its bounds.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) promise: Quantity,
    /// The joint, the frame or the foot.
    pub(super) place: String,
    /// The bounds; infinite without one.
    pub(super) bounds: [f64; 2],
    /// The unit of reserves.
    pub(super) scale: f64,
    /// The times between which it is kept, s.
    pub(super) times: [f64; 2],
}

impl Row {
    /// A row of scale one that is kept throughout.
    pub(super) fn new(promise: Quantity, place: String, bounds: [f64; 2]) -> Self {
        Self { promise, place, bounds, scale: 1.0, times: [f64::NEG_INFINITY, f64::INFINITY] }
    }

    /// True if it is kept at some time of a part.
    pub(super) fn is_kept(&self, motion: &Motion, part: Part) -> bool {
        let [from, to] = [-1.0, 1.0].map(|s| motion.time(part, s));
        from < self.times[1] && to > self.times[0]
    }
}

/// The limits of joints that are proved: without the zero torques of passive joints.
fn limits(scenario: &Scenario) -> Vec<(usize, Promise)> {
    let all = scenario.limits().into_iter().filter(|limit| limit.quantity != Quantity::Passive);
    all.filter_map(|limit| Some((limit.index?, limit))).collect()
}

/// The rows of constraints on the state, an equality to within [`EQUALITY`].
pub(super) fn rows_of(promise: Quantity, constraints: &[AnyConstraint], model: &Model) -> Vec<Row> {
    let row = |i: usize| {
        let RowSet { scale, is_equality, .. } = constraints.row_set(i);
        let bounds = if is_equality { [-EQUALITY * scale, EQUALITY * scale] } else { [f64::NEG_INFINITY, 0.0] };
        Row { scale, ..Row::new(promise, constraints.label(i, model).name, bounds) }
    };
    (0..constraints.dim()).map(row).collect()
}

/// Encloses the rows of constraints in states $(q, v)$.
pub(super) fn values_of<const N: usize>(
    constraints: &[AnyConstraint],
    model: &Model,
    [q, v]: [Vec<TaylorModel<N>>; 2],
) -> Result<Vec<Polynomial>> {
    let mut placements = vec![Placement::identity(); q.len()];
    forward_kinematics(model, &q, &mut placements)?;
    let at = PlacedState { model, x: &[q, v].concat(), placements: &placements, active_pairs: None };
    let mut values = vec![TaylorModel::zero(); constraints.dim()];
    constraints.value(&at, &mut values)?;
    Ok(values.into_iter().map(Polynomial::from).collect())
}

/// The value of a row that is nearest to a bound, or beyond one.
pub(super) struct Nearest {
    /// The bound on the error of the values, relative to the scale of the row.
    error: f64,
    /// The proved reserve relative to that scale, less the allowance for another arithmetic.
    pub(super) claim: f64,
    /// True if the error is small enough for a claim.
    pub(super) is_known: bool,
    /// A value that is taken, rounded outward, the bound that it is nearest to, and its place.
    pub(super) value: f64,
    pub(super) bound: f64,
    pub(super) place: f64,
}

impl Nearest {
    /// The same for positions in a tube about a motion on which it is `alone`: the tube is no error.
    pub(super) fn in_tube(self, alone: &Self) -> Self {
        Self { is_known: alone.is_known, claim: self.claim + OTHER_ERRORS * (self.error - alone.error), ..self }
    }

    /// The value that is not excluded, if the claim is not accepted.
    pub(super) fn not_excluded(&self, row: &Row) -> f64 {
        if self.bound == row.bounds[1] {
            self.bound - self.claim * row.scale
        } else {
            self.bound + self.claim * row.scale
        }
    }

    /// True if the claim is proved and accepted.
    pub(super) fn holds(&self) -> bool {
        self.claim >= -TOLERANCE && self.is_known
    }

    /// True if the value exceeds the bound by more than is accepted.
    pub(super) fn is_beyond(&self, row: &Row) -> bool {
        let beyond = (self.value - self.bound).abs();
        let out = if self.bound == row.bounds[1] { self.value > self.bound } else { self.value < self.bound };
        out && beyond > TOLERANCE * row.scale
    }
}

/// All rows of a scenario that are kept along the way, with the bases and the scratch for their bounds.
pub(super) struct Rows<'a> {
    scenario: &'a Scenario,
    limits: Vec<(usize, Promise)>,
    kept: Vec<AnyConstraint>,
    pub(super) all: Vec<Row>,
    of_motion: Bernstein,
    of_models: Bernstein,
    data: Data<TaylorModel<ORDER>>,
}

impl<'a> Rows<'a> {
    pub(super) fn new(scenario: &'a Scenario, motion: &Motion) -> Result<Self> {
        let (model, limits) = (&scenario.model, limits(scenario));
        let limit_row = |(joint, limit): &(usize, Promise)| {
            let place = format!("joint '{}'", model.joints()[*joint].name());
            let largest = limit.bounds.into_iter().filter(|bound| bound.is_finite()).map(f64::abs).fold(0.0, f64::max);
            let scale = if largest > 0.0 { largest } else { 1.0 };
            let row = Row { scale, ..Row::new(limit.quantity, place, limit.bounds) };
            if let Scope::Between(times) = limit.scope { Row { times, ..row } } else { row }
        };
        let mut all: Vec<Row> = limits.iter().map(limit_row).collect();
        let mut kept = Vec::new();
        for (i, condition) in scenario.file.keep.iter().enumerate() {
            let rows = condition.rows(model, &format!("keep[{i}]"), &scenario.name)?;
            let times = condition.times();
            let own = rows_of(Quantity::Frame, &rows, model).into_iter();
            all.extend(own.map(|row| Row { times, ..row }));
            kept.extend(rows);
        }
        if let Some(foot) = scenario.foot() {
            let row = |i| {
                let (place, bounds) = (foot.label(i).name, [f64::NEG_INFINITY, 0.0]);
                Row::new(Quantity::Foot, place, bounds)
            };
            all.extend((0..foot.dim()).map(row));
        }
        Ok(Self {
            scenario,
            limits,
            kept,
            all,
            of_motion: Bernstein::new(motion.degree()),
            of_models: Bernstein::new(ORDER - 1),
            data: Data::new(model),
        })
    }

    /// The nearest values of all rows on a piece.
    pub(super) fn nearest(&mut self, piece: &Piece) -> Result<Vec<Nearest>> {
        let model = &self.scenario.model;
        let [q, v, a] = piece.models();
        let mut torques = Vec::new();
        if self.limits.iter().any(|(_, limit)| limit.quantity.order().is_none()) {
            torques = piece.torques(model, &mut self.data)?;
        }
        let derivatives = [&piece.q, &piece.v, &piece.a, &piece.jerk];
        let value = |(joint, limit): &(usize, Promise)| match limit.quantity.order() {
            Some(order) => derivatives[order][*joint].clone(),
            None if limit.quantity == Quantity::Power => Polynomial::from(torques[*joint] * v[*joint]),
            None => Polynomial::from(torques[*joint]),
        };
        let mut values: Vec<Polynomial> = self.limits.iter().map(value).collect();
        if !self.kept.is_empty() {
            values.extend(values_of(&self.kept, model, [q.clone(), v.clone()])?);
        }
        if let Some(foot) = self.scenario.foot() {
            let mut g = vec![TaylorModel::zero(); foot.dim()];
            foot.value(model, &mut self.data, [&q, &v, &a], &mut g)?;
            values.extend(g.into_iter().map(Polynomial::from));
        }
        let rows = self.all.iter().zip(&values);
        Ok(rows.map(|(row, value)| self.nearest_of(row, value)).collect())
    }

    /// The nearest value of a row whose values are those of a polynomial.
    pub(super) fn nearest_of(&self, row: &Row, polynomial: &Polynomial) -> Nearest {
        let basis = if polynomial.coefficients.len() <= ORDER { &self.of_models } else { &self.of_motion };
        let (scale, [least, most]) = (row.scale, row.bounds);
        let of = |range: Range| {
            let below = ((range.lower - least) / scale, range.least_at_most, least, range.places[0]);
            let above = ((most - range.upper) / scale, range.most_at_least, most, range.places[1]);
            // A reserve of NaN is none.
            if below.0 <= above.0 || below.0.is_nan() { below } else { above }
        };
        let mut found = of(basis.range(polynomial, COARSE * scale));
        if found.0 < NEAR {
            found = of(basis.range(polynomial, FINE * scale));
        }
        let (reserve, value, bound, place) = found;
        let error = polynomial.radius / scale;
        Nearest {
            is_known: polynomial.radius <= MAX_ERROR * scale,
            error,
            claim: reserve - OTHER_ERRORS * error - FINE,
            value,
            bound,
            place,
        }
    }
}
