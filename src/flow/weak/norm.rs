//! The metric of a flow in its weak form.

use crate::cost::{Point, PointCost, PointDerivatives};
use crate::error::{Result, check_length};
use crate::flow::{ActuationMetric, Metric};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Tanh};
use std::f64::consts::PI;

crate::names::named_enum! {
/// The metric of a flow to rest. It changes the path, but not the condition at its end, where the gradient vanishes.
pub enum RestMetric("metric") {
    /// The mean square of the velocities, $\tfrac{T}{2 \pi^2} \int |\dot x_{P1}|^2 + |x_{P2}|^2 dt$: without a slip that of
    /// the direct method.
    Velocity = "velocity",
    /// The metric of the flow, $\int \partial x^T G\\, \partial x\\, dt$ with (11) for $G$, or with any other.
    Flow = "flow",
}
}

/// A metric in which the coefficients of a curve in the state flow: as a cost without value, whose
/// [metric](PointDerivatives::metric) integrates to the matrix $M_{mn} = \int \varphi_m \varphi_n\\, G\\, dt$.
#[derive(Clone, Debug)]
pub struct Norm<'m, C: Scalar = f64, M = ActuationMetric<C>> {
    /// The robot.
    pub model: &'m Model<C>,
    /// The kind of metric.
    pub kind: RestMetric,
    /// The metric $G$.
    pub metric: M,
    /// The penalty of the metric.
    pub k: C,
    /// The horizon, s.
    pub horizon: C,
}

impl<C: Scalar, M: Metric<C>, S: AlgebraOver<C> + Tanh> PointCost<S> for Norm<'_, C, M> {
    fn value(&mut self, _: Point<'_, S>) -> Result<S> {
        Ok(S::zero())
    }

    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        let (x, n) = (point.q, self.model.dof());
        check_length("states", 2 * n, x.len())?;
        out.gradient.fill(S::zero());
        out.hessian.fill(S::zero());
        out.metric.fill(S::zero());
        match self.kind {
            RestMetric::Velocity => {
                let weight = S::lift(self.horizon) * S::from_f64(0.5 * PI.powi(-2));
                for i in n..3 * n {
                    // The velocity, and the rate of the configuration.
                    out.metric[(i, i)] = weight;
                }
            }
            RestMetric::Flow => {
                let g = self.metric.matrix(self.model, point.time, x, self.k)?;
                check_length("metric", 4 * n * n, g.len())?;
                out.metric.view_mut((0, 0), (2 * n, 2 * n)).copy_from(&g);
            }
        }
        Ok(S::zero())
    }
}
