//! `aghf certify`.

use super::compare::summary_at;
use super::{CHECK_FAILED, RobotArgs, print};
use crate::output::{certification_text, refuse_existing, write_json, write_text};
use aghf::error::{Error, Result};
use aghf_scenario::Solved;
use aghf_scenario::certify::certify;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Prove that a motion keeps the promises of its scenario at all times, and write the proof.
///
/// Limits of positions, velocities, accelerations, jerks and torques, clearances, and the states at both ends are proved
/// for every time, not for samples, with rounding accounted for. The certificate lists intervals and a reserve of each
/// promise on each; `aghf-check` and `python -m aghf.check_certificate` check it with code of their own. Exit code 1,
/// and no file, if a promise is broken or cannot be proved; the message names each row, its time and its excess. What the
/// scenario asks for and no certificate covers yet is listed in it and printed.
#[derive(Debug, Args)]
pub(super) struct Certify {
    /// A built-in or generated scenario, or the path of a JSON file, "-" for the standard input.
    scenario: String,
    #[command(flatten)]
    robot: RobotArgs,
    /// Folder of a solve, or its summary.json.
    run: PathBuf,
    /// File for the certificate.
    #[arg(long, short, default_value = "certificate.json")]
    out: PathBuf,
    /// Replace the file if it exists.
    #[arg(long)]
    force: bool,
}

impl Certify {
    pub(super) fn run(self) -> Result<ExitCode> {
        refuse_existing(&self.out, self.force)?;
        let scenario = self.robot.scenario(&self.scenario)?;
        let solved = Solved::load(&summary_at(&self.run)?)?;
        let begin = Instant::now();
        let certification = certify(&scenario, &solved)?;
        let seconds = begin.elapsed().as_secs_f64();
        print(&certification_text(&certification, seconds))?;
        let Some(certificate) = certification.certificate else {
            return Ok(ExitCode::from(CHECK_FAILED));
        };
        let mut text = Vec::new();
        write_json(&certificate, &mut text).map_err(|e| Error::io(self.out.clone(), e))?;
        write_text(&format!("{}\n", String::from_utf8_lossy(&text)), &self.out)?;
        print(&format!("wrote {}", self.out.display()))?;
        Ok(ExitCode::SUCCESS)
    }
}
