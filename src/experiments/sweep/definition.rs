//! Reading a sweep, and its grid.

use crate::curve::Chebyshev;
use crate::error::{Error, Result};
use crate::motion::Guess;
use crate::scenario::{Method, Scenario, SolveOptions, builtin_scenarios};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

/// Names and texts of the sweeps that are built in.
macro_rules! sweeps {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../../robots/sweeps/", $name, ".toml")))),*]
    };
}

/// The sweeps, in the order in which they are listed.
const SWEEPS: [(&str, &str); 7] = sweeps!(
    "table_09_pendulums",
    "table_10_kinova",
    "table_11_digit",
    "table_12_kinova_obstacles",
    "table_13_digit_obstacles",
    "table_09_quick",
    "table_10_quick"
);

/// The most sets a grid can have; so many rows are kept in memory.
const MOST_SETS: usize = 1_000_000;

/// The names of the sweeps that are built in.
pub fn builtin_sweeps() -> impl Iterator<Item = &'static str> {
    SWEEPS.iter().map(|(name, _)| *name)
}

/// A sweep as it is written in a file. Its grid is every combination of the entries of its lists.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// The name of the folder of results; that of the file without its ending where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Scenarios that are built in, or paths relative to the sweep; `kinova_free_*` stands for all built-in ones that start so.
    pub scenarios: Vec<String>,
    /// The wall time of one solve, s, after which it is stopped.
    pub timeout_s: f64,
    /// Degrees of the polynomial.
    pub p: Vec<usize>,
    /// Penalties of (11).
    pub k: Vec<f64>,
    /// The values of `s` to which the flow runs.
    pub s_max: Vec<f64>,
    /// The curves to start from; the line of the paper's released code where there is no list.
    #[serde(default = "line")]
    pub guess: Vec<Guess>,
    /// Weights (A2) of the constraints; the scenario's where there is no list.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k_cons: Option<Vec<f64>>,
    /// Sharpnesses (A3) of the constraints; the scenario's where there is no list.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c_cons: Option<Vec<f64>>,
}

fn line() -> Vec<Guess> {
    vec![Guess::default()]
}

/// One point of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Degree of the polynomial.
    pub p: usize,
    /// Penalty of (11).
    pub k: f64,
    /// The `s` to which the flow runs.
    pub s_max: f64,
    /// The curve to start from.
    pub guess: Guess,
    /// Weight (A2) of the constraints; the scenario's if `None`.
    pub k_cons: Option<f64>,
    /// Sharpness (A3) of the constraints; the scenario's if `None`.
    pub c_cons: Option<f64>,
}

/// One solve of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSet {
    /// Its place in the sweep, from 0.
    pub index: usize,
    /// The place of its scenario in [`Sweep::scenarios`].
    pub scenario: usize,
    /// Its parameters.
    pub parameters: Parameters,
}

/// A sweep with its scenarios, checked.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The name of its folder of results.
    pub name: String,
    /// The contents of the file.
    pub file: SweepFile,
    /// The scenarios.
    pub scenarios: Vec<Scenario>,
    /// The grid: each scenario in turn with all parameters, in the same order.
    pub sets: Vec<ParameterSet>,
}

impl Sweep {
    /// The sweep that is built in under this name, or else the one in the file at this path.
    ///
    /// # Errors
    /// Names the file, the key and what is wrong with it.
    pub fn load(name_or_path: &str) -> Result<Self> {
        if let Some((_, text)) = SWEEPS.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(text, name_or_path, Path::new(""));
        }
        let path = Path::new(name_or_path);
        let text = std::fs::read_to_string(path).map_err(|e| {
            if e.kind() == std::io::ErrorKind::NotFound {
                let condition = "there is neither a file nor a built-in sweep of this name";
                Error::input(name_or_path, "sweep", condition)
            } else {
                Error::io(path, e)
            }
        })?;
        Self::parse(&text, name_or_path, path.parent().unwrap_or(Path::new("")))
    }

    /// A sweep from its text. `path` names it in errors; scenarios are looked for in `folder`.
    fn parse(text: &str, path: &str, folder: &Path) -> Result<Self> {
        let file = read_toml(text, path)?;
        check(&file).map_err(|(key, condition)| Error::input(path, key, condition))?;
        let stem = Path::new(path).file_stem().unwrap_or_default();
        let name = (file.name.clone()).unwrap_or_else(|| stem.to_string_lossy().into_owned());
        let mut scenarios = Vec::<Scenario>::new();
        for (i, entry) in file.scenarios.iter().enumerate() {
            let key = format!("scenarios[{i}]");
            let refuse = |condition: String| Error::input(path, &key, condition);
            for (place, _) in named(entry, folder).map_err(refuse)? {
                let scenario = Scenario::load(&place).map_err(|e| refuse(e.to_string()))?;
                if scenarios.iter().any(|other| other.name == scenario.name) {
                    return Err(refuse(format!("'{}' is there already", scenario.name)));
                }
                let constrained = file.k_cons.is_some() || file.c_cons.is_some();
                if constrained && scenario.is_free() {
                    let name = scenario.name;
                    let condition = format!("k_cons and c_cons: '{name}' has no constraints");
                    return Err(refuse(condition));
                }
                scenarios.push(scenario);
            }
        }
        let count = [file.p.len(), file.k.len(), file.s_max.len()]
            .into_iter()
            .chain([file.guess.len()])
            .chain([&file.k_cons, &file.c_cons].map(|l| l.as_ref().map_or(1, Vec::len)))
            .try_fold(scenarios.len(), usize::checked_mul);
        if count.is_none_or(|count| count > MOST_SETS) {
            let condition = format!("the grid has more than {MOST_SETS} sets");
            return Err(Error::input(path, "sweep", condition));
        }
        let points = points(&file);
        let sets = (0..scenarios.len())
            .flat_map(|scenario| points.iter().map(move |point| (scenario, *point)))
            .enumerate()
            .map(|(index, (scenario, parameters))| ParameterSet {
                index,
                scenario,
                parameters,
            })
            .collect();
        Ok(Self {
            name,
            file,
            scenarios,
            sets,
        })
    }

    /// The number of sets of each scenario.
    #[must_use]
    pub fn sets_a_scenario(&self) -> usize {
        self.sets.len() / self.scenarios.len()
    }

    /// The options with which one set is solved.
    #[must_use]
    pub fn options(&self, parameters: &Parameters) -> SolveOptions {
        SolveOptions {
            method: Method::Flow,
            degree: Some(parameters.p),
            k: Some(parameters.k),
            s_max: Some(parameters.s_max),
            guess: Some(parameters.guess),
            k_cons: parameters.k_cons,
            c_cons: parameters.c_cons,
            time_limit: Some(Duration::from_secs_f64(self.file.timeout_s)),
            ..SolveOptions::default()
        }
    }
}

/// A part of a sweep for one of several machines: its sets `index - 1`, `index - 1 + count` and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// The number of this part, from 1.
    pub index: usize,
    /// The number of parts.
    pub count: usize,
}

impl Shard {
    /// The one part of a sweep that is not spread.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Tells whether a set belongs to this part.
    #[must_use]
    pub fn has(&self, set: usize) -> bool {
        set % self.count == self.index - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parts = text.split_once('/');
        let shard = parts.and_then(|(index, count)| {
            let (index, count) = (index.parse().ok()?, count.parse().ok()?);
            (1..=count)
                .contains(&index)
                .then_some(Self { index, count })
        });
        shard.ok_or_else(|| "i/n with 1 <= i <= n is needed, such as 2/8".to_owned())
    }
}

/// The scenarios that an entry of the list stands for, as [`Scenario::load`] takes them, with their folders.
fn named(
    entry: &str,
    folder: &Path,
) -> std::result::Result<Vec<(String, std::path::PathBuf)>, String> {
    if let Some(start) = entry.strip_suffix('*') {
        let all = builtin_scenarios().filter(|name| name.starts_with(start));
        let all: Vec<_> = all.map(|name| (name.to_owned(), "".into())).collect();
        return if all.is_empty() {
            Err(format!("no built-in scenario matches '{entry}'"))
        } else {
            Ok(all)
        };
    }
    if builtin_scenarios().any(|name| name == entry) {
        return Ok(vec![(entry.to_owned(), "".into())]);
    }
    let path = folder.join(entry);
    let beside = path.parent().unwrap_or(Path::new("")).to_owned();
    Ok(vec![(path.to_string_lossy().into_owned(), beside)])
}

/// Says which key is wrong and why, if one is.
fn check(file: &SweepFile) -> std::result::Result<(), (String, String)> {
    if let Some(name) = &file.name {
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
        if name.is_empty() || name.starts_with('.') || !name.chars().all(plain) {
            let condition = format!("'{name}': letters, digits, '_', '-' and '.' are needed");
            return Err(("name".into(), condition));
        }
    }
    if Duration::try_from_secs_f64(file.timeout_s).is_err() || file.timeout_s <= 0.0 {
        let condition = format!("it is {}, a positive time is needed", file.timeout_s);
        return Err(("timeout_s".into(), condition));
    }
    let empty = "it is an empty list".to_owned();
    if file.scenarios.is_empty() {
        return Err(("scenarios".into(), empty));
    }
    let none = Vec::new();
    let positive = [
        ("k", &file.k),
        ("s_max", &file.s_max),
        ("k_cons", file.k_cons.as_ref().unwrap_or(&none)),
        ("c_cons", file.c_cons.as_ref().unwrap_or(&none)),
    ];
    for (key, values) in positive {
        if let Some(i) = values.iter().position(|x| !(x.is_finite() && *x > 0.0)) {
            let condition = format!("it is {}, a positive number is needed", values[i]);
            return Err((format!("{key}[{i}]"), condition));
        }
        distinct(key, values)?;
    }
    for (i, p) in file.p.iter().enumerate() {
        Chebyshev::check_degree(*p).map_err(|condition| (format!("p[{i}]"), condition))?;
    }
    distinct("p", &file.p)?;
    distinct("guess", &file.guess)?;
    let lists = [
        ("p", Some(file.p.len())),
        ("k", Some(file.k.len())),
        ("s_max", Some(file.s_max.len())),
        ("guess", Some(file.guess.len())),
        ("k_cons", file.k_cons.as_ref().map(Vec::len)),
        ("c_cons", file.c_cons.as_ref().map(Vec::len)),
    ];
    match lists.into_iter().find(|(_, length)| *length == Some(0)) {
        Some((key, _)) => Err((key.into(), empty)),
        None => Ok(()),
    }
}

/// Refuses a value that is in a list twice.
fn distinct<T: PartialEq>(key: &str, values: &[T]) -> std::result::Result<(), (String, String)> {
    for (i, value) in values.iter().enumerate() {
        if values[..i].contains(value) {
            return Err((format!("{key}[{i}]"), "the value is there already".into()));
        }
    }
    Ok(())
}

/// All combinations of the lists, the last one running fastest.
fn points(file: &SweepFile) -> Vec<Parameters> {
    let optional = |list: &Option<Vec<f64>>| match list {
        Some(list) => list.iter().copied().map(Some).collect(),
        None => vec![None],
    };
    let (k_cons, c_cons) = (optional(&file.k_cons), optional(&file.c_cons));
    let mut points = Vec::new();
    for &p in &file.p {
        for &k in &file.k {
            for &s_max in &file.s_max {
                for &guess in &file.guess {
                    for &k_cons in &k_cons {
                        for &c_cons in &c_cons {
                            points.push(Parameters {
                                p,
                                k,
                                s_max,
                                guess,
                                k_cons,
                                c_cons,
                            });
                        }
                    }
                }
            }
        }
    }
    points
}

/// Reads a sweep file; an error names the key that is wrong, or the line where the text is no TOML.
fn read_toml(text: &str, path: &str) -> Result<SweepFile> {
    let reader = toml::Deserializer::parse(text).map_err(|e| {
        let before = e.span().map_or("", |span| &text[..span.start]);
        let line = 1 + before.matches('\n').count();
        Error::input(path, format!("line {line}"), e.message())
    })?;
    serde_path_to_error::deserialize(reader).map_err(|e| {
        let key = match e.path().to_string().as_str() {
            "." => "sweep".to_owned(),
            path => path.to_owned(),
        };
        Error::input(path, key, e.inner().message())
    })
}
