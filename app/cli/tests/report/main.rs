//! The pages of motions and of tables: what is in them. `tests/browser` has what they do.

#[path = "../command/mod.rs"]
mod command;
mod foot;
mod page;
mod shapes;
mod tables;

#[path = "../output"]
mod output {
    mod files;
    mod folder;
    mod results_file;
    mod walk;
}

use aghf_cli::report::{Motion, page};
use aghf_scenario::{DirectOptions, Scenario, Solve, SolveReport};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The solve of a scenario from some starts.
fn solved(scenario: &Scenario, starts: usize) -> SolveReport {
    let options = DirectOptions { starts: Some(starts), ..DirectOptions::default() };
    Solve::new(scenario).options(options.clone()).run().expect("it can be solved")
}

/// The text of a page and its data of the one motion.
fn page_of(scenario: &Scenario, outcome: &SolveReport) -> (String, Value) {
    let text = page(&[Motion::of_report(scenario, outcome)]).expect("it can be written");
    let begin = "<script type=\"application/json\" id=\"data\">";
    let (_, after) = text.split_once(begin).expect("it has data");
    let (data, _) = after.split_once("</script>").expect("they end");
    let data: Value = serde_json::from_str(data).expect("they are JSON");
    (text.clone(), data[0].clone())
}

fn bytes(value: &Value) -> Vec<u8> {
    STANDARD.decode(value.as_str().expect("it is text")).expect("base 64")
}

fn floats(value: &Value) -> Vec<f64> {
    let bytes = bytes(value);
    let all = bytes.chunks_exact(4);
    all.map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))).collect()
}

fn shorts(value: &Value) -> Vec<f64> {
    let bytes = bytes(value);
    let all = bytes.chunks_exact(2);
    all.map(|b| f64::from(i16::from_le_bytes([b[0], b[1]]))).collect()
}

/// An empty folder for one test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report").join(test);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("it is ours");
    }
    std::fs::create_dir_all(&folder).expect("it is writable");
    folder
}
