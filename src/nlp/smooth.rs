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

/// The cost of violations that do not decrease, with their penalties and relative to an objective of the size 1, at
/// which rows are given up: the objective itself says nothing about them.
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

/// Solves a program from `x`, moved inside the bounds of the unknowns. It has converged if and only if the largest
/// [error](KktError) is at most the tolerance. One iteration costs $O(n^3 + m n^2)$.
///
/// Of the options those are replaced that depend on the size of the objective or are tuned for motions: the scale, the
/// last barrier parameter and its update (the first one is per row), the tolerance of rows, the longest step, the part
/// up to the boundary, and the rules for penalties but the first one.
///
/// # Errors
/// Those of the program; a length, a bound or an option is not acceptable.
pub fn solve_smooth<P: SmoothProgram>(program: &mut P, x: &DVector<f64>, options: &Options) -> Result<SmoothSolution> {
    options.check()?;
    let mut scaled = Scaled::new(program, x)?;
    let x = scaled.inside(x);
    scaled.set_scales(&x)?;
    let options = scaled.options(options);
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
    source: usize,
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
        let (bounds, row_bounds) = (program.bounds(), program.row_bounds());
        let (n, m) = (bounds.len(), row_bounds.len());
        if x.len() != n {
            let condition = format!("it has {} entries, and there are bounds of {n} unknowns", x.len());
            return Err(Error::input("nlp", "x", condition));
        }
        if let Some(k) = x.iter().position(|x| !x.is_finite()) {
            return Err(Error::input("nlp", format!("x[{k}]"), format!("it is {}", x[k])));
        }
        let mut rows = Vec::new();
        for (source, [lower, upper]) in row_bounds.iter().chain(&bounds).copied().enumerate() {
            let good = lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
            if !good {
                let (what, k) = if source < m { ("row", source) } else { ("unknown", source - m) };
                let condition = format!("its bounds are {lower} and {upper}");
                return Err(Error::input("nlp", format!("{what} {k}"), condition));
            }
            if lower == upper {
                rows.push(OneSided { source, sign: 1.0, bound: upper, is_equality: true });
                continue;
            }
            let sides = [(-1.0, lower), (1.0, upper)].into_iter().filter(|(_, bound)| bound.is_finite());
            rows.extend(sides.map(|(sign, bound)| OneSided { source, sign, bound, is_equality: false }));
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

    /// Sets the scales by the derivatives at the start.
    fn set_scales(&mut self, x: &DVector<f64>) -> Result<()> {
        self.program.derivatives(x, &DVector::zeros(self.g.len()), &mut self.derivatives)?;
        self.scales = Scales::new(&self.derivatives);
        Ok(())
    }

    /// The options for these rows, from those per row.
    fn options(&self, given: &Options) -> Options {
        let count = self.rows.len().max(1) as f64;
        let penalty = given.penalty.max(given.penalty_of_multipliers * self.largest_multiplier());
        Options {
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
            barrier: Arc::new(Monotone { done: [SOLVED; 2], ..Monotone::default() }),
            ..given.clone()
        }
    }

    /// The largest of the multipliers of the scaled rows for which the gradient of the Lagrangian at the start is least
    /// (WB 3.6).
    fn largest_multiplier(&self) -> f64 {
        let SmoothDerivatives { gradient, jacobian, .. } = &self.derivatives;
        if jacobian.is_empty() || !jacobian.iter().all(|x| x.is_finite()) {
            return 0.0;
        }
        let mut slopes = jacobian.transpose();
        for (mut slope, scale) in slopes.column_iter_mut().zip(&self.scales.rows) {
            slope *= *scale;
        }
        let found = slopes.svd(true, true).solve(&(gradient * self.scales.objective), 1e-8);
        found.map_or(0.0, |y| y.amax())
    }

    /// The factor of the value of a one-sided row.
    fn factor(&self, row: &OneSided) -> f64 {
        row.sign * self.scales.rows.get(row.source).copied().unwrap_or(1.0)
    }

    /// The gradient of a one-sided row by the last derivatives.
    fn slope(&self, at: usize) -> DVector<f64> {
        let (row, m) = (&self.rows[at], self.g.len());
        let mut slope = DVector::zeros(self.bounds.len());
        if row.source < m {
            slope.copy_from(&self.derivatives.jacobian.row(row.source).transpose());
        } else {
            slope[row.source - m] = 1.0;
        }
        slope * self.factor(row)
    }

    /// A one-sided row as one of the interior-point method.
    fn row(&self, at: usize) -> Row {
        let OneSided { source, is_equality, .. } = self.rows[at];
        Row { is_equality, is_hard: !is_equality && source >= self.g.len(), ..Row::new(at, 1.0) }
    }

    /// The multipliers of the rows, then of the unknowns, from those of the one-sided rows.
    fn multipliers(&self, one_sided: impl Iterator<Item = (usize, f64)>) -> [DVector<f64>; 2] {
        let mut all = [DVector::zeros(self.g.len()), DVector::zeros(self.bounds.len())];
        for (at, multiplier) in one_sided {
            let (row, m) = (&self.rows[at], self.g.len());
            let of_row = if row.source < m { &mut all[0][row.source] } else { &mut all[1][row.source - m] };
            *of_row += self.factor(row) * multiplier / self.scales.objective;
        }
        all
    }

    /// The multipliers of the working set after a step of the equations of the first order,
    /// $\min_d (r + A^T d)^T (r + A^T d) + \sum_j \delta_j d_j^2$: the condensed equations give them with the relative
    /// accuracy of rounding over the slacks.
    fn refined_multipliers(&mut self, x: &DVector<f64>, iterate: &Iterate) -> Result<Vec<f64>> {
        let (n, working) = (x.len(), &iterate.working);
        let known: Vec<_> = working.iter().map(|state| state.multiplier).collect();
        let [y, _] = self.multipliers(working.iter().map(|state| (state.row.at, state.multiplier)));
        self.program.derivatives(x, &y, &mut self.derivatives)?;
        let slopes: Vec<_> = working.iter().map(|state| self.slope(state.row.at)).collect();
        let mut residual = &self.derivatives.gradient * self.scales.objective;
        let mut product = DMatrix::identity(n, n);
        let weight = |state: &RowState| state.distances()[0] / state.slack.max(f64::MIN_POSITIVE);
        for (slope, state) in slopes.iter().zip(working) {
            residual.axpy(state.multiplier, slope, 1.0);
            product.ger(weight(state), slope, slope, 1.0);
        }
        // Positive definite but for numbers that are not finite.
        let Some(factor) = product.cholesky() else {
            return Ok(known);
        };
        let scaled = factor.solve(&residual);
        let changed = slopes.iter().zip(working).map(|(slope, state)| {
            let multiplier = state.multiplier - weight(state) * slope.dot(&scaled);
            if state.row.is_equality { multiplier } else { multiplier.max(0.0) }
        });
        Ok(changed.collect())
    }

    /// The solution at the last evaluated point.
    fn solution(&mut self, x: &DVector<f64>, iterate: &Iterate, iterations: usize) -> Result<SmoothSolution> {
        let refined = self.refined_multipliers(x, iterate)?;
        let known = iterate.working.iter().zip(&refined).map(|(state, multiplier)| (state.row.at, *multiplier));
        let [multipliers, bound_multipliers] = self.multipliers(known);
        Ok(SmoothSolution {
            x: x.clone(),
            objective: self.program.value(x, &mut self.g)?,
            error: KktError::new(self.program, &self.scales, x, [&multipliers, &bound_multipliers])?,
            multipliers,
            bound_multipliers,
            status: Status::NoDescent,
            iterations,
        })
    }

    /// Puts the values of the one-sided rows at `x`, the last evaluated point, into `h`.
    fn put_rows(&self, x: &DVector<f64>, h: &mut Vec<f64>) {
        let value = |source: usize| self.g.get(source).copied().unwrap_or_else(|| x[source - self.g.len()]);
        h.clear();
        h.extend(self.rows.iter().map(|row| self.factor(row) * (value(row.source) - row.bound)));
    }
}

impl<P: SmoothProgram> Nlp for Scaled<'_, P> {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        let f = self.program.value(x, &mut self.g)?;
        self.put_rows(x, h);
        let is_finite = f.is_finite() && h.iter().all(|h| h.is_finite());
        Ok(if is_finite { self.scales.objective * f } else { f64::INFINITY })
    }

    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        let mut h = Vec::new();
        self.put_rows(x, &mut h);
        let terms = iterate.working.iter().map(|state| (state.row.at, iterate.term(state, h[state.row.at])));
        let terms: Vec<_> = terms.collect();
        let [y, _] = self.multipliers(terms.iter().map(|(at, term)| (*at, term.multiplier)));
        self.program.derivatives(x, &y, &mut self.derivatives)?;
        out.gradient.copy_from(&self.derivatives.gradient);
        out.gradient *= self.scales.objective;
        let hessian = &mut out.hessian.matrix.diagonal[0];
        hessian.copy_from(&self.derivatives.hessian);
        *hessian *= self.scales.objective;
        for (at, term) in terms {
            let slope = self.slope(at);
            out.gradient.axpy(term.slope, &slope, 1.0);
            if self.rows[at].source < self.g.len() {
                hessian.ger(term.curvature, &slope, &slope, 1.0);
            } else {
                let i = self.rows[at].source - self.g.len();
                hessian[(i, i)] += term.curvature * slope[i] * slope[i];
            }
        }
        Ok(())
    }

    fn measure(&self, _: &DVector<f64>) -> f64 {
        1.0
    }

    fn working_set(&mut self, _: &[f64], rows: &mut Vec<Row>) {
        rows.clear();
        rows.extend((0..self.rows.len()).map(|at| self.row(at)));
    }

    const HAS_ROW_GRADIENTS: bool = true;

    fn add_row_gradients(&self, weights: &[(usize, f64)], out: &mut DVector<f64>) {
        for (at, weight) in weights {
            out.axpy(*weight, &self.slope(*at), 1.0);
        }
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
        let violations = h.iter().enumerate().map(|(at, h)| self.row(at).violation(*h));
        Ok(Tightened::Violation(violations.fold(0.0, f64::max)))
    }
}
