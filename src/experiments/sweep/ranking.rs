//! Which parameters are best, for each scenario of a sweep and for all of them.

use super::{Row, RowOutcome, Sweep};
use crate::error::Result;
use crate::motion::Guess;
use crate::output::{short, table, write_whole};
use comfy_table::CellAlignment;
use serde::Serialize;
use std::path::Path;

/// The results of one set of parameters in one scenario, or in all: means, largest errors and the smallest clearance are over the solves
/// that succeeded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// The scenario, or `all`.
    pub scenario: String,
    /// Degree of the polynomial.
    pub p: usize,
    /// Penalty of (11).
    pub k: f64,
    /// The `s` to which the flow runs.
    pub s_max: f64,
    /// The curve to start from.
    pub guess: Guess,
    /// Weight (A2) of the constraints, if it was set.
    pub k_cons: Option<f64>,
    /// Sharpness (A3) of the constraints, if it was set.
    pub c_cons: Option<f64>,
    /// The number of solves.
    pub solves: usize,
    /// The part of them that succeeded.
    pub success_rate: f64,
    /// Mean wall time of a solve.
    pub solve_seconds: Option<f64>,
    /// Mean control effort.
    pub control_effort: Option<f64>,
    /// Mean action.
    pub action: Option<f64>,
    /// Largest final error with feedback.
    pub final_error_inf: Option<f64>,
    /// Largest final error without.
    pub open_loop_error_inf: Option<f64>,
    /// Smallest clearance in m, where there are obstacles.
    pub smallest_clearance_m: Option<f64>,
}

/// The parameters of a sweep, best first, for all scenarios if there are several and then for each: those with the highest
/// rate of success come first, and among these the fastest, as in the paper. `rows` are those of all sets, in order.
#[must_use]
pub fn ranking(sweep: &Sweep, rows: &[Row]) -> Vec<Ranked> {
    let points = sweep.sets_a_scenario();
    let scenarios: Vec<&[Row]> = rows.chunks(points).collect();
    let mut ranking = Vec::new();
    if scenarios.len() > 1 {
        ranking.extend(ranked("all", &scenarios));
    }
    for (scenario, rows) in sweep.scenarios.iter().zip(&scenarios) {
        ranking.extend(ranked(&scenario.name, &[rows]));
    }
    ranking
}

/// The same for those scenarios of a sweep whose names begin with `prefix`, taken together. `rows` are those of all their sets, and
/// may be those of others, in order.
#[must_use]
pub fn ranking_of(sweep: &Sweep, rows: &[Row], prefix: &str) -> Vec<Ranked> {
    let chosen = rows.iter().filter(|row| row.scenario.starts_with(prefix));
    let rows: Vec<Row> = chosen.cloned().collect();
    let scenarios: Vec<&[Row]> = rows.chunks(sweep.sets_a_scenario()).collect();
    ranked(prefix, &scenarios)
}

/// The fastest set among those with the highest rate of success in a ranking of one group of scenarios, and the one of least
/// effort; `None` where no set succeeds.
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

/// The ranking over scenarios whose rows are in the same order.
fn ranked(name: &str, scenarios: &[&[Row]]) -> Vec<Ranked> {
    let points = scenarios.first().map_or(0, |rows| rows.len());
    let mut ranked: Vec<Ranked> = (0..points)
        .map(|i| {
            summarise(
                name,
                &scenarios.iter().map(|rows| &rows[i]).collect::<Vec<_>>(),
            )
        })
        .collect();
    let time = |r: &Ranked| r.solve_seconds.unwrap_or(f64::INFINITY);
    ranked.sort_by(|a, b| {
        (b.success_rate.total_cmp(&a.success_rate)).then(time(a).total_cmp(&time(b)))
    });
    ranked
}

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
    let p = rows[0].parameters();
    Ranked {
        scenario: scenario.to_owned(),
        p: p.p,
        k: p.k,
        s_max: p.s_max,
        guess: p.guess,
        k_cons: p.k_cons,
        c_cons: p.c_cons,
        solves: rows.len(),
        success_rate: good.len() as f64 / rows.len() as f64,
        solve_seconds: mean(|row| Some(row.solve_seconds)),
        control_effort: mean(|row| row.control_effort),
        action: mean(|row| row.action),
        final_error_inf: largest(|row| row.final_error_inf),
        open_loop_error_inf: largest(|row| row.open_loop_error_inf),
        smallest_clearance_m: largest(|row| row.smallest_clearance_m.map(|m| -m)).map(|m| -m),
    }
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

/// For all scenarios and for each: the fastest parameters among those with the highest rate of success, and those of least
/// effort.
#[must_use]
pub fn ranking_table(ranking: &[Ranked]) -> String {
    let mut table = table();
    table.set_header([
        "scenario",
        "best by",
        "success",
        "p",
        "k",
        "s_max",
        "guess",
        "k_cons",
        "c_cons",
        "solve, ms",
        "effort",
        "action",
        "final error",
        "open loop",
        "clearance, m",
    ]);
    for group in ranking.chunk_by(|a, b| a.scenario == b.scenario) {
        let Some(best) = best(group) else {
            table.add_row([&group[0].scenario, "no set succeeds"]);
            continue;
        };
        for (by, r) in ["time", "effort"].into_iter().zip(best) {
            let optional = |x: Option<f64>, form: fn(f64) -> String| x.map_or("-".to_owned(), form);
            let exponent = |x: f64| format!("{x:e}");
            table.add_row([
                r.scenario.clone(),
                by.to_owned(),
                format!("{:.0} %", 100.0 * r.success_rate),
                r.p.to_string(),
                exponent(r.k),
                exponent(r.s_max),
                r.guess.to_string(),
                optional(r.k_cons, exponent),
                optional(r.c_cons, exponent),
                optional(r.solve_seconds.map(|s| 1e3 * s), |ms| format!("{ms:.2}")),
                optional(r.control_effort, short),
                optional(r.action, short),
                optional(r.final_error_inf, short),
                optional(r.open_loop_error_inf, short),
                optional(r.smallest_clearance_m, short),
            ]);
        }
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}
