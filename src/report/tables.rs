//! A page of tables and plots, such as that of a sweep.

use super::plots::{COLOURS, css};
use super::{escaped, filled};
use crate::error::{Error, Result};
use crate::output::write_text;
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// The most rows of a table of a page, and the most points of a plot: more make a browser slow, and the files have them all.
const MOST_ROWS: usize = 5_000;
const MOST_POINTS: usize = 20_000;
/// Digits that a page has of a number.
const DIGITS: usize = 7;
/// The largest integer up to which a script knows them all.
const LARGEST_INTEGER: u64 = 1 << 53;

const SCRIPT: [&str; 4] = [
    include_str!("page/elements.js"),
    include_str!("page/scatter.js"),
    include_str!("page/sorting.js"),
    include_str!("page/tables.js"),
];

/// A page of tables and plots. All text in it is shown as it is, whatever it contains.
#[derive(Clone, Debug, Serialize)]
pub struct TablePage {
    /// Its heading.
    pub title: String,
    /// What it is about.
    pub about: String,
    /// The names and values of the figures beside the heading.
    pub figures: Vec<[String; 2]>,
    /// What follows, in this order.
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
    /// A paragraph.
    Note {
        /// Its text.
        text: String,
    },
}

/// A plot of a page.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Plot {
    /// Points, and lines through them.
    Scatter(Scatter),
    /// A bar for each value of something.
    Bars {
        /// Its heading.
        title: String,
        /// The bars.
        bars: Vec<Bar>,
    },
    /// An SVG drawn elsewhere.
    Picture {
        /// Its heading.
        title: String,
        /// The SVG.
        svg: String,
        /// What its circles are, in their order.
        circles: Vec<String>,
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
    /// The points. Those of which a coordinate is not finite are left out.
    pub groups: Vec<Group>,
    /// True to join the points of each group that is no failure by a line.
    pub joined: bool,
}

/// Points of one colour.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// True if they are drawn as crosses: failures.
    pub failed: bool,
    color: String,
    /// `x`, `y` and the name of each point.
    points: Vec<(f64, f64, String)>,
}

impl Group {
    /// Group number `index` of a plot, from 0, which gives its colour.
    #[must_use]
    pub fn new(name: String, index: usize, failed: bool, points: Vec<(f64, f64, String)>) -> Self {
        let finite = points.into_iter();
        let finite = finite.filter(|(x, y, _)| x.is_finite() && y.is_finite());
        Self {
            name,
            failed,
            color: css(COLOURS[index % COLOURS.len()]),
            points: finite.collect(),
        }
    }

    /// True if it has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// How many of the solves with one value succeed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Bar {
    /// The value.
    pub name: String,
    /// The number of solves that succeed.
    pub good: usize,
    /// The number of all.
    pub all: usize,
}

/// A table that can be sorted and filtered.
#[derive(Clone, Debug, Serialize)]
pub struct Table {
    title: String,
    /// The name of the file that has the rows too.
    file: Option<String>,
    columns: Vec<String>,
    rows: Vec<Vec<Value>>,
    /// The numbers of the rows that are failures.
    failed: Vec<usize>,
    /// The number of rows of the file.
    all: usize,
}

impl Table {
    /// Of cells as they are. A row that is too short is filled up, what is too long is left out.
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
            rows: rows.iter().take(MOST_ROWS).map(cells).collect(),
            failed: Vec::new(),
        }
    }

    /// Of rows that are in `file` too, as comma-separated values, without the columns that are empty. `fails` tells whether a row is a failure.
    ///
    /// # Errors
    /// The rows are none of comma-separated values.
    pub fn of_rows<T: Serialize>(
        title: &str,
        file: &str,
        rows: &[T],
        fails: impl Fn(&T) -> bool,
    ) -> Result<Self> {
        let refused = |e: String| Error::input(file, "table", e);
        let shown = &rows[..rows.len().min(MOST_ROWS)];
        let mut csv = csv::Writer::from_writer(Vec::new());
        for row in shown {
            csv.serialize(row).map_err(|e| refused(e.to_string()))?;
        }
        let text = csv.into_inner().map_err(|e| refused(e.to_string()))?;
        let table = Self::of_csv(title, file, &text, |i| shown.get(i).is_some_and(&fails))?;
        let all = rows.len();
        Ok(Self { all, ..table })
    }

    /// Of comma-separated values with a header that are in `file` too, without the columns that are empty. `fails` tells by the number of a
    /// row, from 0, whether it is a failure.
    ///
    /// # Errors
    /// It is no table of comma-separated values.
    pub fn of_csv(
        title: &str,
        file: &str,
        text: &[u8],
        fails: impl Fn(usize) -> bool,
    ) -> Result<Self> {
        let refused = |e: csv::Error| Error::input(file, "table", e.to_string());
        let mut reader = csv::Reader::from_reader(text);
        let header = reader.headers().map_err(refused)?.clone();
        let rows: Vec<csv::StringRecord> = reader
            .records()
            .collect::<csv::Result<_>>()
            .map_err(refused)?;
        let shown = &rows[..rows.len().min(MOST_ROWS)];
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

/// A cell: a number where it is one, and nothing where it is empty.
fn cell(text: &str) -> Value {
    if text.is_empty() {
        return Value::Null;
    }
    if let Ok(integer) = text.parse::<i64>() {
        let exact = integer.unsigned_abs() <= LARGEST_INTEGER;
        return if exact { integer.into() } else { text.into() };
    }
    let is_number = text
        .bytes()
        .all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    match text.parse::<f64>() {
        // A script would lose digits of an integer of this size.
        Ok(_) if text.bytes().all(|b| b.is_ascii_digit()) => text.into(),
        Ok(x) if is_number && x.is_finite() => {
            let rounded = format!("{x:.*e}", DIGITS - 1).parse::<f64>();
            rounded.map_or(Value::Null, Value::from)
        }
        _ => text.into(),
    }
}

/// Evenly chosen points where there are more than a plot should have.
fn thinned(plot: &Scatter) -> Scatter {
    let mut plot = plot.clone();
    let all: usize = plot.groups.iter().map(|group| group.points.len()).sum();
    if all > MOST_POINTS {
        let step = all.div_ceil(MOST_POINTS);
        for group in &mut plot.groups {
            group.points = std::mem::take(&mut group.points)
                .into_iter()
                .step_by(step)
                .collect();
        }
        plot.title += &format!(" (one point of {step})");
    }
    plot
}

impl TablePage {
    /// The page as HTML.
    ///
    /// # Errors
    /// Its data cannot be written as JSON.
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
    /// As [`TablePage::html`], or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_text(&self.html()?, path)
    }
}
