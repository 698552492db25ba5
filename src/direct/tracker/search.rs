//! The search of a step, and the look at its result.

use super::Tracker;
use super::pace::{Pace, learn};
use super::plan::Plan;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::curve::Curve;
use crate::direct::minimise::{Context, Iterations, improve};
use crate::direct::{DirectSettings, FreeHorizon};
use crate::error::Result;
use crate::motion::{Interrupt, Problem, Violation, Watch, curve_of, violations_near_ends};
use crate::transcription::Rows;
use std::time::Instant;

/// The work of the search of a step.
#[derive(Clone, Copy, Default)]
pub(super) struct Searched {
    pub iterations: usize,
    pub replaced: bool,
    pub converged: bool,
    pub cut_off: bool,
}

impl<K: Constraint + Sync, P: CostWithControl> Tracker<'_, K, P> {
    /// Improves a plan that begins at a state now, if there is time, and follows it if it is safe and better.
    pub(super) fn search(
        &mut self,
        begin: Vec<f64>,
        now: f64,
        is_current: bool,
    ) -> Result<Searched> {
        if !self
            .pace
            .fits(self.pace.preparation + self.pace.iteration + self.pace.look)
        {
            self.pace.forget();
            return Ok(Searched {
                cut_off: true,
                ..Searched::default()
            });
        }
        let shortest = self.options.shortest_horizon;
        let reference = self.plan.rest(now, shortest);
        let mut plan = match self.attempt.take() {
            Some((attempt, of_current)) if of_current == is_current => {
                let mut rest = attempt.rest(now, shortest);
                if !is_current {
                    // The horizon begins when the plan does.
                    rest.motion.horizon = attempt.motion.horizon;
                }
                rest
            }
            _ => {
                let mut rest = reference.clone();
                rest.motion.horizon = self.asked.unwrap_or(rest.motion.horizon);
                rest
            }
        };
        let most = self.options.iterations_per_step;
        let found = self.improve(begin, &mut plan, &reference, most)?;
        let mut replaced = !is_current || found.gain >= self.options.least_gain;
        if replaced {
            let began = Instant::now();
            replaced = self.look(&plan)?.is_none();
            learn(&mut self.pace.look, began.elapsed().as_secs_f64());
        }
        if replaced {
            (self.plan, self.asked, self.aims, self.violated) = (plan, None, true, None);
        } else if !found.converged {
            self.attempt = Some((plan, is_current));
        }
        Ok(Searched {
            iterations: found.count,
            replaced,
            converged: found.converged,
            cut_off: !found.converged && found.count < most,
        })
    }

    /// Takes iterations on a plan that begins at a state, up to `most` and as many as there is time for.
    fn improve(
        &mut self,
        begin: Vec<f64>,
        plan: &mut Plan,
        reference: &Plan,
        most: usize,
    ) -> Result<Iterations> {
        let mut since = Instant::now();
        let motion = &mut plan.motion;
        let problem = Problem::new(self.model, begin, self.goal.clone(), motion.horizon)?;
        motion.path = motion.path.clone().between_ends_of(&problem);
        let rows = Rows::new(self.model, &self.constraints, self.cost.clone())?;
        let watch = Watch::start(None, &Interrupt::default());
        let context = Context {
            problem: &problem,
            grids: &self.grids,
            rows: &rows,
            watch: &watch,
            settings: &self.options.settings,
            free_horizon: self.free_horizon(),
            goal: None,
        };
        let pace = &mut self.pace;
        let mut goes_on = |count: usize| {
            let estimate = match count {
                0 => &mut pace.preparation,
                _ => &mut pace.iteration,
            };
            learn(estimate, since.elapsed().as_secs_f64());
            since = Instant::now();
            count < most && (count == 0 || pace.fits(pace.iteration + pace.look))
        };
        improve(
            context,
            motion,
            &reference.motion,
            self.options.barrier,
            &mut goes_on,
        )
    }

    /// The bounds and the weight of a free horizon, which gets shorter on the way.
    pub(super) fn free_horizon(&self) -> Option<FreeHorizon> {
        let free = self.options.settings.free_horizon?;
        Some(FreeHorizon {
            shortest: self.options.shortest_horizon.min(free.shortest),
            ..free
        })
    }

    /// The motion of a plan.
    pub(super) fn curve(&self, plan: &Plan) -> Result<Curve> {
        let path = &plan.motion.path;
        let horizon = plan.motion.horizon;
        let states = [plan.began, plan.began + horizon].map(|time| {
            let [q, v, _] = plan.at(time);
            [q, v].concat()
        });
        let [begin, end] = states;
        curve_of(&Problem::new(self.model, begin, end, horizon)?, path)
    }

    /// The row that a plan violates most; `None` if it is safe.
    pub(super) fn look(&self, plan: &Plan) -> Result<Option<Violation>> {
        let rows = violations_near_ends(
            self.model,
            &self.curve(plan)?,
            &self.constraints,
            self.options.look,
        )?;
        let most = rows.into_iter().max_by(|a, b| a.by.total_cmp(&b.by));
        Ok(most.filter(|row| row.by > DirectSettings::FEASIBLE))
    }

    /// Improves the first plan to the barrier parameter of the later ones, and measures the parts of a step.
    pub(super) fn centre(&mut self) -> Result<()> {
        let mut plan = self.plan.clone();
        for most in [self.options.settings.iterations, 1] {
            // The first time makes the tables.
            self.pace = Pace::unknown();
            let reference = plan.clone();
            let [q, v, _] = plan.at(plan.began);
            self.improve([q, v].concat(), &mut plan, &reference, most)?;
            let began = Instant::now();
            if self.look(&plan)?.is_none() {
                self.plan = plan.clone();
            }
            learn(&mut self.pace.look, began.elapsed().as_secs_f64());
        }
        Ok(())
    }
}
