//! The options of the direct method.

use super::{PASSIVE_BASIS, PASSIVE_ITERATIONS, PASSIVE_STARTS, starts_of, time_limit};
use crate::keys::schema::one_of;
use crate::{Continuous, Preset, Scenario};
use aghf::direct::{DirectSettings, PlannedStarts, SearchOptions};
use aghf::error::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The number of starts by default if the goal is a set, so that several of its ends are tried.
const GOAL_STARTS: usize = 12;

/// The degree of the polynomial of each phase of a walk: with 10 the effort of ten steps of a humanoid is 2 to 5 %
/// less, and one of three walks ends at no motion.
const WALK_DEGREE: usize = 8;
/// The largest number of iterations of a walk: where edges of soles hold for long, a free horizon takes many.
const WALK_ITERATIONS: usize = 2000;
/// The same at lower degrees: the first one brings all feet to their places.
const WALK_LOWER_ITERATIONS: usize = 200;

/// The distance from limits and obstacles by default. Between the times at which rows are evaluated they may exceed
/// their bounds by about 1e-6 of these, which no certificate accepts.
const RESERVE: f64 = 3e-6;

/// The options of the direct method.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DirectOptions {
    /// Degree of the polynomial, or of each segment; by default 16, with passive joints and in a walk 8.
    pub degree: Option<usize>,
    /// Number of polynomials on equal parts of the horizon; by default 1, with passive joints 8, in a walk one
    /// per phase.
    pub segments: Option<usize>,
    /// Relative change of the effort between two degrees at which the degree stops growing, such as 0.01; by default
    /// the degree does not grow.
    pub degree_tolerance: Option<f64>,
    /// Relative norm of the gradient at the end; by default 1e-6, with a flow to rest without constraints 1e-8.
    pub tolerance: Option<f64>,
    /// Distance that a motion keeps from its limits and obstacles, relative to the limit, so that it can be certified;
    /// by default 3e-6.
    pub reserve: Option<f64>,
    /// Number of starts; by default 32 up to 7 joints and fewer beyond, 1 within limits of the joints, on a standing
    /// foot or if links keep clear of each other, 40 with passive joints. More follow until one satisfies the
    /// constraints.
    pub starts: Option<usize>,
    /// Seed of the starts; by default 0.
    pub seed: Option<u64>,
    /// Starts that follow planned paths around obstacles; by default `later`, and `first` among obstacles if poses are
    /// kept exactly.
    #[schemars(schema_with = "one_of::<PlannedStarts>")]
    pub planned_starts: Option<PlannedStarts>,
    /// Number of threads for the starts, with the same result; by default all cores.
    pub threads: Option<usize>,
    /// Time limit, s, after which the search stops with the best motion so far or one along a planned path; starts that
    /// other searches follow, as with a free horizon, have a half or a quarter of it.
    pub time_limit_s: Option<f64>,
}

impl DirectOptions {
    /// The settings of the direct method for `scenario`: these options, completed by its defaults.
    ///
    /// # Errors
    /// The time limit is out of range.
    pub fn settings(&self, scenario: &Scenario) -> Result<DirectSettings> {
        let mut default = DirectSettings::constrained();
        if !scenario.file.passive.is_empty() {
            (default.degree, default.segments) = PASSIVE_BASIS;
            default.starts = PASSIVE_STARTS;
            default.iterations = PASSIVE_ITERATIONS;
            default.start_amplitude = DirectSettings::default().start_amplitude;
        } else if !scenario.limits_are_enforced() && !scenario.keeps_links_clear() && scenario.foot().is_none() {
            // With limits, links that keep clear of each other, or a foot there are few minima; without them there are
            // many.
            default.starts = starts_of(scenario.model.dof());
            default.start_amplitude = DirectSettings::default().start_amplitude;
            default.lowest_degree = DirectSettings::default().lowest_degree;
        }
        let phases = scenario.file.phases.len();
        if phases > 0 {
            (default.degree, default.segments) = (WALK_DEGREE, phases);
            default.iterations = WALK_ITERATIONS;
            default.search.lower_iterations = WALK_LOWER_ITERATIONS;
            default.lowest_degree = DirectSettings::default().lowest_degree;
            // As many checks of each phase as of a motion.
            default.search.last_scan *= phases;
            // There is nothing to plan around.
            default.planned_starts = PlannedStarts::Never;
        }
        if scenario.keeps_poses_exactly() && !scenario.file.obstacles.is_empty() {
            // A straight line through an obstacle rarely leads around it within equalities.
            default.planned_starts = PlannedStarts::First;
        }
        let compares_ends = matches!(scenario.file.objective.preset(), Some(Preset::LeastTime | Preset::Balanced));
        if scenario.goal.is_some() && !compares_ends {
            default.starts = default.starts.max(GOAL_STARTS);
        }
        Ok(DirectSettings {
            degree: self.degree.unwrap_or(default.degree),
            segments: self.segments.unwrap_or(default.segments),
            degree_tolerance: self.degree_tolerance,
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            starts: self.starts.unwrap_or(default.starts),
            search: SearchOptions { reserve: self.reserve.unwrap_or(RESERVE), ..default.search.clone() },
            seed: self.seed.unwrap_or(default.seed),
            planned_starts: self.planned_starts.unwrap_or(default.planned_starts),
            time_limit: time_limit(self.time_limit_s)?,
            threads: self.threads.unwrap_or_else(all_cores),
            free_final_velocity: scenario.file.free_final_velocity,
            continuous_acceleration: scenario.file.continuity() == Continuous::Acceleration,
            free_horizon: scenario.free_horizon()?,
            parts: scenario.file.durations(),
            goal: scenario.goal.clone(),
            period: scenario.period.clone(),
            ..default
        })
    }

    /// The same options with all defaults filled in, without those that change no result.
    pub(super) fn in_full(&self, scenario: &Scenario) -> Result<Self> {
        let settings = self.settings(scenario)?;
        Ok(Self {
            degree: Some(settings.degree),
            segments: Some(settings.segments),
            tolerance: Some(settings.tolerance),
            reserve: Some(settings.search.reserve),
            starts: Some(settings.starts),
            seed: Some(settings.seed),
            planned_starts: Some(settings.planned_starts),
            ..self.clone()
        })
    }
}

/// The number of cores on which threads can run.
fn all_cores() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    cores.min(DirectSettings::MAX_THREADS)
}
