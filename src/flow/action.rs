//! The control effort and the action of a curve.

use super::lagrangian_of_control;
use crate::curve::Curve;
use crate::error::Result;
use crate::model::Model;
use crate::motion::{Sample, samples_at};

/// The smallest number of time intervals on which [`effort_of`] integrates.
const INTERVALS: usize = 2000;

/// The costs of a curve and its defect in the dynamics, computed on a grid of at least 2001 times and not at the nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortSummary {
    /// $\int |u|^2 dt$, in N^2 m^2 s, by Simpson's rule.
    pub control_effort: f64,
    /// The action $\int L\\, dt$, by Simpson's rule.
    pub action: f64,
    /// The action by Clenshaw-Curtis quadrature over the nodes of each segment, which the flow minimises.
    pub action_at_nodes: f64,
    /// $\max_t |\dot q - v|_\infty$.
    pub dynamics_defect: f64,
}

/// Computes the costs and the defect of a curve under the penalty `k`, segment by segment, because the control may jump
/// between segments.
///
/// # Errors
/// The curve has another number of joints than `model`.
pub fn effort_of(model: &Model, curve: &Curve, k: f64) -> Result<EffortSummary> {
    let mut effort = EffortSummary { control_effort: 0.0, action: 0.0, action_at_nodes: 0.0, dynamics_defect: 0.0 };
    for segment in 0..curve.segments() {
        add_segment(model, curve, k, segment, &mut effort)?;
    }
    Ok(effort)
}

fn add_segment(model: &Model, curve: &Curve, k: f64, segment: usize, effort: &mut EffortSummary) -> Result<()> {
    let action = |s: &Sample| lagrangian_of_control(&s.qdot, &s.v, &s.u, k);
    let (chebyshev, begin) = (curve.chebyshev(segment), curve.breakpoints()[segment]);
    let nodes = chebyshev.times().iter().map(|t| (segment, begin + t));
    for (sample, weight) in samples_at(model, curve, nodes).zip(chebyshev.weights()) {
        effort.action_at_nodes += weight * action(&sample?)?;
    }
    // Even, for Simpson's rule.
    let intervals = 2 * INTERVALS.div_ceil(2 * curve.segments());
    let length = chebyshev.horizon();
    let times = (0..=intervals).map(|i| (segment, begin + length * i as f64 / intervals as f64));
    let third = length / intervals as f64 / 3.0;
    for (i, sample) in samples_at(model, curve, times).enumerate() {
        let sample = &sample?;
        let simpson = match i {
            _ if i == 0 || i == intervals => third,
            _ if i % 2 == 1 => 4.0 * third,
            _ => 2.0 * third,
        };
        effort.control_effort += simpson * sample.u.iter().map(|u| u * u).sum::<f64>();
        effort.action += simpson * action(sample)?;
        for (qdot, v) in sample.qdot.iter().zip(&sample.v) {
            effort.dynamics_defect = effort.dynamics_defect.max((qdot - v).abs());
        }
    }
    Ok(())
}
