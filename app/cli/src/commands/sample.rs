//! `aghf sample`.

use super::compare::summary_at;
use super::output::SamplingArgs;
use super::{print, printed};
use crate::output::{Sampling, failure_comment, refuse_existing, write_table, write_trajectory};
use aghf::error::Result;
use aghf::input::read_bytes;
use aghf_scenario::certify::NAME;
use aghf_scenario::{Solved, sha256};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Makes a table of a motion from the summary of a solve, at any rate.
///
/// The columns are those of trajectory.csv: t (s), then q_JOINT (rad or m), v_JOINT (rad/s or m/s), a_JOINT (rad/s^2 or
/// m/s^2) and u_JOINT (N m or N) of every joint. Before them is a comment, after a #, with the SHA-256 of the summary,
/// by which `aghf check-certificate --table` knows the motion, and for a failed solve another one with the reason.
#[derive(Debug, Args)]
pub(super) struct Sample {
    /// Folder of a solve, or its summary.json.
    run: PathBuf,
    #[command(flatten)]
    sampling: SamplingArgs,
    /// File for the table [default: the standard output].
    #[arg(long, short)]
    out: Option<PathBuf>,
    /// Replaces the file if it exists.
    #[arg(long, requires = "out")]
    force: bool,
}

impl Sample {
    pub(super) fn run(self) -> Result<ExitCode> {
        let path = summary_at(&self.run)?;
        let Solved { scenario, curve, summary } = Solved::load(&path)?;
        let model = &scenario.model;
        let mut comments = vec![format!("{NAME}{}", sha256(&read_bytes(Path::new(&path))?))];
        comments.extend(failure_comment(summary.failure.as_deref()));
        let chosen = self.sampling.sampling();
        let times = Sampling::or_sufficient(chosen, &scenario, &curve)?.times(curve.horizon())?;
        match &self.out {
            Some(path) => {
                refuse_existing(path, self.force)?;
                write_table(model, &curve, times, &comments, path)?;
                print(&format!("wrote {}", path.display()))?;
            }
            None => {
                let out = std::io::stdout().lock();
                printed(write_trajectory(model, &curve, times, &comments, out))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
