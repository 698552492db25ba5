//! The flow as a system of ordinary differential equations at the nodes, (22) and (23).

use super::jacobian::{NodeBlocks, NodeJacobian};
use super::{Node, RightHandSide};
use crate::curve::Chebyshev;
use crate::error::{Result, check_length};
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::DMatrix;

/// A curve at the nodes with its derivatives in time, one column per node: $\xi$, $D \xi$ and $D^2 \xi$ transposed.
#[derive(Clone, Debug)]
pub struct Collocation<C: Scalar, S: Scalar> {
    times: Vec<C>,
    d: DMatrix<C>,
    d2: DMatrix<C>,
    /// `2 N` by `p + 1`. The first and the last column are the boundary conditions.
    xi: DMatrix<S>,
    xi_dot: DMatrix<S>,
    xi_ddot: DMatrix<S>,
}

impl<C: Scalar, S: AlgebraOver<C>> Collocation<C, S> {
    /// Allocates curves from `start` to `goal`, states with `2 N` entries, through the nodes of `chebyshev`.
    ///
    /// # Errors
    /// `start` and `goal` differ in length.
    pub fn new(chebyshev: &Chebyshev, start: &[S], goal: &[S]) -> Result<Self> {
        check_length("goal", start.len(), goal.len())?;
        let p = chebyshev.degree();
        let mut xi = DMatrix::zeros(start.len(), p + 1);
        xi.column_mut(0).copy_from_slice(start);
        xi.column_mut(p).copy_from_slice(goal);
        Ok(Self {
            times: chebyshev.times().iter().map(|t| C::from_f64(*t)).collect(),
            d: chebyshev.d().map(C::from_f64),
            d2: chebyshev.d2().map(C::from_f64),
            xi_dot: xi.clone(),
            xi_ddot: xi.clone(),
            xi,
        })
    }

    /// The number of unknowns: the states at the `p - 1` interior nodes, `2 N (p - 1)`.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.xi.nrows() * self.interior().len()
    }

    /// The indices of the interior nodes.
    #[must_use]
    pub fn interior(&self) -> std::ops::Range<usize> {
        1..self.xi.ncols() - 1
    }

    /// Sets the states at the interior nodes to `unknowns`, node after node. Cost O(N p^2).
    ///
    /// # Errors
    /// The length of `unknowns` is not [`unknowns`](Self::unknowns).
    pub fn set(&mut self, unknowns: &[S]) -> Result<()> {
        check_length("unknowns", self.unknowns(), unknowns.len())?;
        let m = self.xi.nrows();
        self.xi.as_mut_slice()[m..m + unknowns.len()].copy_from_slice(unknowns);
        differentiate(&self.xi, &self.d, &mut self.xi_dot);
        differentiate(&self.xi, &self.d2, &mut self.xi_ddot);
        Ok(())
    }

    /// The states at all nodes, `2 N` by `p + 1`.
    #[must_use]
    pub fn xi(&self) -> &DMatrix<S> {
        &self.xi
    }

    /// The time, the state and its derivatives at node `i`.
    #[must_use]
    pub fn node(&self, i: usize) -> Node<'_, S> {
        let m = self.xi.nrows();
        let column = i * m..(i + 1) * m;
        Node {
            t: S::lift(self.times[i]),
            x: &self.xi.as_slice()[column.clone()],
            xdot: &self.xi_dot.as_slice()[column.clone()],
            xddot: &self.xi_ddot.as_slice()[column],
        }
    }

    /// Computes the right-hand side (23), $d \xi_i / ds = \Omega(t_i, \xi_i, [D \xi]_i, [D^2 \xi]_i, k)$, at all
    /// interior nodes, node after node, into `out`. Cost: `p - 1` evaluations of $\Omega$.
    ///
    /// # Errors
    /// The length of `out` is not [`unknowns`](Self::unknowns), or `rhs` has another number of joints.
    pub fn rates(&self, rhs: &mut (impl RightHandSide<C, S> + ?Sized), k: C, out: &mut [S]) -> Result<()> {
        check_length("rates", self.unknowns(), out.len())?;
        for (i, omega) in self.interior().zip(out.chunks_exact_mut(self.xi.nrows())) {
            rhs.omega(self.node(i), k, omega)?;
        }
        Ok(())
    }
}

/// Multiplies `xi` by the transpose of a differentiation matrix.
fn differentiate<C: Scalar, S: AlgebraOver<C>>(xi: &DMatrix<S>, d: &DMatrix<C>, out: &mut DMatrix<S>) {
    for i in 0..d.nrows() {
        for row in 0..xi.nrows() {
            out[(row, i)] = (0..d.ncols()).fold(S::zero(), |sum, j| sum + xi[(row, j)].scale(d[(i, j)]));
        }
    }
}

/// Computes the Jacobian of [`Collocation::rates`] in the unknowns, `2 N (p - 1)` squared, from that of $\Omega$ at
/// each node:
///
/// $$ \frac{\partial (d\xi_i / ds)}{\partial \xi_j} = \delta_{ij} \frac{d\Omega}{dx} + D_{ij} \frac{d\Omega}{d\dot x} +
///    (D^2)_{ij} \frac{d\Omega}{d\ddot x}. $$
///
/// All implementations of [`NodeJacobian`] are assembled here. Cost: `p - 1` evaluations of `jacobian`, and O(N^2 p^2).
///
/// * `blocks`: scratch space for `N` joints
/// * `out`: overwritten
///
/// # Errors
/// `out` does not have [`unknowns`](Collocation::unknowns) rows and columns, or `jacobian` has another number of
/// joints.
pub fn assemble_jacobian<C: Scalar, S: AlgebraOver<C>>(
    collocation: &Collocation<C, S>,
    jacobian: &mut (impl NodeJacobian<C, S> + ?Sized),
    k: C,
    blocks: &mut NodeBlocks<S>,
    out: &mut DMatrix<S>,
) -> Result<()> {
    check_length("jacobian", collocation.unknowns(), out.nrows())?;
    check_length("jacobian", collocation.unknowns(), out.ncols())?;
    let m = collocation.xi.nrows();
    for i in collocation.interior() {
        jacobian.evaluate(collocation.node(i), k, blocks)?;
        for j in collocation.interior() {
            let (d, d2) = (collocation.d[(i, j)], collocation.d2[(i, j)]);
            let mut target = out.view_mut(((i - 1) * m, (j - 1) * m), (m, m));
            target.zip_zip_apply(&blocks.dxdot, &blocks.dxddot, |t, dxdot, dxddot| {
                *t = dxdot.scale(d) + dxddot.scale(d2);
            });
            if i == j {
                target += &blocks.dx;
            }
        }
    }
    Ok(())
}
