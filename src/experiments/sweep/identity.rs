//! What tells one sweep from another: results of two must not be mixed.

use super::Sweep;
use crate::error::{Error, Result};
use crate::urdf::builtin_robot_text;
use serde_json::{Value, json};
use std::path::Path;

/// The text of the robot that is built in under this name, or else of the file at this path below `folder`.
pub(super) fn robot_text(name_or_path: &str, folder: &Path) -> Result<String> {
    if let Some(text) = builtin_robot_text(name_or_path) {
        return Ok(text.to_owned());
    }
    let path = folder.join(name_or_path);
    std::fs::read_to_string(&path).map_err(|e| Error::io(path, e))
}

impl Sweep {
    /// All that the results depend on: the version of this library, the grid, the scenarios and their robots.
    ///
    /// # Errors
    /// None that a checked sweep should show.
    pub fn identity(&self) -> Result<Value> {
        let mut grid = json_value(&self.file)?;
        if let Some(grid) = grid.as_object_mut() {
            // The scenarios are told in full below, and the name changes no result.
            grid.retain(|key, _| key != "scenarios" && key != "name");
        }
        let mut scenarios = Vec::new();
        for (scenario, robot) in self.scenarios.iter().zip(&self.robots) {
            let hash = twox_hash::XxHash64::oneshot(0, robot.as_bytes());
            scenarios.push(json!({
                "name": scenario.name,
                "file": json_value(&scenario.file)?,
                "robot_xxh64": format!("{hash:016x}"),
            }));
        }
        Ok(json!({
            "aghf": env!("CARGO_PKG_VERSION"),
            "grid": grid,
            "scenarios": scenarios,
        }))
    }
}

fn json_value(value: &impl serde::Serialize) -> Result<Value> {
    serde_json::to_value(value)
        .map_err(|e| Error::input("sweep", "definition", format!("it is no JSON: {e}")))
}
