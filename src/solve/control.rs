//! The control that a curve takes, and what it costs.

use crate::aghf::lagrangian_of_control;
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::model::Model;
use crate::pseudospectral::Curve;
use nalgebra::DVector;

/// How many intervals of time [`measure`] looks at, at least.
const INTERVALS: usize = 2000;

/// A curve at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub t: f64,
    /// $x_{P1}$, the configuration.
    pub q: Vec<f64>,
    /// $x_{P2}$, the velocity.
    pub v: Vec<f64>,
    /// $\dot x_{P2}$, the acceleration.
    pub a: Vec<f64>,
    /// The control (13).
    pub u: Vec<f64>,
    /// $\dot x_{P1}$, which is `v` where the curve is dynamically consistent.
    pub qdot: Vec<f64>,
}

/// What a curve costs and how well it keeps to the dynamics, all from a grid of 2001 times, a few more for several parts, not
/// from the nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// $\int |u|^2 dt$, in N^2 m^2 s, by Simpson's rule.
    pub control_effort: f64,
    /// The action $\int L\, dt$, by Simpson's rule.
    pub action: f64,
    /// The action by Clenshaw-Curtis quadrature over the nodes of each part: what the flow itself sees.
    pub action_at_nodes: f64,
    /// $\max_t |\dot q - v|_\infty$.
    pub dynamics_defect: f64,
}

/// The control extraction (13): $u(t) = H \dot x_{P2} + C$, inverse dynamics at $(x_{P1}, x_{P2}, \dot x_{P2})$.
/// `u` has `N` entries.
///
/// # Errors
/// The curve or `u` is for another robot.
pub fn control_at(
    model: &Model,
    data: &mut Data<f64>,
    x: &DVector<f64>,
    xdot: &DVector<f64>,
    u: &mut [f64],
) -> Result<()> {
    crate::error::check_length("x", 2 * model.dof(), x.len())?;
    let (q, v) = x.as_slice().split_at(model.dof());
    rnea(model, data, q, v, &xdot.as_slice()[model.dof()..], u)
}

/// The curve at `intervals + 1` equidistant times, both ends included. At a joint of two parts acceleration and control are those of
/// the later one.
///
/// # Errors
/// The curve is for another robot.
pub fn sample(model: &Model, curve: &Curve, intervals: usize) -> Result<Vec<Sample>> {
    let times = (0..=intervals).map(|i| curve.horizon() * i as f64 / intervals as f64);
    samples_at(model, curve, times.map(|t| (curve.part_at(t), t)))
}

/// The curve at times, each by the polynomial of the part before it.
fn samples_at(
    model: &Model,
    curve: &Curve,
    times: impl Iterator<Item = (usize, f64)>,
) -> Result<Vec<Sample>> {
    let n = model.dof();
    let mut data = Data::new(model);
    times
        .map(|(part, t)| {
            let (x, xdot) = curve.at_of(part, t);
            let mut u = vec![0.0; n];
            control_at(model, &mut data, &x, &xdot, &mut u)?;
            Ok(Sample {
                t,
                q: x.as_slice()[..n].to_vec(),
                v: x.as_slice()[n..].to_vec(),
                a: xdot.as_slice()[n..].to_vec(),
                u,
                qdot: xdot.as_slice()[..n].to_vec(),
            })
        })
        .collect()
}

/// The costs and the defect of a curve under the penalty `k`, each part by itself, because the control may jump where two meet.
///
/// # Errors
/// The curve is for another robot.
pub fn measure(model: &Model, curve: &Curve, k: f64) -> Result<Effort> {
    let mut effort = Effort {
        control_effort: 0.0,
        action: 0.0,
        action_at_nodes: 0.0,
        dynamics_defect: 0.0,
    };
    for part in 0..curve.pieces() {
        add_part(model, curve, k, part, &mut effort)?;
    }
    Ok(effort)
}

fn add_part(model: &Model, curve: &Curve, k: f64, part: usize, effort: &mut Effort) -> Result<()> {
    let action = |s: &Sample| lagrangian_of_control(&s.qdot, &s.v, &s.u, k);
    let (chebyshev, begin) = (curve.chebyshev(), curve.joints()[part]);
    let nodes = chebyshev.times().iter().map(|t| (part, begin + t));
    let at_nodes = samples_at(model, curve, nodes)?;
    for (sample, weight) in at_nodes.iter().zip(chebyshev.weights()) {
        effort.action_at_nodes += weight * action(sample)?;
    }
    // Even, for Simpson's rule.
    let intervals = 2 * INTERVALS.div_ceil(2 * curve.pieces());
    let length = chebyshev.horizon();
    let times = (0..=intervals).map(|i| (part, begin + length * i as f64 / intervals as f64));
    let third = length / intervals as f64 / 3.0;
    for (i, sample) in samples_at(model, curve, times)?.iter().enumerate() {
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
