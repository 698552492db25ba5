//! The table of a trade-off between duration and effort.

use super::{OutputFolder, csv_of, short, table, write_json, write_whole};
use aghf::error::Result;
use aghf_scenario::{Details, Scenario, SolveReport, Verdict};
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;

/// A motion of a trade-off in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TradeoffRow {
    /// The number of the motion, from 1, by duration.
    pub motion: usize,
    /// Its duration, s.
    pub duration_s: f64,
    /// Its control effort, $\int |u|^2 dt$.
    pub control_effort: f64,
    /// The verdict on it.
    pub verdict: Verdict,
    /// Newton iterations from the motion before.
    pub iterations: usize,
    /// Wall time of its search, s.
    pub solve_seconds: f64,
}

/// The rows of a trade-off.
#[must_use]
pub fn tradeoff_rows(found: &[(Scenario, SolveReport)]) -> Vec<TradeoffRow> {
    let rows = found.iter().enumerate();
    let rows = rows.map(|(index, (_, report))| TradeoffRow {
        motion: index + 1,
        duration_s: report.curve.horizon(),
        control_effort: report.summary.control_effort,
        verdict: report.summary.verdict,
        iterations: match &report.summary.details {
            Details::Direct(direct) => direct.iterations,
            Details::Flow(_) | Details::Rest(_) => 0,
        },
        solve_seconds: report.summary.solve_seconds,
    });
    rows.collect()
}

/// Formats the rows as a table.
#[must_use]
pub fn tradeoff_table(rows: &[TradeoffRow]) -> String {
    let mut table = table();
    table.set_header(["motion", "duration, s", "effort", "verdict", "iterations", "solve, s"]);
    for row in rows {
        table.add_row([
            row.motion.to_string(),
            short(row.duration_s),
            short(row.control_effort),
            row.verdict.to_string(),
            row.iterations.to_string(),
            short(row.solve_seconds),
        ]);
    }
    table.to_string()
}

/// Writes `tradeoff.csv`, `summary_NN.json` of each motion, and `report.html` with this page last, as it can be made
/// again from the motions; returns their paths.
///
/// # Errors
/// A file cannot be written.
pub fn write_tradeoff(found: &[(Scenario, SolveReport)], page: &str, folder: &OutputFolder) -> Result<Vec<PathBuf>> {
    let rows = tradeoff_rows(found);
    let csv = csv_of(&rows, true)?;
    let mut files = vec![("tradeoff.csv".to_owned(), csv)];
    for (row, (_, report)) in rows.iter().zip(found) {
        let mut text = Vec::new();
        let written = write_json(&report.summary, &mut text);
        let name = format!("summary_{:02}.json", row.motion);
        written.map_err(|e| aghf::Error::io(folder.path().join(&name), e))?;
        text.push(b'\n');
        files.push((name, text));
    }
    files.push(("report.html".to_owned(), page.as_bytes().to_vec()));
    let mut paths = Vec::new();
    for (name, text) in files {
        let path = folder.path().join(name);
        write_whole(&path, |file| file.write_all(&text))?;
        paths.push(path);
    }
    Ok(paths)
}
