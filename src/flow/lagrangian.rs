//! The Lagrangian, whose integral over time is the action that the flow minimises.

use super::{ActuationMetric, ActuationWeights, ControlCost, DualTrajectory};
use crate::dynamics::{Data, aba, crba, rnea};
use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Tanh};
use nalgebra::{DMatrix, DVector, DVectorView};

/// A function $L(t, x, \dot x)$ whose integral over time a flow minimises.
///
/// It is implemented once for all scalars; derivatives come from dual numbers. An implementation for all types `C` of
/// constants can also be proved over a finite field. The [guide](crate::guide::lagrangian) has an example.
pub trait Lagrangian<C: Scalar = f64> {
    /// Computes $L$ at the time `t`, in s, and at `x` and `xdot`, `2 N` entries each, under the penalty `k`.
    ///
    /// # Errors
    /// `x` or `xdot` does not have `2 N` entries.
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], xdot: &[S], k: C) -> Result<S>;
}

impl<C: Scalar, L: Lagrangian<C>> Lagrangian<C> for &L {
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], xdot: &[S], k: C) -> Result<S> {
        (**self).value(model, t, x, xdot, k)
    }
}

/// The Lagrangian of the paper in its control form, $k\\, |\dot x_{P1} - x_{P2}|^2 + |u|^2$.
#[derive(Clone, Copy, Debug, Default)]
pub struct AghfLagrangian;

impl<C: Scalar> Lagrangian<C> for AghfLagrangian {
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, _: S, x: &[S], xdot: &[S], k: C) -> Result<S> {
        let u = control(model, x, xdot)?;
        lagrangian_of_control(split(xdot).0, split(x).1, &u, k)
    }
}

/// The control $u = ID(x_{P1}, x_{P2}, \dot x_{P2})$.
fn control<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>, x: &[S], xdot: &[S]) -> Result<Vec<S>> {
    let mut u = vec![S::zero(); model.dof()];
    let ((q, v), (_, vdot)) = (split(x), split(xdot));
    rnea(model, &mut Data::new(model), q, v, vdot, &mut u)?;
    Ok(u)
}

/// The Lagrangian with actuation weights, a dual trajectory of the slip, and a cost of the control:
///
/// $$ L = k |e|^2 + \lambda_e(t)^T e + u^T W u + \sum_i \ell_i(t, u_i), \quad e = \dot x_{P1} - x_{P2}, \quad
///    u = ID(x_{P1}, x_{P2}, \dot x_{P2}) . $$
///
/// The default is the paper's. [`ControlForm`](super::ControlForm) is the flow in closed form, in the corresponding
/// [`metric`](Self::metric).
#[derive(Clone, Debug, PartialEq)]
pub struct ControlLagrangian<C: Scalar = f64, L = ()> {
    /// The weights $W$.
    pub weights: ActuationWeights<C>,
    /// The dual $\lambda_e$, `N` components; `None` is zero.
    pub slip_dual: Option<DualTrajectory<C>>,
    /// The cost $\ell$.
    pub cost: L,
}

impl<C: Scalar, L: Default> Default for ControlLagrangian<C, L> {
    fn default() -> Self {
        Self::with_cost(L::default())
    }
}

impl<C: Scalar, L> ControlLagrangian<C, L> {
    /// The paper's Lagrangian plus `cost`.
    #[must_use]
    pub fn with_cost(cost: L) -> Self {
        Self { weights: ActuationWeights::ones(), slip_dual: None, cost }
    }

    /// This Lagrangian plus another cost.
    #[must_use]
    pub fn and_cost<K>(self, cost: K) -> ControlLagrangian<C, (L, K)> {
        ControlLagrangian { weights: self.weights, slip_dual: self.slip_dual, cost: (self.cost, cost) }
    }

    /// The metric of the flow, $\mathrm{blockdiag}(k I, H W H)$.
    #[must_use]
    pub fn metric(&self) -> ActuationMetric<C> {
        ActuationMetric { weights: self.weights.clone() }
    }

    /// Checks that all parts have `n` joints.
    pub(super) fn check(&self, n: usize) -> Result<()> {
        self.weights.check(n)?;
        let components = self.slip_dual.as_ref().map(DualTrajectory::components);
        check_length("components of the dual of the slip", n, components.unwrap_or(n))
    }
}

impl<C: Scalar, L: ControlCost<C>> Lagrangian<C> for ControlLagrangian<C, L> {
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], xdot: &[S], k: C) -> Result<S> {
        self.check(model.dof())?;
        let (u, v, qdot) = (control(model, x, xdot)?, split(x).1, split(xdot).0);
        check_length("xdot", x.len(), xdot.len())?;
        let mut sum = S::zero();
        for i in 0..u.len() {
            let slip = qdot[i] - v[i];
            let effort = (u[i] * u[i]).scale(self.weights.of(i));
            sum += (slip * slip).scale(k) + effort + self.cost.value(t, i, u[i]);
            if let Some(dual) = &self.slip_dual {
                sum += dual.value(i, t) * slip;
            }
        }
        Ok(sum)
    }
}

/// The two halves of a state.
pub(super) fn split<S>(x: &[S]) -> (&[S], &[S]) {
    x.split_at(x.len() / 2)
}

/// Computes the Lagrangian by its definition, equations (5) and (11):
///
/// $$ L = (\dot x - F_d)^T G\\, (\dot x - F_d), \quad F_d = \begin{bmatrix} x_{P2} \\\\ FD_0 \end{bmatrix}, \quad
///    G = \begin{bmatrix} k I & 0 \\\\ 0 & H^T H \end{bmatrix}, \quad FD_0 = -H^{-1} C. $$
///
/// `x` and `xdot` have `2 N` entries. This definition allocates; the fast forms are tested against it. Cost O(N^2).
///
/// # Errors
/// `x` or `xdot` does not have `2 N` entries.
pub fn lagrangian<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    x: &[S],
    xdot: &[S],
    k: C,
) -> Result<S> {
    let n = model.dof();
    check_length("x", 2 * n, x.len())?;
    check_length("xdot", 2 * n, xdot.len())?;
    let (q, v) = x.split_at(n);
    let mut h = DMatrix::zeros(n, n);
    crba(model, data, q, &mut h)?;
    let mut fd0 = DVector::zeros(n);
    let zero = DVector::zeros(n);
    aba(model, data, q, v, zero.as_slice(), fd0.as_mut_slice())?;
    let slip = DVectorView::from_slice(&xdot[..n], n) - DVectorView::from_slice(v, n);
    let force = h * (DVectorView::from_slice(&xdot[n..], n) - fd0);
    Ok(slip.dot(&slip).scale(k) + force.dot(&force))
}

/// Computes the Lagrangian from the control `u`, $L = k\\, |\dot x_{P1} - x_{P2}|^2 + |u|^2$.
///
/// The value equals that of [`lagrangian`], because $H (\dot x_{P2} - FD_0) = H \dot x_{P2} + C = u$, the control (13).
/// `xdot_p1`, `x_p2` and `u` have `N` entries. Cost O(N).
///
/// # Errors
/// `xdot_p1` or `x_p2` does not have the length of `u`.
pub fn lagrangian_of_control<C: Scalar, S: AlgebraOver<C>>(xdot_p1: &[S], x_p2: &[S], u: &[S], k: C) -> Result<S> {
    check_length("xdot_p1", u.len(), xdot_p1.len())?;
    check_length("x_p2", u.len(), x_p2.len())?;
    let square = |sum, x| sum + x * x;
    let slip = xdot_p1.iter().zip(x_p2).map(|(a, b)| *a - *b);
    let slip = slip.fold(S::zero(), square);
    let force = u.iter().copied().fold(S::zero(), square);
    Ok(slip.scale(k) + force)
}
