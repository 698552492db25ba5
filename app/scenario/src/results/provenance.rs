//! All inputs of a solve, so that it can be repeated.

use crate::keys::json::read_json;
use crate::{LoadOptions, Scenario, ScenarioFile, SolveOptions, Summary};
use aghf::curve::Curve;
use aghf::error::{Error, Result};
use aghf::input::read_named;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The key of a summary that scenarios do not have.
const KEY: &str = "provenance";

/// All inputs of a solve.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The version of this library.
    pub version: String,
    /// The commit of the build, with `-modified` if files had changed since; empty if the build was not in a
    /// repository.
    pub commit: String,
    /// The SHA-256 of the text of the robot, in hexadecimal digits.
    pub robot_sha256: String,
    /// The options, defaults filled in.
    pub options: SolveOptions,
    /// The scenario. Its robot is built in, or at an absolute path, as packages are.
    pub scenario: ScenarioFile,
}

impl Provenance {
    /// The provenance of a solve with these options.
    pub(crate) fn new(scenario: &Scenario, options: &SolveOptions) -> Result<Self> {
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: git_version::git_version!(
                args = ["--always", "--dirty=-modified", "--abbrev=12", "--exclude=*"],
                fallback = ""
            )
            .to_owned(),
            robot_sha256: scenario.robot_sha256.clone(),
            options: options.in_full(scenario)?,
            scenario: scenario.placed_file(),
        })
    }
}

impl Scenario {
    /// The file with a robot that is built in, or at an absolute path.
    pub(crate) fn placed_file(&self) -> ScenarioFile {
        ScenarioFile { robot: self.robot_place.clone(), ..self.file.clone() }
    }
}

/// A solve as stored in its `summary.json`.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The scenario.
    pub scenario: Scenario,
    /// The motion.
    pub curve: Curve,
    /// The contents of the file.
    pub summary: Summary,
}

impl Solved {
    /// Loads a solve from a file that `aghf_cli::output::write_report` wrote.
    ///
    /// # Errors
    /// Names the file, the key and the fault, among others a change of the robot's file since the solve.
    pub fn load(path: &str) -> Result<Self> {
        let text = read_named(Path::new(path), "scenario")?;
        if !is_summary(&text) {
            let condition = "it is missing, so this is no summary of a solve";
            return Err(Error::input(path, KEY, condition));
        }
        Self::parse(&text, path, &LoadOptions::default())
    }

    /// Parses the summary of a solve, with the values beside it; `path` names it in errors.
    ///
    /// # Errors
    /// Those of [`load`](Self::load).
    pub fn parse(text: &str, path: &str, given: &LoadOptions) -> Result<Self> {
        let summary: Summary = read_json(text, path)?;
        let (name, provenance) = (&summary.scenario, &summary.provenance);
        let mut file = provenance.scenario.clone();
        given.apply(&mut file)?;
        let mut scenario = Scenario::new(file, path, Path::new(""))?;
        scenario.name = match Path::new(name).file_name() {
            Some(name) => name.to_string_lossy().into_owned(),
            None => {
                let condition = format!("'{name}' is not a valid name");
                return Err(Error::input(path, "scenario", condition));
            }
        };
        if scenario.robot_sha256 != provenance.robot_sha256 {
            let condition = format!(
                "its text is not what it was: the hash is {}, that of the solve {}",
                scenario.robot_sha256, provenance.robot_sha256
            );
            return Err(Error::input(path, scenario.robot_place, condition));
        }
        let curve = summary.curve.curve(&scenario.model, path)?;
        Ok(Self { scenario, curve, summary })
    }
}

/// Returns true if a text is the summary of a solve and not a scenario.
pub(crate) fn is_summary(text: &str) -> bool {
    let value: Option<serde_json::Value> = serde_json::from_str(text).ok();
    value.is_some_and(|value| value.get(KEY).is_some())
}
