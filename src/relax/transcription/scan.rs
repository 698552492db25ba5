//! The peaks of the constraint rows along a curve, between the quadrature points.

use super::objective::scale;
use super::{CostWithControl, Points, Rows, place};
use crate::constraint::Constraint;
use crate::curve::Basis;
use crate::error::Result;
use crate::motion::Bracket;
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

    /// Finds the local maxima in time of all rows above `floor`, ends of the segments included, refined by a parabola;
    /// one that may be above zero by further values of its row. Equalities have none. The times of the maxima are
    /// normalised.
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
        let mut uncertain = Vec::new();
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
                    let time = (first + k - 1) as f64 * interval;
                    let mut peak = Peak {
                        row,
                        segment,
                        time,
                        height: b,
                    };
                    let bracket = Bracket {
                        times: [time - interval, time, time + interval],
                        values: [a, b, c],
                    };
                    if bracket.is_valid() {
                        (peak.time, peak.height) = bracket.vertex();
                        if bracket.may_exceed(0.0) {
                            uncertain.push((found.len(), bracket));
                        }
                    }
                    found.push(peak);
                }
                std::mem::swap(&mut before, &mut here);
                std::mem::swap(&mut here, &mut next);
            }
        }
        if !uncertain.is_empty() {
            for _ in 0..Bracket::REFINEMENTS {
                self.refine(rows, coefficients, horizon, &mut uncertain, &mut found)?;
            }
        }
        Ok(found)
    }

    /// Evaluates the rows at the estimated times of maxima, and estimates them again.
    fn refine<K: Constraint, P: CostWithControl>(
        &self,
        rows: &mut Rows<'_, K, P>,
        coefficients: &DMatrix<f64>,
        horizon: f64,
        uncertain: &mut [(usize, Bracket)],
        found: &mut [Peak],
    ) -> Result<()> {
        let (n, count, segments) = (coefficients.nrows(), rows.count(), self.basis.segments());
        let mut states = DMatrix::zeros(n, 3 * uncertain.len());
        let (mut one, mut times) = (DMatrix::zeros(n, 3), Vec::new());
        for (k, (at, bracket)) in uncertain.iter().enumerate() {
            let (segment, time) = (found[*at].segment, bracket.next());
            let local = 2.0 * (time * segments as f64 - segment as f64) - 1.0;
            let table = self.basis.local(local).transpose();
            place(coefficients, self.basis.first(segment), &table, &mut one);
            states.columns_mut(3 * k, 3).copy_from(&one);
            times.push(time * horizon);
        }
        scale(&mut states, horizon);
        let mut h = vec![0.0; count * times.len()];
        let points = Points {
            first: 0,
            times: &times,
            states: &states,
        };
        rows.of_all(points, &mut h)?;
        for (k, (at, bracket)) in uncertain.iter_mut().enumerate() {
            let peak = &mut found[*at];
            bracket.narrow(bracket.next(), h[k * count + peak.row]);
            (peak.time, peak.height) = bracket.vertex();
        }
        Ok(())
    }
}
