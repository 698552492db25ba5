//! Any smooth program, dense: an objective of any sign, with bounds of the unknowns and of rows.

use super::iterate;
use super::{
    Bordered, Iterate, Kkt, KktError, Monotone, Nlp, Options, Row, RowState, Scales, SmoothDerivatives, SmoothProgram,
    State, Status, Tightened,
};
use crate::error::{Error, Result};
use crate::linalg::BlockTridiagonal;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The Newton decrement at the last barrier parameter from which on the errors are computed in each iteration.
const NEARLY: f64 = 1e-2;

/// The part of its range, or of its size, by which an unknown is inside its bounds at the start: 1e-2 as in WB (3.6).
const INSIDE: f64 = 1e-2;

/// The last barrier parameter per row relative to the tolerance: a tenth, as in WB (7).
const LAST_BARRIER: f64 = 0.1;

/// The predicted decrease relative to the barrier parameter at which that is reduced: 10 as in WB (3.1).
const SOLVED: f64 = 10.0;

/// The compliance of equalities whose slopes are of the size 1 (of 20 problems of S2MPJ with equalities HS26 takes 602,
/// 313, 86 and 32 iterations with 1e-9 to 1e-6, the others at most as many).
const COMPLIANCE: f64 = 1e-6;

/// The cost of violations that do not decrease, with their penalties, beside an objective of the size 1, at which rows
/// are given up: the objective itself says nothing about them.
const INFEASIBLE_COST: f64 = 1e5;

/// The largest penalty at the start, beyond which multipliers of nearly dependent rows say nothing, and the largest of
/// all, with which a violation of the tolerance 1e-8 costs as much as the objective.
const LARGEST_FIRST_PENALTY: f64 = 1e4;
const LARGEST_PENALTY: f64 = 1e8;

/// The part of its distance from a bound that an unknown or a slack moves at most in a step: 0.99 as in WB (8).
const TO_BOUND: f64 = 0.99;

/// A point with multipliers, which are positive at upper bounds.
#[derive(Clone, Debug)]
pub struct SmoothSolution {
    pub x: DVector<f64>,
    pub objective: f64,
    /// The multipliers of the rows.
    pub multipliers: DVector<f64>,
    /// The multipliers of the bounds of the unknowns.
    pub bound_multipliers: DVector<f64>,
    pub status: Status,
    pub iterations: usize,
    /// The errors of the conditions of Karush, Kuhn and Tucker of the program as it is scaled at the start.
    pub error: KktError,
}

/// Solves a program from `x`, moved inside the bounds of the unknowns. The options are those of a program whose
/// objective has the size 1; barrier parameters are per row. It has converged if and only if the largest
/// [error](KktError) is at most the tolerance. One iteration costs $O(n^3 + m n^2)$.
///
/// # Errors
/// Those of the program; a length, a bound or an option is not acceptable.
pub fn solve_smooth<P: SmoothProgram>(program: &mut P, x: &DVector<f64>, options: &Options) -> Result<SmoothSolution> {
    options.check()?;
    let mut scaled = Scaled::new(program, x)?;
    let x = scaled.inside(x);
    scaled.scales = Scales::at(scaled.program, &x)?;
    let options = scaled.options(&x, options)?;
    let mut norm = BlockTridiagonal::new(&[x.len()], 0);
    norm.diagonal[0].fill_with_identity();
    let kkt = Kkt::new(Bordered::with_border(norm, 0));
    let kkt = kkt.ok_or_else(|| Error::input("nlp", "x", "it has no entries"))?;
    let mut state = State::new(&mut scaled, x, None, kkt, &options)?;
    let mut iterations = 0;
    loop {
        let end = iterate(&mut scaled, &mut state, &options, &mut |_| iterations += 1)?;
        let is_near = state.is_last_barrier(&options) && state.progress.stationarity <= NEARLY;
        if end.is_none() && !is_near {
            continue;
        }
        let found = scaled.solution(&state.x, &state.iterate, iterations)?;
        if found.error.largest() <= options.tolerance {
            return Ok(SmoothSolution { status: Status::Converged, ..found });
        }
        if let Some(status) = end {
            // A small Newton decrement alone is no minimum.
            let status = if status == Status::Converged { Status::NoDescent } else { status };
            return Ok(SmoothSolution { status, ..found });
        }
    }
}

/// A bound of a row or of an unknown: `sign * (value - bound)` is at most zero.
struct OneSided {
    /// The index of the row, or that of the unknown after all rows.
    of: usize,
    sign: f64,
    bound: f64,
    is_equality: bool,
}

/// A program with scaled objective and rows.
struct Scaled<'p, P> {
    program: &'p mut P,
    bounds: Vec<[f64; 2]>,
    rows: Vec<OneSided>,
    scales: Scales,
    g: DVector<f64>,
    derivatives: SmoothDerivatives,
}

impl<'p, P: SmoothProgram> Scaled<'p, P> {
    fn new(program: &'p mut P, x: &DVector<f64>) -> Result<Self> {
        let (bounds, of_rows) = (program.bounds(), program.row_bounds());
        let (n, m) = (bounds.len(), of_rows.len());
        if x.len() != n {
            let condition = format!("it has {} entries, and there are bounds of {n} unknowns", x.len());
            return Err(Error::input("nlp", "x", condition));
        }
        if let Some(k) = x.iter().position(|x| !x.is_finite()) {
            return Err(Error::input("nlp", format!("x[{k}]"), format!("it is {}", x[k])));
        }
        let mut rows = Vec::new();
        for (of, [lower, upper]) in of_rows.iter().chain(&bounds).copied().enumerate() {
            let good = lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
            if !good {
                let (what, k) = if of < m { ("row", of) } else { ("unknown", of - m) };
                let condition = format!("its bounds are {lower} and {upper}");
                return Err(Error::input("nlp", format!("{what} {k}"), condition));
            }
            if lower == upper {
                rows.push(OneSided { of, sign: 1.0, bound: upper, is_equality: true });
                continue;
            }
            let sides = [(-1.0, lower), (1.0, upper)].into_iter().filter(|(_, bound)| bound.is_finite());
            rows.extend(sides.map(|(sign, bound)| OneSided { of, sign, bound, is_equality: false }));
        }
        Ok(Self {
            program,
            bounds,
            rows,
            scales: Scales { objective: 1.0, rows: DVector::from_element(m, 1.0) },
            g: DVector::zeros(m),
            derivatives: SmoothDerivatives::new(n, m),
        })
    }

    /// The nearest point that is well inside the bounds.
    fn inside(&self, x: &DVector<f64>) -> DVector<f64> {
        let inside = |i: usize| {
            let [lower, upper] = self.bounds[i];
            let distance = |bound: f64| (INSIDE * bound.abs().max(1.0)).min(INSIDE * (upper - lower));
            if lower == upper {
                return lower;
            }
            let from = if lower.is_finite() { lower + distance(lower) } else { lower };
            let to = if upper.is_finite() { upper - distance(upper) } else { upper };
            x[i].max(from).min(to)
        };
        DVector::from_fn(x.len(), |i, _| inside(i))
    }

    /// The factor of a row, or of an unknown after all rows.
    fn scale(&self, of: usize) -> f64 {
        self.scales.rows.get(of).copied().unwrap_or(1.0)
    }

    /// The options for these rows, from those per row.
    fn options(&mut self, x: &DVector<f64>, given: &Options) -> Result<Options> {
        let count = self.rows.len().max(1) as f64;
        let penalty = given.penalty.max(given.penalty_of_multipliers * self.largest_multiplier(x)?);
        Ok(Options {
            scale: Some(1.0),
            first_barrier: count * given.first_barrier,
            last_barrier: count * LAST_BARRIER * given.tolerance,
            feasible: given.tolerance,
            // No step is too long without a robot.
            longest_step: f64::INFINITY,
            penalty: penalty.min(LARGEST_FIRST_PENALTY),
            largest_penalty: LARGEST_PENALTY,
            infeasible_cost: INFEASIBLE_COST,
            fraction_to_boundary: TO_BOUND,
            steers: true,
            compliance: COMPLIANCE,
            barrier: Arc::new(Monotone { done: [SOLVED; 2], ..Monotone::default() }),
            ..given.clone()
        })
    }

    /// The largest of the multipliers of the scaled rows for which the gradient of the Lagrangian at the start is least
    /// (WB 3.6).
    fn largest_multiplier(&mut self, x: &DVector<f64>) -> Result<f64> {
        let none = DVector::zeros(self.g.len());
        self.program.value(x, &mut self.g)?;
        self.program.derivatives(x, &none, &mut self.derivatives)?;
        let SmoothDerivatives { gradient, jacobian, .. } = &self.derivatives;
        if jacobian.is_empty() || !jacobian.iter().all(|x| x.is_finite()) {
            return Ok(0.0);
        }
        let mut slopes = jacobian.transpose();
        for (mut slope, scale) in slopes.column_iter_mut().zip(self.scales.rows.iter()) {
            slope *= *scale;
        }
        let found = slopes.svd(true, true).solve(&(gradient * self.scales.objective), 1e-8);
        Ok(found.map_or(0.0, |y| y.amax()))
    }

    /// The multipliers of the rows, then of the unknowns, from those of the one-sided rows.
    fn multipliers(&self, of_rows: impl Iterator<Item = (usize, f64)>) -> DVector<f64> {
        let mut all = DVector::zeros(self.g.len() + self.bounds.len());
        for (at, multiplier) in of_rows {
            let OneSided { of, sign, .. } = self.rows[at];
            all[of] += sign * self.scale(of) * multiplier / self.scales.objective;
        }
        all
    }

    /// The multipliers of the working set after a step of the equations of the first order,
    /// $\min \|r + A^T d\|^2 + \sum_j \delta_j d_j^2$: the condensed equations give them with the relative accuracy of
    /// rounding over the slacks.
    fn refined_multipliers(&mut self, x: &DVector<f64>, iterate: &Iterate) -> Result<Vec<f64>> {
        let (n, m) = (x.len(), self.g.len());
        let working = &iterate.working;
        let known: Vec<_> = working.iter().map(|of| of.multiplier).collect();
        let y = self.multipliers(working.iter().map(|of| (of.row.at, of.multiplier)));
        self.program.value(x, &mut self.g)?;
        self.program.derivatives(x, &y.rows(0, m).into_owned(), &mut self.derivatives)?;
        let mut slopes = DMatrix::zeros(n, working.len());
        for (mut slope, of) in slopes.column_iter_mut().zip(working) {
            let OneSided { of, sign, .. } = self.rows[of.row.at];
            if of < m {
                slope.copy_from(&self.derivatives.jacobian.row(of).transpose());
            } else {
                slope[of - m] = 1.0;
            }
            slope *= self.scale(of) * sign;
        }
        let residual =
            &self.derivatives.gradient * self.scales.objective + &slopes * DVector::from_column_slice(&known);
        // Without dependent slopes the product is positive definite by the slacks alone.
        let mut product = DMatrix::identity(n, n);
        let weight = |of: &RowState| of.distances()[0] / of.slack.max(f64::MIN_POSITIVE);
        for (slope, of) in slopes.column_iter().zip(working) {
            product.ger(weight(of), &slope, &slope, 1.0);
        }
        let Some(factor) = product.cholesky() else {
            return Ok(known);
        };
        let scaled = factor.solve(&residual);
        let changed = known.iter().zip(slopes.column_iter()).zip(working).map(|((z, slope), of)| {
            let z = z - weight(of) * slope.dot(&scaled);
            if of.row.is_equality { z } else { z.max(0.0) }
        });
        Ok(changed.collect())
    }

    fn solution(&mut self, x: &DVector<f64>, iterate: &Iterate, iterations: usize) -> Result<SmoothSolution> {
        let m = self.g.len();
        let refined = self.refined_multipliers(x, iterate)?;
        let known = iterate.working.iter().zip(&refined).map(|(of, multiplier)| (of.row.at, *multiplier));
        let all = self.multipliers(known);
        let (multipliers, of_bounds) = (all.rows(0, m).into_owned(), all.rows(m, x.len()).into_owned());
        let objective = self.program.value(x, &mut self.g)?;
        Ok(SmoothSolution {
            x: x.clone(),
            objective,
            error: KktError::new(self.program, &self.scales, x, [&multipliers, &of_bounds])?,
            multipliers,
            bound_multipliers: of_bounds,
            status: Status::NoDescent,
            iterations,
        })
    }
}

impl<P: SmoothProgram> Nlp for Scaled<'_, P> {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        let f = self.program.value(x, &mut self.g)?;
        let m = self.g.len();
        let value = |of: usize| if of < m { self.g[of] } else { x[of - m] };
        h.clear();
        h.extend(self.rows.iter().map(|row| self.scale(row.of) * row.sign * (value(row.of) - row.bound)));
        let is_finite = f.is_finite() && h.iter().all(|h| h.is_finite());
        Ok(if is_finite { self.scales.objective * f } else { f64::INFINITY })
    }

    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        let mut h = Vec::new();
        self.value(x, &mut h)?;
        let m = self.g.len();
        let terms = iterate.working.iter().map(|of| (of.row.at, iterate.term(of, h[of.row.at])));
        let terms: Vec<_> = terms.collect();
        let y = self.multipliers(terms.iter().map(|(at, term)| (*at, term.multiplier)));
        self.program.derivatives(x, &y.rows(0, m).into_owned(), &mut self.derivatives)?;
        let SmoothDerivatives { gradient, jacobian, hessian } = &self.derivatives;
        let to = &mut out.hessian.matrix.diagonal[0];
        to.copy_from(hessian);
        *to *= self.scales.objective;
        out.gradient.copy_from(gradient);
        out.gradient *= self.scales.objective;
        for (at, term) in terms {
            let OneSided { of, sign, .. } = self.rows[at];
            let factor = self.scale(of) * sign;
            if of < m {
                let slope = jacobian.row(of).transpose();
                out.gradient.axpy(factor * term.slope, &slope, 1.0);
                to.ger(factor * factor * term.curvature, &slope, &slope, 1.0);
            } else {
                out.gradient[of - m] += factor * term.slope;
                to[(of - m, of - m)] += factor * factor * term.curvature;
            }
        }
        Ok(())
    }

    fn measure(&self, _: &DVector<f64>) -> f64 {
        1.0
    }

    fn working_set(&mut self, _: &[f64], rows: &mut Vec<Row>) {
        rows.clear();
        let (m, all) = (self.g.len(), self.rows.iter().enumerate());
        rows.extend(all.map(|(at, row)| match row.is_equality {
            true => Row::equality(at, 1.0),
            false if row.of < m => Row::new(at, 1.0),
            false => Row { stiffness: f64::INFINITY, ..Row::new(at, 1.0) },
        }));
    }

    fn add_row_gradients(
        &mut self,
        _: &DVector<f64>,
        weights: &[(usize, f64)],
        out: &mut DVector<f64>,
    ) -> Result<bool> {
        let m = self.g.len();
        for (at, weight) in weights {
            let OneSided { of, sign, .. } = self.rows[*at];
            let factor = self.scale(of) * sign * weight;
            if of < m {
                out.axpy(factor, &self.derivatives.jacobian.row(of).transpose(), 1.0);
            } else {
                out[of - m] += factor;
            }
        }
        Ok(true)
    }

    /// Unknowns remain inside their bounds.
    fn max_step_fraction(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64 {
        let mut fraction = 1.0_f64;
        for ((x, step), [lower, upper]) in x.iter().zip(step).zip(&self.bounds) {
            let distance = if *step > 0.0 { upper - x } else { x - lower };
            if lower < upper && TO_BOUND * distance < fraction * step.abs() {
                fraction = TO_BOUND * distance / step.abs();
            }
        }
        fraction
    }

    fn tighten(&mut self, x: &DVector<f64>, h: &mut Vec<f64>, _: usize) -> Result<Tightened> {
        self.value(x, h)?;
        let rows = self.rows.iter().zip(h.iter());
        let violations = rows.map(|(row, h)| if row.is_equality { h.abs() } else { *h });
        Ok(Tightened::Violation(violations.fold(0.0, f64::max)))
    }
}
