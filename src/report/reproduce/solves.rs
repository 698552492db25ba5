//! Every scenario of a system, solved with the best sets.

use super::Settings;
use super::systems::{SYSTEMS, System};
use super::timing::median;
use crate::error::Result;
use crate::scenario::{
    FlowParameters, Method, Scenario, ScenarioFile, SolveOptions, builtin_scenarios, solve,
};
use crate::solve::flow;
use std::time::Instant;

/// Whose parameters a scenario was solved with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The best set that the supplement prints.
    Paper,
    /// Our own best set.
    Own,
}

impl Origin {
    /// In a word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Own => "own",
        }
    }
}

/// What came of one scenario with one set.
#[derive(Clone, Debug)]
pub struct ScenarioResult {
    /// The name of the scenario.
    pub scenario: String,
    /// How it was solved: the scenario with the parameters that were used.
    pub file: ScenarioFile,
    /// The tolerance of the integrator.
    pub tolerance: f64,
    /// Whether the flow came to its end and the simulation with feedback near enough to the goal.
    pub success: bool,
    /// The median wall time of the flow, s.
    pub solve_seconds: f64,
    /// $\int |u|^2 dt$.
    pub effort: f64,
    /// The action.
    pub action: f64,
    /// The final error of the simulation without feedback; `None` where it stopped early.
    pub open_loop_error: Option<f64>,
    /// The same with feedback.
    pub feedback_error: Option<f64>,
}

/// What came of all scenarios of a system with the sets of one origin.
#[derive(Clone, Debug)]
pub struct SystemResult {
    /// The system.
    pub system: System,
    /// Whose sets these are.
    pub origin: Origin,
    /// One for each scenario, at least one.
    pub results: Vec<ScenarioResult>,
}

/// Solves the scenarios of all systems that the settings choose: with the paper's best set where there is one, and with our
/// own best sets where these are not the same.
pub(super) fn solves(
    settings: &Settings,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<SystemResult>> {
    let mut all = Vec::new();
    for system in SYSTEMS.into_iter().filter(|s| settings.chooses(s.prefix)) {
        let names = builtin_scenarios().filter(|name| name.starts_with(system.prefix));
        let scenarios = names.map(Scenario::load).collect::<Result<Vec<_>>>()?;
        let own = best_sets(&scenarios);
        let paper = system.paper.map(|set| {
            let over = |scenario: &Scenario| set.over(scenario.file.flow);
            scenarios.iter().map(over).collect::<Vec<_>>()
        });
        let differs = paper.as_ref() != Some(&own);
        let ours = differs.then_some((Origin::Own, own));
        for (origin, sets) in (paper.map(|p| (Origin::Paper, p)).into_iter()).chain(ours) {
            let results = (scenarios.iter().zip(sets))
                .map(|(scenario, set)| {
                    progress(&scenario.name);
                    run(scenario, set, settings.repetitions)
                })
                .collect::<Result<Vec<_>>>()?;
            all.push(SystemResult {
                system,
                origin,
                results,
            });
        }
    }
    Ok(all)
}

/// Our own best set for each scenario of a system: those in the scenario files.
fn best_sets(scenarios: &[Scenario]) -> Vec<FlowParameters> {
    scenarios.iter().map(|s| s.file.flow).collect()
}

/// Solves a scenario with a set once to test the curve, then several times by the clock.
fn run(scenario: &Scenario, set: FlowParameters, repetitions: usize) -> Result<ScenarioResult> {
    let mut scenario = scenario.clone();
    scenario.file.flow = set;
    let options = SolveOptions {
        method: Method::Flow,
        ..SolveOptions::default()
    };
    let summary = solve(&scenario, &options, &mut |_| {})?.summary;
    let flow_settings = options.flow_settings(&scenario);
    let problem = scenario.problem()?;
    let mut seconds = (0..repetitions)
        .map(|_| {
            let started = Instant::now();
            // Whether it came to its end is in the summary: the same call gives the same curve.
            let _ = flow(&problem, &flow_settings, &mut |_| {})?;
            Ok(started.elapsed().as_secs_f64())
        })
        .collect::<Result<Vec<f64>>>()?;
    Ok(ScenarioResult {
        scenario: scenario.name,
        file: scenario.file,
        tolerance: flow_settings.tolerance,
        success: summary.success,
        solve_seconds: median(&mut seconds),
        effort: summary.control_effort,
        action: summary.details.flow().map_or(f64::NAN, |f| f.action),
        open_loop_error: summary.open_loop_error_inf,
        feedback_error: summary.final_error_inf,
    })
}
