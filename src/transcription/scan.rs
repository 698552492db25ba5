//! The maxima of the constraint rows along a curve, between the quadrature points.

use super::horizons::place_in;
use super::place::scale;
use super::{Horizons, RowSelection, Rows};
use crate::constraint::{Constraint, MAX_ORDER, StageConstraint};
use crate::cost::{CostWithControl, Points};
use crate::curve::{Basis, Bracket, Functions};
use crate::error::Result;
use crate::scalar::LANES;
use nalgebra::DMatrix;
use std::ops::Range;

/// A basis tabulated at equally spaced times.
pub(crate) struct Scan {
    basis: Basis,
    /// Value, first and second derivative in normalised time at each time of a segment.
    table: DMatrix<f64>,
    /// The derivatives of higher orders, from three to [`MAX_ORDER`].
    higher: Vec<DMatrix<f64>>,
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

/// A part of a segment.
struct Part {
    segment: usize,
    phase: usize,
    /// The group of points whose lists it has.
    group: Option<usize>,
    /// Its times, without the one before and the one after, by intervals.
    middles: Range<usize>,
}

/// The maxima of a scan, and its memory.
#[derive(Default)]
pub(crate) struct ScanWorkspace {
    /// The local maxima that were found.
    pub found: Vec<Maximum>,
    /// Those that may be above zero, by their index, with their phases.
    uncertain: Vec<(usize, usize, Bracket)>,
    all: States,
    /// Those of a part, its times in s and in parts of the segment, and the rows that may have a maximum there.
    of_part: States,
    times: Vec<f64>,
    parts: Vec<f64>,
    rows: Vec<usize>,
    h: Vec<f64>,
    /// The functions at a time, and the curve there and at up to `LANES` times.
    functions: Functions,
    one: DMatrix<f64>,
    few: [States; LANES],
}

/// A curve at some times: $q, v, a$, one column each, and its derivatives of the higher orders of the rows.
#[derive(Default)]
struct States {
    states: DMatrix<f64>,
    higher: Vec<DMatrix<f64>>,
}

impl States {
    fn zeros(n: usize, times: usize, higher: usize) -> Self {
        Self { states: DMatrix::zeros(n, 3 * times), higher: vec![DMatrix::zeros(n, times); higher] }
    }

    /// Sets time `k` to a curve with one column per order.
    fn set(&mut self, k: usize, one: &DMatrix<f64>) {
        self.states.columns_mut(3 * k, 3).copy_from(&one.columns(0, 3));
        for (order, rates) in (3..).zip(&mut self.higher) {
            rates.set_column(k, &one.column(order));
        }
    }
}

impl ScanWorkspace {
    /// Memory for a scan of `times` times of `n` joints.
    fn resize(&mut self, n: usize, times: usize, higher: usize) {
        if self.all.states.shape() == (n, 3 * times) && self.all.higher.len() == higher {
            return;
        }
        self.all = States::zeros(n, times, higher);
        self.of_part = States::zeros(n, 0, higher);
        self.one = DMatrix::zeros(n, MAX_ORDER + 1);
        self.few = std::array::from_fn(|k| States::zeros(n, k + 1, higher));
    }
}

/// Copies columns of a matrix.
fn cut(from: &DMatrix<f64>, columns: Range<usize>, to: &mut DMatrix<f64>) {
    let (n, count) = (from.nrows(), columns.len());
    let mut data: Vec<f64> = std::mem::take(to).data.into();
    data.clear();
    data.extend_from_slice(&from.as_slice()[n * columns.start..n * columns.end]);
    *to = DMatrix::from_vec(n, count, data);
}

impl Scan {
    /// Tabulates `basis` at `intervals` intervals per segment.
    pub fn new(basis: &Basis, intervals: usize) -> Self {
        let mut table = DMatrix::zeros(basis.degree() + 1, 3 * (intervals + 1));
        let mut higher = vec![DMatrix::zeros(basis.degree() + 1, intervals + 1); MAX_ORDER - 2];
        for k in 0..=intervals {
            let local = basis.local(2.0 * k as f64 / intervals as f64 - 1.0);
            for d in 0..3 {
                table.set_column(3 * k + d, &local.row(d).transpose());
            }
            for (order, table) in (3..).zip(&mut higher) {
                table.set_column(k, &local.row(order).transpose());
            }
        }
        Self { basis: basis.clone(), table, higher, intervals }
    }

    /// Finds the local maxima in time of all rows above `floor`, ends of the segments included, refined by a parabola;
    /// one that may be above zero by further values of its row. The times of the maxima are normalised. Equalities have
    /// none. Returns the largest deviation of those of the state, in their units.
    pub fn maxima<K: Constraint, P: CostWithControl>(
        &self,
        rows: &mut Rows<'_, K, P>,
        coefficients: &DMatrix<f64>,
        horizons: &Horizons<f64>,
        floor: f64,
        work: &mut ScanWorkspace,
    ) -> Result<f64> {
        let (segments, count) = (self.basis.segments(), rows.count());
        work.resize(coefficients.nrows(), self.intervals + 1, rows.constraints.stage.order() - 2);
        work.found.clear();
        work.uncertain.clear();
        let mut deviation = 0.0_f64;
        for segment in 0..segments {
            let first = self.basis.first(segment);
            let part = horizons.part(segment, segments);
            let (horizon, factor) = (horizons.parts()[part], self.factor(horizons, part));
            place_in(coefficients, first, &self.table, factor, &mut work.all.states);
            scale(&mut work.all.states, horizon);
            for ((order, rates), table) in (3..).zip(&mut work.all.higher).zip(&self.higher) {
                place_in(coefficients, first, table, factor, rates);
                *rates *= horizon.powi(-order);
            }
            let phase = segment * rows.cost.phases() / segments;
            for k in 0..rows.near.parts() {
                let (group, middles) = rows.near.part(segment, k, self.intervals);
                let part = Part { segment, phase, group, middles };
                self.evaluate(rows, &part, (horizons, floor), work)?;
                for (row, unit) in rows.equalities_of_state() {
                    let values = work.h.iter().skip(row).step_by(count);
                    deviation = values.fold(deviation, |most, h| most.max(h.abs() * unit));
                }
                self.find(&part, floor, &rows.attributes().equalities, work);
            }
        }
        for _ in 0..Bracket::REFINEMENTS {
            self.refine(rows, coefficients, horizons, work)?;
        }
        self.keep_times(rows, coefficients, (horizons, floor), work)?;
        Ok(deviation)
    }

    /// Removes maxima at times at which their rows are not kept, and adds the rows above `floor` at the first and the
    /// last time at which they are.
    fn keep_times<K: Constraint, P: CostWithControl>(
        &self,
        rows: &mut Rows<'_, K, P>,
        coefficients: &DMatrix<f64>,
        (horizons, floor): (&Horizons<f64>, f64),
        work: &mut ScanWorkspace,
    ) -> Result<()> {
        let segments = self.basis.segments();
        let of_rows = &rows.attributes.times;
        work.found.retain(|maximum| {
            let [from, to] = of_rows[maximum.row];
            let part = horizons.part(maximum.segment, segments);
            (from..=to).contains(&horizons.time(part, maximum.time))
        });
        let constraints = rows.constraints.clone();
        for (first, window) in constraints.windows() {
            for time in window.times() {
                let Some(normalised) = horizons.normalised(time) else {
                    continue;
                };
                let segment = ((normalised * segments as f64) as usize).min(segments - 1);
                let phase = segment * rows.cost.phases() / segments;
                let ScanWorkspace { functions, one, few: [few, ..], h, .. } = work;
                let at = (segment, normalised);
                self.place_at(coefficients, horizons, at, functions, one);
                few.set(0, one);
                let States { states, higher } = few;
                let points = Points { first: 0, phase, times: &[time], states, higher };
                h.resize(rows.count(), 0.0);
                rows.of_all(points, RowSelection::Listed(&[]), h)?;
                let own = h[first..first + window.dim()].iter().enumerate();
                work.found.extend(own.filter(|(_, height)| **height > floor).map(|(row, height)| Maximum {
                    row: first + row,
                    segment,
                    time: normalised,
                    height: *height,
                }));
            }
        }
        Ok(())
    }

    /// Places the curve at a normalised time of a segment, with derivatives in s.
    fn place_at(
        &self,
        coefficients: &DMatrix<f64>,
        horizons: &Horizons<f64>,
        (segment, time): (usize, f64),
        functions: &mut Functions,
        one: &mut DMatrix<f64>,
    ) {
        let segments = self.basis.segments();
        let local = 2.0 * (time * segments as f64 - segment as f64) - 1.0;
        self.basis.functions_in(local, functions);
        let first = self.basis.first(segment);
        let part = horizons.part(segment, segments);
        let factor = self.factor(horizons, part);
        place_in(coefficients, first, &functions.transposed, factor, one);
        let horizon = horizons.parts()[part];
        scale(one, horizon);
        for order in 3..=MAX_ORDER {
            let factor = horizon.powi(-(order as i32));
            one.column_mut(order).apply(|x| *x *= factor);
        }
    }

    /// Evaluates the rows at the times of a part and one time before and after, and lists those that may have a maximum
    /// above `floor` there.
    fn evaluate<K: Constraint, P: CostWithControl>(
        &self,
        rows: &mut Rows<'_, K, P>,
        part: &Part,
        (horizons, floor): (&Horizons<f64>, f64),
        work: &mut ScanWorkspace,
    ) -> Result<()> {
        let (first, segments) = (part.segment * self.intervals, self.basis.segments());
        let interval = 1.0 / (segments * self.intervals) as f64;
        let own = part.middles.start - 1..part.middles.end + 1;
        let States { states, higher } = &mut work.of_part;
        cut(&work.all.states, 3 * own.start..3 * own.end, states);
        for (of_all, rates) in work.all.higher.iter().zip(&mut *higher) {
            cut(of_all, own.clone(), rates);
        }
        let (times, parts) = (&mut work.times, &mut work.parts);
        times.clear();
        let of_horizon = horizons.part(part.segment, segments);
        let normalised = own.clone().map(|k| (first + k) as f64 * interval);
        times.extend(normalised.map(|time| horizons.time(of_horizon, time)));
        parts.clear();
        parts.extend(own.map(|k| k as f64 / self.intervals as f64));
        let points = Points { first: 0, phase: part.phase, times, states, higher };
        let which = match part.group {
            Some(group) => RowSelection::CachedOverInterval(group, parts),
            None => RowSelection::All,
        };
        let count = rows.count();
        work.h.resize(count * points.count(), 0.0);
        let all = rows.of_all(points, which, &mut work.h)?;
        let is_high = |row: &usize| rows.highest[*row] > floor.max(-rows.attributes.cutoffs[*row]);
        work.rows.clear();
        match part.group.filter(|_| !all) {
            Some(group) => {
                let listed = rows.near.listed(group).iter().copied();
                work.rows.extend(listed.filter(is_high));
            }
            None => work.rows.extend((0..rows.states()).filter(is_high)),
        }
        work.rows.extend(rows.states()..count);
        Ok(())
    }

    /// Finds the local maxima above `floor` in a part among the listed rows.
    fn find(&self, part: &Part, floor: f64, equalities: &[bool], work: &mut ScanWorkspace) {
        let (segment, count) = (part.segment, equalities.len());
        let interval = 1.0 / (self.basis.segments() * self.intervals) as f64;
        let (found, uncertain) = (&mut work.found, &mut work.uncertain);
        // The control may jump where two segments meet, so each has ends of its own.
        for k in part.middles.clone() {
            let time = (segment * self.intervals + k) as f64 * interval;
            let times = [time - interval, time, time + interval];
            let here = &work.h[(k - part.middles.start) * count..];
            for row in work.rows.iter().copied() {
                let values = [here[row], here[count + row], here[2 * count + row]];
                let is_high = values[0] > floor || values[1] > floor || values[2] > floor;
                if !is_high || equalities[row] {
                    continue;
                }
                let bracket = Bracket { times, values };
                let maximum = |(time, height)| Maximum { row, segment, time, height };
                if k == 1 && values[0] > floor && values[0] > values[1] {
                    found.push(maximum(bracket.at_end(0)));
                }
                if values[1] > floor && values[0] <= values[1] && values[2] < values[1] {
                    if bracket.is_valid() && bracket.may_exceed(0.0) {
                        uncertain.push((found.len(), part.phase, bracket));
                    }
                    found.push(maximum(bracket.vertex()));
                }
                if k + 1 == self.intervals && values[2] > floor && values[1] <= values[2] {
                    found.push(maximum(bracket.at_end(2)));
                }
            }
        }
    }

    /// The number of functions per breakpoint, and the factor of slopes in a part.
    fn factor(&self, horizons: &Horizons<f64>, part: usize) -> (usize, Option<f64>) {
        (self.basis.continuity().order(), horizons.stretch(part))
    }

    /// Evaluates the rows at the estimated times of maxima, side by side in one phase, and estimates them again.
    fn refine<K: Constraint, P: CostWithControl>(
        &self,
        rows: &mut Rows<'_, K, P>,
        coefficients: &DMatrix<f64>,
        horizons: &Horizons<f64>,
        work: &mut ScanWorkspace,
    ) -> Result<()> {
        let (count, segments) = (rows.count(), self.basis.segments());
        let ScanWorkspace { found, uncertain, times, rows: own, h, functions, one, few, .. } = work;
        let of_phases = uncertain.chunk_by_mut(|(_, a, _), (_, b, _)| a == b);
        for few_maxima in of_phases.flat_map(|of_phase| of_phase.chunks_mut(LANES)) {
            let own_few = &mut few[few_maxima.len() - 1];
            times.clear();
            for (k, (at, _, bracket)) in few_maxima.iter().enumerate() {
                let (segment, time) = (found[*at].segment, bracket.next());
                self.place_at(coefficients, horizons, (segment, time), functions, one);
                own_few.set(k, one);
                let part = horizons.part(segment, segments);
                times.push(horizons.time(part, time));
            }
            let States { states, higher } = own_few;
            let points = Points { first: 0, phase: few_maxima[0].1, times, states, higher };
            let of_maxima = few_maxima.iter().map(|(at, ..)| found[*at].row);
            own.clear();
            own.extend(of_maxima.filter(|row| *row < rows.states()));
            own.sort_unstable();
            h.resize(count * times.len(), 0.0);
            rows.of_all(points, RowSelection::Listed(own), h)?;
            for (k, (at, _, bracket)) in few_maxima.iter_mut().enumerate() {
                let maximum = &mut found[*at];
                bracket.narrow(bracket.next(), h[k * count + maximum.row]);
                (maximum.time, maximum.height) = bracket.vertex();
            }
        }
        Ok(())
    }
}
