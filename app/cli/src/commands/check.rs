//! `aghf check`.

use super::{CHECK_FAILED, UrdfArgs, print, print_json};
use crate::output::check_table;
use aghf::error::Result;
use aghf::verify::{CheckOptions, check_all};
use clap::Args;
use serde_json::json;
use std::process::ExitCode;

/// Compares every analytic derivative with dual numbers at random states of a robot, and the direct method with the
/// flow.
///
/// Prints the worst relative error of each quantity, its entry in the matrix and the number of its state; the same seed
/// gives the same states. With --json the states are printed too. Exit code 1 if an error exceeds its bound.
#[derive(Debug, Args)]
pub(super) struct Check {
    /// A built-in robot, or the path of a URDF file, "-" for the standard input.
    robot: String,
    #[command(flatten)]
    reading: UrdfArgs,
    /// Number of random states.
    #[arg(long, default_value_t = CheckOptions::default().samples)]
    samples: usize,
    /// Seed of the states.
    #[arg(long, default_value_t = CheckOptions::default().seed)]
    seed: u64,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
}

impl Check {
    pub(super) fn run(self) -> Result<ExitCode> {
        let model = self.reading.load(&self.robot)?;
        let options = CheckOptions { samples: self.samples, seed: self.seed, ..CheckOptions::default() };
        let findings = check_all(&model, &options)?;
        let off = findings.iter().filter(|f| !f.passes()).count();
        let passed = off == 0;
        if self.json {
            let (samples, seed) = (self.samples, self.seed);
            print_json(&json!({
                "robot": self.robot,
                "samples": samples,
                "seed": seed,
                "passed": passed,
                "findings": findings,
            }))?;
        } else {
            print(&check_table(&findings))?;
            let (all, states) = (findings.len(), self.samples);
            print(&format!("{all} quantities at {states} states, {off} off"))?;
        }
        Ok(if passed { ExitCode::SUCCESS } else { ExitCode::from(CHECK_FAILED) })
    }
}
