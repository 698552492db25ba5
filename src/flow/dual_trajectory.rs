//! Lagrange multipliers as functions of time.

use crate::curve::Chebyshev;
use crate::error::{Error, Result, check_length};
use crate::scalar::{AlgebraOver, Jet, Scalar};
use nalgebra::DMatrix;

/// A vector $\lambda(t)$ of polynomials on `[0, T]`, one multiplier per component, as sums of Chebyshev polynomials.
///
/// Evaluated by Clenshaw's recurrence over any scalar, so that dual numbers differentiate it exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct DualTrajectory<C: Scalar = f64> {
    horizon: C,
    /// One row per component, one column per degree, from 0.
    coefficients: DMatrix<C>,
}

impl<C: Scalar> DualTrajectory<C> {
    /// Builds the trajectory from the horizon `T`, in s, and the coefficients of the Chebyshev polynomials in
    /// $2 t / T - 1$: one row per component, one column per degree, from 0.
    ///
    /// # Errors
    /// The matrix has no column, or the horizon is zero.
    pub fn new(horizon: C, coefficients: DMatrix<C>) -> Result<Self> {
        let refused = |what, condition| Err(Error::input("dual trajectory", what, condition));
        if coefficients.ncols() == 0 {
            return refused("coefficients", "there are none, at least one column is needed");
        }
        if horizon.is_zero() {
            return refused("horizon", "it is zero and must be a positive time");
        }
        Ok(Self { horizon, coefficients })
    }

    /// The number of components.
    #[must_use]
    pub fn components(&self) -> usize {
        self.coefficients.nrows()
    }

    /// The coefficients, one row per component, one column per degree.
    #[must_use]
    pub fn coefficients(&self) -> &DMatrix<C> {
        &self.coefficients
    }

    /// Computes $\lambda_i(t)$, zero for a missing component. Cost: linear in the degree.
    pub fn value<S: AlgebraOver<C>>(&self, component: usize, t: S) -> S {
        if component >= self.components() {
            return S::zero();
        }
        let c = |degree| S::lift(self.coefficients[(component, degree)]);
        let two = C::one() + C::one();
        let s = t.scale(two / self.horizon) - S::one();
        let (mut b, mut above) = (S::zero(), S::zero());
        for degree in (1..self.coefficients.ncols()).rev() {
            (b, above) = (c(degree) + (s + s) * b - above, b);
        }
        c(0) + s * b - above
    }

    /// Computes $\lambda_i(t)$ and $\dot \lambda_i(t)$.
    pub fn value_and_rate<S: AlgebraOver<C>>(&self, component: usize, t: S) -> [S; 2] {
        let moving = self.value(component, Jet::new(t, [S::one()]));
        [moving.re, moving.eps[0]]
    }
}

impl DualTrajectory {
    /// Interpolates `values` at the nodes of `chebyshev` by polynomials: one row per component, one column per node.
    /// Cost O(p^2) per component.
    ///
    /// # Errors
    /// The number of columns is not the number of nodes.
    pub fn through(chebyshev: &Chebyshev, values: &DMatrix<f64>) -> Result<Self> {
        check_length("values", chebyshev.degree() + 1, values.ncols())?;
        Self::new(chebyshev.horizon(), chebyshev.coefficients(values))
    }

    /// Takes the step of an augmented Lagrangian method, $\lambda \leftarrow \lambda + \rho\\, c$, with the violation
    /// `c` of the constraints given by its values at the nodes of `chebyshev`: one row per component, one column per
    /// node.
    ///
    /// # Errors
    /// `c` does not have one row per component and one column per node, or the horizons differ.
    pub fn ascend(&mut self, rho: f64, chebyshev: &Chebyshev, c: &DMatrix<f64>) -> Result<()> {
        check_length("c", self.components(), c.nrows())?;
        let step = Self::through(chebyshev, c)?;
        if step.horizon != self.horizon {
            let condition = format!("it is {}, that of the step {}", self.horizon, step.horizon);
            return Err(Error::input("dual trajectory", "horizon", condition));
        }
        let degrees = step.coefficients.ncols().max(self.coefficients.ncols());
        let grown = |c: DMatrix<f64>| c.resize_horizontally(degrees, 0.0);
        let own = std::mem::replace(&mut self.coefficients, DMatrix::zeros(0, 0));
        self.coefficients = grown(own) + grown(step.coefficients) * rho;
        Ok(())
    }
}
