//! A motion as a table of samples.

use crate::JointTrajectory;
use aghf::error::{Error, Result};
use aghf::input::read_text;
use aghf::model::Model;
use aghf::motion::Sample;
use csv::{ReaderBuilder, StringRecord, Trim};
use std::ffi::OsStr;
use std::path::Path;

/// The number of neighbouring samples through which a polynomial is differentiated.
const NEIGHBOURS: usize = 5;

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
    /// The velocities.
    pub v: Vec<Vec<f64>>,
    /// The accelerations.
    pub a: Vec<Vec<f64>>,
    /// The torques or forces; `None` if the table has none.
    pub u: Option<Vec<Vec<f64>>>,
    /// True if the table has velocities; otherwise they are those of the polynomials of degree four through five
    /// neighbouring positions.
    pub has_velocities: bool,
    /// True if the table has accelerations; otherwise they come from the velocities in the same way.
    pub has_accelerations: bool,
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
            Some("yaml" | "yml" | "json") => {
                Self::of_message(&JointTrajectory::parse(&text, &file)?, &file, model)
            }
            _ => Self::parse(&text, &file, model),
        }
    }

    /// Parses a CSV table with a header for `model`. The columns, in any order, are `t` in s and `q_JOINT` for every
    /// joint, and, each for all joints or for none, `v_JOINT`, `a_JOINT` and `u_JOINT`, as `aghf solve` writes them.
    /// Lines that begin with `#` are ignored. `file` names the table in errors. Cost O(N) per sample.
    ///
    /// # Errors
    /// A column is unknown, duplicate or missing; a line has another number of fields than the header; a field is not a
    /// finite number; the times do not ascend; or there are fewer than two samples. The error names line and column.
    pub fn parse(text: &str, file: &str, model: &Model) -> Result<Self> {
        let mut reader = ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let of_csv = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            Error::input(file, format!("line {line}"), error.to_string())
        };
        let header = reader.headers().map_err(of_csv)?.clone();
        let line = header.position().map_or(1, csv::Position::line);
        let columns = Columns::new(&header, model).map_err(|(element, condition)| {
            Error::input(file, format!("line {line}: {element}"), condition)
        })?;
        let mut times: Vec<f64> = Vec::new();
        let mut tables: [Option<Vec<Vec<f64>>>; 4] = columns
            .of_joints
            .each_ref()
            .map(|c| c.as_ref().map(|_| Vec::new()));
        for record in reader.records() {
            let record = record.map_err(of_csv)?;
            let line = record.position().map_or(0, csv::Position::line);
            let error = |element: &str, condition: String| {
                Error::input(file, format!("line {line}{element}"), condition)
            };
            if record.len() != header.len() {
                let condition = format!(
                    "it has {} fields, the header has {}",
                    record.len(),
                    header.len()
                );
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
        Ok(Self::of_tables(times, tables))
    }

    /// The motion with `q` and, if they are given, `v`, `a` and `u` at ascending times; see the fields.
    ///
    /// # Errors
    /// Names the argument and its fault: there are fewer than two times, they do not ascend, a table is missing or has
    /// another number of rows, or a number is not finite.
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
        Ok(Self::of_tables(times, tables))
    }

    /// The motion with these `q, v, a, u` at the times; velocities and accelerations that are not given are derived.
    pub(super) fn of_tables(times: Vec<f64>, [q, v, a, u]: [Option<Vec<Vec<f64>>>; 4]) -> Self {
        let (has_velocities, has_accelerations) = (v.is_some(), a.is_some());
        let q = q.unwrap_or_default();
        let v = v.unwrap_or_else(|| rates(&times, &q));
        let a = a.unwrap_or_else(|| rates(&times, &v));
        Self {
            times,
            q,
            v,
            a,
            u,
            has_velocities,
            has_accelerations,
        }
    }

    /// The motion through samples of a curve, ascending in time.
    #[must_use]
    pub fn of_samples(samples: impl IntoIterator<Item = Sample>) -> Self {
        let mut all = Self {
            times: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
            a: Vec::new(),
            u: Some(Vec::new()),
            has_velocities: true,
            has_accelerations: true,
        };
        for Sample { t, q, v, a, u, .. } in samples {
            all.times.push(t);
            all.q.push(q);
            all.v.push(v);
            all.a.push(a);
            all.u.get_or_insert_default().push(u);
        }
        all
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
        let missing =
            |name: String, condition: &str| Err((format!("column '{name}'"), condition.to_owned()));
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

/// The derivatives in time at the samples, by the polynomials through [`NEIGHBOURS`] of them, or through all if there
/// are fewer. The error is of fourth order in the spacing if the fifth derivative is bounded.
fn rates(times: &[f64], samples: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let count = NEIGHBOURS.min(times.len());
    let rate = |k: usize| {
        let first = k.saturating_sub(count / 2).min(times.len() - count);
        let weights = derivative_weights(&times[first..first + count], k - first);
        let mut rate = vec![0.0; samples[k].len()];
        for (weight, sample) in weights.iter().zip(&samples[first..]) {
            for (rate, x) in rate.iter_mut().zip(sample) {
                *rate += weight * x;
            }
        }
        rate
    };
    (0..times.len()).map(rate).collect()
}

/// The weights of the values at `times` in the derivative of the polynomial through them at time `k`.
fn derivative_weights(times: &[f64], k: usize) -> Vec<f64> {
    let others = |j: usize| (0..times.len()).filter(move |m| *m != j);
    let weight = |j: usize| {
        if j == k {
            return others(k).map(|m| (times[k] - times[m]).recip()).sum();
        }
        let product: f64 = others(j)
            .filter(|m| *m != k)
            .map(|m| (times[k] - times[m]) / (times[j] - times[m]))
            .product();
        product / (times[j] - times[k])
    };
    (0..times.len()).map(weight).collect()
}
