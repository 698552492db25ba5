//! Files that are complete or not there: each is written beside its place and then moved.

use crate::error::{Error, Result};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

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
    Partial::write(path, write)?.complete(true)
}

/// Partial files and empty folders, to be removed should the program end at once.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Takes note of what is unfinished, or of the end of that.
pub(super) fn unfinished(path: &Path, is: bool) {
    let mut all = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    if is {
        all.insert(path.to_owned());
    } else {
        all.remove(path);
    }
}

/// Removes the partial files and empty folders of what is in progress, before the program ends at once.
pub fn remove_unfinished() {
    let all = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    // Files before the folders that they are in, which have shorter names.
    for path in all.iter().rev() {
        // A folder with results cannot be removed.
        let _ = std::fs::remove_file(path).or_else(|_| std::fs::remove_dir(path));
    }
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
        let whole = Self {
            path: path.to_owned(),
            partial: partial.into(),
        };
        unfinished(&whole.partial, true);
        let file = File::create(&whole.partial).map_err(|e| Error::io(path, e))?;
        let mut file = BufWriter::new(file);
        let written = write(&mut file).and_then(|()| {
            file.flush()?;
            file.get_ref().sync_all()
        });
        written.map_err(|e| Error::io(path, e))?;
        Ok(whole)
    }

    /// Moves it to its place. If it may not `replace` a file that is there already, that is an error.
    pub fn complete(self, replace: bool) -> Result<()> {
        let moved = if replace {
            std::fs::rename(&self.partial, &self.path)
        } else {
            // Unlike a rename it fails where there is a file, whoever made it meanwhile.
            std::fs::hard_link(&self.partial, &self.path)
        };
        moved.map_err(|e| Error::io(&self.path, e))
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        // It is not there once it was renamed. What is left of it otherwise helps nobody, and the error to report is another.
        let _ = std::fs::remove_file(&self.partial);
        unfinished(&self.partial, false);
    }
}
