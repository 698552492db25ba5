//! Reading of sweep files.

use super::grid::{Grid, Parameter, Refusal};
use aghf::error::{Error, Result, plain};
use aghf::urdf::Mimic;
use aghf_scenario::{Method, SolveOptions, scenario_schema};
use serde::Deserialize;
use serde_json::Value;
use toml::Table;

/// A sweep as written in a file. Its grid is every combination of the entries of its lists.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepFile {
    /// The keys that are no lists of parameters.
    pub head: Head,
    /// The lists of parameters.
    pub grid: Grid,
}

/// The keys of a sweep beside its lists of parameters.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Head {
    /// The method of all solves.
    #[serde(default)]
    pub method: Method,
    /// The name of the folder of results; by default the file name without its extension.
    pub name: Option<String>,
    /// Built-in or generated scenarios, or paths relative to the sweep of files or of folders of them; `kinova_free_*`
    /// denotes all built-in ones with this prefix, or the listed generated ones.
    pub scenarios: Vec<String>,
    /// The robot of generated scenarios that accept any: a built-in name, or a path relative to the sweep.
    pub robot: Option<String>,
    /// The treatment of mimic joints; by default that of the scenario.
    pub mimic: Option<Mimic>,
    /// The wall time after which a solve is stopped, s. Unlike the option of a solve it leaves a direct solve no time
    /// for further starts.
    pub time_limit_s: f64,
}

/// The names of all these keys.
const HEAD: [&str; 6] = ["method", "name", "scenarios", "robot", "mimic", "time_limit_s"];

impl SweepFile {
    /// The wall time, s, of one solve in the sweep of [all](Self::of_all) scenarios of a folder.
    const TIME_LIMIT_S: f64 = 60.0;

    /// The sweep of all scenarios of its folder by the direct method with default options.
    #[must_use]
    pub fn of_all(name: String) -> Self {
        let (scenarios, time_limit_s) = (vec![".".to_owned()], Self::TIME_LIMIT_S);
        let method = Method::Direct;
        let head = Head { method, name: Some(name), scenarios, robot: None, mimic: None, time_limit_s };
        Self { head, grid: Grid::default() }
    }

    /// The sweep `name` of these scenarios with these options.
    ///
    /// # Errors
    /// The time limit is out of range.
    pub fn from_scenarios(name: &str, scenarios: Vec<String>, options: &SolveOptions) -> Result<Self> {
        let mut file = Self::of_all("problems".to_owned());
        let mut keys = options.keys()?;
        if let Some(limit) = keys.shift_remove("time_limit_s").and_then(|limit| limit.as_f64()) {
            file.head.time_limit_s = limit;
        }
        (file.head.method, file.head.scenarios) = (options.method(), scenarios);
        let lists = keys.into_iter().map(|(name, value)| Parameter { name, values: vec![value], of_scenario: false });
        let grid = check(&file.head).and_then(|()| Grid::new(lists.collect()));
        file.grid = grid.map_err(|(key, condition)| Error::input("options", key, condition))?;
        // The name of a folder may have any letters.
        file.head.name = Some(name.to_owned());
        Ok(file)
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
        Self::read(table).map_err(|(key, condition)| Error::input(path, key, condition))
    }

    fn read(table: Table) -> std::result::Result<Self, Refusal> {
        let is_head = |(key, _): &(String, toml::Value)| HEAD.contains(&key.as_str());
        let (head, lists): (Vec<_>, Vec<_>) = table.into_iter().partition(is_head);
        let head = Table::from_iter(head);
        // The method determines which lists are valid, and an unknown key may be a required one that is misspelt.
        let method = match head.get("method") {
            None => Method::default(),
            Some(name) => {
                name.clone().try_into().map_err(|e: toml::de::Error| ("method".to_owned(), e.message().to_owned()))?
            }
        };
        let options = SolveOptions::schema_of(method);
        let (options, scenario) = (&options["properties"], &scenario_schema()["properties"]);
        let mut parameters = Vec::new();
        for (key, value) in lists {
            let of_scenario = options.get(&key).is_none();
            if of_scenario && scenario.get(&key).is_none() {
                let condition = format!(
                    "it is no key of a sweep ({}), no option of the method '{method}' ({}) and no key of a scenario",
                    HEAD.join(", "),
                    names(options)
                );
                return Err((key, condition));
            }
            add_lists(key, value, of_scenario, &mut parameters)?;
        }
        let head: Head = serde_path_to_error::deserialize(head).map_err(|e| {
            let key = match e.path().to_string().as_str() {
                "." => "sweep".to_owned(),
                path => path.to_owned(),
            };
            (key, e.inner().message().to_owned())
        })?;
        check(&head)?;
        let grid = Grid::new(parameters)?;
        Ok(Self { head, grid })
    }
}

/// Checks the values of the head; the error names the faulty key and the reason.
fn check(head: &Head) -> std::result::Result<(), Refusal> {
    if let Some(name) = &head.name {
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
        if name.is_empty() || name.starts_with('.') || !name.chars().all(plain) {
            let condition = format!("'{name}': letters, digits, '_', '-' and '.' are needed");
            return Err(("name".into(), condition));
        }
    }
    let (limit, longest) = (head.time_limit_s, SolveOptions::MAX_TIME_LIMIT_S);
    if !(limit > 0.0 && limit <= longest) {
        let limit = plain(limit);
        let condition = format!("it is {limit} and must be a positive time of at most {longest} s");
        return Err(("time_limit_s".into(), condition));
    }
    if head.scenarios.is_empty() {
        return Err(("scenarios".into(), "it is an empty list".into()));
    }
    Ok(())
}

/// The names of properties in a schema.
fn names(properties: &Value) -> String {
    let keys = properties.as_object().into_iter().flat_map(|all| all.keys());
    keys.map(String::as_str).collect::<Vec<_>>().join(", ")
}

/// Adds the list of a key, or the lists of the keys in its table.
fn add_lists(
    name: String,
    value: toml::Value,
    of_scenario: bool,
    parameters: &mut Vec<Parameter>,
) -> std::result::Result<(), Refusal> {
    match value {
        toml::Value::Table(table) if of_scenario => {
            for (key, inner) in table {
                add_lists(format!("{name}.{key}"), inner, of_scenario, parameters)?;
            }
            Ok(())
        }
        toml::Value::Array(values) => {
            let mut all = Vec::with_capacity(values.len());
            for (i, value) in values.into_iter().enumerate() {
                all.push(json(value).map_err(|condition| (format!("{name}[{i}]"), condition))?);
            }
            parameters.push(Parameter { name, values: all, of_scenario });
            Ok(())
        }
        other => Err((name, format!("it is a {} and must be a list of values", other.type_str()))),
    }
}

/// A value of TOML in JSON, which has neither dates nor numbers that are not finite.
fn json(value: toml::Value) -> std::result::Result<Value, String> {
    Ok(match value {
        toml::Value::String(text) => Value::from(text),
        toml::Value::Integer(number) => Value::from(number),
        toml::Value::Boolean(truth) => Value::from(truth),
        toml::Value::Float(number) if number.is_finite() => Value::from(number),
        toml::Value::Array(values) => values.into_iter().map(json).collect::<std::result::Result<_, _>>()?,
        toml::Value::Table(table) => {
            let pairs = table.into_iter();
            let pairs = pairs.map(|(key, value)| Ok((key, json(value)?)));
            Value::Object(pairs.collect::<std::result::Result<_, String>>()?)
        }
        toml::Value::Float(number) => {
            return Err(format!("it is {number} and must be a finite number"));
        }
        toml::Value::Datetime(date) => return Err(format!("it is the date {date}")),
    })
}
