//! A sweep with its scenarios and its sets.

use super::{Grid, SweepFile};
use aghf::error::{Error, Result};
use aghf::input::{entries, name_of, read_named};
use aghf::urdf::builtin_robot_text;
use aghf_scenario::{
    LoadOptions, Method, Scenario, SolveOptions, builtin_scenarios, generated_scenarios, is_generated,
};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::Duration;

/// Names and texts of the built-in sweeps.
macro_rules! sweeps {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../robots/sweeps/", $name, ".toml")))),*]
    };
}

/// The sweeps, in the order of the listing.
const SWEEPS: [(&str, &str); 9] = sweeps!(
    "table_09_pendulums",
    "table_10_kinova",
    "table_11_digit",
    "table_12_kinova_obstacles",
    "table_13_digit_obstacles",
    "table_09_quick",
    "table_10_quick",
    "direct_quick",
    "direct_limits_quick"
);

/// The largest number of sets of a grid, all of whose rows are kept in memory.
const MAX_SETS: usize = 1_000_000;

/// The largest number of scenarios with other keys, each of which is kept with its robot.
const MAX_VARIANTS: usize = 10_000;

/// The names of the built-in sweeps.
pub fn builtin_sweeps() -> impl Iterator<Item = &'static str> {
    SWEEPS.iter().map(|(name, _)| *name)
}

/// One solve of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterSet {
    /// Index in the sweep, from 0.
    pub index: usize,
    /// Index of its scenario in [`Sweep::scenarios`].
    pub scenario: usize,
    /// Index of its point in the grid.
    pub point: usize,
}

/// A sweep with its scenarios, checked.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The name of the folder of results.
    pub name: String,
    /// The contents of the file.
    pub file: SweepFile,
    /// The scenarios.
    pub scenarios: Vec<Scenario>,
    /// Each scenario in turn at all points of the keys of scenarios.
    variants: Vec<Scenario>,
    /// The grid: each scenario in turn with all parameters, in the same order.
    pub sets: Vec<ParameterSet>,
}

impl Sweep {
    /// Loads the sweep that is built in under this name, otherwise the one in the file at this path; for a folder, all
    /// scenarios in it by the direct method with default options.
    ///
    /// # Errors
    /// Names the file, the key and the fault.
    pub fn load(name_or_path: &str) -> Result<Self> {
        if let Some((_, text)) = SWEEPS.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(text, name_or_path, Path::new(""));
        }
        let path = Path::new(name_or_path);
        if path.is_dir() {
            // The current folder has no name of its own.
            let name = path.canonicalize().map_err(|e| Error::io(path, e))?;
            let name = name.file_name().unwrap_or_default();
            let file = SweepFile::of_all(name.to_string_lossy().into_owned());
            return Self::new(file, name_or_path, path);
        }
        let text = read_named(path, "sweep")?;
        Self::parse(&text, name_or_path, path.parent().unwrap_or(Path::new("")))
    }

    /// Parses a sweep. `path` names it in errors; scenarios are looked up in `folder`.
    fn parse(text: &str, path: &str, folder: &Path) -> Result<Self> {
        Self::new(SweepFile::parse(text, path)?, path, folder)
    }

    /// Builds a sweep from its keys; the arguments are those of [`parse`](Self::parse).
    fn new(file: SweepFile, path: &str, folder: &Path) -> Result<Self> {
        let name = file.head.name.clone();
        let name = name.unwrap_or_else(|| name_of(path));
        let too_many = |most: usize, what: &str| {
            let condition = format!("the grid has more than {most} {what}");
            Error::input(path, "sweep", condition)
        };
        let points = file.grid.count().filter(|points| *points <= MAX_SETS);
        let points = points.ok_or_else(|| too_many(MAX_SETS, "sets"))?;
        let mut scenarios = Vec::<Scenario>::new();
        for (i, entry) in file.head.scenarios.iter().enumerate() {
            let key = format!("scenarios[{i}]");
            let refuse = |condition: String| Error::input(path, &key, condition);
            for place in named(entry, folder).map_err(refuse)? {
                let scenario = load(&file, &place, folder).map_err(|e| refuse(e.to_string()))?;
                if scenarios.iter().any(|other| other.name == scenario.name) {
                    return Err(refuse(format!("'{}' is there already", scenario.name)));
                }
                scenarios.push(scenario);
            }
        }
        let [options, keys] = [false, true].map(|of_scenario| file.grid.part(of_scenario));
        let variants = keys.count().map(|count| count.saturating_mul(scenarios.len()));
        if points.saturating_mul(scenarios.len()) > MAX_SETS {
            return Err(too_many(MAX_SETS, "sets"));
        }
        if variants.is_none_or(|count| count > MAX_VARIANTS) {
            return Err(too_many(MAX_VARIANTS, "scenarios"));
        }
        let refuse = |(key, condition)| Error::input(path, key, condition);
        let mut variants = Vec::new();
        for scenario in &scenarios {
            options.check_options(file.head.method, scenario).map_err(refuse)?;
            variants.extend(keys.variants(scenario).map_err(refuse)?);
        }
        let sets = (0..scenarios.len())
            .flat_map(|scenario| (0..points).map(move |point| (scenario, point)))
            .enumerate()
            .map(|(index, (scenario, point))| ParameterSet { index, scenario, point })
            .collect();
        Ok(Self { name, file, scenarios, variants, sets })
    }

    /// The number of sets per scenario.
    #[must_use]
    pub fn sets_a_scenario(&self) -> usize {
        self.sets.len() / self.scenarios.len()
    }

    /// The method of all solves.
    #[must_use]
    pub fn method(&self) -> Method {
        self.file.head.method
    }

    /// The scenario of one set, with the keys of that set.
    #[must_use]
    pub fn scenario(&self, set: &ParameterSet) -> &Scenario {
        let count = self.variants.len() / self.scenarios.len();
        &self.variants[set.scenario * count + self.file.grid.scenario_point(set.point)]
    }

    /// The parameters of one set, by name.
    #[must_use]
    pub fn parameters(&self, set: &ParameterSet) -> Map<String, Value> {
        self.file.grid.point(set.point)
    }

    /// The options with which one set is solved. They have no time limit, because a direct solve would use all of it
    /// for further starts.
    ///
    /// # Errors
    /// None for a set of this sweep.
    pub fn options(&self, set: &ParameterSet) -> Result<SolveOptions> {
        let keys = self.file.grid.parameters().iter();
        let mut own = self.parameters(set);
        for parameter in keys.filter(|parameter| parameter.of_scenario) {
            own.shift_remove(&parameter.name);
        }
        Grid::options(self.method(), own)
    }

    /// The wall time after which a solve is stopped.
    #[must_use]
    pub fn time_limit(&self) -> Duration {
        // It was checked when it was read.
        Duration::from_secs_f64(self.file.head.time_limit_s)
    }

    /// All data on which the results depend: the version of this library, the grid, the scenarios and their robots. The
    /// name changes no result.
    #[must_use]
    pub fn identity(&self) -> Value {
        let lists = self.file.grid.parameters().iter();
        let grid: Map<_, _> = lists.map(|p| (p.name.clone(), json!(p.values))).collect();
        let scenarios = self.scenarios.iter().map(|scenario| {
            json!({
                "name": scenario.name,
                "file": scenario.file,
                "robot_sha256": scenario.robot_sha256,
            })
        });
        json!({
            "aghf": env!("CARGO_PKG_VERSION"),
            "method": self.method(),
            "time_limit_s": self.file.head.time_limit_s,
            "grid": grid,
            "scenarios": scenarios.collect::<Vec<_>>(),
        })
    }
}

/// The scenarios that an entry of the list denotes, in the form of [`Scenario::load`].
fn named(entry: &str, folder: &Path) -> std::result::Result<Vec<String>, String> {
    if let Some(start) = entry.strip_suffix('*') {
        let built_in = builtin_scenarios().filter(|name| name.starts_with(start));
        let mut all: Vec<_> = built_in.map(str::to_owned).collect();
        if all.is_empty() {
            all = generated_scenarios().filter(|name| name.starts_with(start)).collect();
        }
        if all.is_empty() {
            return Err(format!("no built-in scenario matches '{entry}'"));
        }
        return Ok(all);
    }
    if builtin_scenarios().any(|name| name == entry) || is_generated(entry) {
        return Ok(vec![entry.to_owned()]);
    }
    let path = folder.join(entry);
    if !path.is_dir() {
        return Ok(vec![path.to_string_lossy().into_owned()]);
    }
    let scenarios = entries(&path).map_err(|e| e.to_string())?;
    let scenarios = scenarios.iter().filter(|path| path.extension() == Some("json".as_ref()));
    let all: Vec<_> = scenarios.map(|path| path.to_string_lossy().into_owned()).collect();
    if all.is_empty() {
        return Err(format!("the folder '{entry}' has no scenario, no file *.json"));
    }
    Ok(all)
}

/// Loads a scenario of a sweep in `folder`.
fn load(file: &SweepFile, name_or_path: &str, folder: &Path) -> Result<Scenario> {
    let robot = file.head.robot.as_deref();
    let path = robot.map(|robot| match builtin_robot_text(robot) {
        Some(_) => robot.to_owned(),
        None => folder.join(robot).to_string_lossy().into_owned(),
    });
    let given = LoadOptions { robot: path, mimic: file.head.mimic, ..LoadOptions::default() };
    let mut scenario = Scenario::load_for(name_or_path, &given)?;
    if let Some(robot) = robot {
        // As written in the sweep, which has the same results in any folder.
        scenario.file.robot = robot.to_owned();
    }
    Ok(scenario)
}
