//! A page of tables and plots, such as that of a sweep.

use super::plots::{COLOURS, css};
use super::{escaped, filled};
use crate::output::{csv_of, write_text};
use aghf::error::{Error, Result};
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// The largest number of rows of a table and of points of a plot: more make a browser slow, and the result files are
/// complete.
const MAX_ROWS: usize = 5_000;
const MAX_POINTS: usize = 20_000;
/// The number of digits of a number on a page.
const DIGITS: usize = 7;
/// The largest integer up to which scripts represent all integers exactly.
const MAX_INTEGER: u64 = 1 << 53;

const SCRIPT: [&str; 4] = [
    include_str!("page/elements.js"),
    include_str!("page/scatter.js"),
    include_str!("page/sorting.js"),
    include_str!("page/tables.js"),
];

/// A page of tables and plots. All text is escaped.
#[derive(Clone, Debug, Serialize)]
pub struct TablePage {
    /// Its heading.
    pub title: String,
    /// Its introduction.
    pub about: String,
    /// The names and values of the figures next to the heading.
    pub figures: Vec<[String; 2]>,
    /// Its parts, in this order.
    pub parts: Vec<Part>,
}

/// A part of a page.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Part {
    /// Plots side by side.
    Plots {
        /// Its heading.
        title: String,
        /// The plots.
        plots: Vec<Plot>,
    },
    /// A table.
    Table(Table),
}

/// A plot of a page.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Plot {
    /// Points.
    Scatter(Scatter),
    /// One bar per value of a parameter.
    Bars {
        /// Its heading.
        title: String,
        /// The bars.
        bars: Vec<Bar>,
    },
}

/// A plot of points.
#[derive(Clone, Debug, Serialize)]
pub struct Scatter {
    /// Its heading.
    pub title: String,
    /// The name of the horizontal axis with its unit.
    pub x: String,
    /// The name of the vertical axis with its unit.
    pub y: String,
    /// The points. Those with a coordinate that is not finite are left out.
    pub groups: Vec<Group>,
}

/// Points of one colour.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// True if they are failures, which are drawn as crosses.
    pub failed: bool,
    color: String,
    /// `x`, `y` and the name of each point.
    points: Vec<(f64, f64, String)>,
}

impl Group {
    /// The group of index `index` in a plot, from 0, which determines its colour.
    #[must_use]
    pub fn new(name: String, index: usize, failed: bool, points: Vec<(f64, f64, String)>) -> Self {
        let finite = points.into_iter();
        let finite = finite.filter(|(x, y, _)| x.is_finite() && y.is_finite());
        Self { name, failed, color: css(COLOURS[index % COLOURS.len()]), points: finite.collect() }
    }

    /// Returns true if it has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// The number of successful solves for one value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Bar {
    /// The value.
    pub name: String,
    /// The number of successful solves.
    pub good: usize,
    /// The number of all solves.
    pub all: usize,
}

/// A table that can be sorted and filtered.
#[derive(Clone, Debug, Serialize)]
pub struct Table {
    title: String,
    /// The name of the file that contains the rows.
    file: Option<String>,
    columns: Vec<String>,
    rows: Vec<Vec<Value>>,
    /// The indices of the rows that are failures.
    failed: Vec<usize>,
    /// The number of rows of the file.
    all: usize,
}

impl Table {
    /// A table of these cells. Short rows are padded, long ones are cut.
    #[must_use]
    pub fn new(title: &str, columns: &[String], rows: &[Vec<String>]) -> Self {
        let cells = |row: &Vec<String>| {
            let mut cells: Vec<Value> = row.iter().map(|text| cell(text)).collect();
            cells.resize(columns.len(), Value::Null);
            cells
        };
        Self {
            title: title.to_owned(),
            file: None,
            columns: columns.to_vec(),
            all: rows.len(),
            rows: rows.iter().take(MAX_ROWS).map(cells).collect(),
            failed: Vec::new(),
        }
    }

    /// A table of rows that are also in `file` as comma-separated values, without empty columns. `fails` returns true
    /// for a failure.
    ///
    /// # Errors
    /// The rows cannot be written as comma-separated values.
    pub fn of_rows<T: Serialize>(title: &str, file: &str, rows: &[T], fails: impl Fn(&T) -> bool) -> Result<Self> {
        let shown = &rows[..rows.len().min(MAX_ROWS)];
        let text = csv_of(shown, true)?;
        let table = Self::of_csv(title, file, &text, |i| shown.get(i).is_some_and(&fails))?;
        let all = rows.len();
        Ok(Self { all, ..table })
    }

    /// A table of comma-separated values with a header that are also in `file`, without empty columns. `fails` returns
    /// true if the row of an index, from 0, is a failure.
    ///
    /// # Errors
    /// The text is not a table of comma-separated values.
    pub fn of_csv(title: &str, file: &str, text: &[u8], fails: impl Fn(usize) -> bool) -> Result<Self> {
        let refused = |e: csv::Error| Error::input(file, "table", e.to_string());
        let mut reader = csv::Reader::from_reader(text);
        let header = reader.headers().map_err(refused)?.clone();
        let rows: Vec<csv::StringRecord> = reader.records().collect::<csv::Result<_>>().map_err(refused)?;
        let shown = &rows[..rows.len().min(MAX_ROWS)];
        let used = |i: &usize| shown.iter().any(|row| !row[*i].is_empty());
        let used: Vec<usize> = (0..header.len()).filter(used).collect();
        let cells = |row: &csv::StringRecord| used.iter().map(|i| cell(&row[*i])).collect();
        Ok(Self {
            title: title.to_owned(),
            file: Some(file.to_owned()),
            columns: used.iter().map(|i| header[*i].to_owned()).collect(),
            rows: shown.iter().map(cells).collect(),
            failed: (0..shown.len()).filter(|i| fails(*i)).collect(),
            all: rows.len(),
        })
    }
}

/// A cell: a number if it is one, null if it is empty.
fn cell(text: &str) -> Value {
    if text.is_empty() {
        return Value::Null;
    }
    if let Ok(integer) = text.parse::<i64>() {
        let exact = integer.unsigned_abs() <= MAX_INTEGER;
        return if exact { integer.into() } else { text.into() };
    }
    let is_number = text.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    match text.parse::<f64>() {
        // A script would round an integer of this size.
        Ok(_) if text.bytes().all(|b| b.is_ascii_digit()) => text.into(),
        Ok(x) if is_number && x.is_finite() => {
            let rounded = format!("{x:.*e}", DIGITS - 1).parse::<f64>();
            rounded.map_or(Value::Null, Value::from)
        }
        _ => text.into(),
    }
}

/// Evenly selected points if there are more than a plot should have.
fn thinned(plot: &Scatter) -> Scatter {
    let mut plot = plot.clone();
    let all: usize = plot.groups.iter().map(|group| group.points.len()).sum();
    if all > MAX_POINTS {
        let step = all.div_ceil(MAX_POINTS);
        for group in &mut plot.groups {
            group.points = std::mem::take(&mut group.points).into_iter().step_by(step).collect();
        }
        plot.title += &format!(" (one point of {step})");
    }
    plot
}

impl TablePage {
    /// Builds the page as HTML.
    ///
    /// # Errors
    /// The data cannot be written as JSON.
    pub fn html(&self) -> Result<String> {
        let mut page = self.clone();
        for part in &mut page.parts {
            if let Part::Plots { plots, .. } = part {
                for plot in plots {
                    if let Plot::Scatter(scatter) = plot {
                        *scatter = thinned(scatter);
                    }
                }
            }
        }
        filled(&page, &SCRIPT, &escaped(&self.title))
    }

    /// Writes the page to the file at `path`.
    ///
    /// # Errors
    /// Those of [`TablePage::html`], or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_text(&self.html()?, path)
    }
}
