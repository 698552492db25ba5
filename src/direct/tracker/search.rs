//! The search of a step, and the check of its result.

use super::Tracker;
use super::pace::{Pace, learn};
use super::plan::Plan;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::curve::Curve;
use crate::direct::DirectSettings;
use crate::direct::minimise::Iterations;
use crate::error::Result;
use crate::motion::{Problem, Violation, curve_of};
use std::time::Instant;

/// A plan beside the one that is followed: the plan that is tried, or the rest of the plan that is followed.
pub(super) enum Checked {
    Tried,
    Reference,
}

/// The work of the search of a step.
#[derive(Clone, Copy, Default)]
pub(super) struct Searched {
    pub iterations: usize,
    pub replaced: bool,
    pub converged: bool,
    pub cut_off: bool,
}

impl<K: Constraint + Send + Sync, P: CostWithControl> Tracker<'_, K, P> {
    /// Improves a plan that begins at a state now, if there is time, and follows it if it is safe and better.
    pub(super) fn search(&mut self, begin: &[f64], now: f64, is_current: bool) -> Result<Searched> {
        let times = *self.pace.times();
        if !(self.pace).fits(times.preparation + times.iteration + times.look) {
            self.pace.forget();
            return Ok(Searched { cut_off: true, ..Searched::default() });
        }
        let shortest = self.options.shortest_horizon;
        let [reference, tried, attempt] = &mut self.others;
        self.plan.rest_in(now, shortest, &mut self.memory, reference);
        let is_same = self.attempted.take() == Some(is_current);
        if is_same {
            attempt.rest_in(now, shortest, &mut self.memory, tried);
            if !is_current {
                // The horizon begins when the plan does.
                tried.motion.horizons.assign(&attempt.motion.horizons);
            }
        } else {
            tried.set(reference);
            let horizon = self.asked.unwrap_or(tried.motion.horizons.whole());
            tried.motion.horizons.set(0, horizon);
        }
        let most = self.options.iterations_per_step;
        let found = self.improve(begin, most, is_same)?;
        let mut replaced = !is_current || found.gain >= self.options.least_gain;
        if replaced {
            let began = Instant::now();
            replaced = self.look(Checked::Tried)?.is_none();
            learn(&mut self.pace.times().look, began.elapsed().as_secs_f64());
        }
        self.pace.is_first = false;
        let [_, tried, attempt] = &mut self.others;
        if replaced {
            std::mem::swap(&mut self.plan, tried);
            (self.asked, self.aims, self.violated) = (None, true, None);
        } else if !found.converged {
            std::mem::swap(attempt, tried);
            self.attempted = Some(is_current);
        }
        Ok(Searched {
            iterations: found.count,
            replaced,
            converged: found.converged,
            cut_off: !found.converged && found.count < most,
        })
    }

    /// Takes iterations on the plan that is tried, from a state: up to `most`, as many as time allows.
    fn improve(&mut self, begin: &[f64], most: usize, is_same: bool) -> Result<Iterations> {
        let mut since = Instant::now();
        let [reference, tried, _] = &mut self.others;
        let motion = &mut tried.motion;
        self.problem.set(begin, &self.goal, motion.horizons.whole())?;
        motion.path.set_ends(&self.problem);
        let pace = &mut self.pace;
        let mut should_continue = |count: usize| {
            let times = pace.times();
            let estimate = match count {
                0 => &mut times.preparation,
                _ => &mut times.iteration,
            };
            learn(estimate, since.elapsed().as_secs_f64());
            since = Instant::now();
            let next = times.iteration + times.look;
            count < most && (count == 0 || pace.fits(next))
        };
        let workspace = &mut self.workspace.search;
        let reference = (&reference.motion, is_same);
        workspace.improve(&self.problem, motion, reference, &mut should_continue)
    }

    /// The motion of a plan.
    pub(super) fn curve(&self, plan: &Plan) -> Result<Curve> {
        let path = &plan.motion.path;
        let horizon = plan.motion.horizons.whole();
        let states = [plan.began, plan.began + horizon].map(|time| {
            let [q, v, _] = plan.at(time);
            [q, v].concat()
        });
        let [begin, end] = states;
        curve_of(&Problem::new(self.model, begin, end, horizon)?, path)
    }

    /// The row that a plan violates most; `None` if it is safe.
    pub(super) fn look(&mut self, plan: Checked) -> Result<Option<Violation>> {
        let [reference, tried, _] = &self.others;
        let plan = match plan {
            Checked::Tried => tried,
            Checked::Reference => reference,
        };
        let rows = &mut self.workspace.rows;
        let rows = rows.along(&mut self.on_plan.of(plan))?;
        let most = rows.iter().copied().max_by(|a, b| a.by.total_cmp(&b.by));
        Ok(most.filter(|row| row.by > DirectSettings::FEASIBLE))
    }

    /// Improves the first plan to the barrier parameter of the later ones, and measures the parts of a step.
    pub(super) fn centre(&mut self) -> Result<()> {
        self.pace = Pace::unknown();
        for most in [self.options.settings.iterations, 1] {
            let [reference, tried, _] = &mut self.others;
            reference.set(tried);
            let [q, v, _] = tried.at(tried.began);
            self.improve(&[q, v].concat(), most, false)?;
            let began = Instant::now();
            if self.look(Checked::Tried)?.is_none() {
                let [_, tried, _] = &self.others;
                self.plan.set(tried);
            }
            learn(&mut self.pace.times().look, began.elapsed().as_secs_f64());
            // The next one does not make the tables.
            self.pace.is_first = false;
        }
        Ok(())
    }
}
