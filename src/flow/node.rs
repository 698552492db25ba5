//! The input of the flow at one time of a curve.

use crate::error::{Result, check_length};

/// A time of a curve with the state and its first two derivatives in time, `2 N` entries each.
#[derive(Clone, Copy, Debug)]
pub struct Node<'a, S> {
    /// The time $t$, in s.
    pub t: S,
    /// The state $x = [q; v]$.
    pub x: &'a [S],
    /// The rate $\dot x$.
    pub xdot: &'a [S],
    /// The second derivative $\ddot x$.
    pub xddot: &'a [S],
}

impl<'a, S> Node<'a, S> {
    /// The number of joints `N`.
    fn dof(&self) -> usize {
        self.x.len() / 2
    }

    /// The configuration $x_{P1}$.
    #[must_use]
    pub fn x_p1(&self) -> &'a [S] {
        &self.x[..self.dof()]
    }

    /// The velocity $x_{P2}$.
    #[must_use]
    pub fn x_p2(&self) -> &'a [S] {
        &self.x[self.dof()..]
    }

    /// The rate of the configuration, $\dot x_{P1}$.
    #[must_use]
    pub fn xdot_p1(&self) -> &'a [S] {
        &self.xdot[..self.dof()]
    }

    /// The acceleration $\dot x_{P2}$.
    #[must_use]
    pub fn xdot_p2(&self) -> &'a [S] {
        &self.xdot[self.dof()..]
    }

    /// The second derivative of the configuration, $\ddot x_{P1}$.
    #[must_use]
    pub fn xddot_p1(&self) -> &'a [S] {
        &self.xddot[..self.dof()]
    }

    /// The rate of the acceleration, $\ddot x_{P2}$.
    #[must_use]
    pub fn xddot_p2(&self) -> &'a [S] {
        &self.xddot[self.dof()..]
    }

    /// Checks that all slices have `2 n` entries, and that a result has as many, `result`.
    pub(crate) fn check(&self, n: usize, result: usize) -> Result<()> {
        check_length("x", 2 * n, self.x.len())?;
        check_length("xdot", 2 * n, self.xdot.len())?;
        check_length("xddot", 2 * n, self.xddot.len())?;
        check_length("omega", 2 * n, result)
    }
}
