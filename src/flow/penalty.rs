//! Inequality constraints as penalties in the Lagrangian: (A1) to (A3).

use crate::scalar::{AlgebraOver, Scalar, Tanh};

/// The parameters $k_{cons}$ and $c_{cons}$ of a penalty, the same for all rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty<C = f64> {
    /// The weight $k_{cons}$ of (A2).
    pub k_cons: C,
    /// The sharpness $c_{cons}$ of the activation (A3).
    pub c_cons: C,
}

impl<C: Scalar> Penalty<C> {
    /// Computes $b(g)$ and its first three derivatives, including those of the activation. With
    /// $t = \tanh(c_{cons}\\, g)$ the latter are $S^{\prime} = \tfrac12 c\\, (1 - t^2)$,
    /// $S^{\prime\prime} = -2 c\\, t S^{\prime}$ and
    /// $S^{\prime\prime\prime} = -2 c\\, (c\\, (1 - t^2)\\, S^{\prime} + t S^{\prime\prime})$.
    #[inline]
    #[must_use]
    pub fn derivatives<S: AlgebraOver<C> + Tanh>(&self, g: S) -> [S; 4] {
        let Self { k_cons, c_cons } = *self;
        let (half, two) = (S::from_f64(0.5), S::from_f64(2.0));
        let (four, six) = (S::from_f64(4.0), S::from_f64(6.0));
        let tanh = g.scale(c_cons).tanh();
        let rate = (S::one() - tanh * tanh).scale(c_cons);
        let s = half + half * tanh;
        let s1 = half * rate;
        let s2 = -(two * tanh * s1).scale(c_cons);
        let s3 = -(two * (rate * s1 + tanh * s2)).scale(c_cons);
        [
            g * g * s,
            two * g * s + g * g * s1,
            two * s + four * g * s1 + g * g * s2,
            six * s1 + six * g * s2 + g * g * s3,
        ]
        .map(|b| b.scale(k_cons))
    }
}

/// Computes the activation (A3), $S(g) = \tfrac12 + \tfrac12 \tanh(c_{cons}\\, g)$. It rises from 0 in the interior to
/// 1 at violated constraints, and is one half on the boundary.
pub fn activation<C: Scalar, S: AlgebraOver<C> + Tanh>(g: S, c_cons: C) -> S {
    let half = S::from_f64(0.5);
    half + half * g.scale(c_cons).tanh()
}

/// Computes $S'(g) = \tfrac12 c_{cons} (1 - \tanh^2(c_{cons}\\, g))$.
pub fn activation_slope<C: Scalar, S: AlgebraOver<C> + Tanh>(g: S, c_cons: C) -> S {
    let tanh = g.scale(c_cons).tanh();
    (S::from_f64(0.5) * (S::one() - tanh * tanh)).scale(c_cons)
}

/// Computes the penalty (A2), $b(g) = k_{cons}\\, g^2 S(g)$.
pub fn penalty<C: Scalar, S: AlgebraOver<C> + Tanh>(g: S, k_cons: C, c_cons: C) -> S {
    (g * g * activation(g, c_cons)).scale(k_cons)
}

/// Computes $b^{\prime}(g) = k_{cons} (2 g S + g^2 S^{\prime})$, including the derivative of the activation.
pub fn penalty_slope<C: Scalar, S: AlgebraOver<C> + Tanh>(g: S, k_cons: C, c_cons: C) -> S {
    Penalty { k_cons, c_cons }.derivatives(g)[1]
}

/// Computes $b^{\prime\prime}(g) = k_{cons} (2 S + 4 g S^{\prime} + g^2 S^{\prime\prime})$, including the derivatives
/// of the activation.
pub fn penalty_curvature<C: Scalar, S: AlgebraOver<C> + Tanh>(g: S, k_cons: C, c_cons: C) -> S {
    Penalty { k_cons, c_cons }.derivatives(g)[2]
}

/// Computes (A1), $L_{cons} = L + \sum_j b(g_j)$, from the Lagrangian and the values of the constraints.
pub fn constrained_lagrangian<C: Scalar, S: AlgebraOver<C> + Tanh>(
    lagrangian: S,
    g: impl IntoIterator<Item = S>,
    k_cons: C,
    c_cons: C,
) -> S {
    g.into_iter().fold(lagrangian, |sum, g| sum + penalty(g, k_cons, c_cons))
}
