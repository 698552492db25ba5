//! `aghf scenarios`.

use super::{RobotArgs, print, print_json};
use crate::output::{refuse_existing, scenario_table, write_json, write_whole};
use aghf::error::Result;
use aghf::input::read_named;
use aghf_scenario::{ScenarioFile, SolveOptions, option_keys, scenario_keys, scenario_schema};
use clap::{Args, ValueEnum};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Lists the built-in and generated scenarios, or prints one as a JSON file.
///
/// Generated ones are called FAMILY_SEED; ten of each family are listed, and any other seed gives a new one.
#[derive(Debug, Args)]
pub(super) struct Scenarios {
    /// A built-in or generated scenario, or the path of a JSON file, "-" for the standard input [default: list all].
    scenario: Option<String>,
    #[command(flatten)]
    robot: RobotArgs,
    /// Prints the JSON Schema of scenario files instead, which a file may name as "$schema" for completion in an
    /// editor, or that of the options of a solve.
    #[arg(long, value_name = "OF", num_args = 0..=1, default_missing_value = "scenario",
        conflicts_with_all = ["scenario", "keys"])]
    schema: Option<Keys>,
    /// Prints a Markdown table of the keys of scenario files instead, or of the options of a solve.
    #[arg(long, value_name = "OF", num_args = 0..=1, default_missing_value = "scenario", conflicts_with = "scenario")]
    keys: Option<Keys>,
    /// Rewrites a scenario file of version 0.2 in the form of this version, with the same meaning: defaults that have
    /// changed are written out.
    #[arg(long, requires = "scenario",
        conflicts_with_all = ["schema", "keys", "robot", "mimic", "packages", "group", "srdf"])]
    upgrade: bool,
    /// File for the scenario [default: printed].
    #[arg(long, short, requires = "scenario")]
    out: Option<PathBuf>,
    /// Replaces that file if it exists.
    #[arg(long, requires = "out")]
    force: bool,
}

/// The keys that are described.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Keys {
    /// The keys of scenario files.
    Scenario,
    /// The options of a solve.
    Options,
}

impl Scenarios {
    pub(super) fn run(self) -> Result<ExitCode> {
        match (&self.scenario, self.schema, self.keys) {
            (_, Some(Keys::Scenario), _) => print_json(&scenario_schema())?,
            (_, Some(Keys::Options), _) => print_json(&SolveOptions::schema())?,
            (_, _, Some(Keys::Scenario)) => print(scenario_keys().trim_end())?,
            (_, _, Some(Keys::Options)) => print(option_keys().trim_end())?,
            (Some(name), ..) => self.write(name)?,
            (None, ..) => print(&scenario_table()?)?,
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Writes the scenario of this name.
    fn write(&self, name: &str) -> Result<()> {
        if let Some(path) = &self.out {
            refuse_existing(path, self.force)?;
        }
        let scenario = if self.upgrade {
            ScenarioFile::upgrade(&read_named(Path::new(name), "scenario")?, name)?
        } else {
            self.robot.scenario(name)?.file
        };
        match &self.out {
            None => print_json(&scenario),
            Some(path) => {
                write_whole(path, |file| {
                    write_json(&scenario, &mut *file)?;
                    writeln!(file)
                })?;
                print(&format!("wrote {}", path.display()))
            }
        }
    }
}
