//! The search of the direct method for the motion of an objective: one solve, or one after the other for a preset.

use crate::{Preset, Scenario};
use aghf::constraint::{AnyConstraint, Constraints};
use aghf::cost::CostWithControl;
use aghf::direct::{DirectSequence, DirectSettings, DirectSolution, FreeHorizon, Iteration, SequenceOptions};
use aghf::error::Result;
use aghf::motion::Problem;
use std::time::Instant;

/// A search for the motion of a scenario.
pub(crate) struct Search<'s, 'o> {
    pub scenario: &'s Scenario,
    pub settings: DirectSettings,
    /// Those of the scenario.
    pub constraints: Constraints<Vec<AnyConstraint>>,
    pub observe: &'o mut dyn FnMut(&Iteration),
    pub started: Instant,
    /// The final configuration, if it is one of those in a goal that is a set.
    pub end: Option<Vec<f64>>,
    /// The number of ends of a goal that is a set to which motions were compared one by one.
    pub tried: Option<usize>,
    /// The last search of the solve from which this one starts, if it led to a minimum of the same scenario.
    pub last: Option<FreeHorizon>,
    /// The first weight of time, if this search starts from the motion of another scenario.
    pub first_weight: Option<f64>,
}

impl<'s, 'o> Search<'s, 'o> {
    pub fn new(scenario: &'s Scenario, settings: DirectSettings, observe: &'o mut dyn FnMut(&Iteration)) -> Self {
        Self {
            scenario,
            settings,
            constraints: scenario.constraints(),
            observe,
            started: Instant::now(),
            end: None,
            tried: None,
            last: None,
            first_weight: None,
        }
    }

    /// Finds the motion of the objective.
    pub fn run(&mut self) -> Result<DirectSolution> {
        if let Some(last) = self.last.take() {
            let free_horizon = self.settings.free_horizon.replace(last);
            let found = self.solves()?.first()?;
            self.settings.free_horizon = free_horizon;
            if found.converged && found.is_feasible() {
                return Ok(found);
            }
        }
        match self.scenario.file.objective.preset() {
            None | Some(Preset::LeastEffort) => self.solves()?.first(),
            Some(Preset::LeastTime) => self.least_time(),
            Some(Preset::Balanced) => self.compare_ends(|search| {
                let weight = search.first_weight()?;
                search.solves()?.balanced(weight)
            }),
        }
    }

    /// The motion of least time.
    pub fn least_time(&mut self) -> Result<DirectSolution> {
        self.compare_ends(|search| {
            let weight = search.first_weight()?;
            search.solves()?.least_time(weight)
        })
    }

    /// The weight of time that counts as much as the effort of the straight motion, or that of a start.
    fn first_weight(&self) -> Result<f64> {
        if let Some(weight) = self.first_weight {
            return Ok(weight);
        }
        let scenario = self.scenario;
        let goal = self.first_end().unwrap_or(&scenario.file.q_goal);
        let unit = scenario.cost_of_straight(&mut scenario.running_cost()?, goal)?;
        Ok(unit / scenario.unit_of_time(Some(goal)))
    }

    /// The solves of the search. A walk on a free horizon is first solved on the given one: from the longest horizon
    /// the search would shorten it at once, while feet are not yet at their places.
    pub fn solves(&mut self) -> Result<DirectSequence<'_, Vec<AnyConstraint>, impl CostWithControl>> {
        let fixed_first = !self.scenario.file.phases.is_empty();
        let solves = DirectSequence::new(self.problem()?, self.scenario.running_cost()?, &self.constraints)
            .settings(self.settings.clone())
            .options(SequenceOptions { fixed_first, ..SequenceOptions::default() })
            .started(self.started)
            .observe(&mut *self.observe);
        Ok(solves)
    }

    /// The problem with which a search begins: on a free horizon to an end of a goal that is a set, whatever
    /// `horizon_s`.
    fn problem(&self) -> Result<Problem<'s>> {
        let mut problem = self.scenario.problem()?;
        if let Some(end) = &self.end {
            problem = problem.with_final_position(end)?;
        }
        match (self.first_end(), self.settings.free_horizon) {
            (Some(end), Some(free)) if self.scenario.file.objective.weighs_time() => {
                let first = self.scenario.first_horizon(end);
                problem.with_horizon(first.clamp(free.shortest, free.longest))
            }
            // The longest horizon may be that of another search.
            (_, Some(free)) => {
                let given = problem.horizon();
                problem.with_horizon(given.clamp(free.shortest, free.longest))
            }
            (_, None) => Ok(problem),
        }
    }

    /// The end of a goal that is a set to which the search goes first.
    fn first_end(&self) -> Option<&[f64]> {
        let goal = self.settings.goal.as_ref();
        let end = self.end.as_deref();
        end.or_else(|| goal.map(|goal| &goal.ends[0].q[..]))
    }
}
