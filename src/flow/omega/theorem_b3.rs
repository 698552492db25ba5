//! Theorem B3: the right-hand side of the flow as four terms in the dynamics and their first derivatives.

use crate::error::Result;
use crate::flow::Node;
use crate::linalg::Ldlt;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{DMatrix, DVector, DVectorView};

/// The quantities of Theorem B3, and its four terms as functions of them.
///
/// Matrices are `N` by `N`, vectors have `N` entries; the terms have `2 N`. Nothing is allocated after
/// [`new`](Self::new). The quantities may be computed by any method: [`AlgorithmB1`](crate::flow::AlgorithmB1) uses
/// recursions, the tests also dual numbers.
#[derive(Clone, Debug)]
pub struct TheoremB3<S: Scalar> {
    /// $H$, at $x_{P1}$.
    pub h: DMatrix<S>,
    /// $\dot H$, along $\dot x_{P1}$.
    pub hdot: DMatrix<S>,
    /// $C$, at $x_{P1}, x_{P2}$.
    pub c: DVector<S>,
    /// $\dot C$, along $\dot x_{P1}, \dot x_{P2}$.
    pub cdot: DVector<S>,
    /// $FD_0 = -H^{-1} C$.
    pub fd0: DVector<S>,
    /// $\partial FD_0 / \partial x_{P1}$, rows are those of $FD_0$.
    pub dfd0_dq: DMatrix<S>,
    /// $\partial FD_0 / \partial x_{P2}$.
    pub dfd0_dv: DMatrix<S>,
    /// $\left[ \frac{\partial H}{\partial x_{P1}} (\dot x_{P2} - FD_0) \right]\_{ij} = \sum_k \frac{\partial
    /// H_{ik}}{\partial q_j} (\dot x_{P2} - FD_0)\_k$.
    pub dh_dq_w: DMatrix<S>,
    ldlt: Ldlt<S>,
    force: DVector<S>,
    force_rate: DVector<S>,
    sum: DVector<S>,
    term: DVector<S>,
}

impl<S: Scalar> TheoremB3<S> {
    /// Zeros for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let (matrix, vector) = (DMatrix::zeros(n, n), DVector::zeros(n));
        Self {
            h: matrix.clone(),
            hdot: matrix.clone(),
            c: vector.clone(),
            cdot: vector.clone(),
            fd0: vector.clone(),
            dfd0_dq: matrix.clone(),
            dfd0_dv: matrix.clone(),
            dh_dq_w: matrix,
            ldlt: Ldlt::new(n),
            force: vector.clone(),
            force_rate: vector.clone(),
            sum: vector,
            term: DVector::zeros(2 * n),
        }
    }

    /// Computes (B5), $\Omega = \Omega_1 - (\Omega_2 - \Omega_3 + \Omega_4)$, into `omega`, `2 N` entries. Cost O(N^3)
    /// for the factors of `H`, O(N^2) for the rest.
    ///
    /// # Errors
    /// A slice of `node`, or `omega`, does not have `2 N` entries.
    pub fn omega<C: Scalar>(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()>
    where
        S: AlgebraOver<C>,
    {
        let n = self.c.len();
        node.check(n, omega.len())?;
        let mut term = std::mem::replace(&mut self.term, DVector::zeros(0));
        self.omega_1(node, &mut term);
        omega.copy_from_slice(term.as_slice());
        self.omega_2(node, k, &mut term);
        omega.iter_mut().zip(&term).for_each(|(o, t)| *o -= *t);
        self.omega_3(node, k, &mut term);
        omega.iter_mut().zip(&term).for_each(|(o, t)| *o += *t);
        self.omega_4(node, k, &mut term);
        omega.iter_mut().zip(&term).for_each(|(o, t)| *o -= *t);
        self.term = term;
        Ok(())
    }

    /// (B6): $\Omega_1 = 2 [\ddot x_{P1} - \dot x_{P2};\\; (H^T H)^{-1} \gamma]$ with
    /// $\gamma = (\dot H^T H + H^T \dot H) \dot x_{P2} + H^T H \ddot x_{P2} + \dot H^T C + H^T \dot C$.
    pub fn omega_1(&mut self, node: Node<'_, S>, omega_1: &mut DVector<S>) {
        let (n, one, zero, two) = (self.c.len(), S::one(), S::zero(), S::from_f64(2.0));
        let xdot_p2 = DVectorView::from_slice(node.xdot_p2(), n);
        let xddot_p2 = DVectorView::from_slice(node.xddot_p2(), n);
        self.force_along(&xdot_p2);
        self.force_rate.copy_from(&self.cdot);
        self.force_rate.gemv(one, &self.hdot, &xdot_p2, one);
        self.force_rate.gemv(one, &self.h, &xddot_p2, one);
        self.sum.gemv_tr(one, &self.hdot, &self.force, zero);
        self.sum.gemv_tr(one, &self.h, &self.force_rate, one);
        self.solve_hth();
        for i in 0..n {
            omega_1[i] = two * (node.xddot_p1()[i] - node.xdot_p2()[i]);
            omega_1[n + i] = two * self.sum[i];
        }
    }

    /// (B7): $\Omega_2 = -[\tfrac1k \frac{\partial FD_0}{\partial x_{P1}}^T f;\\; (H^T H)^{-1} \frac{\partial
    /// FD_0}{\partial x_{P2}}^T f]$ with $f = H^T (2 C + 2 H \dot x_{P2})$.
    pub fn omega_2<C: Scalar>(&mut self, node: Node<'_, S>, k: C, omega_2: &mut DVector<S>)
    where
        S: AlgebraOver<C>,
    {
        let (n, one, zero, two) = (self.c.len(), S::one(), S::zero(), S::from_f64(2.0));
        self.force_along(&DVectorView::from_slice(node.xdot_p2(), n));
        self.force_rate.gemv_tr(two, &self.h, &self.force, zero);
        self.sum.gemv_tr(one, &self.dfd0_dq, &self.force_rate, zero);
        let per_k = C::one() / k;
        for i in 0..n {
            omega_2[i] = -self.sum[i].scale(per_k);
        }
        self.sum.gemv_tr(one, &self.dfd0_dv, &self.force_rate, zero);
        self.solve_hth();
        for i in 0..n {
            omega_2[n + i] = -self.sum[i];
        }
    }

    /// (B8): $\Omega_3 = [0;\\; 2 k (H^T H)^{-1} (\dot x_{P1} - x_{P2})]$.
    pub fn omega_3<C: Scalar>(&mut self, node: Node<'_, S>, k: C, omega_3: &mut DVector<S>)
    where
        S: AlgebraOver<C>,
    {
        let (n, two) = (self.c.len(), S::from_f64(2.0));
        for i in 0..n {
            self.sum[i] = node.xdot_p1()[i] - node.x_p2()[i];
        }
        self.solve_hth();
        for i in 0..n {
            omega_3[i] = S::zero();
            omega_3[n + i] = (two * self.sum[i]).scale(k);
        }
    }

    /// (B9): $\Omega_4 = [\tfrac2k \left[ \frac{\partial H}{\partial x_{P1}} w \right]^T H w;\\; 0]$ with
    /// $w = \dot x_{P2} - FD_0$.
    pub fn omega_4<C: Scalar>(&mut self, node: Node<'_, S>, k: C, omega_4: &mut DVector<S>)
    where
        S: AlgebraOver<C>,
    {
        let (n, one, zero, two) = (self.c.len(), S::one(), S::zero(), S::from_f64(2.0));
        for i in 0..n {
            self.sum[i] = node.xdot_p2()[i] - self.fd0[i];
        }
        self.force.gemv(one, &self.h, &self.sum, zero);
        self.sum.gemv_tr(two, &self.dh_dq_w, &self.force, zero);
        let per_k = C::one() / k;
        for i in 0..n {
            omega_4[i] = self.sum[i].scale(per_k);
            omega_4[n + i] = zero;
        }
    }

    /// Sets `force` to $H \dot x_{P2} + C$.
    fn force_along(&mut self, xdot_p2: &DVectorView<'_, S>) {
        self.force.copy_from(&self.c);
        self.force.gemv(S::one(), &self.h, xdot_p2, S::one());
    }

    /// Multiplies `sum` by $(H^T H)^{-1}$.
    fn solve_hth(&mut self) {
        self.ldlt.factorise(&self.h);
        self.ldlt.solve(self.sum.as_mut_slice());
        self.ldlt.solve(self.sum.as_mut_slice());
    }
}
