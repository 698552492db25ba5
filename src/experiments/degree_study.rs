//! The effort against degree and pieces.

use crate::error::{Error, Result};
use crate::output::{short, table, write_whole};
use crate::relax::RelaxSettings;
use crate::scenario::{Details, Scenario, SolveOptions, Summary, solve};
use comfy_table::CellAlignment;
use serde::Serialize;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// Of what polynomials a motion is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// The number of polynomials.
    pub pieces: usize,
    /// Of which degree each.
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

/// The result of one size. The columns of the file are in this order.
#[derive(Clone, Debug, Serialize)]
pub struct SizeRow {
    /// The name of the scenario.
    pub scenario: String,
    /// The number of polynomials.
    pub pieces: usize,
    /// Of which degree each.
    pub p: usize,
    /// The number of unknowns.
    pub unknowns: usize,
    /// True if the motion was found, ends at the goal and keeps what it has to.
    pub success: bool,
    /// $\int |u|^2 dt$.
    pub control_effort: f64,
    /// The relative gradient norm at the end.
    pub gradient_norm: f64,
    /// The smallest curvature there.
    pub smallest_curvature: f64,
    /// The final error of the simulation with feedback.
    pub final_error_inf: Option<f64>,
    /// The same without.
    pub open_loop_error_inf: Option<f64>,
    /// The error of an interval by the control at the nodes alone; see [`replay_error`](crate::motion::replay_error).
    pub replay_error_inf: Option<f64>,
    /// Iterations of Newton's method, of all starts and rungs.
    pub iterations: usize,
    /// Cholesky factorisations.
    pub factorisations: usize,
    /// Wall time.
    pub solve_seconds: f64,
    /// The reason why it failed, if it did.
    pub failure: Option<String>,
}

impl SizeRow {
    /// The row of what was found; `None` if that is no relaxation.
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

/// Relaxes `scenario` with motions of each size, one after the other and each from its own starts. `done` is called after each.
///
/// # Errors
/// Bad input. A size that fails is a row that says so.
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

/// Rows for people.
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
