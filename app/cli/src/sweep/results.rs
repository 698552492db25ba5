//! The file `results.csv`: one line per set, written as soon as the set is solved.
//!
//! An interrupted sweep is resumed; each set, also a refused one, is in the file at most once. `sweep.json` next to it
//! identifies the sweep, so that results of two sweeps cannot be mixed. At the end the lines are sorted in the order of
//! the grid.

use super::{ParameterSet, Row, Shard, Sweep};
use crate::output::{ResultsFile, complete_lines, csv_of, line_error, write_json, write_whole};
use aghf::error::{Error, Result};
use csv::StringRecord;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Writes rows as a JSON array of objects; numbers that are not finite are null.
///
/// # Errors
/// The file cannot be written.
pub fn write_rows(rows: &[Row], path: &Path) -> Result<()> {
    write_whole(path, |file| write_json(&rows, file))
}

/// The rows of a sweep, or of a shard of it, in a file that is locked and open for further rows.
#[derive(Debug)]
pub struct Results<'s> {
    sweep: &'s Sweep,
    shard: Shard,
    path: PathBuf,
    /// The file and its rows behind one lock, so that both agree and lines are complete.
    state: Mutex<(ResultsFile, BTreeMap<usize, Row>)>,
}

impl<'s> Results<'s> {
    /// Opens the results of `shard` in `folder`, both created if necessary, and reads the existing rows. An incomplete
    /// last line, of an interrupted process, is dropped.
    ///
    /// # Errors
    /// The folder has results of another sweep, another process uses the file, or a line of it is invalid.
    pub fn open(sweep: &'s Sweep, shard: Shard, folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
        let path = folder.join(file_name(shard));
        let identity = folder.join("sweep.json");
        if identity.exists() {
            check_identity(sweep, &identity)?;
        } else if path.exists() {
            let condition = "it is missing, so the results beside it could be of any sweep";
            return Err(Error::input(identity.display().to_string(), "sweep", condition));
        } else {
            let value = sweep.identity();
            write_whole(&identity, |file| write_json(&value, file))?;
        }
        let (file, lines) = ResultsFile::open(&path, &any_row(sweep))?;
        let rows = parse(sweep, shard, &lines, &path)?;
        Ok(Self { sweep, shard, path, state: Mutex::new((file, rows)) })
    }

    /// The sets of the shard that have no row yet.
    #[must_use]
    pub fn missing(&self) -> Vec<ParameterSet> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let missing = self.sets().filter(|set| !state.1.contains_key(&set.index));
        missing.copied().collect()
    }

    /// The existing rows, in the order of the grid.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.1.values().cloned().collect()
    }

    fn sets(&self) -> impl Iterator<Item = &'s ParameterSet> {
        let shard = self.shard;
        (self.sweep.sets.iter()).filter(move |set| shard.has(set.index))
    }

    /// Appends a row to the file; it is on the disk when this returns.
    ///
    /// # Errors
    /// The file cannot be written. A partial row is dropped when the file is opened again.
    pub fn append(&self, row: Row) -> Result<()> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.0.append(&row)?;
        state.1.insert(row.set, row);
        Ok(())
    }

    /// Sorts the lines of the file in the order of the grid and returns its rows and its path.
    ///
    /// # Errors
    /// Sets are missing, or the file cannot be written.
    pub fn finish(self) -> Result<(Vec<Row>, PathBuf)> {
        let missing = self.missing();
        if let Some(first) = missing.first() {
            let (count, all) = (missing.len(), self.sets().count());
            let condition = format!("{count} of {all} sets are missing, the first is set {}", first.index);
            let file = self.path.display().to_string();
            return Err(Error::input(file, "results", condition));
        }
        // The lock is held until the new file is in place.
        let (_file, rows) = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        let rows: Vec<Row> = rows.into_values().collect();
        let text = csv_of(&rows, true)?;
        write_whole(&self.path, |file| file.write_all(&text))?;
        Ok((rows, self.path))
    }
}

/// Merges files of shards, each with a `sweep.json` next to it, into `results.csv` in `folder`.
///
/// # Errors
/// A file is of another sweep or has an invalid line, two of them differ in a set, or sets are missing.
pub fn merge(sweep: &Sweep, files: &[PathBuf], folder: &Path) -> Result<(Vec<Row>, PathBuf)> {
    let results = Results::open(sweep, Shard::WHOLE, folder)?;
    {
        let mut state = results.state.lock().unwrap_or_else(PoisonError::into_inner);
        for path in files {
            check_identity(sweep, &path.with_file_name("sweep.json"))?;
            let text = std::fs::read(path).map_err(|e| Error::io(path, e))?;
            let lines = complete_lines(&text, &any_row(sweep), path)?;
            for (set, row) in parse(sweep, Shard::WHOLE, &lines, path)? {
                let known = state.1.entry(set).or_insert_with(|| row.clone());
                if !known.agrees(&row) {
                    let condition = "another file has other values for this set";
                    let element = format!("set {set}");
                    return Err(Error::input(path.display().to_string(), element, condition));
                }
            }
        }
    }
    results.finish()
}

/// The files of shards in a folder, by name.
///
/// # Errors
/// The folder cannot be read.
pub fn shard_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = |e| Error::io(folder, e);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("results.shard-") && name.ends_with(".csv") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn file_name(shard: Shard) -> String {
    match shard {
        Shard::WHOLE => "results.csv".to_owned(),
        Shard { index, count } => format!("results.shard-{index}-of-{count}.csv"),
    }
}

/// Refuses a `sweep.json` of another sweep.
fn check_identity(sweep: &Sweep, path: &Path) -> Result<()> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
    let refuse = |element: String, condition| Err(Error::input(path.display().to_string(), element, condition));
    let Ok(found) = serde_json::from_str::<Value>(&text) else {
        return refuse("sweep".to_owned(), "it is no JSON");
    };
    match difference(&found, &sweep.identity()) {
        Some(key) => {
            let key = if key.is_empty() { "sweep" } else { &key[1..] };
            let condition = "the results here are of a sweep with another value; choose another folder or remove \
                this one";
            refuse(key.to_owned(), condition)
        }
        None => Ok(()),
    }
}

/// The path of the first value that differs.
fn difference(a: &Value, b: &Value) -> Option<String> {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            a.keys().chain(b.keys()).find_map(|key| match (a.get(key), b.get(key)) {
                (Some(a), Some(b)) => difference(a, b).map(|rest| format!(".{key}{rest}")),
                _ => Some(format!(".{key}")),
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            (a.iter().zip(b)).enumerate().find_map(|(i, (a, b))| difference(a, b).map(|rest| format!(".{i}{rest}")))
        }
        _ => (a != b).then(String::new),
    }
}

/// A row with the columns of the file.
fn any_row(sweep: &Sweep) -> Row {
    Row::failed(sweep, &sweep.sets[0], "", 0.0)
}

/// The rows in the lines of a file, by set.
fn parse(sweep: &Sweep, shard: Shard, lines: &[StringRecord], path: &Path) -> Result<BTreeMap<usize, Row>> {
    let mut rows = BTreeMap::new();
    for (i, line) in lines.iter().enumerate() {
        let refuse = |condition| line_error(path, i, condition);
        let set = line[0].parse::<usize>().map_err(|e| refuse(e.to_string()))?;
        let own = sweep.sets.get(set).filter(|_| shard.has(set));
        let own = own.ok_or_else(|| refuse(format!("its set {set} is not one of this sweep")))?;
        let row = Row::read(sweep, own, line).map_err(refuse)?;
        if let Some(row) = rows.insert(row.set, row) {
            let condition = format!("set {} is there already", row.set);
            return Err(refuse(condition));
        }
    }
    Ok(rows)
}
