//! Options for the files that are written.

use crate::error::Result;
use crate::output::{OutputFolder, Sampling};
use clap::Args;
use std::path::{Path, PathBuf};

/// The place for files.
#[derive(Debug, Default, Args)]
pub(super) struct OutArgs {
    /// The folder for the files [default: one below out/ with the name of what runs, and a number where there is such a folder already].
    #[arg(long)]
    out: Option<PathBuf>,
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

impl OutArgs {
    /// The folder for files of these names, or else `default`, or one like it that was not there.
    pub(super) fn folder(&self, default: &Path, files: &[&str]) -> Result<OutputFolder> {
        match &self.out {
            Some(path) => OutputFolder::open(path, files, self.force),
            None if self.force => OutputFolder::open(default, files, true),
            None => OutputFolder::fresh(default),
        }
    }
}

/// The rows of a table of a motion.
#[derive(Debug, Default, Args)]
pub(super) struct SamplingArgs {
    /// Rows of the table per second, Hz, from the start, and one at the end.
    #[arg(long, conflicts_with = "samples", allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Rows of the table at equal distances, both ends of the motion included [default: 201].
    #[arg(long)]
    samples: Option<usize>,
}

impl SamplingArgs {
    pub(super) fn sampling(&self) -> Sampling {
        let samples = self.samples.map(Sampling::Samples);
        (self.rate.map(Sampling::Rate))
            .or(samples)
            .unwrap_or_default()
    }
}
