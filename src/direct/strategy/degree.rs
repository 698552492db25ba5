//! The adaptive degree.

use crate::curve::Basis;
use crate::direct::DirectSettings;
use crate::direct::minimise::Candidate;
use crate::error::Result;
use serde::{Deserialize, Serialize};

/// The degrees of a solve with an adaptive degree.
///
/// Only the cost decides. The open-loop error over the whole motion is no criterion: in an unstable motion it grows
/// exponentially in time at any degree, because the control is exactly that of the polynomial. The error over one
/// interval with the control interpolated at the nodes, [`replay_error`](crate::motion::replay_error), is reported but
/// is not a criterion either, because at degree 64 it is still tens of rad/s for a Kinova with its light wrist. To
/// replay a stored control, sample it at more times than the nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DegreeRefinement {
    /// The largest relative change of the cost between two degrees.
    pub tolerance: f64,
    /// The degrees tried, ascending. The motion has the last one at which the search converged.
    pub degrees: Vec<usize>,
    /// The cost at each degree.
    pub costs: Vec<f64>,
    /// True if the last change is within the tolerance and the search converged at both degrees. If false, this was not
    /// reached up to the largest degree, or up to one at which the search did not converge.
    pub converged: bool,
}

/// Continues from `found` to higher degrees, each from the end of the one before, if the settings request it.
pub(crate) fn refine(
    settings: &DirectSettings,
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
    let (segments, continuity) = (found.path.basis.segments(), found.path.basis.continuity());
    for degree in DirectSettings::higher_degrees(&found.path.basis) {
        if !found.converged || adapted.converged {
            break;
        }
        let higher = next(&found, Basis::new(segments, degree, continuity))?;
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
