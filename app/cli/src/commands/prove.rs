//! `aghf prove`.

use super::{CHECK_FAILED, print, print_json};
use crate::output::verdict_table;
use aghf::error::Result;
use aghf::verify::field::prove;
use clap::Args;
use serde_json::json;
use std::process::ExitCode;

/// Proves every numbered equation over a prime field, at random robots and states, and prints the ledger.
///
/// Both sides of an equation are computed exactly and compared with ==. A false identity would pass with at most the
/// printed probability. Exit code 1 if an identity fails; the output names it, its conventions, and the first entry
/// that differs.
#[derive(Debug, Args)]
pub(super) struct Prove {
    /// Number of random points.
    #[arg(long, default_value_t = 3)]
    points: usize,
    /// Seed of the points.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
}

impl Prove {
    pub(super) fn run(self) -> Result<ExitCode> {
        let verdicts = prove(self.points, self.seed)?;
        let failures: Vec<&String> = verdicts.iter().filter_map(|v| v.failure.as_ref()).collect();
        if self.json {
            print_json(&json!({
                "points": self.points,
                "seed": self.seed,
                "identities": verdicts.len(),
                "failures": failures.len(),
                "verdicts": verdicts,
            }))?;
        } else {
            print(&verdict_table(&verdicts))?;
            for failure in &failures {
                print(failure)?;
            }
            let (all, failed) = (verdicts.len(), failures.len());
            print(&format!("{all} identities at {} points, {failed} failures", self.points))?;
        }
        Ok(if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(CHECK_FAILED) })
    }
}
