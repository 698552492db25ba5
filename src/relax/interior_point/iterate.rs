//! Where a search stands.

use crate::relax::Iteration;
use nalgebra::DMatrix;

/// The iterate of a search: the derivatives are those of `coefficients`.
pub(super) struct Iterate {
    pub coefficients: DMatrix<f64>,
    /// $\phi$.
    pub merit: f64,
    pub iteration: Iteration,
    /// True if the barriers are as weak as they have to be in the end, and no row is relaxed.
    pub at_last_barrier: bool,
    /// The cost by a finer quadrature when that was asked last, and how far it is from this one.
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
