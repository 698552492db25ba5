//! The conditions of Karush, Kuhn and Tucker, from the derivatives alone.

use super::{SmoothDerivatives, SmoothProgram};
use crate::error::Result;
use nalgebra::DVector;

/// The mean multiplier above which errors are relative to it: 100 as in WB (6).
const LARGE_MULTIPLIER: f64 = 100.0;

/// The largest slope of the objective and of a row after they are scaled at the start: 100 as in WB (3.8).
const MAX_SLOPE: f64 = 100.0;

/// The factors of the objective and of the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Scales {
    pub objective: f64,
    pub rows: DVector<f64>,
}

impl Scales {
    /// Those with which no slope among these derivatives is larger than 100.
    #[must_use]
    pub fn new(derivatives: &SmoothDerivatives) -> Self {
        let scale = |slope: f64| if slope > MAX_SLOPE { MAX_SLOPE / slope } else { 1.0 };
        let SmoothDerivatives { gradient, jacobian, .. } = derivatives;
        let rows = jacobian.row_iter().map(|row| scale(row.amax()));
        Self { objective: scale(gradient.amax()), rows: DVector::from_iterator(jacobian.nrows(), rows) }
    }
}

/// The errors of the conditions of a minimum of the first order (NW 12.34), scaled as WB (5) and (6). They do not
/// depend on how a point was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KktError {
    /// The largest entry of the gradient of the Lagrangian, and the largest multiplier of a bound that does not exist.
    pub stationarity: f64,
    /// The largest violation of a bound, in its unit.
    pub feasibility: f64,
    /// The largest product of a multiplier and the distance from its bound.
    pub complementarity: f64,
}

impl KktError {
    /// The errors at `x` of the program with these scales, with the multipliers of the rows and of the unknowns of the
    /// program without them, positive at upper bounds and negative at lower ones.
    ///
    /// # Errors
    /// Those of the program.
    pub fn new<P: SmoothProgram>(
        program: &mut P,
        scales: &Scales,
        x: &DVector<f64>,
        [row_multipliers, bound_multipliers]: [&DVector<f64>; 2],
    ) -> Result<Self> {
        let (bounds, row_bounds) = (program.bounds(), program.row_bounds());
        let mut g = DVector::zeros(row_multipliers.len());
        let mut derivatives = SmoothDerivatives::new(x.len(), g.len());
        program.value(x, &mut g)?;
        program.derivatives(x, row_multipliers, &mut derivatives)?;
        let SmoothDerivatives { gradient, jacobian, .. } = &derivatives;
        let lagrangian = (gradient + jacobian.tr_mul(row_multipliers) + bound_multipliers) * scales.objective;
        let factors = scales.rows.iter().copied().chain(std::iter::repeat(1.0));
        let scaled = row_multipliers.iter().chain(bound_multipliers).zip(factors.clone());
        let multipliers: Vec<_> = scaled.map(|(multiplier, factor)| multiplier * scales.objective / factor).collect();
        let sum: f64 = multipliers.iter().map(|multiplier| multiplier.abs()).sum();
        let scale = (sum / multipliers.len() as f64 / LARGE_MULTIPLIER).max(1.0);
        let stationarity = lagrangian.iter().fold(0.0, |most, entry| larger(most, entry.abs()));
        let mut error = Self { stationarity, feasibility: 0.0, complementarity: 0.0 };
        let values = g.iter().chain(x).zip(row_bounds.iter().chain(&bounds));
        for (((value, [lower, upper]), multiplier), factor) in values.zip(&multipliers).zip(factors) {
            error.feasibility = larger(error.feasibility, factor * (value - upper).max(lower - value));
            if lower == upper {
                continue;
            }
            let distance = if *multiplier > 0.0 { upper - value } else { value - lower };
            if distance.is_infinite() {
                error.stationarity = larger(error.stationarity, multiplier.abs());
            } else {
                error.complementarity = larger(error.complementarity, (factor * multiplier * distance).abs());
            }
        }
        error.stationarity /= scale;
        error.complementarity /= scale;
        Ok(error)
    }

    /// The largest of the three.
    #[must_use]
    pub fn largest(&self) -> f64 {
        [self.stationarity, self.feasibility, self.complementarity].into_iter().fold(0.0, larger)
    }
}

/// The larger of two errors, infinite if one is not a number.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}
