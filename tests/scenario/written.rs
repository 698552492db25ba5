//! Scenario files written by a test.

use aghf::scenario::Scenario;
use serde_json::Value;
use std::path::Path;

/// `scenario` with some keys more, or others.
pub fn with(mut scenario: Value, keys: Value) -> Value {
    for (key, value) in keys.as_object().expect("it is one") {
        scenario[key] = value.clone();
    }
    scenario
}

/// Writes a scenario file and loads it; the error is without the path of the file, which is there.
pub fn load(name: &str, scenario: &Value) -> Result<Scenario, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenario_written");
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    let path = folder.join(format!("{name}.json"));
    std::fs::write(&path, scenario.to_string()).expect("the folder is writable");
    let path = path.to_str().expect("it is text");
    Scenario::load(path).map_err(|e| {
        let error = e.to_string();
        let rest = error.strip_prefix(&format!("{path}: "));
        rest.unwrap_or_else(|| panic!("no file: {error}"))
            .to_owned()
    })
}
