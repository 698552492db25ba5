//! Values of curves in a basis, and the curves in it that are closest to others.

use super::basis::{Basis, Functions};
use super::gauss_legendre;
use nalgebra::{DMatrix, DVector};

/// A configuration and its first two derivatives in normalised time.
pub(crate) type Local = [DVector<f64>; 3];

/// Memory of a [fit](Basis::fit_in).
#[derive(Clone, Debug, Default)]
pub(crate) struct Fit {
    functions: Functions,
    bubbles: DMatrix<f64>,
    local: Local,
    product: DVector<f64>,
    /// The quadrature.
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl Basis {
    /// Evaluates the curve with these coefficients, `N` by [`count`](Self::count), at a normalised time.
    pub(crate) fn evaluate(&self, coefficients: &DMatrix<f64>, time: f64) -> Local {
        let mut local = [(); 3].map(|()| DVector::zeros(coefficients.nrows()));
        self.evaluate_in(coefficients, time, &mut Functions::default(), &mut local);
        local
    }

    /// Does the same with memory that is kept.
    pub(crate) fn evaluate_in(
        &self,
        coefficients: &DMatrix<f64>,
        time: f64,
        functions: &mut Functions,
        local: &mut Local,
    ) {
        let e = self.functions_at_in(time, functions);
        let own = coefficients.columns(self.first(e), self.degree + 1);
        for (d, out) in local.iter_mut().enumerate() {
            out.gemv(1.0, &own, &functions.transposed.column(d), 0.0);
        }
    }

    /// The coefficients of a curve: the derivatives of the breakpoints are interpolated, and between them the second
    /// derivative is the best approximation, for a continuous second derivative with the weight $1 / (1 - s^2)$, or the
    /// slope if that may jump. Exact for curves in the basis, if the breakpoints of the curve are among its own.
    pub(crate) fn fit(&self, dof: usize, mut curve: impl FnMut(f64) -> Local) -> DMatrix<f64> {
        let mut coefficients = DMatrix::zeros(dof, self.count());
        let curve = |time: f64, local: &mut Local| *local = curve(time);
        self.fit_in(curve, &mut Fit::default(), &mut coefficients);
        coefficients
    }

    /// Computes the coefficients of a curve as [`fit`](Self::fit) does, `N` by [`count`](Self::count).
    pub(crate) fn fit_in(
        &self,
        mut curve: impl FnMut(f64, &mut Local),
        memory: &mut Fit,
        coefficients: &mut DMatrix<f64>,
    ) {
        let k = self.continuity.order();
        let (dof, count) = coefficients.shape();
        if memory.bubbles.shape() != (dof, count) {
            memory.bubbles = DMatrix::zeros(dof, count);
            memory.local = [(); 3].map(|()| DVector::zeros(dof));
            memory.product = DVector::zeros(dof);
            (memory.nodes, memory.weights) = gauss_legendre(self.degree + 1);
        }
        let Fit { functions, bubbles, local, product, nodes, weights } = memory;
        coefficients.fill(0.0);
        bubbles.fill(0.0);
        for e in 0..=self.segments {
            curve(e as f64 / self.segments as f64, local);
            let [value, slope, second] = &*local;
            if k > 2 {
                coefficients.set_column(self.first(e), second);
            }
            if k > 1 {
                coefficients.set_column(self.slope(e), slope);
            }
            coefficients.set_column(self.value(e), value);
        }
        for (s, weight) in nodes.iter().zip(weights.iter()) {
            self.functions_in(*s, functions);
            for e in 0..self.segments {
                curve(self.time(e, *s), local);
                let [_, slope, second] = local;
                let (order, highest) = match k {
                    1 => (1, slope),
                    _ => (2, second),
                };
                // The second derivatives of cubics are orthogonal to those of the bubbles, as slopes of lines are.
                let mut weight = *weight * self.half();
                if k > 2 {
                    let own = coefficients.columns(self.first(e), self.degree + 1);
                    product.gemv(1.0, &own, &functions.transposed.column(2), 0.0);
                    *highest -= &*product;
                    weight /= 1.0 - s * s;
                }
                for f in k..=self.degree - k {
                    let by = weight * functions.table[(order, f)] / self.weighted_square(f);
                    let mut column = bubbles.column_mut(self.first(e) + f);
                    column.axpy(by, highest, 1.0);
                }
            }
        }
        *coefficients += &*bubbles;
    }

    /// The integral of the square of the highest derivative in [`fit`](Self::fit) of a bubble, with its weight.
    fn weighted_square(&self, f: usize) -> f64 {
        let m = f as f64;
        match self.continuity.order() {
            1 | 2 => 1.0,
            // $P_{m-1} - P_{m+1} = (2 m + 1) (1 - s^2) P_m' / (m (m + 1))$, whose weighted square is that of $P_m'$.
            _ => {
                let unscaled = 2.0 * (2.0 * m + 1.0) / (m * (m + 1.0));
                unscaled / (2.0 / (2.0 * m - 1.0) + 2.0 / (2.0 * m + 3.0))
            }
        }
    }
}
