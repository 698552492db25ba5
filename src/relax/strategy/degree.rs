//! A degree that is as high as it has to be.

use crate::curve::Basis;
use crate::error::Result;
use crate::relax::RelaxSettings;
use crate::relax::interior_point::Candidate;
use serde::Serialize;

/// How a relaxation came to its degree.
///
/// The cost alone decides. The error of an open loop over the whole motion cannot: where the motion is unstable it grows exponentially in
/// time whatever the degree, since the control is that of the polynomial exactly. That of one interval with the control through the
/// nodes, [`replay_error`](crate::motion::replay_error), is told beside; it is no condition, because at degree 64 it is still tens of rad/s
/// for a Kinova with its light wrist. Whoever stores a control to replay it needs more times than there are nodes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DegreeRefinement {
    /// By how much the cost was to change at most from one degree to the next, relative.
    pub tolerance: f64,
    /// The degrees that were tried, ascending. The last one at which the search converged is that of the motion.
    pub degrees: Vec<usize>,
    /// The costs there.
    pub costs: Vec<f64>,
    /// Whether the last change is within the tolerance and the search converged on both sides of it. If not, that was so up to the
    /// largest degree there is, or up to one at which the search did not converge.
    #[serde(rename = "settled")]
    pub converged: bool,
}

/// Goes on from `found` to higher degrees, each from where the one before ended, if the settings ask for it.
pub(in crate::relax) fn refine(
    settings: &RelaxSettings,
    mut found: Candidate,
    mut next: impl FnMut(&Candidate, Basis) -> Result<Candidate>,
) -> Result<(Candidate, Option<DegreeRefinement>)> {
    let Some(tolerance) = settings.degree_tolerance else {
        return Ok((found, None));
    };
    let mut adapted = DegreeRefinement {
        tolerance,
        degrees: vec![found.path.basis.degree()],
        costs: vec![found.cost],
        converged: false,
    };
    let (segments, free_end) = (found.path.basis.segments(), settings.free_final_velocity);
    for degree in RelaxSettings::higher_degrees(&found.path.basis) {
        if !found.converged || adapted.converged {
            break;
        }
        let higher = next(&found, Basis::new(segments, degree, free_end))?;
        adapted.degrees.push(degree);
        adapted.costs.push(higher.cost);
        if !higher.converged {
            break;
        }
        let change = (higher.cost - found.cost).abs();
        adapted.converged = change <= tolerance * higher.cost.abs();
        found = higher;
    }
    Ok((found, Some(adapted)))
}
