//! The facts of a solve: its summary, and the commands that repeat it.

use crate::output::{cost_of, csv_cell, minimised, short, summary_rows};
use aghf_scenario::{Details, Summary, builtin_scenarios, is_generated};

/// The facts of a motion on a page.
pub(super) struct SolveFacts {
    /// Labels and values.
    pub facts: Vec<[String; 2]>,
    /// The commands that repeat the solve.
    pub commands: Vec<String>,
    /// The verdict in words.
    pub verdict: String,
    /// The method in words.
    pub method: String,
    /// The minimised quantity.
    pub cost: f64,
    pub effort: f64,
    pub least_clearance: Option<f64>,
    /// The times at which the motion passes the waypoints, s.
    pub waypoint_times: Vec<f64>,
}

impl SolveFacts {
    /// The facts in the summary in the file at `path` that a comparison shows.
    pub fn of_file(summary: &Summary, path: &str) -> Self {
        let s = summary;
        let gradient_norm = match &s.details {
            Details::Flow(_) => None,
            Details::Rest(rest) => Some(rest.gradient_norm),
            Details::Direct(direct) => Some(direct.gradient_norm),
        };
        let all = [
            ("summary", Some(path.to_owned())),
            ("scenario", Some(s.scenario.clone())),
            ("robot", Some(s.robot.clone())),
            ("method", Some(s.method.to_string())),
            ("degree", Some(s.degree.to_string())),
            ("segments", Some(s.segments.to_string())),
            ("verdict", Some(s.verdict.to_string())),
            ("control effort, int |u|^2 dt", Some(short(s.control_effort))),
            ("cost", Some(cost_of(summary))),
            ("final error with feedback", s.final_error_inf.map(short)),
            ("final error open loop", s.open_loop_error_inf.map(short)),
            ("gradient norm, relative", gradient_norm.map(short)),
            ("solve time, s", Some(short(s.solve_seconds))),
        ];
        let given = all.into_iter();
        let given = given.filter_map(|(what, value)| Some([what.to_owned(), value?]));
        Self { commands: vec![format!("aghf solve {}", quoted(path))], ..Self::of(summary, given.collect()) }
    }

    /// The facts of a solve with its whole table.
    pub fn of_solve(summary: &Summary) -> Self {
        Self { commands: commands(summary), ..Self::of(summary, summary_rows(summary)) }
    }

    fn of(summary: &Summary, facts: Vec<[String; 2]>) -> Self {
        Self {
            facts,
            commands: Vec::new(),
            verdict: summary.verdict.to_string(),
            method: summary.method.to_string(),
            cost: minimised(summary),
            effort: summary.control_effort,
            least_clearance: summary.feasibility.smallest_clearance_m,
            waypoint_times: match &summary.details {
                Details::Direct(direct) => direct.waypoint_times_s.clone(),
                Details::Flow(_) | Details::Rest(_) => Vec::new(),
            },
        }
    }
}

/// The commands that repeat a solve: from its summary in its folder, and by all options if the scenario is built in.
fn commands(summary: &Summary) -> Vec<String> {
    let file = if summary.success { "summary.json" } else { "summary.failed.json" };
    let mut commands = vec![format!("aghf solve {file}")];
    let name = &summary.scenario;
    if builtin_scenarios().any(|other| other == name) || is_generated(name) {
        let options = serde_json::to_value(&summary.provenance.options).unwrap_or_default();
        let mut command = format!("aghf solve {name}");
        for (key, value) in options.as_object().into_iter().flatten() {
            let (flag, value) = (key.replace('_', "-"), csv_cell(value));
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
