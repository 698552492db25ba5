//! Folders for results, without accidental overwriting.

use super::files::{refuse_special, unfinished};
use aghf::error::{Error, Result};
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The largest number of folders of one name.
const MAX_FOLDERS: usize = 10_000;

/// A folder that is tested for writing before the work begins. A newly created one is removed again if nothing was
/// written.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    made: bool,
    replace: bool,
}

impl OutputFolder {
    /// Opens this folder, which is created if necessary, for files of these names.
    ///
    /// # Errors
    /// A file exists already and may not be replaced, the folder cannot be created, or no file can be written in it.
    pub fn open(path: &Path, files: &[&str], replace: bool) -> Result<Self> {
        for file in files {
            refuse_existing(&path.join(file), replace)?;
        }
        let made = !path.exists();
        fs::create_dir_all(path).map_err(|e| Error::io(path, e))?;
        Self::new(path, made, replace)
    }

    /// Creates a new folder: this one, or the same with the suffix `-2`, `-3` and so on.
    ///
    /// # Errors
    /// The folder cannot be created, or no file can be written in it.
    pub fn fresh(path: &Path) -> Result<Self> {
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(|e| Error::io(parent, e))?;
        }
        for number in 1..=MAX_FOLDERS {
            let mut name = path.as_os_str().to_owned();
            if number > 1 {
                name.push(format!("-{number}"));
            }
            // Creating it also reserves the name against other processes.
            match fs::create_dir(&name) {
                Ok(()) => return Self::new(Path::new(&name), true, false),
                Err(e) if e.kind() == ErrorKind::AlreadyExists => (),
                Err(e) => return Err(Error::io(name, e)),
            }
        }
        let condition = format!("there are {MAX_FOLDERS} folders of this name already");
        Err(Error::input(path.display().to_string(), "folder", condition))
    }

    /// Creates a folder of a random name for the results called `name` in the folder of temporary files; on Unix no
    /// other user may read it.
    ///
    /// # Errors
    /// The folder cannot be created.
    pub fn private(name: &str) -> Result<Self> {
        let prefix = format!("aghf-{name}-");
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        let folder = builder.tempdir();
        let folder = folder.map_err(|e| Error::io(std::env::temp_dir(), e))?;
        Self::new(&folder.keep(), true, false)
    }

    fn new(path: &Path, made: bool, replace: bool) -> Result<Self> {
        let folder = Self { path: path.to_owned(), made, replace };
        if made {
            unfinished(path, true);
        }
        let mut probe = tempfile::tempfile_in(path).map_err(|e| Error::io(path, e))?;
        probe.write_all(b"probe").map_err(|e| Error::io(path, e))?;
        Ok(folder)
    }

    /// True if files in it may be replaced.
    #[must_use]
    pub fn replaces(&self) -> bool {
        self.replace
    }

    /// The path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if self.made {
            // Best effort: only an empty folder can be removed, and one with results should stay.
            let _ = fs::remove_dir(&self.path);
            unfinished(&self.path, false);
        }
    }
}

/// Refuses a file that exists already, unless it may be replaced, and anything that is no file.
///
/// # Errors
/// Names the file.
pub fn refuse_existing(path: &Path, replace: bool) -> Result<()> {
    refuse_special(path)?;
    if replace || !path.exists() {
        return Ok(());
    }
    let condition = "it exists already; --force replaces it";
    let file = path.display().to_string();
    Err(Error::input(file, "output", condition))
}
