//! Rankings of the parameters, for each scenario of a sweep and for all of them.

use super::grid::Parameters;
use super::row::{SOME_COLUMNS, minimised};
use super::{Row, RowOutcome, Sweep};
use crate::output::{short, table, write_whole};
use aghf::error::Result;
use comfy_table::CellAlignment;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use std::path::Path;

/// The results of one set of parameters in one scenario, or in all. Means, medians, largest errors and the smallest
/// clearance are over the successful solves. The columns of the file are in its order.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranked {
    /// The scenario, or `all`.
    pub scenario: String,
    /// The parameters, one column each; for the relaxation those of all seeds together.
    pub parameters: Parameters,
    /// The number of solves.
    pub solves: usize,
    /// The fraction of solves that succeeded.
    pub success_rate: f64,
    /// Mean wall time of a solve, s.
    pub solve_seconds: Option<f64>,
    /// Median wall time of a solve, s.
    pub median_seconds: Option<f64>,
    /// Mean control effort.
    pub control_effort: Option<f64>,
    /// Mean of the minimised quantity: the column `action` of the flow, `cost` of the relaxation.
    pub minimised: Option<f64>,
    /// Largest final error with feedback.
    pub final_error_inf: Option<f64>,
    /// Largest final error without feedback.
    pub open_loop_error_inf: Option<f64>,
    /// Smallest clearance in m; `None` without obstacles.
    pub smallest_clearance_m: Option<f64>,
}

impl Serialize for Ranked {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("Ranked", SOME_COLUMNS)?;
        row.serialize_field("scenario", &self.scenario)?;
        self.parameters.columns(&mut row)?;
        row.serialize_field("solves", &self.solves)?;
        row.serialize_field("success_rate", &self.success_rate)?;
        row.serialize_field("solve_seconds", &self.solve_seconds)?;
        row.serialize_field("median_seconds", &self.median_seconds)?;
        row.serialize_field("control_effort", &self.control_effort)?;
        row.serialize_field(minimised(&self.parameters), &self.minimised)?;
        row.serialize_field("final_error_inf", &self.final_error_inf)?;
        row.serialize_field("open_loop_error_inf", &self.open_loop_error_inf)?;
        row.serialize_field("smallest_clearance_m", &self.smallest_clearance_m)?;
        row.end()
    }
}

impl Ranked {
    /// The time for the ranking, s: the mean for the flow, as in the paper; the median for the relaxation, because a
    /// single solve that needs many more starts than the others would dominate the mean.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let time = match self.parameters {
            Parameters::Flow(_) => self.solve_seconds,
            Parameters::Relax(_) => self.median_seconds,
        };
        time.unwrap_or(f64::INFINITY)
    }
}

/// Ranks the parameters of a sweep, best first, for all scenarios if there are several and then for each: those with
/// the highest rate of success come first, and among these the [fastest](Ranked::seconds). `rows` are those of all
/// sets, in order.
#[must_use]
pub fn ranking(sweep: &Sweep, rows: &[Row]) -> Vec<Ranked> {
    let scenarios: Vec<&[Row]> = rows.chunks(sweep.sets_a_scenario()).collect();
    let mut ranking = Vec::new();
    if scenarios.len() > 1 {
        ranking.extend(ranked("all", sweep, rows));
    }
    for (scenario, rows) in sweep.scenarios.iter().zip(scenarios) {
        ranking.extend(ranked(&scenario.name, sweep, rows));
    }
    ranking
}

/// The fastest set among those with the highest rate of success in a ranking of one group of scenarios, and the one of
/// least effort; `None` if no set succeeds.
#[must_use]
pub fn best(ranking: &[Ranked]) -> Option<[&Ranked; 2]> {
    let fastest = ranking.first().filter(|r| r.success_rate > 0.0)?;
    let effort = |r: &&Ranked| r.control_effort.unwrap_or(f64::INFINITY);
    let least = (ranking
        .iter()
        .filter(|r| r.success_rate == fastest.success_rate))
    .min_by(|a, b| effort(a).total_cmp(&effort(b)))?;
    Some([fastest, least])
}

/// The ranking over complete scenarios, by their rows in order.
fn ranked(name: &str, sweep: &Sweep, rows: &[Row]) -> Vec<Ranked> {
    // Seeds run slowest, so each is like one more scenario.
    let points = sweep.sets_a_scenario() / sweep.file.grid.repetitions();
    let mut ranked: Vec<Ranked> = (0..points.min(rows.len()))
        .map(|i| summarise(name, &rows[i..].iter().step_by(points).collect::<Vec<_>>()))
        .collect();
    ranked.sort_by(|a, b| {
        let by_success = b.success_rate.total_cmp(&a.success_rate);
        by_success.then(a.seconds().total_cmp(&b.seconds()))
    });
    ranked
}

/// Summarises the rows of one set of parameters, at least one.
fn summarise(scenario: &str, rows: &[&Row]) -> Ranked {
    let good: Vec<&Row> = (rows.iter().copied())
        .filter(|row| row.outcome == RowOutcome::Success)
        .collect();
    let mean = |f: fn(&Row) -> Option<f64>| {
        let sum: Option<f64> = good.iter().map(|row| f(row)).sum();
        sum.filter(|_| !good.is_empty())
            .map(|sum| sum / good.len() as f64)
    };
    let largest =
        |f: fn(&Row) -> Option<f64>| good.iter().filter_map(|row| f(row)).max_by(f64::total_cmp);
    Ranked {
        scenario: scenario.to_owned(),
        parameters: rows[0].parameters.of_any_seed(),
        solves: rows.len(),
        success_rate: good.len() as f64 / rows.len() as f64,
        solve_seconds: mean(|row| Some(row.solve_seconds)),
        median_seconds: median(good.iter().map(|row| row.solve_seconds).collect()),
        control_effort: mean(|row| row.control_effort),
        minimised: mean(|row| row.minimised),
        final_error_inf: largest(|row| row.final_error_inf),
        open_loop_error_inf: largest(|row| row.open_loop_error_inf),
        smallest_clearance_m: largest(|row| row.smallest_clearance_m.map(|m| -m)).map(|m| -m),
    }
}

/// The median; `None` without values.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let (lower, upper) = (values.len().checked_sub(1)? / 2, values.len() / 2);
    Some(0.5 * (values[lower] + values[upper]))
}

/// Writes a ranking as CSV.
///
/// # Errors
/// The file cannot be written.
pub fn write_ranking(ranking: &[Ranked], path: &Path) -> Result<()> {
    write_whole(path, |file| {
        let mut csv = csv::Writer::from_writer(file);
        for ranked in ranking {
            csv.serialize(ranked)?;
        }
        csv.flush()
    })
}

/// Formats, for all scenarios and for each, the fastest parameters among those with the highest rate of success, and
/// those of least effort.
#[must_use]
pub fn ranking_table(ranking: &[Ranked]) -> String {
    let mut table = table();
    let Some(first) = ranking.first() else {
        return table.to_string();
    };
    let parameters = first.parameters.cells();
    let mut header = vec!["scenario", "best by", "success"];
    header.extend(parameters.iter().map(|(name, _)| *name));
    header.extend(["mean, ms", "median, ms", "effort"]);
    header.extend([minimised(&first.parameters), "final error", "open loop"]);
    header.push("clearance, m");
    table.set_header(header);
    for group in ranking.chunk_by(|a, b| a.scenario == b.scenario) {
        let Some(best) = best(group) else {
            table.add_row([&group[0].scenario, "no set succeeds"]);
            continue;
        };
        for (by, r) in ["time", "effort"].into_iter().zip(best) {
            let optional = |x: Option<f64>| x.map_or("-".to_owned(), short);
            let time = |x: Option<f64>| x.map_or("-".to_owned(), |s| format!("{:.2}", 1e3 * s));
            let success = format!("{:.0} %", 100.0 * r.success_rate);
            let mut row = vec![r.scenario.clone(), by.to_owned(), success];
            row.extend(r.parameters.cells().into_iter().map(|(_, value)| value));
            row.extend([r.solve_seconds, r.median_seconds].map(time));
            row.extend([r.control_effort, r.minimised].map(optional));
            row.extend([r.final_error_inf, r.open_loop_error_inf].map(optional));
            row.push(optional(r.smallest_clearance_m));
            table.add_row(row);
        }
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}
