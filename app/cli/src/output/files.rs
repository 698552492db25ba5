//! Atomic writing of files: each is written to a temporary file and then renamed.

use aghf::error::{Error, Result};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::NamedTempFile;

/// Writes `text` to the file at `path`.
///
/// # Errors
/// The file cannot be written.
pub fn write_text(text: &str, path: &Path) -> Result<()> {
    write_whole(path, |file| file.write_all(text.as_bytes()))
}

/// Writes a temporary file next to `path` and renames it once it is complete.
pub(crate) fn write_whole(path: &Path, write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<()> {
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
    // In reverse order, because the name of a folder comes before those of its files.
    for path in all.iter().rev() {
        // Best effort: a folder with results cannot be removed.
        let _ = std::fs::remove_file(path).or_else(|_| std::fs::remove_dir(path));
    }
}

/// Refuses a path at which there is something else than a file, such as a device, which renaming would replace.
pub(super) fn refuse_special(path: &Path) -> Result<()> {
    let kind = match path.symlink_metadata() {
        Ok(found) if !found.is_file() => found.file_type(),
        _ => return Ok(()),
    };
    let what = if kind.is_dir() {
        "a folder"
    } else if kind.is_symlink() {
        "a symbolic link"
    } else {
        "a device, a pipe or a socket"
    };
    let condition = format!("it is {what}; the path of a file is needed, of a new one or of one to replace");
    let file = path.display().to_string();
    Err(Error::input(file, "output", condition))
}

/// A complete temporary file, which is removed unless it is renamed.
pub(super) struct Partial {
    path: PathBuf,
    partial: NamedTempFile,
}

impl Partial {
    /// Writes a new file of a random name next to `path`, so that no existing file or link is written through.
    pub fn write(path: &Path, write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<Self> {
        refuse_special(path)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(path.file_name().unwrap_or_default());
        builder.suffix(".partial");
        // Permissions by the umask, as for any result; by default only the owner could read the file.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let partial = builder.tempfile_in(folder.unwrap_or(Path::new(".")));
        let mut whole = Self { path: path.to_owned(), partial: partial.map_err(|e| Error::io(path, e))? };
        unfinished(whole.partial.path(), true);
        let mut file = BufWriter::new(whole.partial.as_file_mut());
        let written = write(&mut file).and_then(|()| {
            file.flush()?;
            file.get_ref().sync_all()
        });
        drop(file);
        written.map_err(|e| Error::io(path, e))?;
        Ok(whole)
    }

    /// Renames the file to its final path. An existing file is an error unless `replace` is true.
    pub fn complete(self, replace: bool) -> Result<()> {
        let Self { path, partial } = self;
        unfinished(partial.path(), false);
        let moved = if replace {
            partial.persist(&path)
        } else {
            // Unlike a rename, this fails if the file exists, even if another process has just created it.
            partial.persist_noclobber(&path)
        };
        moved.map_err(|e| Error::io(&path, e.error))?;
        Ok(())
    }
}
