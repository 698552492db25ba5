//! A motion as a table, and the files of a solve.

use super::files::{Partial, write_whole};
use super::{OutputFolder, write_json};
use aghf::curve::Curve;
use aghf::error::{Error, Result};
use aghf::model::Model;
use aghf::motion::samples_at;
use aghf_scenario::judge::sufficient_samples;
use aghf_scenario::{Scenario, SolveReport};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The times of the rows of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// This number of times at equal distances, both ends of the motion included.
    Samples(usize),
    /// This number of times per second, in Hz, from the start, and one at the end.
    Rate(f64),
}

impl Sampling {
    /// The chosen rows, or as many as the judge needs of a motion, by [`sufficient_samples`].
    ///
    /// # Errors
    /// The robot of the curve has another number of joints.
    pub fn or_sufficient(chosen: Option<Self>, scenario: &Scenario, curve: &Curve) -> Result<Self> {
        match chosen {
            Some(chosen) => Ok(chosen),
            None => sufficient_samples(scenario, curve).map(Self::Samples),
        }
    }

    /// The largest number of rows of a table: several GB of text for an arm.
    pub const MAX_ROWS: usize = 10_000_000;

    /// The times of a motion with this horizon, all in s.
    ///
    /// # Errors
    /// The number or the rate is out of range.
    pub fn times(self, horizon: f64) -> Result<impl Iterator<Item = f64> + use<>> {
        let most = Self::MAX_ROWS;
        let refuse = |what: &str, condition: String| Err(Error::input("options", what, condition));
        // Times are quotients, so that each has only one rounding error.
        let (count, per_second) = match self {
            Self::Samples(samples) if !(2..=most).contains(&samples) => {
                let condition = format!("it is {samples} and must be at least 2 and at most {most}");
                return refuse("samples", condition);
            }
            Self::Samples(samples) => (samples - 1, (samples - 1) as f64 / horizon),
            Self::Rate(rate) => {
                if !(rate.is_finite() && rate > 0.0) {
                    return refuse("rate", format!("it is {rate} and must be a positive number"));
                }
                // A product that is an integer up to rounding counts as this integer.
                let count = (horizon * rate * (1.0 - 1e-12)).ceil();
                if count >= most as f64 {
                    let condition = format!("{rate} Hz over {horizon} s are more than {most} rows");
                    return refuse("rate", condition);
                }
                (count as usize, rate)
            }
        };
        let inner = (0..count).map(move |i| (i as f64 / per_second).min(horizon));
        Ok(inner.chain([horizon]))
    }
}

/// The names of the files of a solve: the table, the summary and the page of a valid motion, and those of one that is
/// not valid.
pub const REPORT_FILES: [&str; 6] = [
    "trajectory.csv",
    "summary.json",
    "report.html",
    "trajectory.failed.csv",
    "summary.failed.json",
    "report.failed.html",
];

/// Writes the table of a motion: one row per time with `t` (s), then `q_JOINT` (rad or m), `v_JOINT` (rad/s or m/s),
/// `a_JOINT` (rad/s^2 or m/s^2) and `u_JOINT` (N m or N) of all joints in their order. Each comment is a line before
/// these, after `#`. Rows are written as they are computed.
///
/// # Errors
/// The writer fails, or the curve has another number of joints than `model`.
pub fn write_trajectory(
    model: &Model,
    curve: &Curve,
    times: impl Iterator<Item = f64>,
    comments: &[String],
    mut writer: impl Write,
) -> io::Result<()> {
    for comment in comments {
        writeln!(writer, "# {}", comment.replace(['\n', '\r'], " "))?;
    }
    let mut csv = csv::Writer::from_writer(writer);
    let columns = ["q", "v", "a", "u"].iter().flat_map(|quantity| {
        let joints = model.joints().iter();
        joints.map(move |joint| format!("{quantity}_{}", joint.name()))
    });
    let header = std::iter::once("t".to_owned()).chain(columns);
    csv.write_record(header).map_err(of_csv)?;
    let times = times.map(|t| (curve.segment_at(t), t));
    for sample in samples_at(model, curve, times) {
        let s = sample.map_err(io::Error::other)?;
        let row = [&s.q, &s.v, &s.a, &s.u].into_iter().flatten();
        let row = std::iter::once(&s.t).chain(row);
        csv.write_record(row.map(|x| format!("{x:?}"))).map_err(of_csv)?;
    }
    csv.flush()
}

/// The comment with the reason of a failure.
pub(crate) fn failure_comment(failure: Option<&str>) -> Option<String> {
    failure.map(|reason| format!("failed: {reason}"))
}

/// Converts the error of the CSV writer without losing its kind.
fn of_csv(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// Writes the table of a motion to the file at `path` by [`write_trajectory`].
///
/// # Errors
/// Those of [`write_trajectory`].
pub fn write_table(
    model: &Model,
    curve: &Curve,
    times: impl Iterator<Item = f64>,
    comments: &[String],
    path: &Path,
) -> Result<()> {
    write_whole(path, |file| write_trajectory(model, curve, times, comments, file))
}

/// Writes `trajectory.csv`, see [`write_trajectory`], by default with [as many rows](Sampling::or_sufficient) as the
/// judge needs, `summary.json`, and `report.html` if there is a `page`, into `folder` and returns their paths; a failed
/// solve writes `trajectory.failed.csv` and so on, so that the files of an earlier success remain. If files may be
/// replaced, a success removes those of an earlier failure, and no page of an earlier solve remains next to another
/// motion.
///
/// # Errors
/// A file cannot be written, and then none is; or the sampling is out of range.
pub fn write_report(
    scenario: &Scenario,
    outcome: &SolveReport,
    page: Option<&str>,
    folder: &OutputFolder,
    sampling: Option<Sampling>,
) -> Result<Vec<PathBuf>> {
    let (summary, curve) = (&outcome.summary, &outcome.curve);
    let (success, failure) = REPORT_FILES.split_at(REPORT_FILES.len() / 2);
    let (own, other) = if summary.success { (success, failure) } else { (failure, success) };
    let mut paths: Vec<_> = own.iter().map(|name| folder.path().join(name)).collect();
    let times = Sampling::or_sufficient(sampling, scenario, curve)?.times(curve.horizon())?;
    let comments: Vec<String> = failure_comment(summary.failure.as_deref()).into_iter().collect();
    let mut parts = vec![
        Partial::write(&paths[0], |file| write_trajectory(&scenario.model, curve, times, &comments, file))?,
        Partial::write(&paths[1], |file| {
            write_json(summary, &mut *file)?;
            file.write_all(b"\n")
        })?,
    ];
    match page {
        Some(page) => parts.push(Partial::write(&paths[2], |file| file.write_all(page.as_bytes()))?),
        None => {
            let stale = paths.remove(2);
            if folder.replaces() {
                // Usually there is none.
                let _ = std::fs::remove_file(stale);
            }
        }
    }
    for part in parts {
        part.complete(folder.replaces())?;
    }
    if summary.success && folder.replaces() {
        for name in other {
            // Usually there is none.
            let _ = std::fs::remove_file(folder.path().join(name));
        }
    }
    Ok(paths)
}
