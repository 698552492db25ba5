//! Slacks, elastic variables and multipliers of the rows.

use super::{Barrier, Equality, Options, Row, RowState, RowStep, Term};

/// The part of a violation that is left after a step that hardly decreases it.
const HARDLY: f64 = 0.9;

/// The rows of the working set and the equalities of the saddle-point equations, with their multipliers.
#[derive(Debug)]
pub struct Iterate {
    /// The rows of the working set, by their indices.
    pub working: Vec<RowState>,
    /// Memory for the next working set.
    spare: Vec<RowState>,
    pub equalities: Vec<Equality>,
    pub barrier: Barrier,
    /// True if a [filter](super::Nlp::has_filter) accepts steps.
    pub has_filter: bool,
    /// The least change of a row per change of its multiplier in the condensed equations.
    pub compliance: f64,
    /// The factor, from 0 to 1, of the second derivatives of [curved](Row::is_curved) inequalities in the Hessian.
    pub curvature_weight: f64,
    /// The number of successive steps with a multiple of the norm and without any of these derivatives.
    without_curvature: usize,
    /// True if the terms of inequalities are those of the Lagrangian, and not those of the barrier function.
    pub is_lagrangian: bool,
}

impl Default for Iterate {
    fn default() -> Self {
        Self::new(Barrier::default(), Vec::new())
    }
}

// By hand, so that the memory of the copy is kept.
impl Clone for Iterate {
    fn clone(&self) -> Self {
        let mut clone = Self::new(self.barrier, Vec::new());
        clone.clone_from(self);
        clone
    }

    fn clone_from(&mut self, from: &Self) {
        self.working.clone_from(&from.working);
        self.equalities.clone_from(&from.equalities);
        (self.barrier, self.compliance) = (from.barrier, from.compliance);
        self.has_filter = from.has_filter;
        (self.curvature_weight, self.without_curvature) = (from.curvature_weight, from.without_curvature);
        self.is_lagrangian = from.is_lagrangian;
    }
}

impl Iterate {
    pub fn new(barrier: Barrier, equalities: Vec<Equality>) -> Self {
        Self {
            working: Vec::new(),
            spare: Vec::new(),
            equalities,
            barrier,
            has_filter: false,
            compliance: 0.0,
            curvature_weight: 1.0,
            without_curvature: 0,
            is_lagrangian: false,
        }
    }

    /// The multipliers by the indices of their rows, up to `count`; zero for those outside the working set.
    #[must_use]
    pub fn multipliers(&self, count: usize) -> Vec<f64> {
        let mut all = Vec::new();
        self.multipliers_in(count, &mut all);
        all
    }

    /// Computes [`multipliers`](Self::multipliers) into `all`.
    pub(crate) fn multipliers_in(&self, count: usize, all: &mut Vec<f64>) {
        all.clear();
        all.resize(count, 0.0);
        for of in &self.working {
            all[of.row.at] = of.multiplier;
        }
        for of in &self.equalities {
            all[of.row.at] = of.multiplier;
        }
    }

    /// Allocates memory for a number of rows.
    pub(crate) fn allocate(&mut self, rows: usize) {
        self.working.reserve(rows);
        self.spare.reserve(rows);
    }

    /// Returns true if the multiplier of a row that is violated by more than `feasible` has nearly reached the penalty.
    pub fn is_at_penalty(&self, h: &[f64], feasible: f64) -> bool {
        let mut rows = self.working.iter();
        rows.any(|of| of.needs_penalty(h, feasible))
    }

    /// Raises the penalties of violated rows whose multipliers have nearly reached them, at most to `largest`; returns
    /// true if one is raised.
    pub fn raise_penalties(&mut self, h: &[f64], options: &Options, largest: f64) -> bool {
        let (mu, mut raised) = (self.barrier.mu, false);
        for state in &mut self.working {
            if state.needs_penalty(h, options.feasible) && state.penalty < largest {
                state.penalty = (options.row_penalty_factor * state.penalty).min(largest);
                state.safeguard(mu, options.multiplier_range);
                raised = true;
            }
        }
        raised
    }

    /// Raises the penalties of violated rows whose multipliers have nearly reached them and whose violation has hardly
    /// decreased in a step, at most to `largest`; returns true if one is raised (Byrd, Nocedal and Waltz, *Steering
    /// exact penalty methods for nonlinear programming*, 2008, by the step that was taken).
    pub fn steer(&mut self, before: &[f64], h: &[f64], options: &Options, largest: f64) -> bool {
        let mut raised = false;
        for state in &mut self.working {
            let [old, new] = [before, h].map(|h| state.row.violation(h[state.row.at]));
            if new > HARDLY * old && state.needs_penalty(h, options.feasible) && state.penalty < largest {
                state.penalty = (options.row_penalty_factor * state.penalty).min(largest);
                raised = true;
            }
        }
        raised
    }

    /// Replaces the working set by rows in ascending order. Those that were in it keep their state; new ones have the
    /// slack of their value and the multiplier of that.
    pub fn set_working(&mut self, working: &[Row], h: &[f64]) {
        let mut states = std::mem::take(&mut self.spare);
        states.clear();
        let mut before = self.working.iter().copied().peekable();
        states.extend(working.iter().map(|row| {
            while before.next_if(|known| known.row.at < row.at).is_some() {}
            match before.next_if(|known| known.row.at == row.at) {
                Some(known) => RowState { row: *row, ..known },
                None => self.barrier.central(*row, h[row.at], self.barrier.nu),
            }
        }));
        self.spare = std::mem::replace(&mut self.working, states);
    }

    /// Begins without rows but for these equalities.
    pub(crate) fn restart(&mut self, barrier: Barrier, equalities: Vec<Equality>) {
        self.working.clear();
        (self.equalities, self.barrier) = (equalities, barrier);
        self.curvature_weight = 1.0;
    }

    /// Uses known multipliers $\lambda$ of the first rows, except those that are zero. An inequality whose slack is
    /// smaller than the one that belongs to its multiplier and the barrier parameter moves away from its bound, at most
    /// to the [largest warm slack](Options::largest_warm_slack), and its penalty is raised to its
    /// [multiple](Options::row_penalty_of_multipliers) of the multiplier.
    pub fn set_multipliers(&mut self, known: &[f64], h: &[f64], options: &Options) {
        let (barrier, mu) = (self.barrier, self.barrier.mu);
        for state in &mut self.working {
            let at = state.row.at;
            let Some(z) = known.get(at).filter(|known| **known != 0.0) else {
                continue;
            };
            state.penalty = state.penalty.max(options.row_penalty_of_multipliers * z.abs());
            if state.row.is_equality || state.row.is_hard {
                *state = barrier.central(state.row, h[at], state.penalty);
            } else {
                let slack = (mu / z).min(options.largest_warm_slack);
                if slack > state.slack {
                    state.slack = slack;
                    state.elastic = h[at] + slack;
                }
            }
            state.multiplier = *z;
            state.safeguard(mu, options.multiplier_range);
        }
        for equality in &mut self.equalities {
            equality.multiplier = known.get(equality.row.at).copied().unwrap_or(0.0);
        }
    }

    /// Replaces slacks and elastic variables by the best ones for these values of the rows.
    pub fn recentre(&mut self, h: &[f64], barrier: Barrier) {
        self.barrier = barrier;
        for k in 0..self.working.len() {
            let RowState { row, penalty, .. } = self.working[k];
            self.working[k] = barrier.central(row, h[row.at], penalty);
        }
    }

    /// Changes the barrier; no penalty falls.
    pub fn set_barrier(&mut self, barrier: Barrier, range: f64) {
        self.barrier = barrier;
        for state in &mut self.working {
            state.penalty = state.penalty.max(barrier.nu);
        }
        self.safeguard_all(range);
    }

    /// Makes the constraints $h + s = t$ hold for other values of the rows.
    pub fn reset(&mut self, h: &[f64], range: f64) {
        let mu = self.barrier.mu;
        for state in &mut self.working {
            let h = h[state.row.at];
            if state.row.is_hard {
                state.meet(h);
            } else if h < 0.0 {
                state.slack = state.elastic - h;
            } else {
                state.elastic = state.slack + h;
            }
            state.safeguard(mu, range);
        }
    }

    /// Moves each multiplier to the value that the condensed equations predict for the value of its row: then the
    /// gradient of the Lagrangian is that of these equations.
    pub fn update_multipliers(&mut self, h: &[f64], range: f64) {
        let mu = self.barrier.mu;
        for k in 0..self.working.len() {
            let state = &self.working[k];
            let slope = self.term(state, h[state.row.at]).slope;
            self.working[k].multiplier = slope.clamp(state.least(), state.penalty);
            self.working[k].safeguard(mu, range);
        }
    }

    /// The sum of the products of slacks and multipliers, without the measure.
    pub fn gap(&self) -> f64 {
        let product = |of: &RowState| of.row.weight * of.slack * of.distances()[0];
        self.working.iter().map(product).sum()
    }

    /// Adapts the [weight](Self::curvature_weight) of second derivatives after a step with a multiple of the norm, or
    /// without one; it is one without curved rows.
    pub fn adapt_curvature_weight(&mut self, is_regularised: bool, options: &Options) {
        if !self.working.iter().any(|of| of.row.is_curved) {
            self.curvature_weight = 1.0;
            return;
        }
        let ([less, more], least) = (options.curvature_factors, options.min_curvature_weight);
        let is_without = is_regularised && self.curvature_weight == 0.0;
        self.without_curvature = usize::from(is_without) * (self.without_curvature + 1);
        self.curvature_weight = match is_regularised {
            true if self.without_curvature >= options.max_steps_without_curvature => 1.0,
            true if self.curvature_weight > least => less * self.curvature_weight,
            true => 0.0,
            false => (more * self.curvature_weight).clamp(least, 1.0),
        };
    }

    /// The terms of a row of this value.
    pub fn term(&self, state: &RowState, h: f64) -> Term {
        let (mu, z, [below, above]) = (self.barrier.mu, state.multiplier, state.distances());
        let curvature = self.curvature(state);
        let multiplier = if state.row.is_curved { self.curvature_weight * z } else { z };
        if self.is_lagrangian {
            return Term { slope: z, curvature, multiplier, cost: 0.0 };
        }
        Term {
            slope: z + curvature * (h + mu / below - mu / above),
            curvature,
            multiplier,
            cost: state.barrier_term(mu),
        }
    }

    /// The weight of the product of the gradient of a row with itself,
    /// $1 / (s / (\lambda - \underline\lambda) + t / (\nu - \lambda))$.
    #[inline]
    pub(super) fn curvature(&self, state: &RowState) -> f64 {
        let (RowState { slack: s, elastic: t, .. }, [below, above]) = (*state, state.distances());
        if state.row.is_equality || state.row.is_hard {
            let least = if state.row.is_equality { self.compliance } else { 0.0 };
            return 1.0 / (s / below + t / above + least);
        }
        below * above / (s * above + t * below)
    }

    /// The Newton step of a row that changes by `change`.
    #[inline]
    pub fn step(&self, state: &RowState, h: f64, change: f64) -> RowStep {
        let (mu, [below, above]) = (self.barrier.mu, state.distances());
        let RowState { slack: s, elastic: t, .. } = *state;
        let multiplier = self.curvature(state) * (h + change + mu / below - mu / above);
        RowStep {
            slack: mu / below - s - s / below * multiplier,
            elastic: mu / above - t + t / above * multiplier,
            multiplier,
        }
    }

    /// The curvature of slack and elastic variable along a step, and the part of it in the condensed matrix.
    #[inline]
    pub fn bend(&self, state: &RowState, step: &RowStep, change: f64) -> [f64; 2] {
        let (RowState { slack: s, elastic: t, .. }, [below, above]) = (*state, state.distances());
        let elastic = if state.row.is_hard { 0.0 } else { above / t * step.elastic * step.elastic };
        let own = below / s * step.slack * step.slack + elastic;
        [own, self.curvature(state) * change * change]
    }

    /// Safeguards the multipliers of all rows; see [`RowState::safeguard`].
    pub fn safeguard_all(&mut self, range: f64) {
        let mu = self.barrier.mu;
        for state in &mut self.working {
            state.safeguard(mu, range);
        }
    }

    /// The terms of the equalities in the Lagrangian, for one measure of all rows.
    pub fn lagrangian_terms(&self, h: &[f64], measure: f64) -> f64 {
        let terms = self.equalities.iter().map(|held| held.row.weight * held.term(h[held.row.at]).cost);
        measure * terms.sum::<f64>()
    }

    /// The terms of all rows in the barrier function for these measures of rows.
    pub fn barrier_terms(&self, measure: impl Fn(usize) -> f64) -> f64 {
        let (mut sum, mu) = (MeasuredSum::default(), self.barrier.mu);
        for of in &self.working {
            sum.add(measure(of.row.at), of.row.weight * of.barrier_term(mu));
        }
        sum.total()
    }
}

/// A sum of terms times the measures of their rows, which are those of a few parts.
#[derive(Default)]
pub(super) struct MeasuredSum {
    /// The parts before, and the sum of the terms of the last one without its measure.
    before: f64,
    measure: f64,
    sum: f64,
}

impl MeasuredSum {
    #[inline]
    pub fn add(&mut self, measure: f64, term: f64) {
        if measure != self.measure {
            (self.before, self.measure, self.sum) = (self.total(), measure, 0.0);
        }
        self.sum += term;
    }

    pub fn total(&self) -> f64 {
        self.before + self.measure * self.sum
    }
}
