//! The maxima of the constraint rows along a curve, between the quadrature points.

use super::objective::scale;
use super::{Rows, place};
use crate::constraint::Constraint;
use crate::cost::{CostWithControl, Points};
use crate::curve::Basis;
use crate::error::Result;
use crate::motion::Bracket;
use nalgebra::DMatrix;

/// A basis tabulated at equally spaced times.
pub(crate) struct Scan {
    basis: Basis,
    /// Value, first and second derivative in normalised time at each time of a segment.
    table: DMatrix<f64>,
    /// Third derivatives.
    thirds: DMatrix<f64>,
    intervals: usize,
}

/// A local maximum of a row over time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Maximum {
    pub row: usize,
    pub segment: usize,
    pub time: f64,
    pub height: f64,
}

impl Scan {
    /// Tabulates `basis` at `intervals` intervals per segment.
    pub fn new(basis: &Basis, intervals: usize) -> Self {
        let mut table = DMatrix::zeros(basis.degree() + 1, 3 * (intervals + 1));
        let mut thirds = DMatrix::zeros(basis.degree() + 1, intervals + 1);
        for k in 0..=intervals {
            let local = basis.local(2.0 * k as f64 / intervals as f64 - 1.0);
            for d in 0..3 {
                table.set_column(3 * k + d, &local.row(d).transpose());
            }
            thirds.set_column(k, &local.row(3).transpose());
        }
        Self {
            basis: basis.clone(),
            table,
            thirds,
            intervals,
        }
    }

    /// Finds the local maxima in time of all rows above `floor`, ends of the segments included, refined by a parabola;
    /// one that may be above zero by further values of its row. The times of the maxima are normalised. Equalities have
    /// none; the second result is the largest deviation of those of the state, in their units.
    pub fn maxima<K: Constraint, P: CostWithControl>(
        &self,
        rows: &mut Rows<'_, K, P>,
        coefficients: &DMatrix<f64>,
        horizon: f64,
        floor: f64,
    ) -> Result<(Vec<Maximum>, f64)> {
        let (n, count) = (coefficients.nrows(), rows.count());
        let segments = self.basis.segments();
        let interval = 1.0 / (segments * self.intervals) as f64;
        let (mut found, mut states) = (Vec::new(), DMatrix::zeros(n, self.table.ncols()));
        let (mut uncertain, mut deviation) = (Vec::new(), 0.0_f64);
        let with_jerk = rows.constraints.stage.has_jerk();
        let mut jerks = with_jerk.then(|| DMatrix::zeros(n, self.intervals + 1));
        let mut h = vec![0.0; count * (self.intervals + 1)];
        for segment in 0..segments {
            place(
                coefficients,
                self.basis.first(segment),
                &self.table,
                &mut states,
            );
            scale(&mut states, horizon);
            if let Some(jerks) = &mut jerks {
                place(coefficients, self.basis.first(segment), &self.thirds, jerks);
                *jerks *= horizon.powi(-3);
            }
            let first = segment * self.intervals;
            let times: Vec<_> = (0..=self.intervals)
                .map(|k| (first + k) as f64 * interval * horizon)
                .collect();
            let points = Points {
                first: 0,
                phase: segment * rows.cost.phases() / segments,
                times: &times,
                states: &states,
                jerks: jerks.as_ref(),
            };
            rows.of_all(points, &mut h)?;
            for (row, of_row) in rows.equalities_of_state() {
                let values = h.iter().skip(row).step_by(count);
                deviation = values.fold(deviation, |most, h| most.max(h.abs() * of_row));
            }
            // The control may jump where two segments meet, so each has ends of its own.
            for k in 1..self.intervals {
                let time = (first + k) as f64 * interval;
                let times = [time - interval, time, time + interval];
                let here = &h[(k - 1) * count..(k + 2) * count];
                let (before, here) = here.split_at(count);
                let (here, after) = here.split_at(count);
                let all = before.iter().zip(here).zip(after).enumerate();
                for (row, ((before, here), after)) in all {
                    let values = [*before, *here, *after];
                    let is_low = before.max(*here).max(*after) <= floor;
                    if is_low || rows.attributes().equalities[row] {
                        continue;
                    }
                    let bracket = Bracket { times, values };
                    let maximum = |(time, height)| Maximum {
                        row,
                        segment,
                        time,
                        height,
                    };
                    if k == 1 && values[0] > floor && values[0] > values[1] {
                        found.push(maximum(bracket.at_end(0)));
                    }
                    if values[1] > floor && values[0] <= values[1] && values[2] < values[1] {
                        if bracket.is_valid() && bracket.may_exceed(0.0) {
                            uncertain.push((found.len(), points.phase, bracket));
                        }
                        found.push(maximum(bracket.vertex()));
                    }
                    if k + 1 == self.intervals && values[2] > floor && values[1] <= values[2] {
                        found.push(maximum(bracket.at_end(2)));
                    }
                }
            }
        }
        if !uncertain.is_empty() {
            for _ in 0..Bracket::REFINEMENTS {
                for of_phase in uncertain.chunk_by_mut(|(_, a, _), (_, b, _)| a == b) {
                    self.refine(rows, coefficients, horizon, of_phase, &mut found)?;
                }
            }
        }
        Ok((found, deviation))
    }

    /// Evaluates the rows at the estimated times of maxima in one phase, and estimates them again.
    fn refine<K: Constraint, P: CostWithControl>(
        &self,
        rows: &mut Rows<'_, K, P>,
        coefficients: &DMatrix<f64>,
        horizon: f64,
        uncertain: &mut [(usize, usize, Bracket)],
        found: &mut [Maximum],
    ) -> Result<()> {
        let (n, count, segments) = (coefficients.nrows(), rows.count(), self.basis.segments());
        let mut states = DMatrix::zeros(n, 3 * uncertain.len());
        let (mut one, mut times) = (DMatrix::zeros(n, 4), Vec::new());
        let mut jerks = DMatrix::zeros(n, uncertain.len());
        for (k, (at, _, bracket)) in uncertain.iter().enumerate() {
            let (segment, time) = (found[*at].segment, bracket.next());
            let local = 2.0 * (time * segments as f64 - segment as f64) - 1.0;
            let table = self.basis.local(local).transpose();
            place(coefficients, self.basis.first(segment), &table, &mut one);
            states.columns_mut(3 * k, 3).copy_from(&one.columns(0, 3));
            jerks.set_column(k, &(one.column(3) * horizon.powi(-3)));
            times.push(time * horizon);
        }
        scale(&mut states, horizon);
        let mut h = vec![0.0; count * times.len()];
        let points = Points {
            first: 0,
            phase: uncertain[0].1,
            times: &times,
            states: &states,
            jerks: Some(&jerks),
        };
        rows.of_all(points, &mut h)?;
        for (k, (at, _, bracket)) in uncertain.iter_mut().enumerate() {
            let maximum = &mut found[*at];
            bracket.narrow(bracket.next(), h[k * count + maximum.row]);
            (maximum.time, maximum.height) = bracket.vertex();
        }
        Ok(())
    }
}
