//! Options for output files.

use crate::output::{OutputFolder, Sampling};
use aghf::error::Result;
use clap::Args;
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
    /// The chosen folder for files of these names, otherwise `default` or a new folder of a similar name.
    pub(super) fn folder(&self, default: &Path, files: &[&str]) -> Result<OutputFolder> {
        match &self.out {
            Some(path) => OutputFolder::open(path, files, self.force),
            None if self.force => OutputFolder::open(default, files, true),
            None => OutputFolder::fresh(default),
        }
    }
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
