//! A smooth program and its derivatives.

use crate::error::Result;
use nalgebra::{DMatrix, DVector};

/// A program in `n` unknowns with `m` rows:
///
/// $$ \min_x f(x) \quad \text{subject to} \quad \underline x \le x \le \overline x, \quad
///    \underline g \le g(x) \le \overline g . $$
///
/// Bounds may be infinite; equal ones make an equality. Functions are evaluated inside the bounds of the unknowns
/// alone; a value that is not finite makes the step shorter.
pub trait SmoothProgram {
    /// The lower and the upper bound of each unknown.
    fn bounds(&self) -> Vec<[f64; 2]>;

    /// The lower and the upper bound of each row.
    fn row_bounds(&self) -> Vec<[f64; 2]>;

    /// Evaluates the objective, and the rows into `g`, `m` entries.
    ///
    /// # Errors
    /// Those of the functions.
    fn value(&mut self, x: &DVector<f64>, g: &mut DVector<f64>) -> Result<f64>;

    /// Computes the gradient of the objective, the Jacobian of the rows, and the Hessian of the Lagrangian $f + y^T g$.
    ///
    /// # Errors
    /// Those of the functions.
    fn derivatives(&mut self, x: &DVector<f64>, y: &DVector<f64>, out: &mut SmoothDerivatives) -> Result<()>;
}

/// The derivatives of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothDerivatives {
    /// The gradient of the objective, `n` entries.
    pub gradient: DVector<f64>,
    /// The Jacobian of the rows, `m` by `n`.
    pub jacobian: DMatrix<f64>,
    /// The Hessian of the Lagrangian, `n` by `n`.
    pub hessian: DMatrix<f64>,
}

impl SmoothDerivatives {
    /// Zeros for `n` unknowns and `m` rows.
    #[must_use]
    pub fn new(n: usize, m: usize) -> Self {
        Self { gradient: DVector::zeros(n), jacobian: DMatrix::zeros(m, n), hessian: DMatrix::zeros(n, n) }
    }
}
