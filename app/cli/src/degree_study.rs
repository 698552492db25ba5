//! The effort against the degree and the number of segments.

use crate::output::{short, table, write_whole};
use crate::report::{Group, Part, Plot, Scatter, Table, TablePage};
use aghf::error::{Error, Result};
use aghf::relax::RelaxSettings;
use aghf_scenario::{Details, Scenario, SolveOptions, Summary, solve};
use comfy_table::CellAlignment;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// The polynomials of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// The number of polynomials.
    pub pieces: usize,
    /// The degree of each.
    pub p: usize,
}

impl FromStr for Size {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let parts = text.split_once('x');
        let size = parts.and_then(|(pieces, p)| Some((pieces.parse().ok()?, p.parse().ok()?)));
        let (pieces, p) = size.ok_or_else(|| {
            let condition = format!("'{text}': pieces x degree is needed, such as 4x9");
            Error::input("settings", "size", condition)
        })?;
        RelaxSettings::check_size(p, pieces)?;
        Ok(Self { pieces, p })
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.pieces, self.p)
    }
}

/// The result of one size. The columns of the file have this order.
#[derive(Clone, Debug, Serialize)]
pub struct SizeRow {
    /// The name of the scenario.
    pub scenario: String,
    /// The number of polynomials.
    pub pieces: usize,
    /// The degree of each.
    pub p: usize,
    /// The number of unknowns.
    pub unknowns: usize,
    /// True if the motion was found, ends at the goal and satisfies its constraints.
    pub success: bool,
    /// $\int |u|^2 dt$.
    pub control_effort: f64,
    /// The final relative gradient norm.
    pub gradient_norm: f64,
    /// The smallest curvature at the end.
    pub smallest_curvature: f64,
    /// The final error of the simulation with feedback.
    pub final_error_inf: Option<f64>,
    /// The final error of the simulation without feedback.
    pub open_loop_error_inf: Option<f64>,
    /// The error over one interval with the control values at the nodes; see
    /// [`replay_error`](aghf::motion::replay_error).
    pub replay_error_inf: Option<f64>,
    /// Newton iterations, of all starts and bases.
    pub iterations: usize,
    /// Cholesky factorisations.
    pub factorisations: usize,
    /// Wall time, s.
    pub solve_seconds: f64,
    /// The reason of a failure; `None` for a success.
    pub failure: Option<String>,
}

impl SizeRow {
    /// The row of a summary; `None` if that is not of a relaxation.
    fn new(summary: Summary) -> Option<Self> {
        let Details::Relax(d) = summary.details else {
            return None;
        };
        Some(Self {
            scenario: summary.scenario,
            pieces: summary.pieces,
            p: summary.p,
            unknowns: d.unknowns,
            success: summary.success,
            control_effort: summary.control_effort,
            gradient_norm: d.gradient_norm,
            smallest_curvature: d.smallest_curvature,
            final_error_inf: summary.final_error_inf,
            open_loop_error_inf: summary.open_loop_error_inf,
            replay_error_inf: d.replay_error_inf,
            iterations: d.iterations,
            factorisations: d.factorisations,
            solve_seconds: summary.solve_seconds,
            failure: summary.failure,
        })
    }
}

/// Relaxes `scenario` with motions of each size, one after the other and each from its own starts. `done` is called
/// after each.
///
/// # Errors
/// Invalid input. A size that fails is not an error: its row gives the reason.
pub fn by_size(
    scenario: &Scenario,
    sizes: &[Size],
    starts: Option<usize>,
    done: &mut dyn FnMut(Size),
) -> Result<Vec<SizeRow>> {
    let mut rows = Vec::new();
    for size in sizes {
        let options = SolveOptions {
            degree: Some(size.p),
            segments: Some(size.pieces),
            num_starts: starts,
            ..SolveOptions::default()
        };
        rows.extend(SizeRow::new(
            solve(scenario, &options, &mut |_| {})?.summary,
        ));
        done(*size);
    }
    Ok(rows)
}

/// Writes rows as CSV.
///
/// # Errors
/// The file cannot be written.
pub fn write_sizes(rows: &[SizeRow], path: &Path) -> Result<()> {
    write_whole(path, |file| {
        let mut csv = csv::Writer::from_writer(file);
        for row in rows {
            csv.serialize(row)?;
        }
        csv.flush()
    })
}

/// Builds the page of rows: the effort against the degree and against the number of unknowns, and the table of
/// `degrees.csv`.
///
/// # Errors
/// The rows cannot be written as text.
pub fn size_page(scenario: &Scenario, rows: &[SizeRow]) -> Result<TablePage> {
    let solved = rows.iter().filter(|row| row.success).count();
    let least = rows.iter().filter(|row| row.success);
    let least = least.min_by(|a, b| a.control_effort.total_cmp(&b.control_effort));
    let size = |row: &SizeRow| format!("{}x{}", row.pieces, row.p);
    let mut figures = vec![
        ["robot".to_owned(), scenario.file.robot.clone()],
        ["sizes".to_owned(), rows.len().to_string()],
        ["solved".to_owned(), solved.to_string()],
    ];
    figures.extend(least.map(|row| {
        let effort = short(row.control_effort);
        [
            "least effort".to_owned(),
            format!("{effort} by {}", size(row)),
        ]
    }));
    let plot = |title: &str, x: &str, of: fn(&SizeRow) -> usize| {
        Plot::Scatter(Scatter {
            title: title.to_owned(),
            x: x.to_owned(),
            y: "effort, ∫|u|² dt".to_owned(),
            groups: size_groups(rows, of),
            joined: true,
        })
    };
    let plots = vec![
        plot("Effort against degree", "degree of each polynomial", |r| {
            r.p
        }),
        plot("Effort against unknowns", "unknowns", |r| r.unknowns),
    ];
    let title = "Degrees and pieces".to_owned();
    let table = Table::of_rows("Sizes", "degrees.csv", rows, |row| !row.success)?;
    Ok(TablePage {
        title: scenario.name.clone(),
        about: "effort of motions of several sizes".to_owned(),
        figures,
        parts: vec![Part::Plots { title, plots }, Part::Table(table)],
    })
}

/// One point per size at its number `x`, grouped by the number of segments; failures form a separate group.
fn size_groups(rows: &[SizeRow], x: fn(&SizeRow) -> usize) -> Vec<Group> {
    let point = |row: &SizeRow| {
        let (effort, time) = (short(row.control_effort), 1e3 * row.solve_seconds);
        let mut name = format!(
            "{}x{}: effort {effort}\n{} unknowns, {time:.1} ms",
            row.pieces, row.p, row.unknowns
        );
        if let Some(failure) = &row.failure {
            name += &format!("\n{failure}");
        }
        (x(row) as f64, row.control_effort, name)
    };
    let pieces: BTreeSet<usize> = rows.iter().map(|row| row.pieces).collect();
    let mut groups = Vec::new();
    for (i, pieces) in pieces.into_iter().enumerate() {
        let own = rows.iter().filter(|r| r.pieces == pieces);
        let mut good: Vec<&SizeRow> = own.filter(|r| r.success).collect();
        good.sort_by_key(|row| x(row));
        let name = match pieces {
            1 => "1 piece".to_owned(),
            _ => format!("{pieces} pieces"),
        };
        let points = good.into_iter().map(point).collect();
        groups.push(Group::new(name, i, false, points));
    }
    let failed = rows.iter().filter(|row| !row.success).map(point).collect();
    groups.push(Group::new("failed".to_owned(), groups.len(), true, failed));
    groups.retain(|group| !group.is_empty());
    groups
}

/// Formats rows as a table.
#[must_use]
pub fn size_table(rows: &[SizeRow]) -> String {
    let mut table = table();
    let header = [
        "pieces",
        "p",
        "unknowns",
        "success",
        "effort",
        "with feedback",
        "open loop",
        "by nodes",
        "iterations",
        "solve, ms",
    ];
    table.set_header(header);
    for r in rows {
        let optional = |x: Option<f64>| x.map_or("-".to_owned(), short);
        table.add_row([
            r.pieces.to_string(),
            r.p.to_string(),
            r.unknowns.to_string(),
            if r.success { "yes" } else { "no" }.to_owned(),
            short(r.control_effort),
            optional(r.final_error_inf),
            optional(r.open_loop_error_inf),
            optional(r.replay_error_inf),
            r.iterations.to_string(),
            format!("{:.1}", 1e3 * r.solve_seconds),
        ]);
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}
