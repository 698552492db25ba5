//! A motion as a table of samples.

use crate::JointTrajectory;
use aghf::error::{Error, Result};
use aghf::input::read_text;
use aghf::model::Model;
use aghf::motion::Sample;
use csv::{ReaderBuilder, StringRecord, Trim};
use std::ffi::OsStr;
use std::path::Path;

/// The quantities of a joint, by the first letters of their column names.
const QUANTITIES: [&str; 4] = ["q", "v", "a", "u"];

/// A motion of a robot as samples, from any source.
///
/// Numbers are ordered by sample and then by joint, in the order of the model: rad or m, per s, per s^2, N m or N.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// The times, ascending, s.
    pub times: Vec<f64>,
    /// The positions.
    pub q: Vec<Vec<f64>>,
    /// The velocities; `None` if the table has none.
    pub v: Option<Vec<Vec<f64>>>,
    /// The accelerations; `None` if the table has none, as a table without velocities.
    pub a: Option<Vec<Vec<f64>>>,
    /// The torques or forces; `None` if the table has none.
    pub u: Option<Vec<Vec<f64>>>,
}

impl Trajectory {
    /// Loads the table in the file at `path`, or the message if it ends in `.yaml`, `.yml` or `.json`; `-` reads a
    /// table from the standard input. See [`parse`](Self::parse) and [`of_message`](Self::of_message).
    ///
    /// # Errors
    /// Those of these; or the file cannot be read or is larger than 64 MiB.
    pub fn load(path: &Path, model: &Model) -> Result<Self> {
        let (text, file) = (read_text(path)?, path.display().to_string());
        match path.extension().and_then(OsStr::to_str) {
            Some("yaml" | "yml" | "json") => Self::of_message(&JointTrajectory::parse(&text, &file)?, &file, model),
            _ => Self::parse(&text, &file, model),
        }
    }

    /// Parses a CSV table with a header for `model`. The columns, in any order, are `t` in s and `q_JOINT` for every
    /// joint, and, each for all joints or for none, `v_JOINT`, `a_JOINT`, not without `v_JOINT`, and `u_JOINT`, as
    /// `aghf solve` writes them. Lines that begin with `#` are ignored. `file` names the table in errors. Cost O(N) per
    /// sample.
    ///
    /// # Errors
    /// A column is unknown, duplicate or missing; a line has another number of fields than the header; a field is not a
    /// finite number; the times do not ascend; or there are fewer than two samples. The error names line and column.
    pub fn parse(text: &str, file: &str, model: &Model) -> Result<Self> {
        let mut reader =
            ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).flexible(true).from_reader(text.as_bytes());
        let of_csv = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            Error::input(file, format!("line {line}"), error.to_string())
        };
        let header = reader.headers().map_err(of_csv)?.clone();
        let line = header.position().map_or(1, csv::Position::line);
        let columns = Columns::new(&header, model)
            .map_err(|(element, condition)| Error::input(file, format!("line {line}: {element}"), condition))?;
        let mut times: Vec<f64> = Vec::new();
        let mut tables: [Option<Vec<Vec<f64>>>; 4] =
            columns.of_joints.each_ref().map(|c| c.as_ref().map(|_| Vec::new()));
        for record in reader.records() {
            let record = record.map_err(of_csv)?;
            let line = record.position().map_or(0, csv::Position::line);
            let error =
                |element: &str, condition: String| Error::input(file, format!("line {line}{element}"), condition);
            if record.len() != header.len() {
                let condition = format!("it has {} fields, the header has {}", record.len(), header.len());
                return Err(error("", condition));
            }
            let number = |column: usize| match record[column].parse::<f64>() {
                Ok(x) if x.is_finite() => Ok(x),
                _ => Err(error(
                    &format!(", column '{}'", &header[column]),
                    format!("'{}' is no finite number", &record[column]),
                )),
            };
            let t = number(columns.time)?;
            if let Some(before) = times.last().filter(|before| t <= **before) {
                let condition = format!("the time {t} does not come after {before}");
                return Err(error(", column 't'", condition));
            }
            times.push(t);
            for (table, columns) in tables.iter_mut().zip(&columns.of_joints) {
                if let (Some(table), Some(columns)) = (table, columns) {
                    table.push(columns.iter().map(|c| number(*c)).collect::<Result<_>>()?);
                }
            }
        }
        if times.len() < 2 {
            let condition = format!("{} samples are given, at least 2 are needed", times.len());
            return Err(Error::input(file, "table", condition));
        }
        Self::of_tables(file, times, tables)
    }

    /// The motion with `q` and, if they are given, `v`, `a` and `u` at ascending times; see the fields.
    ///
    /// # Errors
    /// Names the argument and its fault: there are fewer than two times, they do not ascend, a table is missing or has
    /// another number of rows, accelerations are given without velocities, or a number is not finite.
    pub fn new(times: Vec<f64>, tables: [Option<Vec<Vec<f64>>>; 4]) -> Result<Self> {
        let refuse = |what: &str, condition| Err(Error::input("motion", what, condition));
        let count = times.len();
        if count < 2 {
            let condition = format!("{count} samples are given, at least 2 are needed");
            return refuse("t", condition);
        }
        if tables[0].is_none() {
            return refuse("q", "it is missing".to_owned());
        }
        let infinite = |numbers: &[f64]| numbers.iter().copied().find(|x| !x.is_finite());
        if let Some(x) = infinite(&times) {
            return refuse("t", format!("{x} is no finite number"));
        }
        if let Some(k) = (1..count).find(|k| times[*k - 1] >= times[*k]) {
            let condition = format!("{} does not come after {}", times[k], times[k - 1]);
            return refuse("t", condition);
        }
        for (name, table) in ["q", "v", "a", "tau"].into_iter().zip(&tables) {
            let Some(table) = table else { continue };
            if table.len() != count {
                let condition = format!("it has {} samples, t has {count}", table.len());
                return refuse(name, condition);
            }
            if let Some(x) = table.iter().find_map(|row| infinite(row)) {
                return refuse(name, format!("{x} is no finite number"));
            }
        }
        Self::of_tables("motion", times, tables)
    }

    /// The motion of a `file` with these `q, v, a, u` at the times; refuses accelerations without velocities.
    pub(super) fn of_tables(file: &str, times: Vec<f64>, [q, v, a, u]: [Option<Vec<Vec<f64>>>; 4]) -> Result<Self> {
        if a.is_some() && v.is_none() {
            let condition = "velocities are needed with them";
            return Err(Error::input(file, "accelerations", condition));
        }
        let q = q.unwrap_or_default();
        Ok(Self { times, q, v, a, u })
    }

    /// The motion through samples of a curve, ascending in time.
    #[must_use]
    pub fn of_samples(samples: impl IntoIterator<Item = Sample>) -> Self {
        let (mut times, mut tables) = (Vec::new(), [const { Vec::new() }; 4]);
        for Sample { t, q, v, a, u, .. } in samples {
            times.push(t);
            for (table, row) in tables.iter_mut().zip([q, v, a, u]) {
                table.push(row);
            }
        }
        let [q, v, a, u] = tables;
        let [v, a, u] = [v, a, u].map(Some);
        Self { times, q, v, a, u }
    }

    /// The time from the first to the last sample, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.times[self.times.len() - 1] - self.times[0]
    }
}

/// The columns of the quantities.
struct Columns {
    time: usize,
    /// The columns of all joints for each of [`QUANTITIES`]; `None` if the table does not have it.
    of_joints: [Option<Vec<usize>>; 4],
}

impl Columns {
    /// Finds the columns by the names of a header; the error names the faulty element and the reason.
    fn new(header: &StringRecord, model: &Model) -> std::result::Result<Self, (String, String)> {
        let mut time = None;
        let mut found = vec![[None; 4]; model.dof()];
        for (column, name) in header.iter().enumerate() {
            let of_joint = || {
                let (quantity, joint) = name.split_once('_')?;
                let quantity = QUANTITIES.iter().position(|q| *q == quantity)?;
                let joint = model.joints().iter().position(|j| j.name() == joint)?;
                Some((joint, quantity))
            };
            let place = match of_joint() {
                Some((joint, quantity)) => &mut found[joint][quantity],
                None if name == "t" => &mut time,
                None => {
                    let condition = "a column is t, or q_, v_, a_ or u_ and the name of a joint of the robot that \
                        moves";
                    return Err((format!("column '{name}'"), condition.to_owned()));
                }
            };
            if place.replace(column).is_some() {
                return Err((format!("column '{name}'"), "it is there twice".to_owned()));
            }
        }
        let missing = |name: String, condition: &str| Err((format!("column '{name}'"), condition.to_owned()));
        let Some(time) = time else {
            return missing("t".to_owned(), "it is missing");
        };
        let mut of_joints = [const { None }; 4];
        for (i, quantity) in QUANTITIES.iter().enumerate() {
            if i > 0 && found.iter().all(|of| of[i].is_none()) {
                continue;
            }
            let mut columns = Vec::with_capacity(model.dof());
            for (joint, of) in model.joints().iter().zip(&found) {
                let Some(column) = of[i] else {
                    return missing(format!("{quantity}_{}", joint.name()), "it is missing");
                };
                columns.push(column);
            }
            of_joints[i] = Some(columns);
        }
        Ok(Self { time, of_joints })
    }
}
