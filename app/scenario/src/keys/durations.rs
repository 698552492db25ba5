//! The durations of the phases of a walk.

use crate::{ScenarioFile, WalkPhase};
use aghf::error::{Error, Result};
use aghf::motion::Problem;

/// Refuses durations of phases that are not an interval, or that do not add up to the horizon.
pub(crate) fn check_durations(file: &ScenarioFile, path: &str) -> Result<()> {
    for (k, phase) in file.phases.iter().enumerate() {
        let refuse = |key: &str, condition: String| Err(Error::input(path, format!("phases[{k}].{key}"), condition));
        let (shortest, longest) = match (phase.shortest_s, phase.longest_s) {
            (None, None) => continue,
            (Some(shortest), Some(longest)) => (shortest, longest),
            (Some(_), None) => {
                return refuse("longest_s", "it is missing beside shortest_s".to_owned());
            }
            (None, Some(_)) => {
                return refuse("shortest_s", "it is missing beside longest_s".to_owned());
            }
        };
        for (key, value) in [("shortest_s", shortest), ("longest_s", longest)] {
            if let Err(condition) = Problem::check_horizon(value) {
                return refuse(key, condition);
            }
        }
        if shortest > longest {
            return refuse("longest_s", format!("it is {longest}, below shortest_s, {shortest}"));
        }
    }
    let durations = file.durations();
    let [shortest, longest] = sum_of(&durations);
    let horizon = file.horizon_s;
    let rounding = f64::EPSILON.sqrt() * horizon;
    let range = shortest - rounding..=longest + rounding;
    if !durations.is_empty() && !range.contains(&horizon) {
        let condition = format!("it is {horizon}, the phases last from {shortest} to {longest} s");
        return Err(Error::input(path, "horizon_s", condition));
    }
    Ok(())
}

/// The sums of the shortest and of the longest durations.
pub(crate) fn sum_of(durations: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|end| durations.iter().map(|of| of[end]).sum())
}

impl ScenarioFile {
    /// The shortest and the longest duration of each phase, s, where one of them has a duration of its own.
    pub(crate) fn durations(&self) -> Vec<[f64; 2]> {
        let share = self.horizon_s / self.phases.len().max(1) as f64;
        if self.phases.iter().all(|phase| phase.shortest_s.is_none()) {
            return Vec::new();
        }
        let own = |phase: &WalkPhase| [phase.shortest_s, phase.longest_s].map(|of| of.unwrap_or(share));
        self.phases.iter().map(own).collect()
    }
}
