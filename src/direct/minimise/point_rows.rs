//! The rows of a waypoint, and of a goal on the final configuration.

use super::place::Place;
use super::rate_rows::RateRows;
use crate::constraint::{AnyConstraint, Constraint, Evaluator, Weights};
use crate::direct::Waypoint;
use crate::error::Result;
use crate::model::Model;
use crate::nlp::Term;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The rows of constraints on the configuration at one time, equalities on single entries of it or of the slope, and
/// rates of equalities, divided by their scales. They follow those of the points of the quadrature.
pub(super) struct PointRows<'g> {
    constraints: &'g [AnyConstraint],
    evaluator: Evaluator<'g>,
    scales: Vec<f64>,
    /// The entries of $(q, q')$ that have given values, after the rows of the constraints.
    given: Vec<(usize, f64)>,
    /// The rates that are zero, after those.
    rates: RateRows<'g>,
    /// The rows that are linear in the configuration, after those: slopes, and the values that are subtracted.
    linear: Vec<(DVector<f64>, f64)>,
    /// The normalised time, if it is neither that of a waypoint nor that of a goal.
    pub time: Option<f64>,
    /// The time in s at which the rows are those of the whole state, if it is one: a later end of the motion is none.
    pub time_s: Option<f64>,
    /// The factor from slopes to velocities: zero where the rows are those at rest.
    rate: f64,
    /// True if the motion ends before the time in s.
    is_idle: bool,
    /// True for each equality.
    pub equalities: Vec<bool>,
    /// The values at the last evaluation.
    pub h: Vec<f64>,
    /// The state of the last evaluation, at rest.
    state: Vec<f64>,
    /// The index of the first row among all.
    pub first: usize,
}

/// The derivatives of weighted rows in $(q, q')$, the configuration and the slope, without the measure.
pub(super) struct PointDerivatives {
    /// The gradient with the slopes of the rows, `2 N` entries.
    pub gradient: DVector<f64>,
    /// The same with the multipliers, for the second derivatives of the curve.
    pub of_multipliers: DVector<f64>,
    /// The Hessian, `2 N` by `2 N`.
    pub hessian: DMatrix<f64>,
}

impl PointDerivatives {
    /// Zeros for `n` joints.
    fn new(n: usize) -> Self {
        Self {
            gradient: DVector::zeros(2 * n),
            of_multipliers: DVector::zeros(2 * n),
            hessian: DMatrix::zeros(2 * n, 2 * n),
        }
    }
}

impl<'g> PointRows<'g> {
    /// The rows of constraints, of given entries and, where a foot lands, of the rates of all equalities; `first` rows
    /// come before.
    fn new(
        model: &'g Model,
        constraints: &'g [AnyConstraint],
        (given, lands): (Vec<(usize, f64)>, bool),
        first: usize,
    ) -> Self {
        let rows = constraints.dim();
        let scales: Vec<_> = constraints.row_scales().into_iter().map(f64::recip).collect();
        let is_equality = |row: &usize| constraints.row_set(*row).is_equality;
        let rates: Vec<_> = (0..rows).filter(|row| lands && is_equality(row)).collect();
        let others = given.len() + rates.len();
        let equalities = (0..rows).map(|row| is_equality(&row));
        let of_rates = rates.iter().map(|row| scales[*row]).collect();
        Self {
            equalities: equalities.chain(std::iter::repeat_n(true, others)).collect(),
            rates: RateRows::new(model, constraints, (rates, of_rates)),
            scales,
            evaluator: Evaluator::new(model),
            h: vec![0.0; rows + others],
            state: vec![0.0; 2 * model.dof()],
            constraints,
            given,
            linear: Vec::new(),
            time: None,
            time_s: None,
            rate: 0.0,
            is_idle: false,
            first,
        }
    }

    /// Linear inequalities of the configuration at a normalised time: their slopes, and the values that are subtracted.
    pub fn of_linear(model: &'g Model, linear: Vec<(DVector<f64>, f64)>, time: f64, first: usize) -> Self {
        let rows = Self::new(model, &[], (Vec::new(), false), first);
        Self { equalities: vec![false; linear.len()], h: vec![0.0; linear.len()], time: Some(time), linear, ..rows }
    }

    /// The rows of the state at a time in s.
    pub fn of_time(model: &'g Model, constraints: &'g [AnyConstraint], time_s: f64, first: usize) -> Self {
        Self { time_s: Some(time_s), ..Self::new(model, constraints, (Vec::new(), false), first) }
    }

    /// The rows of a goal.
    pub fn of_goal(model: &'g Model, goal: &'g [AnyConstraint], first: usize) -> Self {
        Self::new(model, goal, (Vec::new(), false), first)
    }

    /// The rows of a waypoint.
    pub fn of_waypoint(model: &'g Model, waypoint: &'g Waypoint, first: usize) -> Self {
        let n = model.dof();
        let mut given = Vec::new();
        if waypoint.constraints.is_empty() {
            given.extend(waypoint.guess(0).iter().copied().enumerate());
        }
        if waypoint.stop {
            given.extend((n..2 * n).map(|entry| (entry, 0.0)));
        }
        Self::new(model, &waypoint.constraints, (given, waypoint.lands), first)
    }

    /// The indices of the rows among all.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.h.len()
    }

    /// Computes the rows at a place of a curve.
    pub fn evaluate(&mut self, place: &Place) -> Result<()> {
        let n = self.state.len() / 2;
        if let Some(time) = self.time_s {
            (self.rate, self.is_idle) = (1.0 / place.horizon, time >= place.horizon);
        }
        if self.is_idle {
            self.h.fill(-1.0);
            return Ok(());
        }
        self.state[..n].copy_from_slice(place.q.column(0).as_slice());
        self.state[n..].copy_from_slice((place.q.column(1) * self.rate).as_slice());
        let (rows, others) = self.h.split_at_mut(self.scales.len());
        let (given, others) = others.split_at_mut(self.given.len());
        let (rates, linear) = others.split_at_mut(others.len() - self.linear.len());
        if !rows.is_empty() {
            let placed = self.evaluator.at(&self.state)?;
            placed.value(self.constraints, rows)?;
        }
        for (h, scale) in rows.iter_mut().zip(&self.scales) {
            *h *= scale;
        }
        for (h, (entry, value)) in given.iter_mut().zip(&self.given) {
            *h = place.q.as_slice()[*entry] - value;
        }
        for (h, (slope, value)) in linear.iter_mut().zip(&self.linear) {
            *h = slope.dot(&place.q.column(0)) - value;
        }
        self.rates.evaluate(place, rates)
    }

    /// The largest violation, in m or rad, except of rows that are scanned between the points too: linear ones, which
    /// are multiples of these, and those at times in s.
    pub fn violation(&self) -> f64 {
        if self.time_s.is_some() {
            return 0.0;
        }
        let rows = self.h.iter().zip(&self.equalities);
        let rows = rows.take(self.h.len() - self.linear.len());
        let violations = rows.map(|(h, equality)| if *equality { h.abs() } else { *h });
        violations.fold(0.0, f64::max)
    }

    /// The derivatives of the weighted rows at the last evaluation.
    pub fn derivatives(&mut self, terms: impl Iterator<Item = (usize, Term)>) -> Result<PointDerivatives> {
        let (rows, n) = (self.scales.len(), self.state.len() / 2);
        let [mut slopes, mut multipliers, mut curvatures] = [(); 3].map(|()| vec![0.0; rows]);
        let mut out = PointDerivatives::new(n);
        let mut of_rates = Vec::new();
        let first_linear = self.h.len() - self.linear.len();
        for (at, term) in terms {
            let row = at - self.first;
            if self.is_idle {
                continue;
            }
            if let Some(row) = row.checked_sub(first_linear) {
                let slope = &self.linear[row].0;
                out.gradient.rows_mut(0, n).axpy(term.slope, slope, 1.0);
                let mut own = out.hessian.view_mut((0, 0), (n, n));
                own.ger(term.curvature, slope, slope, 1.0);
                continue;
            }
            if let Some(row) = row.checked_sub(rows) {
                match self.given.get(row) {
                    Some((entry, _)) => {
                        out.gradient[*entry] += term.slope;
                        out.of_multipliers[*entry] += term.multiplier;
                        out.hessian[(*entry, *entry)] += term.curvature;
                    }
                    None => of_rates.push((row - self.given.len(), term)),
                }
                continue;
            }
            let scale = self.scales[row];
            slopes[row] = scale * term.slope;
            multipliers[row] = scale * term.multiplier;
            curvatures[row] = scale * scale * term.curvature;
        }
        if rows > 0 && !self.is_idle {
            self.add_constraints([&slopes, &multipliers, &curvatures], &mut out)?;
        }
        self.rates.add(&of_rates, &mut out)?;
        Ok(out)
    }

    /// The gradient of a row in configuration and slope at the last evaluation, given its index among all rows.
    pub fn gradient(&mut self, at: usize) -> Result<DVector<f64>> {
        let (row, n) = (at - self.first, self.state.len() / 2);
        let mut out = PointDerivatives::new(n);
        if let Some(row) = row.checked_sub(self.scales.len()) {
            match self.given.get(row) {
                Some((entry, _)) => out.gradient[*entry] = 1.0,
                None => {
                    let term = Term { slope: 1.0, curvature: 0.0, multiplier: 0.0, cost: 0.0 };
                    self.rates.add(&[(row - self.given.len(), term)], &mut out)?;
                }
            }
            return Ok(out.gradient);
        }
        let mut slopes = vec![0.0; self.scales.len()];
        slopes[row] = self.scales[row];
        let weights = Weights { first_order: &slopes, gauss_newton: None };
        let found = self.evaluator.weighted_derivatives_at(&self.state, (self.constraints, None), weights)?;
        out.gradient.copy_from(&found.gradient().rows(0, 2 * n));
        out.gradient.rows_mut(n, n).scale_mut(self.rate);
        Ok(out.gradient)
    }

    /// Adds the derivatives of the rows of the constraints with these slopes, multipliers and curvatures.
    fn add_constraints(
        &mut self,
        [slopes, multipliers, curvatures]: [&[f64]; 3],
        out: &mut PointDerivatives,
    ) -> Result<()> {
        let (n, factors) = (self.state.len() / 2, [1.0, self.rate]);
        let mut placed = self.evaluator.at(&self.state)?;
        let weights = Weights { first_order: slopes, gauss_newton: None };
        let first = placed.weighted_derivatives(self.constraints, weights)?;
        for (i, factor) in factors.into_iter().enumerate() {
            let own = first.gradient().rows(i * n, n);
            out.gradient.rows_mut(i * n, n).axpy(factor, &own, 1.0);
        }
        let weights = Weights { first_order: multipliers, gauss_newton: Some(curvatures) };
        let both = placed.weighted_derivatives(self.constraints, weights)?;
        for i in 0..2 {
            let own = both.gradient().rows(i * n, n);
            let mut to = out.of_multipliers.rows_mut(i * n, n);
            to.axpy(factors[i], &own, 1.0);
            for j in 0..2 {
                let own = both.hessian().view((i * n, j * n), (n, n));
                let mut to = out.hessian.view_mut((i * n, j * n), (n, n));
                to += own * (factors[i] * factors[j]);
            }
        }
        Ok(())
    }
}
