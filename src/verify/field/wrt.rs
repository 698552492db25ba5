//! Derivatives of functions of the node with respect to its parts, by dual numbers.

use super::{Equality, Gf, Jet1, RandomInstance};
use crate::error::Result;
use crate::flow::jacobian::TheoremB4;
use crate::flow::jacobian::theorem_b4::Quantities;
use crate::verify::reference::{At, constant, jacobian, omega_terms};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// A function of the node over dual numbers.
pub type NodeFunction = fn(&At<'_, Gf, Jet1>) -> Result<DVector<Jet1>>;

/// The variable of a differentiation.
#[derive(Clone, Copy)]
pub enum Wrt {
    /// $x$.
    X,
    /// $\dot x$.
    Xdot,
    /// $\ddot x$.
    Xddot,
    /// $x_{P1}$.
    XP1,
    /// $x_{P2}$.
    XP2,
    /// $\dot x_{P1}$.
    XdotP1,
    /// $\dot x_{P2}$.
    XdotP2,
    /// $\ddot x_{P2}$.
    XddotP2,
}

impl Wrt {
    /// The corresponding entries of $[x; \dot x; \ddot x]$.
    fn range(self, n: usize) -> Range<usize> {
        let (first, count) = match self {
            Self::X => (0, 2),
            Self::Xdot => (2, 2),
            Self::Xddot => (4, 2),
            Self::XP1 => (0, 1),
            Self::XP2 => (1, 1),
            Self::XdotP1 => (2, 1),
            Self::XdotP2 => (3, 1),
            Self::XddotP2 => (5, 1),
        };
        first * n..(first + count) * n
    }
}

/// The quantities of Theorem B4 at a random instance, as Algorithm B2 gathers them.
pub fn gathered(p: &RandomInstance) -> Result<Quantities<Gf>> {
    Ok(TheoremB4::new(&p.model).gather(p.node())?.clone())
}

/// The derivative of `f`, rows those of `f`.
pub fn derivative(
    p: &RandomInstance,
    part: Wrt,
    f: impl Fn(&At<'_, Gf, Jet1>) -> Result<DVector<Jet1>>,
) -> Result<DMatrix<Gf>> {
    let (z, range) = (p.z(), part.range(p.dof()));
    jacobian(&z[range.clone()], |moved| {
        let mut z = constant(&z);
        z[range.clone()].copy_from_slice(moved);
        let mut at = At::new(&p.model, &z, p.k);
        at.node.t = Jet1::constant(p.t);
        f(&at)
    })
}

/// Compares the block by its formula with the derivative of the function.
pub(super) fn block(
    p: &RandomInstance,
    part: Wrt,
    f: NodeFunction,
    ours: fn(&Quantities<Gf>, Gf) -> DMatrix<Gf>,
) -> Result<Vec<Equality>> {
    let left = ours(&gathered(p)?, p.k);
    Ok(vec![Equality::new("block", left, derivative(p, part, f)?)])
}

/// A tensor as a matrix whose columns belong to its last index.
pub(super) fn unfold(n: usize, entries: &[Gf]) -> DMatrix<Gf> {
    DMatrix::from_column_slice(entries.len() / n, n, entries)
}

/// $\Omega_1$ (B6).
pub(super) fn omega_1(at: &At<'_, Gf, Jet1>) -> Result<DVector<Jet1>> {
    let [omega_1, ..] = omega_terms(at)?;
    Ok(omega_1)
}

/// $\Omega_2$ (B7).
pub(super) fn omega_2(at: &At<'_, Gf, Jet1>) -> Result<DVector<Jet1>> {
    let [_, omega_2, ..] = omega_terms(at)?;
    Ok(omega_2)
}

/// $\Omega_3$ (B8).
pub(super) fn omega_3(at: &At<'_, Gf, Jet1>) -> Result<DVector<Jet1>> {
    let [_, _, omega_3, _] = omega_terms(at)?;
    Ok(omega_3)
}

/// $\Omega_4$ (B9).
pub(super) fn omega_4(at: &At<'_, Gf, Jet1>) -> Result<DVector<Jet1>> {
    let [.., omega_4] = omega_terms(at)?;
    Ok(omega_4)
}
