//! `aghf scenarios`.

use super::{RobotArgs, print, print_json};
use crate::output::scenario_table;
use aghf::error::Result;
use clap::Args;
use std::process::ExitCode;

/// List the built-in and generated scenarios, or print one as a JSON file.
///
/// Generated ones are called FAMILY_SEED; ten of each family are listed, and any other seed gives a new one.
#[derive(Debug, Args)]
pub(super) struct Scenarios {
    /// A built-in or generated scenario, or the path of a JSON file, "-" for the standard input [default: list all].
    scenario: Option<String>,
    #[command(flatten)]
    robot: RobotArgs,
}

impl Scenarios {
    pub(super) fn run(self) -> Result<ExitCode> {
        match &self.scenario {
            Some(name) => print_json(&self.robot.scenario(name)?.file)?,
            None => print(&scenario_table()?)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}
