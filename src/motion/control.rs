//! The control along a curve.

use crate::curve::Curve;
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::model::Model;
use nalgebra::DVector;

/// A curve at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub t: f64,
    /// Configuration $x_{P1}$.
    pub q: Vec<f64>,
    /// Velocity $x_{P2}$.
    pub v: Vec<f64>,
    /// Acceleration $\dot x_{P2}$.
    pub a: Vec<f64>,
    /// Control (13).
    pub u: Vec<f64>,
    /// $\dot x_{P1}$, which equals `v` if the curve is dynamically consistent.
    pub qdot: Vec<f64>,
}

/// Computes the control (13), $u = H \dot x_{P2} + C$, inverse dynamics at $(x_{P1}, x_{P2}, \dot x_{P2})$; line 3 of
/// Algorithm B3.
///
/// * `x`, `xdot`: `2 N` entries, the state in rad or m, per s, and its rate
/// * `u`: `N` entries, overwritten; N m or N
///
/// # Errors
/// `x` or `xdot` does not have `2 N` entries, or `u` not `N`, or `data` was made for another number of joints.
///
/// # Cost
/// O(N), no allocation.
pub fn control_at(
    model: &Model,
    data: &mut Data<f64>,
    x: &DVector<f64>,
    xdot: &DVector<f64>,
    u: &mut [f64],
) -> Result<()> {
    for (what, states) in [("x", x), ("xdot", xdot)] {
        crate::error::check_length(what, 2 * model.dof(), states.len())?;
    }
    let (q, v) = x.as_slice().split_at(model.dof());
    rnea(model, data, q, v, &xdot.as_slice()[model.dof()..], u)
}

/// Samples the curve at `intervals + 1` equidistant times, both ends included. At a breakpoint acceleration and control
/// are those of the later segment.
///
/// # Errors
/// The curve has another number of joints than `model`.
pub fn sample(model: &Model, curve: &Curve, intervals: usize) -> Result<Vec<Sample>> {
    let times = (0..=intervals).map(|i| curve.horizon() * i as f64 / intervals as f64);
    samples_at(model, curve, times.map(|t| (curve.segment_at(t), t))).collect()
}

/// Samples the curve at given times, each in the given segment.
pub fn samples_at(
    model: &Model,
    curve: &Curve,
    times: impl Iterator<Item = (usize, f64)>,
) -> impl Iterator<Item = Result<Sample>> {
    let n = model.dof();
    let mut data = Data::new(model);
    times.map(move |(segment, t)| {
        let (x, xdot) = curve.at_in(segment, t);
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
}
