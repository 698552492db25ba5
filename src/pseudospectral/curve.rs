//! A curve through the nodes, at any time.

use super::Chebyshev;
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};

/// The polynomial curve $x(t)$ through given states at Chebyshev nodes.
#[derive(Clone, Debug)]
pub struct Curve {
    chebyshev: Chebyshev,
    /// `2 N` by `p + 1`: states, one column a node.
    x: DMatrix<f64>,
    /// Their derivatives in time.
    xdot: DMatrix<f64>,
}

impl Curve {
    /// The curve through the columns of `x`, `2 N` by `p + 1`, at the nodes of `chebyshev`.
    ///
    /// # Errors
    /// `x` does not have a column for each node, or has an odd number of rows.
    pub fn new(chebyshev: Chebyshev, x: DMatrix<f64>) -> Result<Self> {
        crate::error::check_length("x", chebyshev.degree() + 1, x.ncols())?;
        if x.nrows() % 2 == 1 {
            let condition = "an odd number of rows is no state [q; v]";
            return Err(Error::input("curve", "x", condition));
        }
        let xdot = &x * chebyshev.d().transpose();
        Ok(Self { chebyshev, x, xdot })
    }

    /// `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.x.nrows() / 2
    }

    /// The nodes.
    #[must_use]
    pub fn chebyshev(&self) -> &Chebyshev {
        &self.chebyshev
    }

    /// The states at the nodes, `2 N` by `p + 1`.
    #[must_use]
    pub fn x(&self) -> &DMatrix<f64> {
        &self.x
    }

    /// The state $x = [q; v]$ at time `t` in s and its derivative $\dot x$. Cost O(N p).
    #[must_use]
    pub fn at(&self, t: f64) -> (DVector<f64>, DVector<f64>) {
        let mut weights = DVector::zeros(self.chebyshev.degree() + 1);
        self.chebyshev.interpolation(t, &mut weights);
        (&self.x * &weights, &self.xdot * &weights)
    }
}
