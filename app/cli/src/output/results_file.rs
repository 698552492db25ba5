//! A file of results: a header, then a line of comma-separated values per problem, on the disk as soon as it is solved.

use super::csv_of;
use aghf::error::{Error, Result};
use csv::StringRecord;
use serde::Serialize;
use std::fs::{File, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// A file of results that is locked and open for further lines. An interruption at any byte loses the incomplete line
/// alone, which is dropped when the file is opened again.
#[derive(Debug)]
pub struct ResultsFile {
    path: PathBuf,
    file: File,
}

impl ResultsFile {
    /// Opens the file at `path`, created if necessary, and reads its lines. `header` is a row with its columns.
    ///
    /// # Errors
    /// Another process uses the file, it cannot be read or written, its header is another one, or a line is no CSV.
    pub fn open(path: &Path, header: &impl Serialize) -> Result<(Self, Vec<StringRecord>)> {
        let io = |e| Error::io(path, e);
        let mut options = File::options();
        let mut file = options.read(true).append(true).create(true).open(path).map_err(io)?;
        file.try_lock().map_err(|e| match e {
            TryLockError::WouldBlock => {
                let condition = "another process is at work on it";
                Error::input(path.display().to_string(), "results", condition)
            }
            TryLockError::Error(e) => Error::io(path, e),
        })?;
        let mut text = Vec::new();
        file.read_to_end(&mut text).map_err(io)?;
        let lines = complete_lines(&text, header, path)?;
        let mut own = Self { path: path.to_owned(), file };
        let complete = complete(&text).len();
        if complete < text.len() {
            own.file.set_len(complete as u64).map_err(io)?;
        }
        if complete == 0 {
            own.write(&header_line(header)?)?;
        }
        Ok((own, lines))
    }

    /// Appends a row; it is on the disk when this returns.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(&mut self, row: &impl Serialize) -> Result<()> {
        self.write(&csv_of([row], false)?)
    }

    /// Writes with one call, so that lines of two calls never mix.
    fn write(&mut self, line: &[u8]) -> Result<()> {
        let written = self.file.write_all(line).and_then(|()| self.file.sync_data());
        written.map_err(|e| Error::io(&self.path, e))
    }
}

/// The complete lines below the header in the text of a file; `header` is a row with its columns.
///
/// # Errors
/// The header is another one, or a line is no CSV.
pub fn complete_lines(text: &[u8], header: &impl Serialize, path: &Path) -> Result<Vec<StringRecord>> {
    let text = complete(text);
    if !text.is_empty() && !text.starts_with(&header_line(header)?) {
        let condition = "it is not the header that this version writes; choose another folder";
        return Err(Error::input(path.display().to_string(), "line 1", condition));
    }
    let lines = csv::Reader::from_reader(text).into_records().enumerate();
    lines.map(|(i, line)| line.map_err(|e| line_error(path, i, e))).collect()
}

/// The error of the line of this index below the header.
pub(crate) fn line_error(path: &Path, index: usize, condition: impl std::fmt::Display) -> Error {
    Error::input(path.display().to_string(), format!("line {}", index + 2), condition.to_string())
}

/// The text up to the end of its last complete line.
fn complete(text: &[u8]) -> &[u8] {
    let end = text.iter().rposition(|byte| *byte == b'\n');
    &text[..end.map_or(0, |end| end + 1)]
}

/// The line with the columns of a row.
fn header_line(row: &impl Serialize) -> Result<Vec<u8>> {
    let mut text = csv_of([row], true)?;
    let end = text.iter().position(|byte| *byte == b'\n');
    text.truncate(end.map_or(0, |end| end + 1));
    Ok(text)
}
