//! Every scenario of a system, solved with the best sets.

use super::Settings;
use super::searches::{Search, search};
use super::systems::{SYSTEMS, System};
use super::timing::median;
use crate::sweep::{FlowPoint, Sweep};
use aghf::error::{Error, Result};
use aghf_scenario::{
    Feasibility, FlowParameters, Limit, Method, Scenario, ScenarioFile, SolveOptions, solve,
};

/// The origin of a set of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The best set printed in the supplement.
    Paper,
    /// Our own choice, in the scenario.
    Own,
    /// The fastest set of the grid search.
    Fastest,
    /// The set of the grid search with the least effort.
    LeastEffort,
}

impl Origin {
    /// The origin in one or two words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Own => "own",
            Self::Fastest => "grid, fastest",
            Self::LeastEffort => "grid, least effort",
        }
    }
}

/// The result of one scenario with one set.
#[derive(Clone, Debug)]
pub struct ScenarioResult {
    /// The name of the scenario.
    pub scenario: String,
    /// The scenario with the parameters of the solve.
    pub file: ScenarioFile,
    /// The tolerance of the integrator.
    pub tolerance: f64,
    /// [`Summary::success`](aghf_scenario::Summary::success).
    pub success: bool,
    /// The reason of a failed flow; `None` if it completed.
    pub failure: Option<String>,
    /// The median wall time of the flow, s; that of the only run without success.
    pub solve_seconds: f64,
    /// $\int |u|^2 dt$.
    pub effort: f64,
    /// The action.
    pub action: f64,
    /// The final error of the simulation without feedback; `None` if it stopped early.
    pub open_loop_error: Option<f64>,
    /// The final error of the simulation with feedback; `None` if it stopped early.
    pub feedback_error: Option<f64>,
    /// The clearance of the motion and the limits that it violates.
    pub feasibility: Feasibility,
}

impl ScenarioResult {
    /// Returns true if `k_cons` and `c_cons` had an effect.
    pub(super) fn constrained(&self) -> bool {
        let file = &self.file;
        !(file.sphere_obstacles.is_empty() && file.half_spaces.is_empty())
            || file.enforced_limits.any()
    }

    /// The number of joints that violate a limit of this kind.
    pub(super) fn joints_beyond(&self, limit: Limit) -> usize {
        let violations = self.feasibility.limit_violations.iter();
        violations.filter(|v| v.limit == limit).count()
    }
}

/// The results of all scenarios of a system with its sets of one origin.
#[derive(Clone, Debug)]
pub struct SystemResult {
    /// The system.
    pub system: System,
    /// The origins of the sets: several if these are equal.
    pub origins: Vec<Origin>,
    /// One result per scenario, at least one.
    pub results: Vec<ScenarioResult>,
}

impl SystemResult {
    /// The names of its origins.
    pub(super) fn origins(&self) -> String {
        let names: Vec<&str> = self.origins.iter().map(|o| o.name()).collect();
        names.join("; ")
    }
}

/// Searches the grids and then solves the scenarios of all selected systems, one after the other, with each of their
/// best sets.
pub(super) fn solves(
    settings: &Settings,
    progress: &mut (dyn FnMut(&str) + Send),
) -> Result<(Vec<Search>, Vec<SystemResult>)> {
    let sweeps = (settings.grids.iter()).map(|grid| Sweep::load(grid));
    let sweeps = sweeps.collect::<Result<Vec<_>>>()?;
    if let Some(i) = sweeps.iter().position(|s| s.method() != Method::Flow) {
        let condition = "the paper's experiments are those of the flow";
        return Err(Error::input(&settings.grids[i], "method", condition));
    }
    let (mut searches, mut all) = (Vec::new(), Vec::new());
    for system in SYSTEMS.into_iter().filter(|s| settings.chooses(s.prefix)) {
        let scenarios = (system.scenarios()).map(|name| Scenario::load(&name));
        let scenarios = scenarios.collect::<Result<Vec<_>>>()?;
        let found = search(system, &sweeps, settings, progress)?;
        for (origins, sets) in best_sets(system, &scenarios, found.as_ref()) {
            let results = (scenarios.iter().zip(sets))
                .map(|(scenario, set)| {
                    progress(&scenario.name);
                    run(scenario, set, settings.repetitions)
                })
                .collect::<Result<Vec<_>>>()?;
            all.push(SystemResult {
                system,
                origins,
                results,
            });
        }
        searches.extend(found);
    }
    Ok((searches, all))
}

/// The origins of sets, and one set per scenario of a system.
type BestSets = (Vec<Origin>, Vec<FlowParameters>);

/// The best sets of a system, one per scenario: the paper's, and those of the grid search or, without one, our own.
/// Equal ones are merged.
fn best_sets(system: System, scenarios: &[Scenario], search: Option<&Search>) -> Vec<BestSets> {
    let mut all: Vec<BestSets> = Vec::new();
    let mut add = |origin, set: &dyn Fn(FlowParameters) -> FlowParameters| {
        let sets: Vec<_> = scenarios.iter().map(|s| set(s.file.flow)).collect();
        match all.iter_mut().find(|(_, known)| *known == sets) {
            Some((origins, _)) => origins.push(origin),
            None => all.push((vec![origin], sets)),
        }
    };
    if let Some(paper) = system.paper {
        add(Origin::Paper, &|flow| paper.over(flow));
    }
    match search {
        None => add(Origin::Own, &|flow| flow),
        Some(search) => {
            let found = search.best.iter().flatten();
            for (origin, best) in [Origin::Fastest, Origin::LeastEffort]
                .into_iter()
                .zip(found)
            {
                add(origin, &|flow| of_grid(&best.point, flow));
            }
        }
    }
    all
}

/// A set of a grid, completed by `flow`.
fn of_grid(point: &FlowPoint, flow: FlowParameters) -> FlowParameters {
    FlowParameters {
        p: point.p,
        k: point.k,
        s_max: point.s_max,
        guess: point.guess,
        k_cons: point.k_cons.unwrap_or(flow.k_cons),
        c_cons: point.c_cons.unwrap_or(flow.c_cons),
    }
}

/// Solves a scenario with a set once for its result, then, after a success, several times for the time.
fn run(scenario: &Scenario, set: FlowParameters, repetitions: usize) -> Result<ScenarioResult> {
    let mut scenario = scenario.clone();
    scenario.file.flow = set;
    let options = SolveOptions {
        method: Method::Flow,
        ..SolveOptions::default()
    };
    let solved = || Ok(solve(&scenario, &options, &mut |_| {})?.summary);
    let summary = solved()?;
    // How long a failure takes need not be known as well.
    let again = if summary.success { repetitions } else { 0 };
    let mut seconds = (0..again)
        .map(|_| Ok(solved()?.solve_seconds))
        .collect::<Result<Vec<f64>>>()?;
    if seconds.is_empty() {
        seconds.push(summary.solve_seconds);
    }
    Ok(ScenarioResult {
        tolerance: options.flow_settings(&scenario).tolerance,
        scenario: scenario.name,
        file: scenario.file,
        success: summary.success,
        failure: summary.failure,
        solve_seconds: median(&mut seconds),
        effort: summary.control_effort,
        action: summary.details.flow().map_or(f64::NAN, |f| f.action),
        open_loop_error: summary.open_loop_error_inf,
        feedback_error: summary.final_error_inf,
        feasibility: summary.feasibility,
    })
}
