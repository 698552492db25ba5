//! The curve of duration against effort of a scenario.

use crate::results::report::report_of;
use crate::solve::by_direct::search_directly;
use crate::solve::search::Search;
use crate::{DirectOptions, Objective, Preset, Record, Scenario, ScenarioFile, SolveReport};
use aghf::direct::DirectSolution;
use aghf::error::{Error, Result};
use aghf::motion::Interrupt;

/// The least effort of a scenario at several durations, from the least one to that of the least effort of all.
///
/// The first motion is that of least time, from which the next ones are found one after the other, each from the one
/// before slowed down; the last one has the least effort on any horizon. The durations between are a geometric
/// sequence. Twenty motions take about as long as a few solves.
///
/// ```
/// use aghf_scenario::{Scenario, Tradeoff};
///
/// let scenario = Scenario::load("limits_01")?;
/// let motions = Tradeoff::new(&scenario).points(3).run()?;
/// let horizons: Vec<f64> = motions.iter().map(|(_, report)| report.curve.horizon()).collect();
/// assert!(horizons.is_sorted());
/// let efforts = motions.iter().map(|(_, report)| report.summary.control_effort);
/// assert!(efforts.rev().is_sorted());
/// # Ok::<(), aghf::Error>(())
/// ```
pub struct Tradeoff<'a> {
    scenario: &'a Scenario,
    points: usize,
    options: DirectOptions,
    interrupt: Interrupt,
    observe: Box<dyn FnMut(&Record) + 'a>,
}

impl<'a> Tradeoff<'a> {
    /// The default number of motions.
    pub const POINTS: usize = 20;
    /// The largest number of motions.
    pub const MAX_POINTS: usize = 1000;

    /// The curve of a scenario, whose objective has no effect, with default options.
    #[must_use]
    pub fn new(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            points: Self::POINTS,
            options: DirectOptions::default(),
            interrupt: Interrupt::default(),
            observe: Box::new(|_| {}),
        }
    }

    /// Sets the number of motions, at least two.
    #[must_use]
    pub fn points(self, points: usize) -> Self {
        Self { points, ..self }
    }

    /// Replaces the options of the solves.
    #[must_use]
    pub fn options(self, options: DirectOptions) -> Self {
        Self { options, ..self }
    }

    /// Sets the handle by which another thread stops the search; the motions until then remain.
    #[must_use]
    pub fn interrupt(self, interrupt: Interrupt) -> Self {
        Self { interrupt, ..self }
    }

    /// Sets a function that is called with the progress.
    #[must_use]
    pub fn observe(self, observe: impl FnMut(&Record) + 'a) -> Self {
        let observe = Box::new(observe);
        Self { observe, ..self }
    }

    /// Finds the motions, each with the scenario that it solves, in the order of their durations. Where a search failed
    /// there is a gap; the only motion may be one that is not valid.
    ///
    /// # Errors
    /// Those of [`Solve::run`](crate::Solve::run); the number of motions is out of range; or the horizon has neither
    /// limits nor bounds.
    pub fn run(self) -> Result<Vec<(Scenario, SolveReport)>> {
        let Self { scenario, points, options, interrupt, mut observe } = self;
        if !(2..=Self::MAX_POINTS).contains(&points) {
            let most = Self::MAX_POINTS;
            let condition = format!("it is {points} and must be at least 2 and at most {most}");
            return Err(Error::input("options", "points", condition));
        }
        scenario.refuse_walk()?;
        let fastest = with_objective(scenario, Preset::LeastTime, |_| ())?;
        let bounds = fastest.horizon_bounds();
        fastest.check_feasible()?;
        options.settings(&fastest)?.check(&fastest.problem()?)?;
        let mut walk = Walk { options, interrupt, observe: &mut *observe, found: Vec::new() };
        let fast = walk.find(fastest, |search| search.least_time())?;
        let first = fast.curve.horizon();
        if !walk.should_continue() {
            return Ok(walk.found);
        }
        // The other end is found from the first one too, and says where the points between are.
        let slow = with_objective(scenario, Preset::LeastEffort, |file| {
            file.free_horizon = bounds;
        })?;
        let longest = bounds.map_or(first, |bounds| bounds.longest_s);
        walk.find(slow, |search| search.solves()?.at_most(&fast, first, longest))?;
        let Some((slow, last)) = walk.found.pop_if(|(_, report)| report.summary.success) else {
            return Ok(walk.found);
        };
        let ratio = last.curve.horizon() / first;
        let mut before = fast;
        for point in 1..points - 1 {
            if !walk.should_continue() {
                break;
            }
            let horizon = first * ratio.powf(point as f64 / (points - 1) as f64);
            let between = with_objective(scenario, Preset::LeastEffort, |file| {
                (file.horizon_s, file.free_horizon) = (horizon, None);
            })?;
            let found = walk.find(between, |search| search.solves()?.at(&before, horizon))?;
            match walk.found.last() {
                Some((_, report)) if report.summary.success => before = found,
                _ => drop(walk.found.pop()),
            }
        }
        walk.found.push((slow, last));
        Ok(walk.found)
    }
}

/// The motions so far.
struct Walk<'o> {
    options: DirectOptions,
    interrupt: Interrupt,
    observe: &'o mut dyn FnMut(&Record),
    found: Vec<(Scenario, SolveReport)>,
}

impl Walk<'_> {
    /// Searches for the motion of a scenario and appends its report.
    fn find(
        &mut self,
        scenario: Scenario,
        search: impl FnOnce(&mut Search<'_, '_>) -> Result<DirectSolution>,
    ) -> Result<DirectSolution> {
        let given = (None, self.interrupt.clone());
        let observe = &mut *self.observe;
        let (found, solution) = search_directly(&scenario, &self.options, given, observe, search)?;
        let report = report_of(&scenario, &self.options.clone().into(), solution)?;
        self.found.push((scenario, report));
        Ok(found)
    }

    /// Returns true if the last motion is valid and nothing stopped the search.
    fn should_continue(&self) -> bool {
        let last = self.found.last();
        last.is_some_and(|(_, report)| report.summary.success && report.stopped.is_none())
    }
}

/// The same scenario with another objective and other keys.
fn with_objective(scenario: &Scenario, preset: Preset, change: impl FnOnce(&mut ScenarioFile)) -> Result<Scenario> {
    let mut scenario = scenario.clone();
    scenario.file.objective = Objective::Preset(preset);
    change(&mut scenario.file);
    scenario.check_objective()?;
    Ok(scenario)
}
