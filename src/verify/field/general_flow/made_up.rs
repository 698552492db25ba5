//! Lagrangians, metrics and drifts from the numbers of an instance, in which no term of an identity vanishes.

use crate::error::Result;
use crate::flow::{
    ActuationMetric, ActuationWeights, ControlCost, ControlDual, ControlLagrangian, Drift, DualTrajectory,
    FreeDynamics, Metric, StateCost,
};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Tanh};
use crate::verify::field::discretisation::numbers;
use crate::verify::field::{Gf, RandomInstance};
use nalgebra::{DMatrix, DVector};

/// One weight per joint.
pub(super) fn weights(p: &RandomInstance) -> Result<ActuationWeights<Gf>> {
    ActuationWeights::diagonal(p.w.as_slice().to_vec())
}

/// A trajectory of degree 3 with one component per joint; the first `skip` random numbers are not used.
pub(super) fn trajectory(p: &RandomInstance, skip: usize) -> Result<DualTrajectory<Gf>> {
    let mut number = numbers(p);
    let all: Vec<Gf> = (0..skip + 4 * p.dof()).map(|_| number()).collect();
    let coefficients = DMatrix::from_column_slice(p.dof(), 4, &all[skip..]);
    DualTrajectory::new(p.extra[0], coefficients)
}

/// The cost $(a t + b)\\, u^3 + t^2 u$ with numbers of each joint: no derivative in the flow vanishes.
#[derive(Clone)]
pub(in crate::verify::field) struct Cubic(DVector<Gf>);

impl ControlCost<Gf> for Cubic {
    fn value<S: AlgebraOver<Gf> + Tanh>(&self, t: S, joint: usize, u: S) -> S {
        let (a, b) = (self.0[joint], self.0[joint] * self.0[joint] + self.0[0]);
        (t.scale(a) + S::lift(b)) * u * u * u + t * t * u
    }
}

/// The cost of the control: a dual trajectory and a cubic.
pub(in crate::verify::field) type Cost = (ControlDual<Gf>, Cubic);

/// Weights, a dual trajectory of the slip, and a cost with a dual trajectory of the control.
pub(in crate::verify::field) fn lagrangian(p: &RandomInstance) -> Result<ControlLagrangian<Gf, Cost>> {
    Ok(ControlLagrangian {
        weights: weights(p)?,
        slip_dual: Some(trajectory(p, 0)?),
        cost: (ControlDual(trajectory(p, 50)?), Cubic(p.w.clone())),
    })
}

/// The metric $\mathrm{blockdiag}(k I, H W H)$ by its matrix alone, without the solves of [`ActuationMetric`].
pub(super) struct MatrixAlone(pub ActuationMetric<Gf>);

impl Metric<Gf> for MatrixAlone {
    fn matrix<S: AlgebraOver<Gf> + Tanh>(&self, model: &Model<Gf>, t: S, x: &[S], k: Gf) -> Result<DMatrix<S>> {
        self.0.matrix(model, t, x, k)
    }
}

/// A metric that couples all states and changes with time, $k I + t\\, x x^T$.
pub(in crate::verify::field) struct Coupled;

impl Metric<Gf> for Coupled {
    fn matrix<S: AlgebraOver<Gf> + Tanh>(&self, _: &Model<Gf>, t: S, x: &[S], k: Gf) -> Result<DMatrix<S>> {
        let count = x.len();
        let identity = DMatrix::identity(count, count) * S::lift(k);
        Ok(identity + DMatrix::from_fn(count, count, |i, j| t * x[i] * x[j]))
    }
}

/// The free dynamics with a time-dependent wind, $F_d + t^2 x$.
pub(super) struct Windy;

impl Drift<Gf> for Windy {
    fn rate<S: AlgebraOver<Gf> + Tanh>(&self, model: &Model<Gf>, t: S, x: &[S]) -> Result<DVector<S>> {
        Ok(FreeDynamics.rate(model, t, x)? + DVector::from_column_slice(x) * (t * t))
    }
}

/// A time-dependent cubic of the state, which couples each entry with others.
pub(in crate::verify::field) struct Place;

impl StateCost<Gf> for Place {
    fn value<S: AlgebraOver<Gf> + Tanh>(&self, _: &Model<Gf>, t: S, x: &[S]) -> Result<S> {
        let m = x.len();
        let term = |i: usize| x[i] * x[(i + 1) % m] * x[(i + m / 2 + 1) % m] + t * x[i] * x[i];
        Ok((0..m).fold(S::zero(), |sum, i| sum + (t + S::one()) * term(i)))
    }
}
