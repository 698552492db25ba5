//! Analytic second derivatives of inverse dynamics (RNEA_2D in the supplement).
//!
//! The tensors are those of Singh, Russell and Wensing, "On the second-order derivatives of rigid-body dynamics"
//! (2022). The formulas here come from the Hessian in [`rnea_weighted_hessian`](super::rnea_weighted_hessian) for
//! weights that choose one joint `i`: its virtual velocities are $S_i$ after that joint and zero before it. Entries
//! vanish unless the three joints are on one path to the base. Let `k` be the last of them, with $I, B, F$ those of its
//! subtree. A rate of $v_k$ changes `B` by $B_v$ and a rate of $q_k$ by $B_q$, and the latter changes `I` by $\dot I$:
//!
//! $$ B_v = B(I, S_k), \quad B_q = S_k \times^* B - B\\, S_k \times + B(I, \dot\Psi_k), \quad \dot I = B_v + B_v^T. $$
//!
//! With $F_q, F_v, F_a$ the derivatives of `F` in the coordinates of joint `k`, as in
//! [`rnea_derivatives`](super::rnea_derivatives()), and with joints `i` and `j` that are not after `k`,
//!
//! $$ \frac{\partial^2 ID_i}{\partial q_j \partial q_k} =
//!    S_i \cdot (2 B_q \dot\Psi_j + \dot I \ddot\Psi_j + \lbrack i < j \rbrack\\, S_j \times^* F_q), $$
//! $$ \frac{\partial^2 ID_i}{\partial q_j \partial v_k} =
//!    S_i \cdot (2 B_v \dot\Psi_j + \lbrack i < j \rbrack\\, S_j \times^* F_v), \quad
//!    \frac{\partial^2 ID_i}{\partial q_k \partial v_j} = S_i \cdot (2 B_q S_j + 2 \dot I \dot\Psi_j), $$
//! $$ \frac{\partial^2 ID_i}{\partial v_j \partial v_k} = S_i \cdot 2 B_v S_j, \quad
//!    \frac{\partial^2 ID_i}{\partial a_j \partial q_k} = S_i \cdot \dot I S_j, \quad
//!    \frac{\partial^2 ID_i}{\partial a_k \partial q_j} = \lbrack i < j \rbrack\\, S_i \cdot (S_j \times^* F_a), $$
//!
//! where `i < j` means that `i` is nearer to the base. The derivatives of $ID_k$ itself in the coordinates of joints
//! `i` and `j` before it need the couples $P = 2 B^T S_k$ and $P_j = S_j \times^* P - 2 B_v^T \dot\Psi_j$. For `i` not
//! after `j`
//!
//! $$ \frac{\partial^2 ID_k}{\partial q_i \partial q_j} =
//!    \dot\Psi_i \cdot P_j + \ddot\Psi_i \cdot (S_j \times^* F_a), \quad
//!    \frac{\partial^2 ID_k}{\partial v_i \partial q_j} = S_i \cdot P_j + 2 \dot\Psi_i \cdot (S_j \times^* F_a), $$
//!
//! and the others follow from the symmetry of `H`, and because velocities at `i` and `j` act on `k` with the opposite
//! of $S_i \cdot B_v S_j$:
//!
//! $$ \frac{\partial^2 ID_k}{\partial a_i \partial q_j} = \frac{\partial^2 ID_i}{\partial a_k \partial q_j}, \quad
//!    \frac{\partial^2 ID_k}{\partial v_i \partial v_j} = -\frac{\partial^2 ID_j}{\partial v_i \partial v_k}, \quad
//!    \frac{\partial^2 ID_k}{\partial q_i \partial v_j} = -\frac{\partial^2 ID_j}{\partial q_i \partial v_k}. $$

use super::rnea_derivatives::SubtreeForceDerivatives;
use super::{Data, path_to_base};
use crate::error::Result;
use crate::linalg::Tensor3;
use crate::model::{Joint, Model};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Coriolis, Force, Motion, cross, dot};
use nalgebra::Vector3;

/// The second derivatives of inverse dynamics that do not vanish.
///
/// `ID` is linear in `a` with the slope $H(q)$, so those in `(a, a)` and in `(a, v)` vanish. The tensors are read-only:
/// entries of joints that are not on one path to the base vanish, and are cleared once per tree.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseDynamicsSecondDerivatives<S: Scalar> {
    pub(crate) dqdq: Tensor3<S>,
    pub(crate) dvdv: Tensor3<S>,
    pub(crate) dqdv: Tensor3<S>,
    pub(crate) dadq: Tensor3<S>,
    /// The parent of each joint of the model at which the tensors were last filled; empty before.
    pub(crate) tree: Vec<Option<usize>>,
}

impl<S: Scalar> InverseDynamicsSecondDerivatives<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            dqdq: Tensor3::new(n),
            dvdv: Tensor3::new(n),
            dqdv: Tensor3::new(n),
            dadq: Tensor3::new(n),
            tree: Vec::new(),
        }
    }

    /// The same with other derivatives by `q` twice and by `v` twice; for tests of wrong formulas.
    #[doc(hidden)]
    #[must_use]
    pub fn with(self, dqdq: Tensor3<S>, dvdv: Tensor3<S>) -> Self {
        Self { dqdq, dvdv, ..self }
    }

    /// $\partial^2 ID_i / (\partial q_j\\, \partial q_k)$.
    #[must_use]
    pub fn dqdq(&self) -> &Tensor3<S> {
        &self.dqdq
    }

    /// $\partial^2 ID_i / (\partial v_j\\, \partial v_k)$.
    #[must_use]
    pub fn dvdv(&self) -> &Tensor3<S> {
        &self.dvdv
    }

    /// $\partial^2 ID_i / (\partial q_j\\, \partial v_k)$.
    #[must_use]
    pub fn dqdv(&self) -> &Tensor3<S> {
        &self.dqdv
    }

    /// $\partial^2 ID_i / (\partial a_j\\, \partial q_k) = \partial H_{ij} / \partial q_k$.
    #[must_use]
    pub fn dadq(&self) -> &Tensor3<S> {
        &self.dadq
    }
}

/// Computes the second derivatives of inverse dynamics.
///
/// * `q`, `v`, `a`: `N` entries; rad or m, per s, per s^2
/// * `out`: made for `N` joints, overwritten
///
/// # Errors
/// A slice does not have `N` entries, or `out` or `data` was made for another number of joints.
///
/// # Cost
/// O(N d^2), with d the depth of the tree, and O(N^3) to clear the tensors at the first call and at another tree.
///
/// # Source
/// The tensors of Singh, Russell and Wensing, "On the second-order derivatives of rigid-body dynamics" (2022); lines 7
/// and 8 of Algorithm B2.
pub fn rnea_second_derivatives<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    out: &mut InverseDynamicsSecondDerivatives<S>,
) -> Result<()> {
    let tree = model.joints().iter().map(Joint::parent);
    let same_tree = out.tree.iter().copied().eq(tree.clone());
    for (what, tensor) in
        [("dqdq", &mut out.dqdq), ("dvdv", &mut out.dvdv), ("dqdv", &mut out.dqdv), ("dadq", &mut out.dadq)]
    {
        tensor.check(what, model.dof())?;
        if !same_tree {
            tensor.fill(S::zero());
        }
    }
    if !same_tree {
        out.tree = tree.collect();
    }
    data.prepare_derivatives(model, q, v, a)?;
    for (k, joint) in model.joints().iter().enumerate().rev() {
        let last = Last::new(k, data);
        for j in path_to_base(model, k) {
            last.fill(model, data, j, out);
        }
        if let Some(parent) = joint.parent() {
            let force = data.forces[k];
            data.forces[parent] += force;
            data.add_to_subtree(k, parent);
        }
    }
    for (i, drive) in model.drives().iter().enumerate() {
        let [_, _, curvature] = drive.losses(v[i]);
        out.dvdv[(i, i, i)] += curvature;
    }
    Ok(())
}

/// The quantities of the subtree of the last of three joints, `k`, that pair with the others.
struct Last<S: Scalar> {
    k: usize,
    /// $F_q, F_v, F_a$.
    force: SubtreeForceDerivatives<S>,
    /// $B_q$.
    b_by_q: Coriolis<S>,
    /// $B_v$.
    b_by_v: Coriolis<S>,
    /// $P$.
    couple: Vector3<S>,
}

impl<S: Scalar> Last<S> {
    /// The quantities of joint `k`, from the sums over its subtree in `data`.
    fn new(k: usize, data: &Data<S>) -> Self {
        let (axis, rate) = (&data.axes[k], &data.axis_rates[k]);
        let (inertia, coriolis) = (&data.inertias[k], &data.coriolis[k]);
        Self {
            k,
            force: data.push(k),
            b_by_q: coriolis.carried(axis) + Coriolis::new(inertia, rate),
            b_by_v: Coriolis::new(inertia, axis),
            couple: coriolis.apply_transpose(axis) * S::from_f64(2.0),
        }
    }

    /// $\dot I m$.
    fn inertia_rate(&self, m: &Motion<S>) -> Force<S> {
        self.b_by_v.apply(m) + Force::couple(self.b_by_v.apply_transpose(m))
    }

    /// The entries of joints `k` and `j` and any third one before `k`.
    fn fill<C: Scalar>(
        &self,
        model: &Model<C>,
        data: &Data<S>,
        j: usize,
        out: &mut InverseDynamicsSecondDerivatives<S>,
    ) {
        let two = S::from_f64(2.0);
        let k = self.k;
        let (axis, rate, psi_ddot) = (&data.axes[j], &data.axis_rates[j], &data.psi_ddot[j]);
        let qq = self.b_by_q.apply(rate) * two + self.inertia_rate(psi_ddot);
        let qv = self.b_by_v.apply(rate) * two;
        let vq = (self.b_by_q.apply(axis) + self.inertia_rate(rate)) * two;
        let vv = self.b_by_v.apply(axis) * two;
        let aq = self.inertia_rate(axis);
        // Joints from k up to j.
        for i in path_to_base(model, k).take_while(|i| *i >= j) {
            let axis_i = &data.axes[i];
            let by_qq = axis_i.dot(&qq);
            let by_qv = axis_i.dot(&qv);
            let by_vv = axis_i.dot(&vv);
            out.dqdq[(i, j, k)] = by_qq;
            out.dqdq[(i, k, j)] = by_qq;
            out.dvdv[(i, j, k)] = by_vv;
            out.dvdv[(i, k, j)] = by_vv;
            out.dqdv[(i, j, k)] = by_qv;
            out.dqdv[(i, k, j)] = axis_i.dot(&vq);
            out.dadq[(i, j, k)] = axis_i.dot(&aq);
            if i < k {
                out.dvdv[(k, j, i)] = -by_vv;
                out.dvdv[(k, i, j)] = -by_vv;
                out.dqdv[(k, j, i)] = -by_qv;
            }
        }
        // Joints before j: moving j also moves its load relative to them.
        let qq = qq + axis.cross_force(&self.force.by_q);
        let qv = qv + axis.cross_force(&self.force.by_v);
        let qa = axis.cross_force(&self.force.by_a);
        for i in path_to_base(model, j).skip(1) {
            let axis_i = &data.axes[i];
            let by_qq = axis_i.dot(&qq);
            let by_vv = axis_i.dot(&vv);
            let by_qa = axis_i.dot(&qa);
            out.dqdq[(i, j, k)] = by_qq;
            out.dqdq[(i, k, j)] = by_qq;
            out.dvdv[(i, j, k)] = by_vv;
            out.dvdv[(i, k, j)] = by_vv;
            out.dqdv[(i, j, k)] = axis_i.dot(&qv);
            out.dqdv[(i, k, j)] = axis_i.dot(&vq);
            out.dadq[(i, j, k)] = axis_i.dot(&aq);
            out.dadq[(i, k, j)] = by_qa;
            out.dadq[(k, i, j)] = by_qa;
        }
        if j < k {
            let couple = cross(&axis.angular, &self.couple) - self.b_by_v.apply_transpose(rate) * two;
            for i in path_to_base(model, j) {
                let (axis_i, rate_i) = (&data.axes[i], &data.axis_rates[i]);
                let by_qq = dot(&rate_i.angular, &couple) + data.psi_ddot[i].dot(&qa);
                out.dqdq[(k, i, j)] = by_qq;
                out.dqdq[(k, j, i)] = by_qq;
                out.dqdv[(k, j, i)] = dot(&axis_i.angular, &couple) + rate_i.dot(&qa) * two;
            }
        }
    }
}
