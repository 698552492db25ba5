//! A scenario with other values for some keys.

use crate::keys::json::read_json;
use crate::{Scenario, ScenarioFile};
use aghf::error::{Error, Result};
use serde_json::{Map, Value};
use std::path::Path;

impl Scenario {
    /// The same scenario with other values for some keys, with dots before the keys of inner objects, such as
    /// `objective.velocity`. As in a merge patch (RFC 7396), a value that is not an object becomes one if an inner key
    /// is set.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); they name the scenario.
    pub fn with_keys(&self, keys: &Map<String, Value>) -> Result<Self> {
        if keys.is_empty() {
            return Ok(self.clone());
        }
        let failed = |e: serde_json::Error| Error::input(&self.name, "scenario", e.to_string());
        let mut patched = serde_json::to_value(&self.file).map_err(failed)?;
        for (key, value) in keys {
            let mut place = &mut patched;
            for part in key.split('.') {
                if !place.is_object() {
                    *place = Value::Object(Map::new());
                }
                place = &mut place[part];
            }
            *place = value.clone();
        }
        let mut file: ScenarioFile = read_json(&patched.to_string(), &self.name)?;
        let robot = std::mem::replace(&mut file.robot, self.robot_place.clone());
        let mut scenario = Self::new(file, &self.name, Path::new(""))?;
        scenario.file.robot = robot;
        scenario.own.take_added(&self.own);
        Ok(scenario)
    }
}
