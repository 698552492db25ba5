//! Scenarios by name or by path.

use crate::builtin::builtin_scenario;
use crate::generate::generate_for;
use crate::keys::json::read_json;
use crate::results::provenance::is_summary;
use crate::{Scenario, ScenarioFile, SolveOptions, Solved};
use aghf::error::{Error, Result};
use aghf::input::read_named;
use aghf::urdf::Mimic;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf, absolute};

/// Values beside a scenario, which replace those of its keys.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// The robot of a generated scenario that accepts any: a built-in name or the path of a URDF file.
    pub robot: Option<String>,
    /// The treatment of mimic joints.
    pub mimic: Option<Mimic>,
    /// Further folders of packages by their names, relative to the current folder.
    pub packages: BTreeMap<String, PathBuf>,
    /// An SRDF, relative to the current folder.
    pub srdf: Option<PathBuf>,
    /// The group of joints that are planned.
    pub group: Option<String>,
}

impl LoadOptions {
    /// Replaces the keys of a file.
    pub(super) fn apply(&self, file: &mut ScenarioFile) -> Result<()> {
        file.mimic = self.mimic.unwrap_or(file.mimic);
        file.packages.extend(absolute_folders(&self.packages)?);
        if let Some(srdf) = &self.srdf {
            let found = absolute(srdf).map_err(|e| Error::io(srdf.clone(), e))?;
            file.srdf = Some(found);
        }
        if let Some(group) = &self.group {
            file.group = Some(group.clone());
        }
        Ok(())
    }
}

/// The folders, relative to the current one, with absolute paths.
pub(super) fn absolute_folders(packages: &BTreeMap<String, PathBuf>) -> Result<BTreeMap<String, PathBuf>> {
    let packages = packages.iter().map(|(name, folder)| {
        let absolute = absolute(folder).map_err(|e| Error::io(folder.clone(), e))?;
        Ok((name.clone(), absolute))
    });
    packages.collect()
}

impl Scenario {
    /// Loads the scenario that is built in or generated under this name, otherwise the one in the file at this path.
    ///
    /// # Errors
    /// Names the file, the key and the fault.
    pub fn load(name_or_path: &str) -> Result<Self> {
        Self::load_for(name_or_path, &LoadOptions::default())
    }

    /// Loads as [`load`](Self::load) does, with options.
    ///
    /// # Errors
    /// Those of [`load`](Self::load), and a robot given for a scenario that names its own.
    pub fn load_for(name_or_path: &str, given: &LoadOptions) -> Result<Self> {
        let (scenario, _) = Self::load_with_options(name_or_path, given)?;
        Ok(scenario)
    }

    /// Loads as [`load_for`](Self::load_for) does, together with the options of the solve if the file is a summary;
    /// default options otherwise.
    ///
    /// # Errors
    /// Those of [`load_for`](Self::load_for), and of [`Solved::load`] for a summary.
    pub fn load_with_options(name_or_path: &str, given: &LoadOptions) -> Result<(Self, SolveOptions)> {
        let options = SolveOptions::default();
        let (robot, mimic) = (given.robot.as_deref(), given.mimic.unwrap_or_default());
        if let Some(generated) = generate_for(name_or_path, robot, mimic) {
            let mut file = generated?;
            given.apply(&mut file)?;
            return Ok((Self::new(file, name_or_path, Path::new(""))?, options));
        }
        if robot.is_some() {
            let condition = "the scenario names its robot; only generated ones can be for another";
            return Err(Error::input(name_or_path, "robot", condition));
        }
        let path = Path::new(name_or_path);
        let (text, folder) = match builtin_scenario(name_or_path) {
            Some(text) => (text.to_owned(), Path::new("")),
            None => (read_named(path, "scenario")?, path.parent().unwrap_or(Path::new(""))),
        };
        if is_summary(&text) {
            let solved = Solved::parse(&text, name_or_path, given)?;
            return Ok((solved.scenario, solved.summary.provenance.options));
        }
        let mut file: ScenarioFile = read_json(&text, name_or_path)?;
        given.apply(&mut file)?;
        Ok((Self::new(file, name_or_path, folder)?, options))
    }
}
