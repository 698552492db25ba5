//! `aghf scenarios`.

use super::{RobotArgs, print, print_json};
use crate::error::Result;
use crate::output::scenario_table;
use clap::Args;
use std::process::ExitCode;

/// List the scenarios that are built in or generated, or print one as the JSON file that it would be.
///
/// Generated ones are called FAMILY_SEED; ten of each family are listed, and any other seed makes another.
#[derive(Debug, Args)]
pub(super) struct Scenarios {
    /// A scenario that is built in or generated, or the path of a JSON file, "-" for the standard input [default: list all].
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
