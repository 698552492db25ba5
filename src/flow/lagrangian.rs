//! The Lagrangian whose integral over time, the action, the flow makes smaller.

use super::{ActuationMetric, ActuationWeights, ControlCost, DualTrajectory};
use crate::dynamics::{Data, aba, crba, rnea};
use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Tanh};
use nalgebra::{DMatrix, DVector, DVectorView};

/// A function $L(t, x, \dot x)$ whose integral over time a flow makes smaller.
///
/// It is written once for every scalar; nothing else is asked for, since derivatives come from dual numbers. One that is
/// written for any type `C` of the constants can be proved over a field as well. A page of the
/// [guide](crate::guide::lagrangian) walks through an example.
pub trait Lagrangian<C: Scalar = f64> {
    /// $L$ at the time `t`, in s, and at `x` and `xdot`, `2 N` entries each, under the penalty `k`.
    ///
    /// # Errors
    /// The lengths are not those of the robot.
    fn value<S: AlgebraOver<C> + Tanh>(
        &self,
        model: &Model<C>,
        t: S,
        x: &[S],
        xdot: &[S],
        k: C,
    ) -> Result<S>;
}

impl<C: Scalar, L: Lagrangian<C>> Lagrangian<C> for &L {
    fn value<S: AlgebraOver<C> + Tanh>(
        &self,
        model: &Model<C>,
        t: S,
        x: &[S],
        xdot: &[S],
        k: C,
    ) -> Result<S> {
        (**self).value(model, t, x, xdot, k)
    }
}

/// The Lagrangian of the paper in its control form, $k\\, |\dot x_{P1} - x_{P2}|^2 + |u|^2$.
#[derive(Clone, Copy, Debug, Default)]
pub struct AghfLagrangian;

impl<C: Scalar> Lagrangian<C> for AghfLagrangian {
    fn value<S: AlgebraOver<C> + Tanh>(
        &self,
        model: &Model<C>,
        _: S,
        x: &[S],
        xdot: &[S],
        k: C,
    ) -> Result<S> {
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

/// Weights of the actuation, a dual trajectory of the slip, and a cost of the control:
///
/// $$ L = k |e|^2 + \lambda_e(t)^T e + u^T W u + \sum_i \ell_i(t, u_i), \quad e = \dot x_{P1} - x_{P2}, \quad
///    u = ID(x_{P1}, x_{P2}, \dot x_{P2}) . $$
///
/// The paper's is the default. [`ControlForm`](super::ControlForm) is its flow in closed form, in the [`metric`](Self::metric) that
/// belongs to it.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlLagrangian<C: Scalar = f64, L = ()> {
    /// $W$.
    pub weights: ActuationWeights<C>,
    /// $\lambda_e$, `N` components; none is zero.
    pub slip_dual: Option<DualTrajectory<C>>,
    /// $\ell$.
    pub cost: L,
}

impl<C: Scalar, L: Default> Default for ControlLagrangian<C, L> {
    fn default() -> Self {
        Self::with_cost(L::default())
    }
}

impl<C: Scalar, L> ControlLagrangian<C, L> {
    /// The paper's Lagrangian with `cost` added.
    #[must_use]
    pub fn with_cost(cost: L) -> Self {
        Self {
            weights: ActuationWeights::ones(),
            slip_dual: None,
            cost,
        }
    }

    /// The same with another cost besides.
    #[must_use]
    pub fn and_cost<K>(self, cost: K) -> ControlLagrangian<C, (L, K)> {
        ControlLagrangian {
            weights: self.weights,
            slip_dual: self.slip_dual,
            cost: (self.cost, cost),
        }
    }

    /// The metric of its flow, $\mathrm{blockdiag}(k I, H W H)$.
    #[must_use]
    pub fn metric(&self) -> ActuationMetric<C> {
        ActuationMetric {
            weights: self.weights.clone(),
        }
    }

    /// Checks that it is for `n` joints.
    pub(super) fn check(&self, n: usize) -> Result<()> {
        self.weights.check(n)?;
        let components = self.slip_dual.as_ref().map(DualTrajectory::components);
        check_length(
            "components of the dual of the slip",
            n,
            components.unwrap_or(n),
        )
    }
}

impl<C: Scalar, L: ControlCost<C>> Lagrangian<C> for ControlLagrangian<C, L> {
    fn value<S: AlgebraOver<C> + Tanh>(
        &self,
        model: &Model<C>,
        t: S,
        x: &[S],
        xdot: &[S],
        k: C,
    ) -> Result<S> {
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

/// The Lagrangian by its definition, equations (5) and (11):
///
/// $$ L = (\dot x - F_d)^T G\\, (\dot x - F_d), \quad F_d = \begin{bmatrix} x_{P2} \\\\ FD_0 \end{bmatrix}, \quad
///    G = \begin{bmatrix} k I & 0 \\\\ 0 & H^T H \end{bmatrix}, \quad FD_0 = -H^{-1} C. $$
///
/// `x` and `xdot` have `2 N` entries. It allocates: this is the definition that the fast forms are tested against.
/// Cost O(N^2).
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

/// The Lagrangian from the control `u`, $L = k\\, |\dot x_{P1} - x_{P2}|^2 + |u|^2$.
///
/// It is the same number as [`lagrangian`] gives, since $H (\dot x_{P2} - FD_0) = H \dot x_{P2} + C = u$, the control
/// (13). `xdot_p1`, `x_p2` and `u` have `N` entries.
///
/// # Errors
/// The lengths differ.
pub fn lagrangian_of_control<C: Scalar, S: AlgebraOver<C>>(
    xdot_p1: &[S],
    x_p2: &[S],
    u: &[S],
    k: C,
) -> Result<S> {
    check_length("xdot_p1", u.len(), xdot_p1.len())?;
    check_length("x_p2", u.len(), x_p2.len())?;
    let square = |sum, x| sum + x * x;
    let slip = xdot_p1.iter().zip(x_p2).map(|(a, b)| *a - *b);
    let slip = slip.fold(S::zero(), square);
    let force = u.iter().copied().fold(S::zero(), square);
    Ok(slip.scale(k) + force)
}
