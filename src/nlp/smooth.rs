//! Any smooth program, dense: an objective of any sign, with bounds of the unknowns and of rows.

use super::iterate;
use super::scaled::{Scaled, TO_BOUND};
use super::{
    Bordered, Iterate, Kkt, KktError, Monotone, Nlp, Options, RowState, Scales, SmoothDerivatives, SmoothProgram,
    State, Status,
};
use crate::error::{Error, Result};
use crate::linalg::BlockTridiagonal;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The Newton decrement at the last barrier parameter from which on the errors are computed in each iteration.
const NEARLY: f64 = 1e-2;

/// The last barrier parameter per row relative to the tolerance: a tenth, as in WB (7).
const LAST_BARRIER: f64 = 0.1;

/// The error of the barrier problem relative to the barrier parameter at which that is reduced: with 10 as in WB (3.1),
/// where each row has an error of its own, motions with contacts take up to twice as many iterations.
const SOLVED: f64 = 1.0;

/// The cost of violations that do not decrease, with their penalties and relative to an objective of the size 1, at
/// which rows are given up: the objective itself says nothing about them.
const INFEASIBLE_COST: f64 = 1e5;

/// The largest penalty at the start, beyond which multipliers of nearly dependent rows say nothing, and the largest of
/// all, with which a violation of the tolerance 1e-8 costs as much as the objective.
const LARGEST_FIRST_PENALTY: f64 = 1e4;
const LARGEST_PENALTY: f64 = 1e8;

/// The number of iterations after which equations whose violation has not decreased to this part are given up: linear
/// ones hardly decrease where their gradients are nearly dependent.
const MAX_WAIT: usize = 30;
const DECREASED: f64 = 0.9;

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
    let found = scaled.solve(x.clone(), &options)?;
    let left = options.iterations.saturating_sub(found.iterations);
    if found.status == Status::Converged || left == 0 || !scaled.has_filter() {
        return Ok(found);
    }
    // With elastic variables there is always a step, and rows that cannot be kept show.
    scaled.is_elastic = true;
    let elastic = scaled.solve(x, &Options { iterations: left, ..options })?;
    Ok(SmoothSolution { iterations: found.iterations + elastic.iterations, ..elastic })
}

impl<P: SmoothProgram> Scaled<'_, P> {
    /// Solves the program from `x`, with elastic variables or without.
    fn solve(&mut self, x: DVector<f64>, options: &Options) -> Result<SmoothSolution> {
        let mut norm = BlockTridiagonal::new(&[x.len()], 0);
        norm.diagonal[0].fill_with_identity();
        let kkt = Kkt::new(Bordered::with_border(norm, 0));
        let kkt = kkt.ok_or_else(|| Error::input("nlp", "x", "it has no entries"))?;
        let mut state = State::new(self, x, None, kkt, options)?;
        let mut iterations = 0;
        // The least violation, and the iteration at which it last decreased.
        let mut best = (f64::INFINITY, 0);
        loop {
            let mut end = iterate(self, &mut state, options, &mut |_| iterations += 1)?;
            let violation = state.iterate.violation(&state.h);
            if violation < DECREASED * best.0 || violation <= options.tolerance {
                best = (violation, iterations);
            }
            if iterations > best.1 + MAX_WAIT {
                end = end.or(Some(Status::NoDescent));
            }
            let is_near = state.is_last_barrier(options) && state.progress.stationarity <= NEARLY;
            if end.is_none() && !is_near {
                continue;
            }
            let found = self.solution(&state.x, &state.iterate, iterations)?;
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

    /// The multipliers of all one-sided rows, with those of the working set after a step of the equations of the first
    /// order, $\min_d (r + A^T d)^T (r + A^T d) + \sum_j \delta_j d_j^2$: the condensed equations give them with the
    /// relative accuracy of rounding over the slacks.
    fn refined_multipliers(&mut self, x: &DVector<f64>, iterate: &Iterate) -> Result<Vec<f64>> {
        let (n, working) = (x.len(), &iterate.working);
        let mut all = iterate.multipliers(self.rows.len());
        let [y, _] = self.multipliers(all.iter().copied().enumerate());
        self.program.derivatives(x, &y, &mut self.derivatives)?;
        let slopes: Vec<_> = working.iter().map(|state| self.slope(state.row.at)).collect();
        let mut residual = &self.derivatives.gradient * self.scales.objective;
        let mut product = DMatrix::identity(n, n);
        let weight = |state: &RowState| state.distances()[0] / state.slack.max(f64::MIN_POSITIVE);
        for (at, multiplier) in all.iter().enumerate() {
            residual.axpy(*multiplier, &self.slope(at), 1.0);
        }
        for (slope, state) in slopes.iter().zip(working) {
            product.ger(weight(state), slope, slope, 1.0);
        }
        // Positive definite but for numbers that are not finite.
        let Some(factor) = product.cholesky() else {
            return Ok(all);
        };
        let scaled = factor.solve(&residual);
        for (slope, state) in slopes.iter().zip(working) {
            let multiplier = state.multiplier - weight(state) * slope.dot(&scaled);
            all[state.row.at] = if state.row.is_equality { multiplier } else { multiplier.max(0.0) };
        }
        Ok(all)
    }

    /// The solution at the last evaluated point.
    fn solution(&mut self, x: &DVector<f64>, iterate: &Iterate, iterations: usize) -> Result<SmoothSolution> {
        let refined = self.refined_multipliers(x, iterate)?;
        let [multipliers, bound_multipliers] = self.multipliers(refined.into_iter().enumerate());
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
}
