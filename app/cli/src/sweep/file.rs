//! Reading of sweep files.

use super::grid::{Grid, Refusal, RelaxGrid};
use aghf::error::{Error, Result, plain};
use aghf::urdf::Mimic;
use aghf_scenario::{Method, SolveOptions};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// A sweep as written in a file. Its grid is every combination of the entries of its lists.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepFile {
    /// The name of the folder of results; by default the file name without its extension.
    pub name: Option<String>,
    /// Built-in or generated scenarios, or paths relative to the sweep of files or of folders of them; `kinova_free_*`
    /// denotes all built-in ones with this prefix, or the listed generated ones.
    pub scenarios: Vec<String>,
    /// The robot of generated scenarios that accept any: a built-in name, or a path relative to the sweep.
    pub robot: Option<String>,
    /// The treatment of mimic joints; by default that of the scenario.
    pub mimic: Option<Mimic>,
    /// The wall time after which a solve is stopped, s.
    pub timeout_s: f64,
    /// The lists of parameters.
    pub grid: Grid,
}

/// The key that determines which others are valid.
#[derive(Deserialize)]
struct Chosen {
    #[serde(default = "flow")]
    method: Method,
}

/// The other keys that sweeps of all methods have.
#[derive(Deserialize)]
struct Head {
    name: Option<String>,
    scenarios: Vec<String>,
    robot: Option<String>,
    mimic: Option<Mimic>,
    timeout_s: f64,
}

/// The names of all these keys.
const HEAD: [&str; 6] = ["method", "name", "scenarios", "robot", "mimic", "timeout_s"];

/// The default method.
fn flow() -> Method {
    Method::Flow
}

impl SweepFile {
    /// The wall time, s, of one solve in the sweep of [all](Self::of_all) scenarios of a folder.
    const TIMEOUT: f64 = 60.0;

    /// The sweep of all scenarios of its folder by the relaxation with default options.
    #[must_use]
    pub fn of_all(name: String) -> Self {
        Self {
            name: Some(name),
            scenarios: vec![".".to_owned()],
            robot: None,
            mimic: None,
            timeout_s: Self::TIMEOUT,
            grid: Grid::Relax(RelaxGrid::default()),
        }
    }

    /// Parses a sweep in TOML. `path` names it in errors.
    ///
    /// # Errors
    /// Names the line that is not TOML, or the faulty key.
    pub fn parse(text: &str, path: &str) -> Result<Self> {
        let table = text.parse::<Table>().map_err(|e| {
            let before = e.span().map_or("", |span| &text[..span.start]);
            let line = 1 + before.matches('\n').count();
            Error::input(path, format!("line {line}"), e.message())
        })?;
        let refuse = |(key, condition): Refusal| Error::input(path, key, condition);
        let Chosen { method } = read(&table).map_err(refuse)?;
        check_keys(&table, method).map_err(refuse)?;
        let head: Head = read(&table).map_err(refuse)?;
        let grid = match method {
            Method::Flow => Grid::Flow(read(&table).map_err(refuse)?),
            Method::Relax => Grid::Relax(read(&table).map_err(refuse)?),
        };
        let file = Self {
            name: head.name,
            scenarios: head.scenarios,
            robot: head.robot,
            mimic: head.mimic,
            timeout_s: head.timeout_s,
            grid,
        };
        file.check().map_err(refuse)?;
        Ok(file)
    }

    /// Checks the values; the error names the faulty key and the reason.
    fn check(&self) -> std::result::Result<(), Refusal> {
        if let Some(name) = &self.name {
            let plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
            if name.is_empty() || name.starts_with('.') || !name.chars().all(plain) {
                let condition = format!("'{name}': letters, digits, '_', '-' and '.' are needed");
                return Err(("name".into(), condition));
            }
        }
        let longest = SolveOptions::LONGEST_TIME_LIMIT.as_secs_f64();
        if !(self.timeout_s > 0.0 && self.timeout_s <= longest) {
            let timeout = plain(self.timeout_s);
            let condition =
                format!("it is {timeout}, a positive time of at most {longest} s is needed");
            return Err(("timeout_s".into(), condition));
        }
        if self.scenarios.is_empty() {
            return Err(("scenarios".into(), "it is an empty list".into()));
        }
        self.grid.check()
    }
}

/// Refuses unknown keys, and those of another method.
fn check_keys(table: &Table, method: Method) -> std::result::Result<(), Refusal> {
    let own = Grid::keys(method);
    // Of a list serde would take the entries for those of the keys in order.
    for key in ["running_cost", "enforced_limits"] {
        if table.get(key).is_some_and(Value::is_array) {
            let condition = "it is a list, not a table with keys";
            return Err((key.to_owned(), condition.to_owned()));
        }
    }
    let known = |key: &&String| HEAD.contains(&key.as_str()) || own.contains(&key.as_str());
    let Some(key) = table.keys().find(|key| !known(key)) else {
        return Ok(());
    };
    let mut others = Method::by_name().flat_map(|(_, other)| Grid::keys(other));
    let condition = if others.any(|other| other == key) {
        format!("the method '{method}' has no such parameter")
    } else {
        let keys = [&HEAD, own].concat().join(", ");
        format!("unknown field `{key}`, expected one of {keys}")
    };
    Err((key.clone(), condition))
}

/// Reads the keys of a type from a table; an error names the faulty key.
fn read<T: DeserializeOwned>(table: &Table) -> std::result::Result<T, Refusal> {
    serde_path_to_error::deserialize(table.clone()).map_err(|e| {
        let key = match e.path().to_string().as_str() {
            "." => "sweep".to_owned(),
            path => path.to_owned(),
        };
        (key, e.inner().message().to_owned())
    })
}
