//! What is integrated along a curve.

use crate::dynamics::{
    ContractedHessian, Data, InverseDynamicsDerivatives, rnea, rnea_contracted_hessian,
    rnea_derivatives,
};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use nalgebra::{DMatrix, DVector};

/// A curve at one quadrature point.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a, S> {
    /// Which point it is, counted along time.
    pub index: usize,
    /// Time, s.
    pub time: S,
    /// The configuration, `N` entries.
    pub q: &'a [S],
    /// The velocity.
    pub v: &'a [S],
    /// The acceleration.
    pub a: &'a [S],
}

/// The derivatives of a running cost in $z = [q; v; a]$.
#[derive(Clone, Debug)]
pub struct PointDerivatives<S: Scalar> {
    /// $\partial l / \partial z$, `3 N` entries.
    pub gradient: DVector<S>,
    /// $\partial^2 l / \partial z^2$, `3 N` by `3 N`.
    pub hessian: DMatrix<S>,
    /// A positive semidefinite part of it, that of Gauss and Newton: the steps of the minimiser are damped in it.
    pub metric: DMatrix<S>,
}

impl<S: Scalar> PointDerivatives<S> {
    /// Room for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            gradient: DVector::zeros(3 * n),
            hessian: DMatrix::zeros(3 * n, 3 * n),
            metric: DMatrix::zeros(3 * n, 3 * n),
        }
    }
}

/// A running cost $l(q, v, a)$ at the points of a quadrature.
pub trait PointCost<S: Scalar> {
    /// $l$.
    ///
    /// # Errors
    /// The point is for another robot.
    fn value(&mut self, point: Point<'_, S>) -> Result<S>;

    /// $l$, and all of `out`.
    ///
    /// # Errors
    /// The point or `out` is for another robot.
    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S>;

    /// $\partial l / \partial t$ where nothing else moves; zero unless `l` depends on time itself.
    ///
    /// # Errors
    /// The point is for another robot.
    fn time_rate(&mut self, point: Point<'_, S>) -> Result<S> {
        let _ = point;
        Ok(S::zero())
    }
}

/// The control effort $l = |u|^2$ with $u = ID(q, v, a)$, by analytic derivatives:
///
/// $$ \frac{\partial l}{\partial z} = 2 J^T u, \qquad \frac{\partial^2 l}{\partial z^2} = 2 J^T J + \Phi(2 u), \qquad
///    J = \left[ \frac{\partial ID}{\partial q}\ \frac{\partial ID}{\partial v}\ H \right], $$
///
/// where $\Phi(w)$ is the Hessian of $w^T ID$. The metric is $2 J^T J$.
#[derive(Clone, Debug)]
pub struct SquaredControl<'m, C: Scalar, S: Scalar> {
    model: &'m Model<C>,
    data: Data<S>,
    id: InverseDynamicsDerivatives<S>,
    second: ContractedHessian<S>,
    weights: DVector<S>,
    stiffness: DVector<S>,
    jacobian: DMatrix<S>,
    transposed: DMatrix<S>,
}

impl<'m, C: Scalar, S: Over<C>> SquaredControl<'m, C, S> {
    /// The control effort of `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        let n = model.dof();
        Self {
            model,
            data: Data::new(model),
            id: InverseDynamicsDerivatives::new(n),
            second: ContractedHessian::new(n),
            weights: DVector::zeros(n),
            stiffness: DVector::zeros(n),
            jacobian: DMatrix::zeros(n, 3 * n),
            transposed: DMatrix::zeros(3 * n, n),
        }
    }

    /// $u$ at a point.
    pub(super) fn control(&mut self, point: Point<'_, S>) -> Result<&DVector<S>> {
        let Point { q, v, a, .. } = point;
        let u = self.weights.as_mut_slice();
        rnea(self.model, &mut self.data, q, v, a, u)?;
        Ok(&self.weights)
    }

    /// The derivatives of the effort and of another cost of the control alone, and the effort. `charge` is handed `u` and adds
    /// what the other cost has as first and second derivatives, the latter with their own joint only; it says whether it has
    /// any of the second. The metric is that of the effort.
    pub(super) fn derivatives_charging(
        &mut self,
        point: Point<'_, S>,
        out: &mut PointDerivatives<S>,
        charge: impl FnOnce(&[S], &mut [S], &mut [S]) -> bool,
    ) -> Result<S> {
        let n = self.model.dof();
        let Point { q, v, a, .. } = point;
        rnea_derivatives(self.model, &mut self.data, q, v, a, &mut self.id)?;
        let InverseDynamicsDerivatives { tau, dq, dv, h } = &self.id;
        let two = S::from_f64(2.0);
        for (i, block) in [dq, dv, h].into_iter().enumerate() {
            self.jacobian.columns_mut(i * n, n).copy_from(block);
        }
        self.jacobian.transpose_to(&mut self.transposed);
        self.weights.copy_from(tau);
        self.weights *= two;
        self.stiffness.fill(S::zero());
        let (first, second) = (&mut self.weights, &mut self.stiffness);
        let stiff = charge(tau.as_slice(), first.as_mut_slice(), second.as_mut_slice());
        out.gradient
            .gemv(S::one(), &self.transposed, &self.weights, S::zero());
        out.metric
            .gemm(two, &self.transposed, &self.jacobian, S::zero());
        out.hessian.copy_from(&out.metric);
        if stiff {
            for (mut row, c) in self.jacobian.row_iter_mut().zip(self.stiffness.iter()) {
                row *= *c;
            }
            out.hessian
                .gemm(S::one(), &self.transposed, &self.jacobian, S::one());
        }

        let w = self.weights.as_slice();
        rnea_contracted_hessian(self.model, &mut self.data, q, v, a, w, &mut self.second)?;
        let ContractedHessian { qq, qv, vv, qa } = &self.second;
        let mut add = |row: usize, column: usize, block: &DMatrix<S>| {
            let mut target = out.hessian.view_mut((row * n, column * n), (n, n));
            target += block;
        };
        add(0, 0, qq);
        add(0, 1, qv);
        add(0, 2, qa);
        add(1, 1, vv);
        for i in 0..n {
            for j in 0..n {
                out.hessian[(n + j, i)] += qv[(i, j)];
                out.hessian[(2 * n + j, i)] += qa[(i, j)];
            }
        }
        Ok(tau.dot(tau))
    }
}

impl<C: Scalar, S: Over<C>> PointCost<S> for SquaredControl<'_, C, S> {
    fn value(&mut self, point: Point<'_, S>) -> Result<S> {
        let u = self.control(point)?;
        Ok(u.dot(u))
    }

    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        self.derivatives_charging(point, out, |_, _, _| false)
    }
}

impl<S: Scalar, P: PointCost<S>> PointCost<S> for &mut P {
    fn value(&mut self, point: Point<'_, S>) -> Result<S> {
        (**self).value(point)
    }

    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        (**self).derivatives(point, out)
    }

    fn time_rate(&mut self, point: Point<'_, S>) -> Result<S> {
        (**self).time_rate(point)
    }
}
