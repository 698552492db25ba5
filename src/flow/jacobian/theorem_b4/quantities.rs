//! The quantities of Theorem B4, computed by Algorithm B2.

use crate::dynamics::{
    BiasRateDerivatives, Data, ForwardDynamicsDerivatives, ForwardDynamicsSecondDerivatives,
    InverseDynamicsDerivatives, InverseDynamicsSecondDerivatives, MassMatrixDerivatives, aba_derivatives,
    aba_second_derivatives, bias, bias_rate_derivatives, crba_second_derivatives, mass_matrix_rate_derivatives,
    rnea_derivatives, rnea_second_derivatives,
};
use crate::error::Result;
use crate::flow::Node;
use crate::linalg::{Ldlt, Tensor3};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{DMatrix, DVector};

/// The quantities of Theorem B4 at one node.
///
/// Vectors have `N` entries, matrices are `N` by `N`. Tensors follow the convention of [`Tensor3`]: a derivative index
/// comes last. The blocks of the theorem are methods that return new matrices at a cost of O(N^3), or O(N^4) for (B59)
/// and everything that uses it.
#[derive(Clone, Debug)]
pub struct Quantities<S: Scalar> {
    /// $x_{P2}$.
    pub x_p2: DVector<S>,
    /// $\dot x_{P1}$.
    pub xdot_p1: DVector<S>,
    /// $\dot x_{P2}$.
    pub xdot_p2: DVector<S>,
    /// $\ddot x_{P2}$.
    pub xddot_p2: DVector<S>,
    /// $H$, $\dot H$ along $\dot x_{P1}$, $\partial H / \partial x_{P1}$ and $\partial^2 H / \partial x_{P1}^2$.
    pub mass: MassMatrixDerivatives<S>,
    /// $FD_0$, its first derivatives and $H^{-1}$.
    pub fd0: ForwardDynamicsDerivatives<S>,
    /// $C$.
    pub c: DVector<S>,
    /// The first derivatives of $C$.
    pub dc: InverseDynamicsDerivatives<S>,
    /// $\dot C$ along $\dot x_{P1}, \dot x_{P2}$ (B72).
    pub cdot: DVector<S>,
    /// $\partial \dot H / \partial x_{P1}$.
    pub dhdot: Tensor3<S>,
    /// The second derivatives of $C$: of `ID` at zero acceleration.
    pub d2c: InverseDynamicsSecondDerivatives<S>,
    /// The second derivatives of `ID` at the acceleration $FD_0$.
    pub d2id: InverseDynamicsSecondDerivatives<S>,
    /// The second derivatives of $FD_0$.
    pub d2fd0: ForwardDynamicsSecondDerivatives<S>,
    /// $\partial \dot C / \partial x_{P1}$ and $\partial \dot C / \partial x_{P2}$.
    pub dcdot: BiasRateDerivatives<S>,
    ldlt: Ldlt<S>,
}

impl<S: Scalar> Quantities<S> {
    /// Zeros for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let vector = DVector::zeros(n);
        Self {
            x_p2: vector.clone(),
            xdot_p1: vector.clone(),
            xdot_p2: vector.clone(),
            xddot_p2: vector.clone(),
            mass: MassMatrixDerivatives::new(n),
            fd0: ForwardDynamicsDerivatives::new(n),
            c: vector.clone(),
            dc: InverseDynamicsDerivatives::new(n),
            cdot: vector,
            dhdot: Tensor3::new(n),
            d2c: InverseDynamicsSecondDerivatives::new(n),
            d2id: InverseDynamicsSecondDerivatives::new(n),
            d2fd0: ForwardDynamicsSecondDerivatives::new(n),
            dcdot: BiasRateDerivatives::new(n),
            ldlt: Ldlt::new(n),
        }
    }

    /// Computes lines 1 to 10 of Algorithm B2.
    pub(super) fn gather<C: Scalar>(&mut self, model: &Model<C>, data: &mut Data<S>, node: Node<'_, S>) -> Result<()>
    where
        S: AlgebraOver<C>,
    {
        node.check(self.c.len(), 2 * model.dof())?;
        self.x_p2.copy_from_slice(node.x_p2());
        self.xdot_p1.copy_from_slice(node.xdot_p1());
        self.xdot_p2.copy_from_slice(node.xdot_p2());
        self.xddot_p2.copy_from_slice(node.xddot_p2());
        let zero = DVector::zeros(model.dof());
        let (q, v, zero) = (node.x_p1(), node.x_p2(), zero.as_slice());
        // Line 1.
        crba_second_derivatives(model, data, q, node.xdot_p1(), &mut self.mass)?;
        // Line 2.
        aba_derivatives(model, data, q, v, zero, &mut self.fd0)?;
        let fd0 = self.fd0.a.as_slice();
        // Line 3.
        bias(model, data, q, v, self.c.as_mut_slice())?;
        // Line 4.
        rnea_derivatives(model, data, q, v, zero, &mut self.dc)?;
        // Line 5.
        self.cdot = &self.dc.dq * &self.xdot_p1 + &self.dc.dv * &self.xdot_p2;
        // Line 6.
        mass_matrix_rate_derivatives(&self.mass.dqdq, node.xdot_p1(), &mut self.dhdot)?;
        // Line 7.
        rnea_second_derivatives(model, data, q, v, zero, &mut self.d2c)?;
        // Line 8.
        rnea_second_derivatives(model, data, q, v, fd0, &mut self.d2id)?;
        // Line 9.
        aba_second_derivatives(&self.fd0, &self.d2id, &mut self.d2fd0)?;
        // Line 10.
        let (qdot, vdot) = (&self.xdot_p1, &self.xdot_p2);
        bias_rate_derivatives(&self.d2c, qdot, vdot, &mut self.dcdot)?;
        self.ldlt.factorise(&self.mass.h);
        Ok(())
    }

    /// Computes $(H^T H)^{-1} M$.
    pub(super) fn solve_hth(&self, mut m: DMatrix<S>) -> DMatrix<S> {
        self.ldlt.solve_columns(&mut m);
        self.ldlt.solve_columns(&mut m);
        m
    }

    /// $\frac{\partial (H^T H)^{-1}}{\partial x_{P1}} w$ as the matrix
    /// $\sum_j \partial (H^T H)^{-1}_{ij} / \partial q_k\\, w_j$.
    ///
    /// With $M = H^T H$ it is $-M^{-1} \frac{\partial M}{\partial x_{P1}} y$ at $y = M^{-1} w$, and
    /// $\frac{\partial M}{\partial x_{P1}} y = \frac{\partial H^T}{\partial x_{P1}} H y + H^T \frac{\partial
    /// H}{\partial x_{P1}} y$.
    #[must_use]
    pub fn dhth_inverse_dx_p1(&self, w: &DVector<S>) -> DMatrix<S> {
        let (h, dh) = (&self.mass.h, &self.mass.dq);
        let mut y = w.clone();
        self.ldlt.solve(y.as_mut_slice());
        self.ldlt.solve(y.as_mut_slice());
        -self.solve_hth(dh.times_first(&(h * &y)) + h.tr_mul(&dh.times_second(&y)))
    }
}
