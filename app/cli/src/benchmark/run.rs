//! The solves of a benchmark.

use super::Problem;
use crate::output::verdict;
use aghf::error::{Error, Result};
use aghf::motion::sample;
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge, sufficient_samples};
use aghf_scenario::{DirectOptions, Solve, Verdict};
use serde::{Deserialize, Serialize};
use std::fs::OpenOptions;
use std::path::Path;

/// The outcome of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The motion is valid and a minimum to within the tolerance.
    Optimal,
    /// The judge accepts the motion.
    Valid,
    /// No motion was found, or the judge does not accept it.
    NotValid,
    /// The problem is known to be infeasible.
    Impossible,
}

impl End {
    /// True if there is a valid motion.
    #[must_use]
    pub fn is_valid(self) -> bool {
        matches!(self, Self::Optimal | Self::Valid)
    }
}

/// The result of a problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The family.
    pub family: String,
    /// The problem.
    pub problem: String,
    /// The outcome.
    pub end: End,
    /// The time of the search on one core, s.
    pub solve_seconds: f64,
    /// The control effort of the motion, N^2 m^2 s.
    pub control_effort: f64,
    /// The duration of the motion, s.
    pub duration_s: f64,
    /// The least clearance from obstacles and between links, as proved by the judge, m.
    pub least_clearance_m: Option<f64>,
    /// The reason why the motion is not valid.
    pub reason: String,
}

/// Solves and judges the problems that have no line in the file at `path` yet, and appends their lines; returns all
/// lines, in the order of the problems. `observe` is called after each.
///
/// # Errors
/// A problem cannot be read, or the file cannot be read or written.
pub fn run(problems: &[Problem], path: &Path, observe: &mut dyn FnMut(&Row)) -> Result<Vec<Row>> {
    let mut known = if path.exists() { read(path)? } else { Vec::new() };
    let file = OpenOptions::new().create(true).append(true).open(path);
    let file = file.map_err(|error| Error::io(path, error))?;
    let mut writer = csv::WriterBuilder::new().has_headers(known.is_empty()).from_writer(file);
    let mut rows = Vec::new();
    for problem in problems {
        let before = known.iter().position(|row| row.problem == problem.name);
        if let Some(before) = before {
            rows.push(known.swap_remove(before));
            continue;
        }
        let row = solve(problem)?;
        writer.serialize(&row).map_err(|error| Error::io(path, error.into()))?;
        writer.flush().map_err(|error| Error::io(path, error))?;
        observe(&row);
        rows.push(row);
    }
    Ok(rows)
}

/// The lines of a file.
fn read(path: &Path) -> Result<Vec<Row>> {
    let file = path.display().to_string();
    let reader = csv::Reader::from_path(path);
    let mut reader = reader.map_err(|error| Error::io(path, error.into()))?;
    let rows = reader.deserialize().enumerate();
    rows.map(|(line, row)| row.map_err(|error| Error::input(&file, format!("line {}", line + 2), error.to_string())))
        .collect()
}

/// Solves a problem and judges the motion.
fn solve(problem: &Problem) -> Result<Row> {
    let scenario = problem.load()?;
    let mut row = Row {
        family: problem.family.clone(),
        problem: problem.name.clone(),
        end: End::Impossible,
        solve_seconds: 0.0,
        control_effort: f64::NAN,
        duration_s: f64::NAN,
        least_clearance_m: None,
        reason: String::new(),
    };
    if let Err(error) = scenario.check_feasible() {
        row.reason = error.to_string();
        return Ok(row);
    }
    // As `aghf solve` without options, on one thread.
    let options = DirectOptions { threads: Some(1), ..DirectOptions::default() };
    let report = Solve::new(&scenario).options(options).run()?;
    let summary = &report.summary;
    row.solve_seconds = summary.solve_seconds;
    (row.control_effort, row.duration_s) = (summary.control_effort, report.curve.horizon());
    if let Some(failure) = &summary.failure {
        row.end = End::NotValid;
        row.reason.clone_from(failure);
        return Ok(row);
    }
    // The same table as that of `aghf solve`.
    let (model, curve) = (&scenario.model, &report.curve);
    let intervals = sufficient_samples(&scenario, curve)? - 1;
    let trajectory = Trajectory::of_samples(sample(model, curve, intervals)?);
    let judgement = judge(&scenario, &trajectory, Tolerances::default())?;
    let of_clearance = judgement.checks.iter().filter_map(|row| {
        let clearance = matches!(row.check, Check::Bounds(of) if of.is_clearance());
        clearance.then_some(row.proved_at_least).flatten()
    });
    row.least_clearance_m = of_clearance.reduce(f64::min);
    row.end = match (judgement.valid, summary.verdict) {
        (false, _) => {
            row.reason = verdict(&judgement);
            End::NotValid
        }
        (true, Verdict::Optimal) => End::Optimal,
        _ => End::Valid,
    };
    Ok(row)
}
