//! What the flow reads at one time of a curve.

use crate::error::{Result, check_length};

/// A time of a curve, the state there and its first two derivatives in time, `2 N` entries each.
#[derive(Clone, Copy, Debug)]
pub struct Node<'a, S> {
    /// $t$, in s.
    pub t: S,
    /// $x = [q; v]$.
    pub x: &'a [S],
    /// $\dot x$.
    pub xdot: &'a [S],
    /// $\ddot x$.
    pub xddot: &'a [S],
}

impl<'a, S> Node<'a, S> {
    /// `N`.
    fn dof(&self) -> usize {
        self.x.len() / 2
    }

    /// $x_{P1}$, the configuration.
    #[must_use]
    pub fn x_p1(&self) -> &'a [S] {
        &self.x[..self.dof()]
    }

    /// $x_{P2}$, the velocity.
    #[must_use]
    pub fn x_p2(&self) -> &'a [S] {
        &self.x[self.dof()..]
    }

    /// $\dot x_{P1}$.
    #[must_use]
    pub fn xdot_p1(&self) -> &'a [S] {
        &self.xdot[..self.dof()]
    }

    /// $\dot x_{P2}$, the acceleration.
    #[must_use]
    pub fn xdot_p2(&self) -> &'a [S] {
        &self.xdot[self.dof()..]
    }

    /// $\ddot x_{P1}$.
    #[must_use]
    pub fn xddot_p1(&self) -> &'a [S] {
        &self.xddot[..self.dof()]
    }

    /// $\ddot x_{P2}$.
    #[must_use]
    pub fn xddot_p2(&self) -> &'a [S] {
        &self.xddot[self.dof()..]
    }

    /// Checks that everything has `2 n` entries, and so does a result of length `result`.
    pub(crate) fn check(&self, n: usize, result: usize) -> Result<()> {
        check_length("x", 2 * n, self.x.len())?;
        check_length("xdot", 2 * n, self.xdot.len())?;
        check_length("xddot", 2 * n, self.xddot.len())?;
        check_length("omega", 2 * n, result)
    }
}
