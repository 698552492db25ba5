//! Rankings of the parameters, for each scenario of a sweep and for all of them.

use super::grid::{Grid, in_table};
use super::{Row, RowOutcome, Sweep};
use crate::output::{csv_of, short, table, write_whole};
use aghf::error::Result;
use aghf_scenario::Method;
use comfy_table::CellAlignment;
use serde::Serialize;
use serde_json::{Map, Value};
use std::io::Write;
use std::path::Path;

/// The results of one set of parameters in one scenario, or in all. Times and results are over the successful solves.
/// The columns of the file are in its order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// The scenario, or `all`.
    pub scenario: String,
    /// The parameters, one column each; those of all seeds together.
    #[serde(flatten)]
    pub parameters: Map<String, Value>,
    /// The number of solves.
    pub solves: usize,
    /// The fraction of solves that succeeded.
    pub success_rate: f64,
    /// Mean wall time of a solve, s.
    pub solve_seconds: Option<f64>,
    /// Median wall time of a solve, s.
    pub median_seconds: Option<f64>,
    /// The time for the ranking, s, infinite without a success: the mean for a flow, as in the paper; the median for
    /// the direct method, because a single solve that needs many more starts than the others would dominate the mean.
    #[serde(skip)]
    pub seconds: f64,
    /// The mean of efforts, costs and actions, the largest error and the smallest clearance, one column each.
    #[serde(flatten)]
    pub results: Map<String, Value>,
}

impl Ranked {
    /// The number of a result; `None` without one.
    #[must_use]
    pub fn result(&self, name: &str) -> Option<f64> {
        self.results.get(name)?.as_f64()
    }
}

/// A number of several, at least one.
type Statistic = fn(&[f64]) -> f64;

/// The results that are ranked, with their headings in the table.
const RANKED: [(&str, &str, Statistic); 6] = [
    ("control_effort", "effort", mean),
    ("cost", "cost", mean),
    ("action", "action", mean),
    ("final_error_inf", "final error", largest),
    ("open_loop_error_inf", "open loop", largest),
    ("smallest_clearance_m", "clearance, m", smallest),
];

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn smallest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Ranks the parameters of a sweep, best first, for all scenarios if there are several and then for each: those with
/// the highest rate of success come first, and among these the [fastest](field@Ranked::seconds). `rows` are those of
/// all sets, in order.
#[must_use]
pub fn ranking(sweep: &Sweep, rows: &[Row]) -> Vec<Ranked> {
    let scenarios: Vec<&[Row]> = rows.chunks(sweep.sets_a_scenario()).collect();
    let mut ranking = Vec::new();
    if scenarios.len() > 1 {
        ranking.extend(ranked("all", sweep, rows));
    }
    for (problem, rows) in sweep.problems.iter().zip(scenarios) {
        ranking.extend(ranked(&problem.name, sweep, rows));
    }
    ranking
}

/// The fastest set among those with the highest rate of success in a ranking of one group of scenarios, and the one of
/// least effort; `None` if no set succeeds.
#[must_use]
pub fn best(ranking: &[Ranked]) -> Option<[&Ranked; 2]> {
    let fastest = ranking.first().filter(|r| r.success_rate > 0.0)?;
    let effort = |r: &&Ranked| r.result("control_effort").unwrap_or(f64::INFINITY);
    let least = (ranking.iter().filter(|r| r.success_rate == fastest.success_rate))
        .min_by(|a, b| effort(a).total_cmp(&effort(b)))?;
    Some([fastest, least])
}

/// The ranking over complete scenarios, by their rows in order.
fn ranked(name: &str, sweep: &Sweep, rows: &[Row]) -> Vec<Ranked> {
    // Seeds vary slowest, so each is like one more scenario.
    let points = sweep.sets_a_scenario() / sweep.file.grid.repetitions();
    let mut ranked: Vec<Ranked> = (0..points.min(rows.len()))
        .map(|i| {
            let rows: Vec<_> = rows[i..].iter().step_by(points).collect();
            summarise(name, sweep.method(), &rows)
        })
        .collect();
    ranked.sort_by(|a, b| {
        let by_success = b.success_rate.total_cmp(&a.success_rate);
        by_success.then(a.seconds.total_cmp(&b.seconds))
    });
    ranked
}

/// Summarises the rows of one set of parameters, at least one.
fn summarise(scenario: &str, method: Method, rows: &[&Row]) -> Ranked {
    let good: Vec<&Row> = (rows.iter().copied()).filter(|row| row.outcome == RowOutcome::Success).collect();
    let times: Vec<f64> = good.iter().map(|row| row.solve_seconds).collect();
    let solve_seconds = (!times.is_empty()).then(|| mean(&times));
    let median_seconds = median(times);
    let time = match method {
        Method::Direct => median_seconds,
        Method::Flow | Method::Rest | Method::Duals | Method::TwoPhases => solve_seconds,
    };
    let mut results = Map::new();
    for (name, _, statistic) in RANKED {
        if rows[0].results.contains_key(name) {
            let values: Vec<f64> = good.iter().filter_map(|row| row.result(name)).collect();
            let value = (!values.is_empty()).then(|| statistic(&values));
            results.insert(name.to_owned(), value.into());
        }
    }
    let mut parameters = rows[0].parameters.clone();
    parameters.shift_remove(Grid::SEED);
    Ranked {
        scenario: scenario.to_owned(),
        parameters,
        solves: rows.len(),
        success_rate: good.len() as f64 / rows.len() as f64,
        solve_seconds,
        median_seconds,
        seconds: time.unwrap_or(f64::INFINITY),
        results,
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
    let text = csv_of(ranking, true)?;
    write_whole(path, |file| file.write_all(&text))
}

/// Formats, for all scenarios and for each, the fastest parameters among those with the highest rate of success, and
/// those of least effort.
#[must_use]
pub fn ranking_table(ranking: &[Ranked]) -> String {
    let mut table = table();
    let Some(first) = ranking.first() else {
        return table.to_string();
    };
    let mut header = vec!["scenario", "best by", "success"];
    header.extend(first.parameters.keys().map(String::as_str));
    header.extend(["mean, ms", "median, ms"]);
    let ranked = RANKED.iter().filter(|(name, ..)| first.results.contains_key(*name));
    header.extend(ranked.map(|(_, heading, _)| *heading));
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
            row.extend(r.parameters.values().map(in_table));
            row.extend([r.solve_seconds, r.median_seconds].map(time));
            row.extend(r.results.values().map(|value| optional(value.as_f64())));
            table.add_row(row);
        }
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}
