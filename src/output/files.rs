//! Results as files. Every file is complete or not there: it is written beside its place and then moved.

use crate::error::{Error, Result};
use crate::model::Model;
use crate::motion::sample;
use crate::scenario::SolveReport;
use serde::Serialize;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// How many intervals of time `trajectory.csv` has.
const INTERVALS: usize = 200;

/// Writes `trajectory.csv` (t, q, v, a, u at 201 times, see [`sample`]) and `summary.json` into `folder`, which is made if need be, and
/// returns where they are.
///
/// # Errors
/// A file cannot be written.
pub fn write_report(model: &Model, outcome: &SolveReport, folder: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    let trajectory = folder.join("trajectory.csv");
    let samples = sample(model, &outcome.curve, INTERVALS)?;
    write_whole(&trajectory, |file| {
        let mut csv = csv::Writer::from_writer(file);
        let columns = ["q", "v", "a", "u"].iter().flat_map(|quantity| {
            model
                .joints()
                .iter()
                .map(move |joint| format!("{quantity}_{}", joint.name()))
        });
        csv.write_record(std::iter::once("t".to_owned()).chain(columns))?;
        for s in &samples {
            let row = [&s.q, &s.v, &s.a, &s.u].into_iter().flatten();
            let row = std::iter::once(&s.t).chain(row);
            csv.write_record(row.map(|x| format!("{x:?}")))?;
        }
        csv.flush()
    })?;
    let summary = folder.join("summary.json");
    write_whole(&summary, |file| {
        write_json(&outcome.summary, &mut *file)?;
        file.write_all(b"\n")
    })?;
    Ok(vec![trajectory, summary])
}

/// Writes `text` to the file at `path`.
///
/// # Errors
/// The file cannot be written.
pub fn write_text(text: &str, path: &Path) -> Result<()> {
    write_whole(path, |file| file.write_all(text.as_bytes()))
}

/// Writes a value as readable JSON.
///
/// # Errors
/// The writer fails.
pub fn write_json(value: &impl Serialize, writer: impl Write) -> io::Result<()> {
    serde_json::to_writer_pretty(writer, value).map_err(io::Error::from)
}

/// Writes a file beside `path` and moves it there once it is complete.
pub(crate) fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<()> {
    let mut partial = path.as_os_str().to_owned();
    partial.push(format!(".{}.partial", std::process::id()));
    let whole = || -> io::Result<()> {
        let mut file = BufWriter::new(File::create(&partial)?);
        write(&mut file)?;
        file.flush()?;
        file.get_ref().sync_all()?;
        std::fs::rename(&partial, path)
    };
    whole().map_err(|e| {
        // What is left of it helps nobody, and the error to report is the first one.
        let _ = std::fs::remove_file(&partial);
        Error::io(path, e)
    })
}
