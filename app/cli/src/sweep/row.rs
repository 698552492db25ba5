//! The result of one solve of a sweep.

use super::{ParameterSet, Sweep};
use crate::output::{csv_cell, one_line};
use aghf::direct::DirectSettings;
use aghf_scenario::{Method, SolveReport};
use csv::StringRecord;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Number, Value};

/// The outcome of a solve of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RowOutcome {
    /// The motion reaches the goal.
    Success,
    /// The flow completed, but the simulation with feedback misses the goal.
    GoalMissed,
    /// The motion reaches the goal, but collides or violates an enforced limit.
    Infeasible,
    /// The flow did not complete, or the direct method did not reach a minimum.
    Failed,
    /// The problem was not solved: its file is faulty, it has no motion, or the method does not support it.
    Refused,
    /// The time limit was reached.
    TimeLimit,
}

impl RowOutcome {
    /// All outcomes.
    pub const ALL: [Self; 6] =
        [Self::Success, Self::GoalMissed, Self::Infeasible, Self::Failed, Self::Refused, Self::TimeLimit];

    /// The name in the results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Success => "success",
            Self::GoalMissed => "goal_missed",
            Self::Infeasible => "infeasible",
            Self::Failed => "failed",
            Self::Refused => "refused",
            Self::TimeLimit => "time_limit",
        }
    }
}

/// A row of the results, with its columns in the order of the file. The state of a solve at its time limit depends on
/// the machine, so that it is not recorded; otherwise only `solve_seconds` differs between runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// [`ParameterSet::index`].
    pub set: usize,
    /// The name of the scenario.
    pub scenario: String,
    /// The parameters of its set, one column each.
    #[serde(flatten)]
    pub parameters: Map<String, Value>,
    /// The outcome.
    pub outcome: RowOutcome,
    /// The reason of a failure; `None` for a success.
    pub reason: Option<String>,
    /// Keys of the summary with numbers, null without one, and with the lengths of lists; one column each.
    #[serde(flatten)]
    pub results: Map<String, Value>,
    /// Wall time of the solve, s.
    pub solve_seconds: f64,
}

/// The keys of the summary that all methods have and that are columns of the results.
const COMMON: [&str; 5] =
    ["final_error_inf", "open_loop_error_inf", "control_effort", "dynamics_defect", "smallest_clearance_m"];

/// Those of one method.
fn results_of(method: Method) -> &'static [&'static str] {
    match method {
        Method::Direct => &[
            "cost",
            "horizon_s",
            "gradient_norm",
            "largest_violation",
            "starts_tried",
            "minima",
            "iterations",
            "factorisations",
        ],
        Method::Flow => &["action", "steps", "omega_evaluations", "jacobian_evaluations"],
        Method::Rest | Method::Duals | Method::TwoPhases => &[
            "action",
            "gradient_norm",
            "slip",
            "largest_violation",
            "starts_tried",
            "steps",
            "factorisations",
            "dual_updates",
        ],
    }
}

impl Sweep {
    /// The names of the columns of results: keys of the summary that are no parameters.
    pub(super) fn results(&self) -> impl Iterator<Item = &'static str> {
        let parameters = self.file.grid.parameters();
        let all = COMMON.iter().chain(results_of(self.method())).copied();
        all.filter(move |name| parameters.iter().all(|p| p.name != *name))
    }
}

impl Row {
    /// The row of `set` in a line of the file.
    ///
    /// # Errors
    /// The line is not of this set, or a cell does not have the type of its column.
    pub(super) fn read(sweep: &Sweep, set: &ParameterSet, line: &StringRecord) -> std::result::Result<Self, String> {
        let mut row = Self::failed(sweep, set, "", 0.0);
        let mut cells = line.iter().skip(1);
        let mut next = || cells.next().unwrap_or_default();
        let own = row.parameters.values().map(csv_cell);
        let own: Vec<String> = own.collect();
        if next() != row.scenario || own.iter().any(|own| next() != own) {
            return Err(format!("its set {} is not one of this sweep", set.index));
        }
        let outcome = next();
        let known = RowOutcome::ALL.into_iter().find(|o| o.name() == outcome);
        row.outcome = known.ok_or_else(|| format!("'{outcome}' is no outcome"))?;
        row.reason = Some(next().to_owned()).filter(|reason| !reason.is_empty());
        for (name, value) in &mut row.results {
            let cell = next();
            if !cell.is_empty() {
                let number = cell.parse::<Number>();
                *value = number.map_err(|e| format!("{name}: '{cell}': {e}"))?.into();
            }
        }
        let seconds = next();
        let wrong = |e| format!("solve_seconds: '{seconds}': {e}");
        row.solve_seconds = seconds.parse().map_err(wrong)?;
        Ok(row)
    }

    /// The row of a set that failed for this reason before any measurement.
    #[must_use]
    pub fn failed(sweep: &Sweep, set: &ParameterSet, reason: &str, solve_seconds: f64) -> Self {
        Self {
            set: set.index,
            scenario: sweep.problems[set.problem].name.clone(),
            parameters: sweep.parameters(set),
            outcome: RowOutcome::Failed,
            reason: Some(one_line(reason)),
            results: sweep.results().map(|name| (name.to_owned(), Value::Null)).collect(),
            solve_seconds,
        }
    }

    /// The row of a set that was refused for this reason.
    pub(super) fn refused(sweep: &Sweep, set: &ParameterSet, reason: &str, solve_seconds: f64) -> Self {
        Self { outcome: RowOutcome::Refused, ..Self::failed(sweep, set, reason, solve_seconds) }
    }

    /// The row of a set that reached its time limit.
    pub(super) fn late(sweep: &Sweep, set: &ParameterSet, solve_seconds: f64) -> Self {
        let limit = sweep.file.head.time_limit_s;
        let reason = format!("time limit of {limit} s reached");
        Self { outcome: RowOutcome::TimeLimit, ..Self::failed(sweep, set, &reason, solve_seconds) }
    }

    /// The row of a solved set.
    #[must_use]
    pub fn new(sweep: &Sweep, set: &ParameterSet, report: &SolveReport) -> Self {
        let s = &report.summary;
        // Only the clock shows an interruption at the very end. A motion that is kept has its own row.
        let is_late = report.stopped.is_some() || s.solve_seconds >= sweep.file.head.time_limit_s;
        if is_late && sweep.motions.is_none() {
            return Self::late(sweep, set, s.solve_seconds);
        }
        let direct = s.method == Method::Direct;
        let violated = direct && !s.feasibility.holds(DirectSettings::FEASIBLE);
        let mut row = Self::failed(sweep, set, "", s.solve_seconds);
        row.reason = s.failure.as_deref().map(one_line);
        row.outcome = if s.success {
            RowOutcome::Success
        } else if violated {
            RowOutcome::Infeasible
        } else if !report.completed {
            RowOutcome::Failed
        } else if s.final_error_inf.is_some_and(|e| e < s.success_threshold) {
            RowOutcome::Infeasible
        } else {
            RowOutcome::GoalMissed
        };
        let summary = serde_json::to_value(s).unwrap_or_default();
        for (name, value) in &mut row.results {
            *value = match &summary[&**name] {
                Value::Array(list) => list.len().into(),
                other => other.clone(),
            };
        }
        row
    }

    /// The number of a result; `None` without one.
    #[must_use]
    pub fn result(&self, name: &str) -> Option<f64> {
        self.results.get(name)?.as_f64()
    }

    /// Returns true if another run gave the same results, apart from the time.
    #[must_use]
    pub fn agrees(&self, other: &Self) -> bool {
        let solve_seconds = self.solve_seconds;
        let other = Self { solve_seconds, ..other.clone() };
        *self == other
    }
}
