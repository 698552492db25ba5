//! The metric of the descent, and the drift of an affine Lagrangian.

use super::ActuationWeights;
use super::lagrangian::{Lagrangian, split};
use crate::dynamics::{Data, aba, crba};
use crate::error::{Result, check_length};
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Tanh};
use nalgebra::{DMatrix, DVector};

/// A metric $G(t, x)$ on states, symmetric and positive definite, for [`LagrangianFlow`](super::LagrangianFlow).
pub trait Metric<C: Scalar = f64> {
    /// Computes $G$, `2 N` by `2 N`, at the time `t`, in s, and the state `x`, under the penalty `k`.
    ///
    /// # Errors
    /// `x` does not have `2 N` entries, or the metric has another number of joints.
    fn matrix<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], k: C) -> Result<DMatrix<S>>;

    /// Replaces `force`, `2 N` entries, by $G^{-1} f$; by default with a factorisation of [`matrix`](Self::matrix).
    ///
    /// # Errors
    /// Those of [`matrix`](Self::matrix), or `force` does not have `2 N` entries.
    fn raise<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], k: C, force: &mut [S]) -> Result<()> {
        let g = self.matrix(model, t, x, k)?;
        check_length("force", g.nrows(), force.len())?;
        let mut ldlt = Ldlt::new(g.nrows());
        ldlt.factorise(&g);
        ldlt.solve(force);
        Ok(())
    }
}

impl<C: Scalar, M: Metric<C>> Metric<C> for &M {
    fn matrix<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], k: C) -> Result<DMatrix<S>> {
        (**self).matrix(model, t, x, k)
    }

    fn raise<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], k: C, force: &mut [S]) -> Result<()> {
        (**self).raise(model, t, x, k, force)
    }
}

/// The metric $G = \mathrm{blockdiag}(k I, H W H)$ with the weights of the actuation: the paper's (11) if all are one.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuationMetric<C: Scalar = f64> {
    /// The weights $W$.
    pub weights: ActuationWeights<C>,
}

impl<C: Scalar> Default for ActuationMetric<C> {
    fn default() -> Self {
        let weights = ActuationWeights::ones();
        Self { weights }
    }
}

impl<C: Scalar> ActuationMetric<C> {
    /// Computes `H` at `x`, after checking the sizes.
    fn mass_matrix<S: AlgebraOver<C>>(&self, model: &Model<C>, x: &[S]) -> Result<DMatrix<S>> {
        let n = model.dof();
        self.weights.check(n)?;
        check_length("x", 2 * n, x.len())?;
        let mut h = DMatrix::zeros(n, n);
        crba(model, &mut Data::new(model), &x[..n], &mut h)?;
        Ok(h)
    }
}

impl<C: Scalar> Metric<C> for ActuationMetric<C> {
    fn matrix<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, _: S, x: &[S], k: C) -> Result<DMatrix<S>> {
        let (n, h) = (model.dof(), self.mass_matrix(model, x)?);
        let mut weighted = h.clone();
        self.weights.multiply(weighted.as_mut_slice());
        let mut g = DMatrix::zeros(2 * n, 2 * n);
        g.view_mut((0, 0), (n, n)).fill_diagonal(S::lift(k));
        let mut lower = g.view_mut((n, n), (n, n));
        lower.gemm_tr(S::one(), &h, &weighted, S::zero());
        Ok(g)
    }

    /// Uses two solves with `H` instead of one with `H W H`, whose condition number is the square.
    fn raise<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, _: S, x: &[S], k: C, force: &mut [S]) -> Result<()> {
        let (n, h) = (model.dof(), self.mass_matrix(model, x)?);
        check_length("force", 2 * n, force.len())?;
        let mut ldlt = Ldlt::new(n);
        ldlt.factorise(&h);
        let (upper, lower) = force.split_at_mut(n);
        let per_k = C::one() / k;
        upper.iter_mut().for_each(|f| *f = f.scale(per_k));
        ldlt.solve(lower);
        self.weights.divide(lower);
        ldlt.solve(lower);
        Ok(())
    }
}

/// A drift $F_d(t, x)$: the rate of the state without control.
pub trait Drift<C: Scalar = f64> {
    /// Computes $F_d$, `2 N` entries, at the time `t`, in s, and the state `x`.
    ///
    /// # Errors
    /// `x` does not have `2 N` entries, or the drift has another number of joints.
    fn rate<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S]) -> Result<DVector<S>>;
}

/// The paper's drift (5), the dynamics without control, $F_d = [x_{P2}; FD_0]$.
#[derive(Clone, Copy, Debug, Default)]
pub struct FreeDynamics;

impl<C: Scalar> Drift<C> for FreeDynamics {
    fn rate<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, _: S, x: &[S]) -> Result<DVector<S>> {
        let n = model.dof();
        check_length("x", 2 * n, x.len())?;
        let (q, v) = split(x);
        let mut rate = DVector::zeros(2 * n);
        let (upper, lower) = rate.as_mut_slice().split_at_mut(n);
        upper.copy_from_slice(v);
        aba(model, &mut Data::new(model), q, v, &vec![S::zero(); n], lower)?;
        Ok(rate)
    }
}

/// The Lagrangian $L = (\dot x - F_d)^T G\\, (\dot x - F_d)$ of the affine geometric heat flow, for any drift and any
/// metric; (5) and (11) give the paper's.
#[derive(Clone, Copy, Debug)]
pub struct AffineLagrangian<D, M> {
    /// The drift $F_d$.
    pub drift: D,
    /// The metric $G$.
    pub metric: M,
}

impl<C: Scalar, D: Drift<C>, M: Metric<C>> Lagrangian<C> for AffineLagrangian<D, M> {
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], xdot: &[S], k: C) -> Result<S> {
        check_length("xdot", 2 * model.dof(), xdot.len())?;
        let drift = self.drift.rate(model, t, x)?;
        check_length("drift", xdot.len(), drift.len())?;
        let g = self.metric.matrix(model, t, x, k)?;
        check_length("metric", xdot.len(), g.nrows())?;
        let away = DVector::from_column_slice(xdot) - drift;
        Ok(away.dot(&(g * &away)))
    }
}
