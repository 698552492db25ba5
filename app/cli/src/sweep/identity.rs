//! The identity of a sweep, which keeps results of different sweeps apart.

use super::Sweep;
use aghf::error::{Error, Result};
use aghf_scenario::Method;
use serde_json::{Value, json};

impl Sweep {
    /// All data on which the results depend: the version of this library, the grid, the scenarios and their robots.
    ///
    /// # Errors
    /// None for a checked sweep.
    pub fn identity(&self) -> Result<Value> {
        // The scenarios and their robots are written in full below, and the name changes no result.
        let mut grid = json_value(&self.file.grid)?;
        grid["timeout_s"] = json!(self.file.timeout_s);
        if self.method() != Method::Flow {
            // Sweeps of the flow were there first.
            grid["method"] = json_value(&self.method())?;
        }
        let mut scenarios = Vec::new();
        for scenario in &self.scenarios {
            scenarios.push(json!({
                "name": scenario.name,
                "file": json_value(&scenario.file)?,
                "robot_xxh64": scenario.robot_xxh64,
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
