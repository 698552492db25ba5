//! The peaks of the constraint rows along a curve, between the quadrature points.

use super::objective::scale;
use super::{CostWithControl, Points, Rows, place};
use crate::constraint::Constraint;
use crate::curve::Basis;
use crate::error::Result;
use nalgebra::DMatrix;

/// A basis tabulated at equally spaced times.
pub(in crate::relax) struct Scan {
    basis: Basis,
    /// Value, first and second derivative in normalised time at each time of a segment.
    table: DMatrix<f64>,
    intervals: usize,
}

/// A local maximum of a row over time.
#[derive(Clone, Copy, Debug)]
pub(in crate::relax) struct Peak {
    pub row: usize,
    pub segment: usize,
    pub time: f64,
    pub height: f64,
}

impl Scan {
    /// Tabulates `basis` at `intervals` intervals per segment.
    pub fn new(basis: &Basis, intervals: usize) -> Self {
        let mut table = DMatrix::zeros(basis.degree() + 1, 3 * (intervals + 1));
        for k in 0..=intervals {
            let local = basis.local(2.0 * k as f64 / intervals as f64 - 1.0);
            for d in 0..3 {
                table.set_column(3 * k + d, &local.row(d).transpose());
            }
        }
        Self {
            basis: basis.clone(),
            table,
            intervals,
        }
    }

    /// Finds the local maxima in time of all rows above `floor`, ends of the segments included, refined by a parabola.
    /// Equalities have none. The times of the maxima are normalised.
    pub fn peaks<K: Constraint, P: CostWithControl>(
        &self,
        rows: &mut Rows<'_, K, P>,
        coefficients: &DMatrix<f64>,
        horizon: f64,
        floor: f64,
    ) -> Result<Vec<Peak>> {
        let (n, count) = (coefficients.nrows(), rows.count());
        let segments = self.basis.segments();
        let interval = 1.0 / (segments * self.intervals) as f64;
        // Three neighbours in time; a value from beyond the ends is below all. The control may jump where two segments
        // meet, so each has ends of its own: after the last value of one `here` is below all again.
        let below = vec![f64::NEG_INFINITY; count];
        let [mut before, mut here, mut next] = [below.clone(), below.clone(), below.clone()];
        let (mut found, mut states) = (Vec::new(), DMatrix::zeros(n, self.table.ncols()));
        let mut h = vec![0.0; count * (self.intervals + 1)];
        for segment in 0..segments {
            place(
                coefficients,
                self.basis.first(segment),
                &self.table,
                &mut states,
            );
            scale(&mut states, horizon);
            let first = segment * self.intervals;
            let times: Vec<_> = (0..=self.intervals)
                .map(|k| (first + k) as f64 * interval * horizon)
                .collect();
            let points = Points {
                first: 0,
                times: &times,
                states: &states,
            };
            rows.of_all(points, &mut h)?;
            for k in 0..=self.intervals + 1 {
                if k <= self.intervals {
                    next.copy_from_slice(&h[k * count..(k + 1) * count]);
                } else {
                    next.copy_from_slice(&below);
                }
                for row in 0..count {
                    let (a, b, c) = (before[row], here[row], next[row]);
                    if k == 0 || b <= floor || a > b || c >= b || rows.attributes().equalities[row]
                    {
                        continue;
                    }
                    let (mut shift, mut height) = (0.0, b);
                    if a.is_finite() && c.is_finite() {
                        let (slope, bend) = ((c - a) / 2.0, 2.0 * b - a - c);
                        shift = (slope / bend).clamp(-0.5, 0.5);
                        height += 0.5 * slope * shift;
                    }
                    found.push(Peak {
                        row,
                        segment,
                        time: ((first + k - 1) as f64 + shift) * interval,
                        height,
                    });
                }
                std::mem::swap(&mut before, &mut here);
                std::mem::swap(&mut here, &mut next);
            }
        }
        Ok(found)
    }
}
