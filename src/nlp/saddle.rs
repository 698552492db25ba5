//! The equalities in the primal-dual equations.
//!
//! The step $p$ and the change $l$ of the multipliers solve
//!
//! $$ W p + A^T l = -g, \quad A p - \delta_c l = -c . $$
//!
//! It is a step of descent along the equalities if and only if the matrix of these equations has as many positive
//! eigenvalues as there are unknowns and as many negative ones as there are equalities (NW 16.3).

use super::Bordered;
use crate::linalg::Indefinite;
use nalgebra::{DMatrix, DVector};

/// The least change of an equality per change of its multiplier if rows are dependent, for an objective of the size 1:
/// $\delta_c$ as in WB (3.1).
const COMPLIANCE: f64 = 1e-8;

/// The gradients and the values of the equalities at an iterate, and the factor of the matrix.
#[derive(Debug, Default)]
pub struct Saddle {
    /// The gradient of each equality: `n` by `m`.
    pub slopes: DMatrix<f64>,
    pub values: DVector<f64>,
    factor: Option<Indefinite>,
    compliance: f64,
}

impl Saddle {
    /// Returns true if there are no equalities.
    pub fn is_empty(&self) -> bool {
        self.slopes.ncols() == 0
    }

    /// Factorises the matrix with `W`; returns false if it has not the inertia of a minimum. Dependent equalities get a
    /// compliance relative to `scale`.
    pub(super) fn factorise(&mut self, hessian: &Bordered, scale: f64) -> bool {
        let (n, m) = self.slopes.shape();
        let mut matrix = DMatrix::zeros(n + m, n + m);
        hessian.put_dense(&mut matrix);
        matrix.view_mut((n, 0), (m, n)).copy_from(&self.slopes.transpose());
        for compliance in [0.0, COMPLIANCE / scale] {
            for i in n..n + m {
                matrix[(i, i)] = -compliance;
            }
            let factor = Indefinite::new(&matrix);
            let [positive, negative, zero] = factor.inertia();
            if [positive, negative] == [n, m] {
                (self.factor, self.compliance) = (Some(factor), compliance);
                return true;
            }
            if negative > m && zero == 0 {
                return false;
            }
        }
        false
    }

    /// Solves $W p + A^T l = b$, $A p - \delta_c l = e$: replaces `b` by `p` and `e` by `l`.
    pub(super) fn solve(&self, b: &mut DVector<f64>, e: &mut DVector<f64>) {
        let Some(factor) = &self.factor else {
            return;
        };
        let (n, m) = (b.len(), e.len());
        let mut both = DVector::from_iterator(n + m, b.iter().chain(e.iter()).copied());
        factor.solve(&mut both);
        b.copy_from(&both.rows(0, n));
        e.copy_from(&both.rows(n, m));
    }

    /// Subtracts $A^T l$ from `b`, and $A p - \delta_c l$ from `e`.
    pub(super) fn subtract(&self, [p, l]: [&DVector<f64>; 2], b: &mut DVector<f64>, e: &mut DVector<f64>) {
        b.gemv(-1.0, &self.slopes, l, 1.0);
        e.gemv_tr(-1.0, &self.slopes, p, 1.0);
        e.axpy(self.compliance, l, 1.0);
    }
}
