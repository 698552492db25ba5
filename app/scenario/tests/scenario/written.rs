//! Scenario files written by a test.

use aghf_scenario::certify::{Failure, Texts, certify};
use aghf_scenario::judge::{Trajectory, sufficient_samples};
use aghf_scenario::{DirectOptions, Scenario, Solve, SolveReport};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// `scenario` with some keys more, or others.
pub fn with(mut scenario: Value, keys: Value) -> Value {
    for (key, value) in keys.as_object().expect("it is one") {
        scenario[key] = value.clone();
    }
    scenario
}

/// The folder of the test that runs, which has a thread of its own.
pub fn folder() -> PathBuf {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("main").replace("::", "_");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenario_written");
    let folder = folder.join(test);
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    folder
}

/// A motion of a scenario from the straight line alone.
pub fn solved_once(scenario: &Scenario) -> SolveReport {
    let options = DirectOptions { starts: Some(1), ..DirectOptions::default() };
    let report = Solve::new(scenario).options(options).run();
    let report = report.expect("it is good");
    assert!(report.summary.success, "{:?}", report.summary);
    report
}

/// As many samples of the motion of a solve as the judge needs.
pub fn sampled(scenario: &Scenario, report: &SolveReport) -> Trajectory {
    let intervals = sufficient_samples(scenario, &report.curve).expect("its joints") - 1;
    let samples = aghf::motion::sample(&scenario.model, &report.curve, intervals);
    Trajectory::of_samples(samples.expect("its joints"))
}

/// The failures of a proof that the motion of a solve without waypoints keeps a scenario.
pub fn failures(scenario: &Scenario, report: &SolveReport) -> Vec<Failure> {
    let texts = Texts { scenario: &[], run: "" };
    certify(scenario, &report.summary.curve, texts, &[], 0.0).expect("its joints").failures
}

/// Writes a scenario file and loads it; the error is without the path of the file, which is there.
pub fn load(name: &str, scenario: &Value) -> Result<Scenario, String> {
    load_text(name, &scenario.to_string())
}

/// The same of any text.
pub fn load_text(name: &str, text: &str) -> Result<Scenario, String> {
    let path = folder().join(format!("{name}.json"));
    std::fs::write(&path, text).expect("the folder is writable");
    let path = path.to_str().expect("it is text");
    Scenario::load(path).map_err(|e| {
        let error = e.to_string();
        let rest = error.strip_prefix(&format!("{path}: "));
        rest.unwrap_or_else(|| panic!("no file: {error}")).to_owned()
    })
}
