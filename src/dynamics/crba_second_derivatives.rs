//! The mass matrix, its rate and its first and second derivatives as tensors (CRBA_2D in the supplement).

use super::crba::add_armature;
use super::{Data, check_square, clear_square, path_to_base};
use crate::error::Result;
use crate::linalg::{Tensor3, Tensor4};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Inertia, Motion};
use nalgebra::{DMatrix, DVectorView};

/// The mass matrix and its derivatives up to the second.
#[derive(Clone, Debug, PartialEq)]
pub struct MassMatrixDerivatives<S: Scalar> {
    /// $H(q)$, `N` by `N`.
    pub h: DMatrix<S>,
    /// $\dot H_{ij} = \sum_k \partial H_{ij} / \partial q_k\\, v_k$ (B71), `N` by `N`.
    pub hdot: DMatrix<S>,
    /// $(\partial H / \partial q)\_{ijk} = \partial H_{ij} / \partial q_k$.
    pub dq: Tensor3<S>,
    /// $(\partial^2 H / \partial q^2)\_{ijkl} = \partial^2 H_{ij} / (\partial q_k\\, \partial q_l)$.
    pub dqdq: Tensor4<S>,
}

impl<S: Scalar> MassMatrixDerivatives<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { h: DMatrix::zeros(n, n), hdot: DMatrix::zeros(n, n), dq: Tensor3::new(n), dqdq: Tensor4::new(n) }
    }
}

/// Computes the mass matrix at `q`, its rate along `v`, and its first and second derivatives in `q`.
///
/// $H_{ij} = \sum_b S_i^T I_b S_j$ over the bodies `b` after both joints. Joint `k` moves the bodies and the axes after
/// it as one body, so relative to a body `b` after `k` only the axes before `k` change:
///
/// $$ D_k S_i = \begin{cases} S_i \times S_k & i < k \\\\ 0 & \text{else} \end{cases} \qquad
///    D_l D_k S_i = \begin{cases} (S_i \times S_k) \times S_l & i < k \le l \\\\ 0 & i \ge k, k \le l, \end{cases} $$
///
/// where `i < k` means that `i` is nearer to the base. As $I_b$ is constant relative to its body, the product rule
/// gives every derivative of $S_i^T I_b S_j$, and the sum over bodies replaces $I_b$ by the composite inertia of the
/// last joint. Derivatives in joints that are not on one path to the base are zero.
///
/// * `q`, `v`: `N` entries; rad or m, per s
/// * `out`: made for `N` joints, overwritten
///
/// # Errors
/// `q` or `v` does not have `N` entries, or `out` or `data` was made for another number of joints.
///
/// # Cost
/// O(N d^3), with d the depth of the tree, and O(N^4) to clear the tensor.
///
/// # Source
/// Line 1 of Algorithm B2.
pub fn crba_second_derivatives<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    out: &mut MassMatrixDerivatives<S>,
) -> Result<()> {
    let n = model.dof();
    clear_square("h", n, &mut out.h)?;
    check_square("hdot", n, &out.hdot)?;
    out.dq.check("dq", n)?;
    out.dqdq.check("dqdq", n)?;
    model.check("v", v.len())?;
    data.place(model, q)?;
    out.dq.fill(S::zero());
    out.dqdq.fill(S::zero());
    for (last, joint) in model.joints().iter().enumerate().rev() {
        let composite = data.inertias[last];
        let products = Products { axes: &data.axes, inertia: &composite };
        // All sets of joints on one path whose last joint is `last`: either `i`, or the last joint of the derivatives.
        for j in path_to_base(model, last) {
            products.entry(last, j, out);
            for k in path_to_base(model, last).skip(1) {
                products.first(last, j, k, out);
                for l in path_to_base(model, k) {
                    products.second(last, j, l, k, out);
                }
            }
        }
        for i in path_to_base(model, last) {
            for j in path_to_base(model, i) {
                products.first(i, j, last, out);
                for k in path_to_base(model, last) {
                    products.second(i, j, k, last, out);
                }
            }
        }
        if let Some(parent) = joint.parent() {
            data.inertias[parent] += composite;
        }
    }
    add_armature(model, &mut out.h);
    out.hdot = out.dq.times_third(&DVectorView::from_slice(v, n).into_owned());
    Ok(())
}

/// The products of axes with the composite inertia of the last of the joints involved.
struct Products<'a, S: Scalar> {
    axes: &'a [Motion<S>],
    inertia: &'a Inertia<S>,
}

impl<S: Scalar> Products<'_, S> {
    /// $H_{ij}$.
    fn entry(&self, i: usize, j: usize, out: &mut MassMatrixDerivatives<S>) {
        let value = self.axes[i].dot(&self.inertia.apply(&self.axes[j]));
        out.h[(i, j)] = value;
        out.h[(j, i)] = value;
    }

    /// $\partial H_{ij} / \partial q_k$.
    fn first(&self, i: usize, j: usize, k: usize, out: &mut MassMatrixDerivatives<S>) {
        let value = self.seen(i, k).dot(&self.inertia.apply(&self.axes[j]))
            + self.seen(j, k).dot(&self.inertia.apply(&self.axes[i]));
        out.dq[(i, j, k)] = value;
        out.dq[(j, i, k)] = value;
    }

    /// $\partial^2 H_{ij} / (\partial q_k\\, \partial q_l)$ for $k \le l$.
    fn second(&self, i: usize, j: usize, k: usize, l: usize, out: &mut MassMatrixDerivatives<S>) {
        let inertia = self.inertia;
        let value = self.seen_twice(i, k, l).dot(&inertia.apply(&self.axes[j]))
            + self.seen(i, k).dot(&inertia.apply(&self.seen(j, l)))
            + self.seen(i, l).dot(&inertia.apply(&self.seen(j, k)))
            + self.seen_twice(j, k, l).dot(&inertia.apply(&self.axes[i]));
        for (i, j) in [(i, j), (j, i)] {
            out.dqdq[(i, j, k, l)] = value;
            out.dqdq[(i, j, l, k)] = value;
        }
    }

    /// $D_k S_i$.
    fn seen(&self, i: usize, k: usize) -> Motion<S> {
        if i < k { self.axes[i].cross(&self.axes[k]) } else { Motion::zero() }
    }

    /// $D_l D_k S_i$ for $k \le l$.
    fn seen_twice(&self, i: usize, k: usize, l: usize) -> Motion<S> {
        self.seen(i, k).cross(&self.axes[l])
    }
}
