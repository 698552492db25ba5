//! The solves of a benchmark.

use super::Problem;
use crate::output::{ResultsFile, line_error, one_line, verdict};
use crate::sweep::caught;
use aghf::error::Result;
use aghf::motion::sample;
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge, sufficient_samples};
use aghf_scenario::{DirectOptions, Solve, Verdict};
use serde::{Deserialize, Serialize};
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
    /// The problem was not solved: its files are faulty, or no end of the motion was found.
    Refused,
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
    pub control_effort: Option<f64>,
    /// The duration of the motion, s.
    pub duration_s: Option<f64>,
    /// The least clearance from obstacles and between links, as proved by the judge, m.
    pub least_clearance_m: Option<f64>,
    /// The reason why the motion is not valid.
    pub reason: String,
}

impl Row {
    /// The row of a problem that is not solved yet.
    fn new(problem: &Problem) -> Self {
        Self {
            family: problem.family.clone(),
            problem: problem.name.clone(),
            end: End::Refused,
            solve_seconds: 0.0,
            control_effort: None,
            duration_s: None,
            least_clearance_m: None,
            reason: String::new(),
        }
    }
}

/// Solves and judges the problems, at least one, that have no line in the file at `path` yet, and appends their lines;
/// returns all lines, in the order of the problems. `observe` is called after each. A problem that is refused has a
/// line like any other.
///
/// # Errors
/// The file cannot be read or written.
pub fn run(problems: &[Problem], path: &Path, observe: &mut dyn FnMut(&Row)) -> Result<Vec<Row>> {
    let (mut file, lines) = ResultsFile::open(path, &Row::new(&problems[0]))?;
    let lines = lines.iter().enumerate();
    let known = lines.map(|(i, line)| line.deserialize::<Row>(None).map_err(|e| line_error(path, i, e)));
    let mut known = known.collect::<Result<Vec<_>>>()?;
    let mut rows = Vec::new();
    for problem in problems {
        let before = known.iter().position(|row| row.problem == problem.name);
        if let Some(before) = before {
            rows.push(known.swap_remove(before));
            continue;
        }
        let mut row = Row::new(problem);
        let refused = match caught(|| solve(problem, &mut row)) {
            Ok(solved) => solved.err().map(|error| error.to_string()),
            Err(panic) => Some(panic),
        };
        if let Some(reason) = refused {
            row = Row { reason: one_line(&reason), ..Row::new(problem) };
        }
        file.append(&row)?;
        observe(&row);
        rows.push(row);
    }
    Ok(rows)
}

/// Solves a problem and judges the motion.
fn solve(problem: &Problem, row: &mut Row) -> Result<()> {
    let scenario = problem.load()?;
    if let Err(error) = scenario.check_feasible() {
        (row.end, row.reason) = (End::Impossible, one_line(&error.to_string()));
        return Ok(());
    }
    // As `aghf solve` without options, on one thread.
    let options = DirectOptions { threads: Some(1), ..DirectOptions::default() };
    let report = Solve::new(&scenario).options(options).run()?;
    let summary = &report.summary;
    row.solve_seconds = summary.solve_seconds;
    (row.control_effort, row.duration_s) = (Some(summary.control_effort), Some(report.curve.horizon()));
    if let Some(failure) = &summary.failure {
        (row.end, row.reason) = (End::NotValid, one_line(failure));
        return Ok(());
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
            row.reason = one_line(&verdict(&judgement));
            End::NotValid
        }
        (true, Verdict::Optimal) => End::Optimal,
        _ => End::Valid,
    };
    Ok(())
}
