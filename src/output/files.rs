//! Files that are complete or not there: each is written beside its place and then moved.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes `text` to the file at `path`.
///
/// # Errors
/// The file cannot be written.
pub fn write_text(text: &str, path: &Path) -> Result<()> {
    write_whole(path, |file| file.write_all(text.as_bytes()))
}

/// Writes a file beside `path` and moves it there once it is complete.
pub(crate) fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<()> {
    Partial::write(path, write)?.complete()
}

/// A complete file beside its place; removed unless it is moved there.
pub(super) struct Partial {
    path: PathBuf,
    partial: PathBuf,
}

impl Partial {
    /// Writes a file beside `path`.
    pub fn write(
        path: &Path,
        write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<Self> {
        let mut partial = path.as_os_str().to_owned();
        partial.push(format!(".{}.partial", std::process::id()));
        let file = File::create(&partial).map_err(|e| Error::io(path, e))?;
        let whole = Self {
            path: path.to_owned(),
            partial: partial.into(),
        };
        let mut file = BufWriter::new(file);
        let written = write(&mut file).and_then(|()| {
            file.flush()?;
            file.get_ref().sync_all()
        });
        written.map_err(|e| Error::io(path, e))?;
        Ok(whole)
    }

    /// Moves it to its place, where it takes that of any other file.
    pub fn complete(self) -> Result<()> {
        std::fs::rename(&self.partial, &self.path).map_err(|e| Error::io(&self.path, e))
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        // It is not there once it was moved. What is left of it otherwise helps nobody, and the error to report is another.
        let _ = std::fs::remove_file(&self.partial);
    }
}
