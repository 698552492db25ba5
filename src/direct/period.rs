//! Periodic motions.

use super::DirectSettings;
use crate::constraint::is_permutation;
use crate::error::{Error, Result, check_length};
use crate::motion::Problem;

/// The relation between the ends of a periodic motion: joint `i` ends at `signs[i]` times the position and the velocity
/// with which joint `joints[i]` starts. For a gait of mirrored steps that is the joint of the other leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Period {
    /// A permutation of the joints, `N` entries.
    pub joints: Vec<usize>,
    /// 1 or -1 per joint.
    pub signs: Vec<f64>,
}

impl Period {
    /// The positions or velocities at the end that follow from those at the start, `N` entries.
    ///
    /// # Panics
    /// `start` has fewer entries than joints are named.
    #[must_use]
    pub fn end_of(&self, start: &[f64]) -> Vec<f64> {
        let all = self.joints.iter().zip(&self.signs);
        all.map(|(joint, sign)| sign * start[*joint]).collect()
    }

    /// Refuses a relation that is not a permutation with signs, and settings that a periodic motion cannot have.
    pub(super) fn check(&self, settings: &DirectSettings, problem: &Problem<'_>) -> Result<()> {
        let n = problem.model().dof();
        check_length("joints of the period", n, self.joints.len())?;
        check_length("signs of the period", n, self.signs.len())?;
        let refuse = |condition: &str| Err(Error::input("settings", "period", condition));
        if !is_permutation(&self.joints, n) {
            return refuse("the joints are not a permutation");
        }
        if self.signs.iter().any(|sign| sign.abs() != 1.0) {
            return refuse("a sign is neither 1 nor -1");
        }
        if settings.goal.is_some() || settings.free_final_velocity {
            return refuse("the end follows from the start, so it has no goal and no free velocity");
        }
        if settings.continuous_acceleration {
            return refuse("accelerations jump where a periodic motion begins anew");
        }
        Ok(())
    }
}
