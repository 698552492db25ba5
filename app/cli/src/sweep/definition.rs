//! A sweep with its scenarios and its sets.

use super::grid::Refusal;
use super::{Grid, Motions, SweepFile};
use crate::output::one_line;
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
    /// Index of its problem in [`Sweep::problems`].
    pub problem: usize,
    /// Index of its point in the grid.
    pub point: usize,
}

/// A problem of a sweep.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its unique name.
    pub name: String,
    /// Its scenario, or the reason for which it is refused.
    pub scenario: std::result::Result<Scenario, String>,
    /// The scenario at all points of the keys of scenarios.
    variants: Vec<Scenario>,
}

/// A sweep with its problems, checked.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The name of the folder of results.
    pub name: String,
    /// The contents of the file.
    pub file: SweepFile,
    /// The problems.
    pub problems: Vec<Problem>,
    /// The place and the form of motions, if they are kept.
    pub motions: Option<Motions>,
    /// The grid: each problem in turn with all parameters, in the same order.
    pub sets: Vec<ParameterSet>,
}

impl Sweep {
    /// Loads the sweep that is built in under this name, otherwise the one in the file at this path; for a folder, all
    /// scenarios in it by the direct method with default options. A file that is refused, or that alone does not accept
    /// the lists, is a refused problem and no error.
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
            return Self::new(file, name_or_path, path, &LoadOptions::default());
        }
        let text = read_named(path, "sweep")?;
        Self::parse(&text, name_or_path, path.parent().unwrap_or(Path::new("")))
    }

    /// The sweep `name` of scenarios in files, in folders or built in, each solved with these options.
    ///
    /// # Errors
    /// There is no such scenario, or none accepts the options.
    pub fn from_scenarios(
        name: &str,
        scenarios: Vec<String>,
        given: &LoadOptions,
        options: &SolveOptions,
    ) -> Result<Self> {
        let file = SweepFile::from_scenarios(name, scenarios, options)?;
        Self::new(file, name, Path::new(""), given)
    }

    /// Parses a sweep. `path` names it in errors; scenarios are looked up in `folder`.
    fn parse(text: &str, path: &str, folder: &Path) -> Result<Self> {
        let file = SweepFile::parse(text, path)?;
        let robot = file.head.robot.as_deref();
        let robot = robot.map(|robot| match builtin_robot_text(robot) {
            Some(_) => robot.to_owned(),
            None => folder.join(robot).to_string_lossy().into_owned(),
        });
        let given = LoadOptions { robot, mimic: file.head.mimic, ..LoadOptions::default() };
        Self::new(file, path, folder, &given)
    }

    /// Builds a sweep from its keys; the other arguments are those of [`parse`](Self::parse).
    fn new(file: SweepFile, path: &str, folder: &Path, given: &LoadOptions) -> Result<Self> {
        let name = file.head.name.clone();
        let name = name.unwrap_or_else(|| name_of(path));
        let too_many = |most: usize, what: &str| {
            let condition = format!("the grid has more than {most} {what}");
            Error::input(path, "sweep", condition)
        };
        let points = file.grid.count().filter(|points| *points <= MAX_SETS);
        let points = points.ok_or_else(|| too_many(MAX_SETS, "sets"))?;
        let mut problems = Vec::<Problem>::new();
        for (i, entry) in file.head.scenarios.iter().enumerate() {
            let key = format!("scenarios[{i}]");
            let refuse = |condition: String| Error::input(path, &key, condition);
            for place in named(entry, folder).map_err(refuse)? {
                let problem = load(&file, &place, given).map_err(refuse)?;
                if problems.iter().any(|other| other.name == problem.name) {
                    return Err(refuse(format!("'{}' is there already", problem.name)));
                }
                problems.push(problem);
            }
        }
        let variants = file.grid.part(true).count().map(|count| count.saturating_mul(problems.len()));
        if points.saturating_mul(problems.len()) > MAX_SETS {
            return Err(too_many(MAX_SETS, "sets"));
        }
        if variants.is_none_or(|count| count > MAX_VARIANTS) {
            return Err(too_many(MAX_VARIANTS, "scenarios"));
        }
        fill(&mut problems, &file).map_err(|(key, condition)| Error::input(path, key, condition))?;
        let sets = (0..problems.len())
            .flat_map(|problem| (0..points).map(move |point| (problem, point)))
            .enumerate()
            .map(|(index, (problem, point))| ParameterSet { index, problem, point })
            .collect();
        Ok(Self { name, file, problems, motions: None, sets })
    }

    /// The number of sets per scenario.
    #[must_use]
    pub fn sets_a_scenario(&self) -> usize {
        self.sets.len() / self.problems.len()
    }

    /// The method of all solves.
    #[must_use]
    pub fn method(&self) -> Method {
        self.file.head.method
    }

    /// The scenario of one set, with the keys of that set.
    ///
    /// # Errors
    /// The reason for which its problem is refused.
    pub fn scenario(&self, set: &ParameterSet) -> std::result::Result<&Scenario, &str> {
        let problem = &self.problems[set.problem];
        let variant = |_| &problem.variants[self.file.grid.scenario_point(set.point)];
        problem.scenario.as_ref().map(variant).map_err(String::as_str)
    }

    /// The loaded scenarios.
    pub fn scenarios(&self) -> impl Iterator<Item = &Scenario> {
        self.problems.iter().filter_map(|problem| problem.scenario.as_ref().ok())
    }

    /// The parameters of one set, by name.
    #[must_use]
    pub fn parameters(&self, set: &ParameterSet) -> Map<String, Value> {
        self.file.grid.point(set.point)
    }

    /// The options with which one set is solved. They have no time limit, because a direct solve would plan a path
    /// first.
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

    /// All data on which the results depend: the version of this library, the grid, the scenarios and their robots, and
    /// whether motions are kept. The name changes no result.
    #[must_use]
    pub fn identity(&self) -> Value {
        let lists = self.file.grid.parameters().iter();
        let grid: Map<_, _> = lists.map(|p| (p.name.clone(), json!(p.values))).collect();
        let scenarios = self.problems.iter().map(|Problem { name, scenario, .. }| match scenario {
            Ok(own) => json!({ "name": name, "file": own.file, "robot_sha256": own.robot_sha256 }),
            Err(reason) => json!({ "name": name, "refused": reason }),
        });
        let mut identity = json!({
            "aghf": env!("CARGO_PKG_VERSION"),
            "method": self.method(),
            "time_limit_s": self.file.head.time_limit_s,
            "grid": grid,
            "scenarios": scenarios.collect::<Vec<_>>(),
        });
        if self.motions.is_some() {
            identity["motions"] = true.into();
        }
        identity
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

/// Loads a scenario, `given` what the sweep says of its robot. A file that is refused is a refused problem.
fn load(file: &SweepFile, name_or_path: &str, given: &LoadOptions) -> std::result::Result<Problem, String> {
    let problem = |name, scenario| Problem { name, scenario, variants: Vec::new() };
    match Scenario::load_for(name_or_path, given) {
        Ok(mut scenario) => {
            if let Some(robot) = &file.head.robot {
                // As written in the sweep, which has the same results in any folder.
                scenario.file.robot.clone_from(robot);
            }
            Ok(problem(scenario.name.clone(), Ok(scenario)))
        }
        Err(error) if Path::new(name_or_path).is_file() => {
            Ok(problem(name_of(name_or_path), Err(one_line(&error.to_string()))))
        }
        Err(error) => Err(error.to_string()),
    }
}

/// Adds the variants of the problems. Those that do not accept the lists are refused, unless none does, which is an
/// error of the lists.
fn fill(problems: &mut [Problem], file: &SweepFile) -> std::result::Result<(), Refusal> {
    let [options, keys] = [false, true].map(|of_scenario| file.grid.part(of_scenario));
    let (mut first, mut accepted) = (None, file.grid.parameters().is_empty());
    for problem in problems {
        let Ok(scenario) = &problem.scenario else {
            continue;
        };
        let checked = options.check_options(file.head.method, scenario);
        match checked.and_then(|()| keys.variants(scenario)) {
            Ok(variants) => (problem.variants, accepted) = (variants, true),
            Err((key, condition)) => {
                problem.scenario = Err(one_line(&format!("{key}: {condition}")));
                first = first.or(Some((key, condition)));
            }
        }
    }
    first.filter(|_| !accepted).map_or(Ok(()), Err)
}
