//! The keys of a scenario that say what the relaxation is to find, beside a motion of least effort from state to state.

use super::Scenario;
use crate::error::{Error, Result};

impl Scenario {
    /// Refuses what only the relaxation can be asked for.
    pub(super) fn check_for_flow(&self) -> Result<()> {
        let keys = [("free_final_velocity", self.file.free_final_velocity)];
        match keys.iter().find(|(_, given)| *given) {
            Some((key, _)) => {
                let condition = "the method 'flow' does not know it, only 'relax' does";
                Err(Error::input(&self.name, *key, condition))
            }
            None => Ok(()),
        }
    }
}
