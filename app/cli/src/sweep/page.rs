//! The page of a sweep.

use super::grid::in_table;
use super::{Ranked, Row, RowOutcome, Sweep};
use crate::output::short;
use crate::report::{Bar, Group, Part, Plot, Scatter, Table, TablePage};
use aghf::error::Result;
use std::collections::HashMap;

/// The largest number of bars of a plot.
const MAX_BARS: usize = 60;
/// The colours of the outcomes: no green for a failure.
const OUTCOME_COLOURS: [usize; RowOutcome::ALL.len()] = [0, 1, 3, 4, 7, 6];

/// Builds the page of a sweep from the rows of all sets: efforts against times, rates of success by parameter, and the
/// tables of `ranking.csv` and `results.csv`.
///
/// # Errors
/// The rows cannot be written as text.
pub fn sweep_page(sweep: &Sweep, rows: &[Row], ranking: &[Ranked]) -> Result<TablePage> {
    let good = rows.iter().filter(|row| succeeds(row)).count();
    let seconds: f64 = rows.iter().map(|row| row.solve_seconds).sum();
    let figures = [
        ("sets", rows.len().to_string()),
        ("solved", good.to_string()),
        ("scenarios", sweep.problems.len().to_string()),
        ("time of all solves", format!("{} s", short(seconds))),
    ];
    let plots = vec![Plot::Scatter(efforts(rows))];
    let shares = shares(rows);
    let mut parts = vec![Part::Plots { title: "Effort against time".to_owned(), plots }];
    if !shares.is_empty() {
        parts.push(Part::Plots { title: "Success by parameter".to_owned(), plots: shares });
    }
    parts.push(Part::Table(Table::of_rows(
        "Ranking: the highest rate of success first, then the least time",
        "ranking.csv",
        ranking,
        |ranked| ranked.success_rate == 0.0,
    )?));
    parts.push(Part::Table(Table::of_rows("Results of all sets", "results.csv", rows, |row| !succeeds(row))?));
    Ok(TablePage {
        title: sweep.name.clone(),
        about: format!("sweep of the method {}", sweep.method()),
        figures: figures.map(|(name, value)| [name.to_owned(), value]).into(),
        parts,
    })
}

fn succeeds(row: &Row) -> bool {
    row.outcome == RowOutcome::Success
}

/// One point per set that led to a motion, in the colour of its outcome.
fn efforts(rows: &[Row]) -> Scatter {
    let point = |row: &Row| {
        let effort = row.result("control_effort")?;
        let time = 1e3 * row.solve_seconds;
        let mut name = format!("set {}: {}\n", row.set, row.scenario);
        let cells = row.parameters.iter();
        let given = cells.map(|(key, value)| format!("{key} {}", in_table(value)));
        let given: Vec<String> = given.collect();
        name += &given.join(", ");
        name += &format!("\neffort {}, {time:.1} ms", short(effort));
        if let Some(reason) = &row.reason {
            name += &format!("\n{reason}");
        }
        Some((time, effort, name))
    };
    let groups = RowOutcome::ALL.iter().zip(OUTCOME_COLOURS).map(|(outcome, colour)| {
        let own = rows.iter().filter(|row| row.outcome == *outcome);
        let failed = *outcome != RowOutcome::Success;
        Group::new(outcome.name().to_owned(), colour, failed, own.filter_map(point).collect())
    });
    let without = rows.iter().filter(|row| row.result("control_effort").is_none()).count();
    let note = match without {
        0 => String::new(),
        _ => format!(" that led to a motion ({without} did not)"),
    };
    Scatter {
        title: format!("A point for each set{note}"),
        x: "time of the solve, ms".to_owned(),
        y: "effort, ∫|u|² dt".to_owned(),
        groups: groups.filter(|group| !group.is_empty()).collect(),
    }
}

/// The rate of success by scenario and by the value of each parameter that has several, except those with very many.
fn shares(rows: &[Row]) -> Vec<Plot> {
    let cells: Vec<Vec<(&str, String)>> = rows
        .iter()
        .map(|row| {
            let cells = row.parameters.iter();
            let cells = cells.map(|(name, value)| (name.as_str(), in_table(value)));
            cells.chain([("scenario", row.scenario.clone())]).collect()
        })
        .collect();
    let parameters = cells.first().map_or(0, Vec::len);
    let plots = (0..parameters).filter_map(|i| {
        let mut bars: Vec<Bar> = Vec::new();
        let mut places = HashMap::new();
        for (row, cells) in rows.iter().zip(&cells) {
            let (_, value) = &cells[i];
            let at = *places.entry(value).or_insert_with(|| {
                bars.push(Bar { name: value.clone(), good: 0, all: 0 });
                bars.len() - 1
            });
            bars[at].all += 1;
            bars[at].good += usize::from(succeeds(row));
        }
        let title = cells.first()?[i].0.to_owned();
        (2..=MAX_BARS).contains(&bars.len()).then_some(Plot::Bars { title, bars })
    });
    plots.collect()
}
