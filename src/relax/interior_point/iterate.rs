//! The current point of a search.

use crate::relax::Iteration;
use nalgebra::DMatrix;

/// The iterate of a search; the derivatives are those at `coefficients`.
pub(super) struct Iterate {
    pub coefficients: DMatrix<f64>,
    /// $\phi$.
    pub merit: f64,
    pub iteration: Iteration,
    /// True at the last barrier weight with no relaxed row.
    pub at_last_barrier: bool,
    /// The last cost by the finer quadrature, and its difference from the cost of the search.
    pub finer: [f64; 2],
    pub violation: f64,
}

impl Iterate {
    pub fn new(coefficients: DMatrix<f64>) -> Self {
        Self {
            coefficients,
            merit: f64::NAN,
            iteration: Iteration {
                start: None,
                horizon: f64::NAN,
                segments: 0,
                degree: 0,
                points: 0,
                cost: f64::NAN,
                gradient_norm: f64::INFINITY,
                damping: 0.0,
                step: 0.0,
                factorisations: 0,
                violation: f64::NAN,
            },
            at_last_barrier: false,
            finer: [f64::NAN; 2],
            violation: f64::NAN,
        }
    }
}
