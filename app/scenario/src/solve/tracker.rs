//! A scenario whose motion is followed and replanned.

use crate::solve::custom_terms::ScenarioCost;
use crate::{DirectOptions, Obstacle, Preset, Scenario};
use aghf::constraint::{AnyConstraint, RowLabel};
use aghf::curve::Curve;
use aghf::direct::{Step, Tracker, TrackerOptions};
use aghf::error::{Error, Result};
use aghf::motion::Interrupt;
use self_cell::self_cell;
use serde::Deserialize;
use std::time::Duration;

/// The degree of the polynomial by default: an iteration takes half the time of one at that of a solve.
const DEGREE: usize = 12;

/// The longest deadline, s.
const MAX_DEADLINE_S: f64 = 3600.0;

/// The options of a tracker; those that are not given are the defaults of [`TrackerOptions`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScenarioTrackerOptions {
    /// Options of the first search; the degree, 12 by default, is that of all plans.
    pub search: DirectOptions,
    /// Fixed barrier parameter after the first search, relative to the objective; by default 0.01.
    pub barrier: Option<f64>,
    /// Largest number of iterations per step; by default 1.
    pub iterations_per_step: Option<usize>,
    /// Least relative decrease of the objective for which a plan to the same goal replaces the old one; by default
    /// 0.001.
    pub least_gain: Option<f64>,
    /// Number of intervals of the check of a plan per degree; by default 10.
    pub look: Option<usize>,
    /// Time within which a step returns, s; by default there is none.
    pub deadline_s: Option<f64>,
    /// Bandwidth of the feedback, rad/s; by default 30.
    pub bandwidth: Option<f64>,
    /// Shortest remaining time for which a plan is changed, s; by default 0.1.
    pub shortest_horizon_s: Option<f64>,
    /// Distance of a joint from the plan, rad or m, beyond which a new plan begins at the measured state; by default
    /// 0.1.
    pub largest_deviation: Option<f64>,
}

type Own<'s> = Tracker<'s, Vec<AnyConstraint>, ScenarioCost<'s>>;

self_cell! {
    struct Cell {
        owner: Scenario,
        #[not_covariant]
        dependent: Own,
    }
}

/// A [`Tracker`] with the scenario that it belongs to.
pub struct ScenarioTracker(Cell);

impl ScenarioTracker {
    /// Searches the first plan.
    ///
    /// # Errors
    /// Those of [`Tracker::new`]; the objective is a preset that takes several searches; or an option is out of range.
    pub fn new(scenario: Scenario, options: &ScenarioTrackerOptions, interrupt: Interrupt) -> Result<Self> {
        scenario.refuse_walk()?;
        if let Some(note) = scenario.notes_on_start().next() {
            return Err(Error::input(&scenario.name, "tracker", format!("{note}; it has to start within it")));
        }
        let mut options = options.in_full(&scenario)?;
        options.settings.interrupt = interrupt;
        let cell = Cell::try_new(scenario, |scenario| {
            let cost = scenario.scenario_cost()?;
            Tracker::new(&scenario.problem()?, scenario.constraints(), cost, options)
        });
        cell.map(Self)
    }

    /// The scenario, with the goal and the obstacles of the first plan.
    #[must_use]
    pub fn scenario(&self) -> &Scenario {
        self.0.borrow_owner()
    }

    /// Takes a [step](Tracker::step).
    ///
    /// # Errors
    /// Those of [`Tracker::step`].
    pub fn step(&mut self, state: &[f64], now: f64) -> Result<Step<'_>> {
        self.0.with_dependent_mut(|_, tracker| tracker.step(state, now))
    }

    /// The rest of the plan; see [`Tracker::rest`].
    ///
    /// # Errors
    /// Those of [`Tracker::rest`].
    pub fn rest(&self) -> Result<Curve> {
        self.0.with_dependent(|_, tracker| tracker.rest())
    }

    /// Changes the [goal](Tracker::set_goal).
    ///
    /// # Errors
    /// Those of [`Tracker::set_goal`].
    pub fn set_goal(&mut self, q: &[f64], horizon: f64) -> Result<()> {
        self.0.with_dependent_mut(|_, tracker| tracker.set_goal(q, horizon))
    }

    /// Replaces all obstacles from the next step on.
    ///
    /// # Errors
    /// Names the key of an obstacle and its fault; the old obstacles then remain.
    pub fn set_obstacles(&mut self, obstacles: &[Obstacle]) -> Result<()> {
        self.0.with_dependent_mut(|scenario, tracker| {
            let scene = scenario.scene_with(obstacles)?;
            tracker.set_constraints(scenario.constraints_in(&scene))
        })
    }

    /// Changes the time within which the next steps return, s; `None` for no end.
    ///
    /// # Errors
    /// It is out of range.
    pub fn set_deadline(&mut self, seconds: Option<f64>) -> Result<()> {
        let deadline = deadline(seconds)?;
        self.0.with_dependent_mut(|_, tracker| tracker.set_deadline(deadline));
        Ok(())
    }

    /// The label of a row of the current constraints.
    #[must_use]
    pub fn label(&self, row: usize) -> RowLabel {
        self.0.with_dependent(|scenario, tracker| tracker.constraints().label(row, &scenario.model))
    }

    /// The excess of the quantity that a row limits over its bound, in the unit of the label, for a violation of it.
    #[must_use]
    pub fn excess(&self, row: usize, by: f64) -> f64 {
        self.0.with_dependent(|scenario, tracker| (tracker.constraints()).excess(row, by, &scenario.model))
    }
}

impl ScenarioTrackerOptions {
    /// The options of a tracker of `scenario`.
    fn in_full(&self, scenario: &Scenario) -> Result<TrackerOptions> {
        if let Some(preset) = scenario.file.objective.preset()
            && preset != Preset::LeastEffort
        {
            let condition = format!("it is '{preset}', a tracker minimises least-effort or weights");
            return Err(Error::input(&scenario.name, "objective", condition));
        }
        let mut search = self.search.clone();
        search.degree = search.degree.or(Some(DEGREE));
        let mut settings = search.settings(scenario)?;
        settings.search.points = TrackerOptions::default().settings.search.points;
        settings.waypoints = scenario.waypoints.clone();
        let default = TrackerOptions::default();
        Ok(TrackerOptions {
            settings,
            deadline: deadline(self.deadline_s)?,
            barrier: self.barrier.unwrap_or(default.barrier),
            iterations_per_step: (self.iterations_per_step).unwrap_or(default.iterations_per_step),
            least_gain: self.least_gain.unwrap_or(default.least_gain),
            look: self.look.unwrap_or(default.look),
            bandwidth: self.bandwidth.unwrap_or(default.bandwidth),
            shortest_horizon: self.shortest_horizon_s.unwrap_or(default.shortest_horizon),
            largest_deviation: self.largest_deviation.unwrap_or(default.largest_deviation),
        })
    }
}

/// A deadline of a step.
fn deadline(seconds: Option<f64>) -> Result<Option<Duration>> {
    match seconds {
        Some(s) if !(0.0..=MAX_DEADLINE_S).contains(&s) => {
            let condition = format!("it is {s} and must be at least 0 and at most {MAX_DEADLINE_S} s");
            Err(Error::input("options", "deadline_s", condition))
        }
        seconds => Ok(seconds.map(Duration::from_secs_f64)),
    }
}
