//! `aghf scenarios`.

use super::{RobotArgs, print, print_json};
use crate::output::scenario_table;
use aghf::error::Result;
use aghf_scenario::{SolveOptions, option_keys, scenario_keys, scenario_schema};
use clap::{Args, ValueEnum};
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
    /// Print the JSON Schema of scenario files instead, which a file may name as "$schema" for completion in an editor,
    /// or that of the options of a solve.
    #[arg(long, value_name = "OF", num_args = 0..=1, default_missing_value = "scenario",
        conflicts_with_all = ["scenario", "keys"])]
    schema: Option<Keys>,
    /// Print a Markdown table of the keys of scenario files instead, or of the options of a solve.
    #[arg(long, value_name = "OF", num_args = 0..=1, default_missing_value = "scenario", conflicts_with = "scenario")]
    keys: Option<Keys>,
}

/// The keys that are described.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Keys {
    /// Those of scenario files.
    Scenario,
    /// Those of the options of a solve.
    Options,
}

impl Scenarios {
    pub(super) fn run(self) -> Result<ExitCode> {
        match (&self.scenario, self.schema, self.keys) {
            (_, Some(Keys::Scenario), _) => print_json(&scenario_schema())?,
            (_, Some(Keys::Options), _) => print_json(&SolveOptions::schema())?,
            (_, _, Some(Keys::Scenario)) => print(scenario_keys().trim_end())?,
            (_, _, Some(Keys::Options)) => print(option_keys().trim_end())?,
            (Some(name), ..) => print_json(&self.robot.scenario(name)?.file)?,
            (None, ..) => print(&scenario_table()?)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}
