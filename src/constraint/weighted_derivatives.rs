//! The accumulator of the derivatives of constraints.

use super::autodiff::Scratch;
use super::pair_loads::PairLoads;
use crate::dynamics::path_to_base;
use crate::error::{Error, Result, check_length};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::spatial::{Force, Motion, cross_matrix};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use num_traits::Zero;

/// Sums of weighted derivatives of constraints.
///
/// A constraint adds to the gradient and the Hessian in `x` directly, or gives its dependence on the position of a
/// point by [`add_point`](Self::add_point). The cost of a point does not depend on `N`: a weighted derivative $f$ in
/// the position `p` of a point acts like a force there, so that points of one body add up to a spatial force, and
/// bodies to sums over subtrees. With `S_j` the joint axes and
/// $\partial p / \partial q_j = v_j + \omega_j \times p =: J_j$, which rotates with every joint `i` before `j`,
///
/// $$ \frac{\partial}{\partial q_j} = S_j \cdot F_j, \qquad
///    \frac{\partial^2}{\partial q_i \partial q_j} = \sum_p J_i^T M J_j + f \cdot (\omega_i \times J_j), $$
///
/// with $F_j$ the force on the subtree of `j`. The sums over points are the stiffness of the subtree, 6 by 6, and
/// $\sum J_j \times f = v_j \times F + (Q - \mathrm{tr}\\, Q)\\, \omega_j$ with the virial $Q = \sum p f^T$. Cost O(N
/// d).
///
/// The dependence on the distance of two points of different bodies is given by [`add_pair`](Self::add_pair), that on
/// the placement of one body in another by [`add_forces`](Self::add_forces); both add up to a force and a coupling, 6
/// by 6, per pair of bodies.
#[derive(Clone, Debug)]
pub struct WeightedDerivatives<S: Scalar> {
    pub(super) gradient: DVector<S>,
    pub(super) hessian: DMatrix<S>,
    pub(super) scratch: Scratch<S>,
    loads: Vec<Load<S>>,
    pairs: PairLoads<S>,
    second: bool,
}

/// The sums over the points of one body, then of a subtree.
#[derive(Clone, Copy, Debug)]
struct Load<S: Scalar> {
    force: Force<S>,
    virial: Matrix3<S>,
    /// The blocks of the stiffness: angular-angular, angular-linear, linear-linear.
    stiffness: [Matrix3<S>; 3],
}

impl<S: Scalar> Load<S> {
    fn zero() -> Self {
        Self { force: Force::zero(), virial: Matrix3::zero(), stiffness: [Matrix3::zero(); 3] }
    }
}

impl<S: Scalar> WeightedDerivatives<S> {
    /// Zeros for a robot with `n` joints.
    pub(super) fn new(n: usize) -> Self {
        Self {
            gradient: DVector::zeros(2 * n),
            hessian: DMatrix::zeros(2 * n, 2 * n),
            scratch: Scratch::new(),
            loads: vec![Load::zero(); n],
            pairs: PairLoads::new(),
            second: true,
        }
    }

    /// The gradient $\sum_j w_j\\, \partial g_j / \partial x$, `2 N` entries.
    #[must_use]
    pub fn gradient(&self) -> &DVector<S> {
        &self.gradient
    }

    /// The Hessian $\sum_j w_j\\, \partial^2 g_j / \partial x^2 + c_j\\, \partial g_j / \partial x\\, (\partial g_j /
    /// \partial x)^T$, `2 N` by `2 N`; zero if it is not needed.
    #[must_use]
    pub fn hessian(&self) -> &DMatrix<S> {
        &self.hessian
    }

    /// Adds `first` and `second`, the weighted derivatives in entry `i` of `x` alone.
    #[inline]
    pub fn add_entry(&mut self, i: usize, first: S, second: S) {
        self.gradient[i] += first;
        self.hessian[(i, i)] += second;
    }

    /// Adds full weighted derivatives in `x`: `gradient` with `2 N` entries, and `hessian` with the products of
    /// gradients, `2 N` by `2 N`, which is ignored if only the gradient is needed.
    ///
    /// # Errors
    /// `gradient` does not have `2 N` entries, or `hessian` is not `2 N` by `2 N`.
    pub fn add_dense(&mut self, gradient: &DVector<S>, hessian: &DMatrix<S>) -> Result<()> {
        let n = self.gradient.len();
        check_length("gradient", n, gradient.len())?;
        check_length("rows of the Hessian", n, hessian.nrows())?;
        check_length("columns of the Hessian", n, hessian.ncols())?;
        self.gradient += gradient;
        if self.second {
            self.hessian += hessian;
        }
        Ok(())
    }

    /// Adds the dependence on the position `p` of a point of `body` in the base frame: `force` is the weighted gradient
    /// in `p`, and `stiffness` the weighted Hessian in `p` with the products of gradients. A point without a body is
    /// fixed.
    ///
    /// # Errors
    /// The robot has no such body.
    #[inline]
    pub fn add_point(
        &mut self,
        body: Option<usize>,
        p: &Vector3<S>,
        force: &Vector3<S>,
        stiffness: &Matrix3<S>,
    ) -> Result<()> {
        let Some(body) = body else { return Ok(()) };
        self.check_body(body)?;
        let load = &mut self.loads[body];
        load.force += Force::new(p.cross(force), *force);
        if self.second {
            let cross = cross_matrix(p);
            let moment = cross * stiffness;
            load.virial += p * force.transpose();
            load.stiffness[0] -= moment * cross;
            load.stiffness[1] += moment;
            load.stiffness[2] += stiffness;
        }
        Ok(())
    }

    /// Adds the dependence on the distance of two points `p`, in the base frame, of two bodies: `slope` is the weighted
    /// first derivative in $s = |p_1 - p_2|^2 / 2$, and `curvature` the second one with the squares of slopes. Points
    /// without a body are fixed. Joints that carry both bodies have no effect; neither have two points of one body.
    ///
    /// # Errors
    /// The robot has no such body.
    #[inline]
    pub fn add_pair(&mut self, bodies: [Option<usize>; 2], p: [&Vector3<S>; 2], slope: S, curvature: S) -> Result<()> {
        for body in bodies.into_iter().flatten() {
            self.check_body(body)?;
        }
        self.pairs.add(bodies, p, slope, curvature, self.second);
        Ok(())
    }

    /// Adds a row that depends on the placement of the first body as seen from the second one: `force` is its gradient
    /// in the motion of the first one, and `coupling` the blocks of `K`, angular before linear, of its second
    /// derivative $S_i \cdot (K S_j + S_j \times^* F)$ in the joints `i` before `j` that carry the first body alone.
    /// `w` is the weight of the row, `c` that of the product of its gradients, `None` if only the gradient is needed.
    /// Without a body the points of it are fixed.
    ///
    /// # Errors
    /// The robot has no such body.
    pub fn add_coupling(
        &mut self,
        bodies: [Option<usize>; 2],
        force: &Force<S>,
        coupling: impl FnOnce() -> [[Matrix3<S>; 2]; 2],
        w: S,
        c: Option<S>,
    ) -> Result<()> {
        for body in bodies.into_iter().flatten() {
            self.check_body(body)?;
        }
        self.pairs.add_coupling(bodies, force, coupling, w, c);
        Ok(())
    }

    /// Adds a row that is linear in the positions `p` of points of the first body as seen from the second one: `force`
    /// is the sum of its gradients `f` in them, in the base frame, and `virial` the sum of $p f^T$. `w` is the weight
    /// of the row, `c` that of the product of its gradients, `None` if only the gradient is needed. Without a body the
    /// points, or their references, are fixed.
    ///
    /// # Errors
    /// The robot has no such body.
    pub fn add_forces(
        &mut self,
        bodies: [Option<usize>; 2],
        force: &Vector3<S>,
        virial: &Matrix3<S>,
        w: S,
        c: Option<S>,
    ) -> Result<()> {
        for body in bodies.into_iter().flatten() {
            self.check_body(body)?;
        }
        self.pairs.add_forces(bodies, force, virial, w, c);
        Ok(())
    }

    /// Checks that the robot has the body.
    #[inline]
    fn check_body(&self, body: usize) -> Result<()> {
        if body < self.loads.len() {
            return Ok(());
        }
        Err(Error::Length { what: "bodies of the robot of a constraint", expected: body + 1, found: self.loads.len() })
    }

    /// Sets all sums to zero, for gradients alone or with Hessians.
    pub(super) fn reset(&mut self, second: bool) {
        self.gradient.fill(S::zero());
        self.hessian.fill(S::zero());
        self.loads.fill(Load::zero());
        self.pairs.clear();
        self.second = second;
    }

    /// Projects the sums over points on the joints.
    pub(super) fn collect<C: Scalar>(&mut self, model: &Model<C>, axes: &[Motion<S>]) {
        let hessian = self.second.then_some(&mut self.hessian);
        self.pairs.collect(model, axes, &mut self.gradient, hessian);
        for (j, joint) in model.joints().iter().enumerate().rev() {
            let load = self.loads[j];
            let axis = &axes[j];
            self.gradient[j] += axis.dot(&load.force);
            if self.second {
                let [twice, mixed, linear] = &load.stiffness;
                let turned = axis.linear.cross(&load.force.linear) + load.virial * axis.angular
                    - axis.angular * load.virial.trace();
                let felt = Force::new(
                    twice * axis.angular + mixed * axis.linear + turned,
                    mixed.tr_mul(&axis.angular) + linear * axis.linear,
                );
                for i in path_to_base(model, j) {
                    let entry = axes[i].dot(&felt);
                    self.hessian[(i, j)] += entry;
                    if i != j {
                        self.hessian[(j, i)] += entry;
                    }
                }
            }
            if let Some(parent) = joint.parent() {
                let carrier = &mut self.loads[parent];
                carrier.force += load.force;
                if self.second {
                    carrier.virial += load.virial;
                    for (sum, own) in carrier.stiffness.iter_mut().zip(&load.stiffness) {
                        *sum += own;
                    }
                }
            }
        }
    }
}
