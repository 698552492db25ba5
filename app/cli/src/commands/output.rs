//! Options for output files.

use super::tell;
use crate::output::{OutputFolder, Sampling};
use aghf::error::{Error, Result};
use clap::Args;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The folder for output files.
#[derive(Debug, Default, Args)]
pub(super) struct OutArgs {
    /// Folder for the files [default: a new one below out/ with the name of the command or scenario, with a number if
    /// necessary].
    #[arg(long, short)]
    out: Option<PathBuf>,
    /// Replaces files that exist.
    #[arg(long)]
    force: bool,
}

impl OutArgs {
    /// The chosen folder.
    pub(super) fn path(&self) -> Option<&Path> {
        self.out.as_deref()
    }

    /// True if files are replaced.
    pub(super) fn replaces(&self) -> bool {
        self.force
    }

    /// The chosen folder for files of these names, otherwise `name` in the folder `parent`, or a new folder of a
    /// similar name.
    pub(super) fn folder(&self, parent: &Path, name: &str, files: &[&str]) -> Result<OutputFolder> {
        if let Some(path) = &self.out {
            return OutputFolder::open(path, files, self.force);
        }
        let path = parent.join(name);
        if path.file_name() != Some(OsStr::new(name)) {
            let condition = "its name is not that of a folder; --out chooses one";
            return Err(Error::input(name, "output", condition));
        }
        if self.force { OutputFolder::open(&path, files, true) } else { OutputFolder::fresh(&path) }
    }
}

/// A folder for the files called `name` in place of one that has meanwhile been removed, filled, or taken by another
/// process, so that no motion is lost.
pub(super) fn spare(error: &Error, name: &str) -> Result<OutputFolder> {
    tell(&format!("aghf: {error}"));
    let spare = OutputFolder::private(name)?;
    tell(&format!("aghf: the files are in {}", spare.path().display()));
    Ok(spare)
}

/// The rows of the table of a motion.
#[derive(Debug, Default, Args)]
pub(super) struct SamplingArgs {
    /// Rows of the table per second, Hz, from the start, and one at the end.
    #[arg(long, conflicts_with = "samples", allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Rows of the table at equal distances, both ends of the motion included [default: as many as
    /// `aghf judge` needs, 201 or more].
    #[arg(long)]
    samples: Option<usize>,
}

impl SamplingArgs {
    /// The chosen rows, if any were.
    pub(super) fn sampling(&self) -> Option<Sampling> {
        let samples = self.samples.map(Sampling::Samples);
        self.rate.map(Sampling::Rate).or(samples)
    }
}
