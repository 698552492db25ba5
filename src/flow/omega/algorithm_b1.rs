//! Algorithm B1: the quantities of Theorem B3 by spatial recursions.

use crate::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, aba_derivatives, mass_matrix_and_rate,
    rnea_derivatives,
};
use crate::error::Result;
use crate::flow::{Node, RightHandSide, TheoremB3};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{DVector, DVectorView, Vector3};

/// The right-hand side of the flow by the paper's algorithm. Cost O(N^3).
#[derive(Clone, Debug)]
pub struct AlgorithmB1<'m, C: Scalar = f64, S: Scalar = C> {
    model: &'m Model<C>,
    /// The model without gravity, for lines 7 and 8.
    weightless: Model<C>,
    data: Data<S>,
    id: InverseDynamicsDerivatives<S>,
    fd: ForwardDynamicsDerivatives<S>,
    theorem: TheoremB3<S>,
    zero: DVector<S>,
    w: DVector<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C>> AlgorithmB1<'m, C, S> {
    /// The right-hand side for `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        let n = model.dof();
        Self {
            model,
            weightless: model.clone().with_gravity(Vector3::zeros()),
            data: Data::new(model),
            id: InverseDynamicsDerivatives::new(n),
            fd: ForwardDynamicsDerivatives::new(n),
            theorem: TheoremB3::new(n),
            zero: DVector::zeros(n),
            w: DVector::zeros(n),
        }
    }
}

impl<C: Scalar, S: AlgebraOver<C>> RightHandSide<C, S> for AlgorithmB1<'_, C, S> {
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()> {
        let (n, one, zero) = (self.model.dof(), S::one(), S::zero());
        node.check(n, omega.len())?;
        let (q, v) = (node.x_p1(), node.x_p2());
        let (data, t) = (&mut self.data, &mut self.theorem);
        // Line 1.
        mass_matrix_and_rate(self.model, data, q, node.xdot_p1(), &mut t.h, &mut t.hdot)?;
        // Lines 2 and 3.
        rnea_derivatives(self.model, data, q, v, self.zero.as_slice(), &mut self.id)?;
        t.c.copy_from(&self.id.tau);
        // Line 4.
        t.cdot.gemv(one, &self.id.dq, &DVectorView::from_slice(node.xdot_p1(), n), zero);
        t.cdot.gemv(one, &self.id.dv, &DVectorView::from_slice(node.xdot_p2(), n), one);
        // Line 5.
        aba_derivatives(self.model, data, q, v, self.zero.as_slice(), &mut self.fd)?;
        t.fd0.copy_from(&self.fd.a);
        t.dfd0_dq.copy_from(&self.fd.dq);
        t.dfd0_dv.copy_from(&self.fd.dv);
        // Lines 7 and 8: without gravity and velocity, inverse dynamics is H w, and its derivative (dH/dq) w.
        for i in 0..n {
            self.w[i] = node.xdot_p2()[i] - self.fd.a[i];
        }
        rnea_derivatives(&self.weightless, data, q, self.zero.as_slice(), self.w.as_slice(), &mut self.id)?;
        t.dh_dq_w.copy_from(&self.id.dq);
        // Lines 6 and 9 to 11.
        t.omega(node, k, omega)
    }
}
