//! The facts of a solve: its summary, and the commands that repeat it.

use aghf::error::{Error, Result};
use aghf::input::read_named;
use aghf_scenario::{Method, SolveOptions, Summary, builtin_scenarios, is_generated};
use serde_json::Value;
use std::path::Path;

/// The keys of a summary that a comparison shows, with their labels.
const FACTS: [(&str, &str); 12] = [
    ("scenario", "scenario"),
    ("robot", "robot"),
    ("method", "method"),
    ("p", "degree"),
    ("pieces", "polynomials"),
    ("success", "success"),
    ("control_effort", "control effort, int |u|^2 dt"),
    ("cost", "cost that was minimised"),
    ("final_error_inf", "final error with feedback"),
    ("open_loop_error_inf", "final error open loop"),
    ("gradient_norm", "gradient norm, relative"),
    ("solve_seconds", "solve time, s"),
];

/// The facts of a motion on a page.
pub(super) struct Told {
    /// Labels and values.
    pub facts: Vec<[String; 2]>,
    /// The commands that repeat the solve.
    pub commands: Vec<String>,
    /// The method, and the variant of a flow.
    pub method: String,
    pub effort: Option<f64>,
    pub least_clearance: Option<f64>,
}

/// The facts in the summary in the file at `path`.
pub(super) fn told_in(path: &str, options: &SolveOptions) -> Result<Told> {
    let text = read_named(Path::new(path), "summary")?;
    let summary: Value =
        serde_json::from_str(&text).map_err(|e| Error::input(path, "summary", e.to_string()))?;
    let mut facts = vec![["summary".to_owned(), path.to_owned()]];
    for (key, what) in FACTS {
        let value = match &summary[key] {
            Value::Null => continue,
            Value::String(text) => text.clone(),
            Value::Number(number) if number.is_f64() => {
                crate::output::short(number.as_f64().unwrap_or(f64::NAN))
            }
            other => other.to_string(),
        };
        facts.push([what.to_owned(), value]);
    }
    Ok(Told {
        facts,
        commands: vec![format!("aghf solve {}", quoted(path))],
        method: method(options),
        effort: summary["control_effort"].as_f64(),
        least_clearance: summary["smallest_clearance_m"].as_f64(),
    })
}

/// The method with the variant of a flow.
pub(super) fn method(options: &SolveOptions) -> String {
    match (options.method, options.variant) {
        (Method::Relax, _) => "relaxation".to_owned(),
        (Method::Flow, None) => "flow".to_owned(),
        (Method::Flow, Some(variant)) => format!("flow, {variant}"),
    }
}

/// The commands that repeat a solve: from its summary in its folder, and by all options if the scenario is built in.
pub(super) fn commands(summary: &Summary) -> Vec<String> {
    let file = match summary.success {
        true => "summary.json",
        false => "summary.failed.json",
    };
    let mut commands = vec![format!("aghf solve {file}")];
    let name = &summary.scenario;
    let known = builtin_scenarios().any(|other| other == name) || is_generated(name);
    let options = serde_json::to_value(&summary.provenance.options);
    if let (true, Ok(Value::Object(options))) = (known, options) {
        let mut command = format!("aghf solve {name}");
        for (key, value) in options {
            let flag = match key.as_str() {
                "num_starts" => "starts".to_owned(),
                "time_limit_s" => "seconds".to_owned(),
                other => other.replace('_', "-"),
            };
            let value = match value {
                Value::String(text) => text,
                other => other.to_string(),
            };
            command.push_str(&format!(" --{flag} {value}"));
        }
        commands.push(command);
    }
    commands
}

/// Quotes a path for a shell.
fn quoted(path: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    if path.chars().all(plain) {
        return path.to_owned();
    }
    format!("'{}'", path.replace('\'', "'\\''"))
}
