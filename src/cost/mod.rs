//! Running costs: functions of the motion and the control at a point in time, with their derivatives.
//!
//! [`RunningCost`] is a cost in $(t, q, v, a, u)$, [`PointCost`] one in $(t, q, v, a)$ that may know the control.
//! [`ControlEffort`] and, for any running cost, [`CostThroughDynamics`] lead from one to the other.

mod autodiff;
mod chain_rule;
mod composition;
mod effort;
mod in_phases;
mod packed_hessian;
mod point_cost;
mod weighted_squares;

pub use crate::constraint::{StageDerivatives, StageInput};
pub use autodiff::AutodiffCost;
pub use chain_rule::ChainRule;
pub use composition::Weighted;
pub use effort::ControlEffort;
pub(crate) use effort::alone;
pub use in_phases::InPhases;
pub use num_dual::HyperDual64;
pub use packed_hessian::PackedHessian;
pub(crate) use packed_hessian::products;
pub use point_cost::{
    ControlDerivatives, ControlTerm, CostWithControl, Point, PointCost, PointDerivatives, Points, PointsDerivatives,
};
pub use weighted_squares::WeightedSquares;

use crate::error::{Error, Result};
use crate::linalg::positive_part;
use crate::model::Model;
use nalgebra::DMatrix;

/// The cost below which a value is rounding error, in N^2 m^2 s; gradients are not measured relative to less.
pub(crate) const MIN_COST: f64 = f64::EPSILON;

/// A running cost $l(t, q, v, a, u)$ with analytic derivatives. [`CostThroughDynamics::new`] accepts a closure without
/// derivatives.
///
/// Tuples of up to six, arrays, vectors and slices of running costs are their sum, and [`Weighted`] is a cost times a
/// constant. `&R` and `Arc<R>` delegate to `R`, so that `Vec<Arc<dyn RunningCost + Send + Sync>>` holds costs of any
/// type.
///
/// The integral must not be negative on any curve of the search, see [`CostThroughDynamics`].
pub trait RunningCost {
    /// Computes $l$.
    ///
    /// # Errors
    /// A slice of the input does not have `N` entries.
    fn value(&self, at: &StageInput<'_, f64>) -> Result<f64>;

    /// Computes $l$, and its derivatives into `out`, which is zero on entry.
    ///
    /// # Errors
    /// A slice of the input does not have `N` entries.
    fn derivatives(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> Result<f64>;

    /// Computes the partial derivative $\partial l / \partial t$, which a free horizon needs for a cost that depends
    /// explicitly on time. Zero by default.
    ///
    /// # Errors
    /// A slice of the input does not have `N` entries.
    fn time_rate(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        let _ = at;
        Ok(0.0)
    }
}

/// A user-defined running cost $l(t, q, v, a, u)$ along motions of a robot, for
/// [`Direct::cost`](crate::direct::Direct::cost).
///
/// The direct method needs derivatives in $z = [q; v; a]$ with $u = ID(z)$; [`ChainRule`] computes them from those in
/// $[z; u]$. The Gauss-Newton metric is the Hessian without the second derivatives of $ID$ and with the negative
/// eigenvalues of $\partial^2 l / \partial y^2$ set to zero.
///
/// The integral must not be negative on any curve of the search, because gradients are measured relative to it; a
/// negative one is an error. A constant added to `l` does not change the optimum over a fixed horizon. Integrals below
/// 2e-16 count as zero.
#[derive(Clone, Debug)]
pub struct CostThroughDynamics<'m, R> {
    running: R,
    rule: ChainRule<'m, f64, f64>,
    by_y: StageDerivatives<f64>,
    by_term: ControlDerivatives<f64>,
    positive: DMatrix<f64>,
}

impl<'m, F: Fn(&StageInput<'_, HyperDual64>) -> HyperDual64> CostThroughDynamics<'m, AutodiffCost<F>> {
    /// A cost given as a closure, with derivatives by dual numbers: about $8 N^2$ calls of the closure per point.
    #[must_use]
    pub fn new(model: &'m Model, value: F) -> Self {
        Self::of(model, AutodiffCost(value))
    }
}

impl<'m, R: RunningCost> CostThroughDynamics<'m, R> {
    /// A cost with analytic derivatives.
    #[must_use]
    pub fn of(model: &'m Model, running: R) -> Self {
        let n = model.dof();
        Self {
            running,
            rule: ChainRule::new(model),
            by_y: StageDerivatives::new(n),
            by_term: ControlDerivatives::new(n),
            positive: DMatrix::zeros(4 * n, 4 * n),
        }
    }
}

impl<R: RunningCost> PointCost<f64> for CostThroughDynamics<'_, R> {
    fn value(&mut self, point: Point<'_, f64>) -> Result<f64> {
        let u = self.rule.control(point)?;
        self.running.value(&point.with_control(u))
    }

    fn derivatives(&mut self, point: Point<'_, f64>, out: &mut PointDerivatives<f64>) -> Result<f64> {
        self.with_term(point, out, &mut |_, _, _| false)
    }

    fn time_rate(&mut self, point: Point<'_, f64>) -> Result<f64> {
        let u = self.rule.control(point)?;
        self.running.time_rate(&point.with_control(u))
    }
}

impl<R: RunningCost + Clone + Send + Sync> CostWithControl for CostThroughDynamics<'_, R> {
    fn values_with_control(
        &mut self,
        points: Points<'_, f64>,
        costs: &mut [f64],
        controls: &mut DMatrix<f64>,
    ) -> Result<()> {
        for (g, (cost, mut u)) in costs.iter_mut().zip(controls.column_iter_mut()).enumerate() {
            let control = self.rule.control(points.point(g))?;
            u.copy_from_slice(control);
            *cost = self.running.value(&points.point(g).with_control(control))?;
        }
        Ok(())
    }

    fn all_derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        term: &mut impl ControlTerm<f64>,
    ) -> Result<()> {
        let mut single = PointDerivatives::new(points.states.nrows());
        for g in 0..points.count() {
            let cost = self.with_term(points.point(g), &mut single, term)?;
            out.set(g, cost, &single);
        }
        Ok(())
    }
}

impl<R: RunningCost> CostThroughDynamics<'_, R> {
    fn with_term(
        &mut self,
        point: Point<'_, f64>,
        out: &mut PointDerivatives<f64>,
        term: &mut impl ControlTerm<f64>,
    ) -> Result<f64> {
        let n = point.q.len();
        let u = self.rule.linearise(point)?;
        let by_y = &mut self.by_y;
        by_y.gradient.fill(0.0);
        by_y.hessian.fill(0.0);
        let value = self.running.derivatives(&point.with_control(u), by_y)?;
        let convex = positive_part(&by_y.hessian, &mut self.positive);
        self.by_term.clear();
        let stiff = term(point.index, u, &mut self.by_term);
        self.rule.pull_back(&self.positive, &mut out.metric);
        if convex && !stiff {
            out.hessian.copy_from(&out.metric);
        } else {
            for (i, c) in self.by_term.hessian.iter().enumerate() {
                by_y.hessian[(3 * n + i, 3 * n + i)] += c;
            }
            self.rule.pull_back(&by_y.hessian, &mut out.hessian);
        }
        let by_u = &mut by_y.gradient.as_mut_slice()[3 * n..];
        let term = &mut self.by_term;
        for (own, (weight, slope)) in by_u.iter_mut().zip(term.curvature_weights.iter_mut().zip(&term.gradient)) {
            *weight += *own;
            *own += slope;
        }
        self.rule.gradient(&by_y.gradient, &mut out.gradient);
        let weights = &self.by_term.curvature_weights;
        self.rule.add_curvature(point, weights, &mut out.hessian)?;
        Ok(value)
    }
}

/// Refuses a negative integral: gradients are measured relative to it.
pub(super) fn check_integral(cost: f64) -> Result<()> {
    if cost < -MIN_COST {
        let condition =
            format!("it is {cost:.3e} on a curve that was tried, and must not be negative: add a constant to the cost");
        return Err(Error::input("running cost", "integral", condition));
    }
    Ok(())
}
