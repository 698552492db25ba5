//! Analytic second derivatives of inverse dynamics (RNEA_2D in the supplement).
//!
//! The first-order formulas of [`rnea_derivatives`](super::rnea_derivatives) are differentiated once more. The tensors are
//! those of Singh, Russell and Wensing, "On the second-order derivatives of rigid-body dynamics"; one formula for all
//! three kinds of coordinates stands here for their table of cases.
//!
//! A unit rate of a coordinate of joint `l` carries the bodies and axes after `l` along with $S_l$ if it is a rate of $q_l$.
//! Beyond that the velocity $v$ of a body after `l` changes by $\nu_l$ and its acceleration by $\alpha_l - v \times \nu_l$:
//!
//! | rate of | $\nu_l$ | $\alpha_l$ |
//! | --- | --- | --- |
//! | $q_l$ | $\dot S_l$ | $\ddot\Psi_l$ |
//! | $v_l$ | $S_l$ | $2 \dot S_l$ |
//! | $a_l$ | $0$ | $S_l$ |
//!
//! so that its force changes by $2 B \nu_l + I \alpha_l$. With these,
//!
//! $$ \frac{\partial ID_i}{\partial y_k} = S_i^T \left( 2 B \nu_k + I \alpha_k + [y = q,\\, i < k]\\, S_k \times^* f \right) $$
//!
//! holds for `y` any of `q`, `v`, `a`, where $I, B, f$ are those of the subtree of the later of `i` and `k`, and `i < k` says
//! that `i` is nearer to the base. For `l` not after `k` the rates $\nu_k$ and $\alpha_k$ of `k` itself change by
//!
//! | rate of | $\delta\nu_k$ | $\delta\alpha_k$ |
//! | --- | --- | --- |
//! | $q_k$ | $\nu_l \times S_k$ | $\alpha_l \times S_k + 2 \nu_l \times \dot S_k$ |
//! | $v_k$ | $0$ | $2 \nu_l \times S_k$ |
//! | $a_k$ | $0$ | $0$ |
//!
//! and `B` by $B(I, \nu_l)$, which gives the second derivatives.

use super::{Data, path_to_base};
use crate::error::Result;
use crate::linalg::Tensor3;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Coriolis, Force, Inertia, Motion};

/// The second derivatives of inverse dynamics that do not vanish.
///
/// `ID` is linear in `a` with the slope $H(q)$, so those in `(a, a)` and in `(a, v)` vanish.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseDynamicsSecondDerivatives<S: Scalar> {
    /// $\partial^2 ID_i / (\partial q_j\\, \partial q_k)$.
    pub dqdq: Tensor3<S>,
    /// $\partial^2 ID_i / (\partial v_j\\, \partial v_k)$.
    pub dvdv: Tensor3<S>,
    /// $\partial^2 ID_i / (\partial q_j\\, \partial v_k)$.
    pub dqdv: Tensor3<S>,
    /// $\partial^2 ID_i / (\partial a_j\\, \partial q_k) = \partial H_{ij} / \partial q_k$.
    pub dadq: Tensor3<S>,
}

impl<S: Scalar> InverseDynamicsSecondDerivatives<S> {
    /// Room for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            dqdq: Tensor3::new(n),
            dvdv: Tensor3::new(n),
            dqdv: Tensor3::new(n),
            dadq: Tensor3::new(n),
        }
    }

    /// Stores the derivative of $ID_i$ in the coordinates `y` of joint `k` and `x` of joint `l`.
    fn store(&mut self, i: usize, (y, k): (Kind, usize), (x, l): (Kind, usize), value: S) {
        use Kind::{A, Q, V};
        match (y, x) {
            (Q, Q) => {
                self.dqdq[(i, k, l)] = value;
                self.dqdq[(i, l, k)] = value;
            }
            (V, V) => {
                self.dvdv[(i, k, l)] = value;
                self.dvdv[(i, l, k)] = value;
            }
            (Q, V) => self.dqdv[(i, k, l)] = value,
            (V, Q) => self.dqdv[(i, l, k)] = value,
            (A, Q) => self.dadq[(i, k, l)] = value,
            (Q, A) => self.dadq[(i, l, k)] = value,
            (A, V | A) | (V, A) => {}
        }
    }
}

/// The second derivatives of inverse dynamics at `(q, v, a)`, `N` entries each, into `out`; lines 7 and 8 of Algorithm B2.
/// Cost O(N d^2) and O(N^3) to clear the tensors, with d the depth of the tree.
///
/// # Errors
/// An argument does not have one entry a joint, or `out` was made for another size.
pub fn rnea_second_derivatives<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    out: &mut InverseDynamicsSecondDerivatives<S>,
) -> Result<()> {
    for (what, tensor) in [
        ("dqdq", &mut out.dqdq),
        ("dvdv", &mut out.dvdv),
        ("dqdv", &mut out.dqdv),
        ("dadq", &mut out.dadq),
    ] {
        tensor.check(what, model.dof())?;
        tensor.fill(S::zero());
    }
    data.prepare_derivatives(model, q, v, a)?;
    for (last, joint) in model.joints().iter().enumerate().rev() {
        let subtree = Subtree {
            inertia: data.inertias[last],
            coriolis: data.coriolis[last],
            force: data.forces[last],
        };
        // Of the three joints `i`, `k` and `l <= k` either `i` is the last, or `k` is.
        for k in path_to_base(model, last) {
            for l in path_to_base(model, k) {
                for (y, x) in PAIRS {
                    let (at_k, at_l) = (Change::new(y, k, data), Change::new(x, l, data));
                    let value = data.axes[last].dot(&at_k.after(&at_l, &subtree));
                    out.store(last, (y, k), (x, l), value);
                }
            }
        }
        for l in path_to_base(model, last) {
            for (y, x) in PAIRS {
                let (at_k, at_l) = (Change::new(y, last, data), Change::new(x, l, data));
                let between = at_k.between(&at_l, &subtree);
                let before = at_k.before(&at_l, &subtree);
                for i in path_to_base(model, last).skip(1) {
                    let force = if i < l { &before } else { &between };
                    out.store(i, (y, last), (x, l), data.axes[i].dot(force));
                }
            }
        }
        if let Some(parent) = joint.parent() {
            data.inertias[parent] += subtree.inertia;
            data.coriolis[parent] += subtree.coriolis;
            data.forces[parent] += subtree.force;
        }
    }
    Ok(())
}

/// The three coordinates of a joint.
#[derive(Clone, Copy)]
enum Kind {
    Q,
    V,
    A,
}

/// The kinds of the later and of the earlier coordinate in a second derivative that does not vanish.
const PAIRS: [(Kind, Kind); 6] = [
    (Kind::Q, Kind::Q),
    (Kind::V, Kind::V),
    (Kind::Q, Kind::V),
    (Kind::V, Kind::Q),
    (Kind::A, Kind::Q),
    (Kind::Q, Kind::A),
];

/// The sums over the bodies after a joint.
struct Subtree<S: Scalar> {
    inertia: Inertia<S>,
    coriolis: Coriolis<S>,
    force: Force<S>,
}

/// What a unit rate of one coordinate of a joint does.
struct Change<S: Scalar> {
    kind: Kind,
    /// $S$.
    axis: Motion<S>,
    /// $\dot S$.
    rate: Motion<S>,
    /// $\nu$.
    nu: Motion<S>,
    /// $\alpha$.
    alpha: Motion<S>,
}

impl<S: Scalar> Change<S> {
    fn new(kind: Kind, joint: usize, data: &Data<S>) -> Self {
        let (axis, rate) = (data.axes[joint], data.axis_rates[joint]);
        let (nu, alpha) = match kind {
            Kind::Q => (rate, data.psi_ddot[joint]),
            Kind::V => (axis, rate + rate),
            Kind::A => (Motion::zero(), axis),
        };
        Self {
            kind,
            axis,
            rate,
            nu,
            alpha,
        }
    }

    /// $2 B \nu + I \alpha$: how the force on the subtree changes beyond being carried along.
    fn force(&self, subtree: &Subtree<S>) -> Force<S> {
        let half = subtree.coriolis.apply(&self.nu);
        half + half + subtree.inertia.apply(&self.alpha)
    }

    /// What `force` brings joints that are not carried along: for a rate of `q`, $S \times^*$ it, else nothing.
    fn carried(&self, force: &Force<S>) -> Force<S> {
        match self.kind {
            Kind::Q => self.axis.cross_force(force),
            Kind::V | Kind::A => Force::zero(),
        }
    }

    /// $\delta\nu$ and $\delta\alpha$ under a change at a joint that is not after this one.
    fn changed_by(&self, l: &Self) -> (Motion<S>, Motion<S>) {
        let turned = l.nu.cross(&self.axis);
        match self.kind {
            Kind::Q => {
                let twice = l.nu.cross(&(self.rate + self.rate));
                (turned, l.alpha.cross(&self.axis) + twice)
            }
            Kind::V => (Motion::zero(), turned + turned),
            Kind::A => (Motion::zero(), Motion::zero()),
        }
    }

    /// The second-order force for a joint that both changes carry along, or that is the last of all.
    fn after(&self, l: &Self, subtree: &Subtree<S>) -> Force<S> {
        let (delta_nu, delta_alpha) = self.changed_by(l);
        let half = Coriolis::new(&subtree.inertia, &l.nu).apply(&self.nu)
            + subtree.coriolis.apply(&delta_nu);
        half + half + subtree.inertia.apply(&delta_alpha)
    }

    /// The same for a joint before this one that `l` carries along.
    fn between(&self, l: &Self, subtree: &Subtree<S>) -> Force<S> {
        self.after(l, subtree) + self.carried(&l.force(subtree))
    }

    /// The same for a joint before both.
    fn before(&self, l: &Self, subtree: &Subtree<S>) -> Force<S> {
        let first = self.force(subtree) + self.carried(&subtree.force);
        self.between(l, subtree) + l.carried(&first)
    }
}
