//! Atomic writing of files: each is written to a temporary file and then renamed.

use aghf::error::{Error, Result};
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

/// Writes a temporary file next to `path` and renames it once it is complete.
pub(crate) fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<()> {
    Partial::write(path, write)?.complete(true)
}

/// Partial files and empty folders, which are removed if the program ends early.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Registers an unfinished file or folder, or removes it from the register.
pub(super) fn unfinished(path: &Path, is: bool) {
    let mut all = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    if is {
        all.insert(path.to_owned());
    } else {
        all.remove(path);
    }
}

/// Removes unfinished files and empty folders before the program ends early.
pub fn remove_unfinished() {
    let all = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    // Files before the folders that they are in, which have shorter names.
    for path in all.iter().rev() {
        // A folder with results cannot be removed.
        let _ = std::fs::remove_file(path).or_else(|_| std::fs::remove_dir(path));
    }
}

/// A complete temporary file, which is removed unless it is renamed.
pub(super) struct Partial {
    path: PathBuf,
    partial: PathBuf,
}

impl Partial {
    /// Writes a temporary file next to `path`.
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

    /// Renames the file to its final path. An existing file is an error unless `replace` is true.
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
