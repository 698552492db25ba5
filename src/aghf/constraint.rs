//! Inequality constraints as penalties in the Lagrangian: (A1) to (A4).

use crate::error::{Result, check_length};
use crate::scalar::{Ldlt, Over, Scalar};

/// One inequality constraint $g(x) \le 0$ at a state.
#[derive(Clone, Copy, Debug)]
pub struct Constraint<'a, S> {
    /// $g(x)$; positive where the constraint is violated.
    pub value: S,
    /// $\partial g / \partial x$, `2 N` entries.
    pub gradient: &'a [S],
}

/// (A3): the activation $S(g) = \tfrac12 + \tfrac12 \tanh(c_{cons}\, g)$. It goes from 0 to 1 where the constraint is
/// violated, and is one half on the boundary.
pub fn activation<C: Scalar, S: Over<C>>(g: S, c_cons: C) -> S {
    let half = S::from_f64(0.5);
    half + half * g.scale(c_cons).tanh()
}

/// $S'(g) = \tfrac12 c_{cons} (1 - \tanh^2(c_{cons}\, g))$.
pub fn activation_slope<C: Scalar, S: Over<C>>(g: S, c_cons: C) -> S {
    let tanh = g.scale(c_cons).tanh();
    (S::from_f64(0.5) * (S::one() - tanh * tanh)).scale(c_cons)
}

/// (A2): the penalty $b(g) = k_{cons}\, g^2 S(g)$.
pub fn penalty<C: Scalar, S: Over<C>>(g: S, k_cons: C, c_cons: C) -> S {
    (g * g * activation(g, c_cons)).scale(k_cons)
}

/// $b'(g) = k_{cons} (2 g S + g^2 S')$, the derivative of the activation kept.
pub fn penalty_slope<C: Scalar, S: Over<C>>(g: S, k_cons: C, c_cons: C) -> S {
    let square = g * g * activation_slope(g, c_cons);
    ((g + g) * activation(g, c_cons) + square).scale(k_cons)
}

/// (A1): $L_{cons} = L + \sum_j b(g_j)$ from the Lagrangian and the values of the constraints.
pub fn constrained_lagrangian<C: Scalar, S: Over<C>>(
    lagrangian: S,
    g: impl IntoIterator<Item = S>,
    k_cons: C,
    c_cons: C,
) -> S {
    g.into_iter()
        .fold(lagrangian, |sum, g| sum + penalty(g, k_cons, c_cons))
}

/// What (A4) takes off the flow: `omega` loses
///
/// $$ G^{-1} \sum_j \frac{\partial b(g_j(x))}{\partial x} = \begin{bmatrix} \tfrac1k \sum_j b'(g_j)\,
///    \partial g_j / \partial x_{P1} \\\\ (H H)^{-1} \sum_j b'(g_j)\, \partial g_j / \partial x_{P2} \end{bmatrix}. $$
///
/// `h` are the factors of the mass matrix, `penalties` are $k$, $k_{cons}$ and $c_{cons}$. `omega` has `2 N` entries.
///
/// # Errors
/// A gradient is not as long as `omega`.
pub fn subtract_penalties<C: Scalar, S: Over<C>>(
    h: &Ldlt<S>,
    constraints: &[Constraint<'_, S>],
    [k, k_cons, c_cons]: [C; 3],
    omega: &mut [S],
) -> Result<()> {
    let mut sum = vec![S::zero(); omega.len()];
    for constraint in constraints {
        check_length(
            "gradient of a constraint",
            sum.len(),
            constraint.gradient.len(),
        )?;
        let slope = penalty_slope(constraint.value, k_cons, c_cons);
        for (sum, g) in sum.iter_mut().zip(constraint.gradient) {
            *sum += slope * *g;
        }
    }
    let (by_q, by_v) = sum.split_at_mut(omega.len() / 2);
    let per_k = C::one() / k;
    by_q.iter_mut().for_each(|b| *b = b.scale(per_k));
    h.solve(by_v);
    h.solve(by_v);
    omega.iter_mut().zip(&sum).for_each(|(o, b)| *o -= *b);
    Ok(())
}
