//! The violations of constraints along a motion, for reports and for the success criterion.

use super::bracket::Bracket;
use crate::constraint::{Constraint, Constraints, Evaluator, RateLimit, StageInput, TorqueLimits};
use crate::curve::{Chebyshev, Curve};
use crate::dynamics::{Data, rnea};
use crate::error::{Error, Result};
use crate::linalg::multiply;
use crate::model::Model;
use crate::scalar::{LANES, Lanes, Wide};
use nalgebra::{DMatrix, DVector};

/// The largest value over time of one row of constraints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The row: those of the state come first, then those of the torque.
    pub row: usize,
    /// The violation, in the unit of its [label](Constraints::label): the row divided by its
    /// [scale](Constraints::row_scales), or the absolute value of that for an equality. Negative if the row is
    /// satisfied with a margin, infinite if it is NaN.
    pub by: f64,
    /// The time of the violation, s.
    pub at_s: f64,
}

/// Computes the largest value over time of every row of `constraints` along `curve`, one entry per row, in their order.
///
/// On each segment of the curve the rows are evaluated at `intervals + 1` equally spaced times, both ends included,
/// because the control may jump between segments. A maximum between the times is that of the parabola through three
/// neighbours, with an error of O(h^3) for a spacing of `h`; if it may be a violation, of parabolas through further
/// values of the row. Each entry depends on its row alone. Cost per time: O(N p)
/// for the curve, O(N) for the dynamics, and that of the rows.
///
/// # Errors
/// The curve or the constraints have another number of joints, a torque limit is negative or not finite, or `intervals`
/// is zero.
pub fn violations<K: Constraint>(
    model: &Model,
    curve: &Curve,
    constraints: &Constraints<K>,
    intervals: usize,
) -> Result<Vec<Violation>> {
    largest_rows(model, curve, constraints, intervals, |part| part)
}

/// The same with times that are dense near the ends of each segment, $T (1 - \cos \pi k / K) / 2$. In `k` a polynomial
/// in time is a sum of cosines with as many half-waves as its degree at most, so that a few times the degree resolve
/// it, near an end at which the state is fixed too.
pub(crate) fn violations_near_ends<K: Constraint>(
    model: &Model,
    curve: &Curve,
    constraints: &Constraints<K>,
    intervals: usize,
) -> Result<Vec<Violation>> {
    let part = |part: f64| 0.5 - 0.5 * (std::f64::consts::PI * part).cos();
    largest_rows(model, curve, constraints, intervals, part)
}

/// The [`violations`] at the times to which `part` takes equal parts of a segment.
fn largest_rows<K: Constraint>(
    model: &Model,
    curve: &Curve,
    constraints: &Constraints<K>,
    intervals: usize,
    part: impl Fn(f64) -> f64,
) -> Result<Vec<Violation>> {
    model.check("curve", curve.dof())?;
    constraints.check(model)?;
    if intervals == 0 {
        let condition = "it is 0, at least 1 is needed";
        return Err(Error::input("violations", "intervals", condition));
    }
    let scales = constraints.row_scales();
    let equalities: Vec<bool> = (0..scales.len())
        .map(|row| constraints.is_equality(row))
        .collect();
    let mut largest: Vec<Violation> = (0..scales.len())
        .map(|row| Violation {
            row,
            by: f64::NEG_INFINITY,
            at_s: 0.0,
        })
        .collect();
    let time = |k: f64| curve.chebyshev().horizon() * part(k / intervals as f64);
    let own_times: Vec<f64> = (0..=intervals).map(|k| time(k as f64)).collect();
    let table = interpolation(curve.chebyshev(), &own_times);
    let mut rows = Rows::new(model, constraints, intervals + 1);
    let mut uncertain: Vec<Option<(usize, Bracket)>> = vec![None; scales.len()];
    for (segment, begin) in curve.breakpoints()[..curve.segments()].iter().enumerate() {
        rows.evaluate(curve, segment, (&own_times, &table), &scales)?;
        let all = rows.values.chunks_exact(rows.stride);
        for ((values, largest), equality) in all.zip(&mut largest).zip(&equalities) {
            let (by, position) = maximum(&values[..=intervals], *equality);
            if by > largest.by {
                largest.by = by;
                largest.at_s = begin + time(position);
                let middle = (position.round() as usize).clamp(1, (intervals - 1).max(1));
                let bracket = Bracket {
                    times: [middle - 1, middle, middle + 1].map(|k| time(k as f64)),
                    values: [middle - 1, middle, middle + 1].map(|k| values[k]),
                };
                let inside = intervals > 1 && !equality && bracket.is_valid();
                let refined = inside && bracket.may_exceed(0.0);
                uncertain[largest.row] = refined.then_some((segment, bracket));
            }
        }
    }
    refine(model, curve, constraints, &uncertain, &mut largest)?;
    Ok(largest)
}

/// Evaluates rows at the estimated times of their maxima, and estimates them again.
fn refine<K: Constraint>(
    model: &Model,
    curve: &Curve,
    constraints: &Constraints<K>,
    uncertain: &[Option<(usize, Bracket)>],
    largest: &mut [Violation],
) -> Result<()> {
    let (chebyshev, scales) = (curve.chebyshev(), constraints.row_scales());
    for (segment, begin) in curve.breakpoints()[..curve.segments()].iter().enumerate() {
        let own = uncertain.iter().enumerate();
        let own =
            own.filter_map(|(row, of)| of.filter(|(at, _)| *at == segment).map(|of| (row, of.1)));
        let mut own: Vec<(usize, Bracket)> = own.collect();
        if own.is_empty() {
            continue;
        }
        let mut rows = Rows::new(model, constraints, own.len());
        for _ in 0..Bracket::REFINEMENTS {
            let times: Vec<f64> = own.iter().map(|(_, bracket)| bracket.next()).collect();
            let table = interpolation(chebyshev, &times);
            rows.evaluate(curve, segment, (&times, &table), &scales)?;
            for (k, (row, bracket)) in own.iter_mut().enumerate() {
                bracket.narrow(times[k], rows.values[*row * rows.stride + k]);
            }
        }
        for (row, bracket) in own {
            let (time, height) = bracket.vertex();
            (largest[row].at_s, largest[row].by) = (begin + time, height);
        }
    }
    Ok(())
}

/// The largest absolute torque of each joint along `curve`, N m or N, `N` entries, on `intervals` intervals per segment
/// and at the maxima between; see [`violations`].
///
/// # Errors
/// The curve has another number of joints than `model`.
pub fn largest_torques(model: &Model, curve: &Curve, intervals: usize) -> Result<Vec<f64>> {
    // The rows of passive joints are the torques themselves.
    let all = Constraints {
        state: (),
        torque: TorqueLimits(vec![Some(0.0); model.dof()]),
        stage: Default::default(),
    };
    let found = violations(model, curve, &all, intervals)?;
    Ok(found.into_iter().map(|torque| torque.by).collect())
}

/// The largest torque of a passive joint along `curve`, relative to the largest torque of any joint; zero if `limits`
/// have no passive joint. The times are those of [`largest_torques`].
///
/// # Errors
/// The curve has another number of joints than `model`.
pub fn passive_share(
    model: &Model,
    curve: &Curve,
    limits: &TorqueLimits,
    intervals: usize,
) -> Result<f64> {
    if !limits.has_passive() {
        return Ok(0.0);
    }
    let torques = largest_torques(model, curve, intervals)?;
    let largest = torques.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let joints = torques.iter().enumerate();
    let passive = joints.filter(|(joint, _)| limits.is_passive(*joint));
    Ok(passive.fold(0.0_f64, |most, (_, torque)| most.max(*torque)) / largest)
}

/// The weights of the nodes of a segment at times in it, one column per time.
fn interpolation(chebyshev: &Chebyshev, times: &[f64]) -> DMatrix<f64> {
    let nodes = chebyshev.degree() + 1;
    let (mut table, mut weights) = (DMatrix::zeros(nodes, times.len()), DVector::zeros(nodes));
    for (k, time) in times.iter().enumerate() {
        chebyshev.interpolation(*time, &mut weights);
        table.set_column(k, &weights);
    }
    table
}

/// All rows at all times of a segment.
struct Rows<'a, K> {
    model: &'a Model,
    constraints: &'a Constraints<K>,
    evaluator: Evaluator<'a, f64, Wide>,
    data: Data<Wide>,
    /// $[q; v; a]$, the torque and the rows at the times that are evaluated side by side.
    z: Vec<Wide>,
    u: Vec<Wide>,
    g: Vec<Wide>,
    /// $[q; v; a; \dot a]$ at all times, one column each.
    states: DMatrix<f64>,
    rates: Vec<RateLimit>,
    /// The rows divided by their scales, one after the other, each over time and padded to full lanes.
    values: Vec<f64>,
    stride: usize,
}

impl<'a, K: Constraint> Rows<'a, K> {
    fn new(model: &'a Model, constraints: &'a Constraints<K>, times: usize) -> Self {
        let (n, count, zero) = (model.dof(), constraints.dim(), Wide::splat(0.0));
        let stride = times.next_multiple_of(LANES);
        Self {
            model,
            constraints,
            evaluator: Evaluator::new(model),
            data: Data::new(model),
            z: vec![zero; 4 * n],
            rates: constraints.stage.rates().collect(),
            u: vec![zero; n],
            g: vec![zero; count],
            states: DMatrix::zeros(4 * n, times),
            values: vec![0.0; count * stride],
            stride,
        }
    }

    fn evaluate(
        &mut self,
        curve: &Curve,
        segment: usize,
        (own_times, table): (&[f64], &DMatrix<f64>),
        scales: &[f64],
    ) -> Result<()> {
        let n = self.model.dof();
        let mut nodes = DMatrix::zeros(4 * n, table.nrows());
        nodes.rows_mut(0, 2 * n).copy_from(&curve.segment(segment));
        let rates = curve.segment_rates(segment);
        nodes.rows_mut(2 * n, n).copy_from(&rates.rows(n, n));
        let jerks = rates.rows(n, n) * curve.chebyshev().d().transpose();
        nodes.rows_mut(3 * n, n).copy_from(&jerks);
        multiply(&nodes, table, &mut self.states);
        let Constraints {
            state,
            torque,
            stage,
        } = self.constraints;
        let (of_state, others) = self.g.split_at_mut(state.dim());
        let (of_torque, of_stage) = others.split_at_mut(torque.dim());
        let times = self.states.ncols();
        for first in (0..times).step_by(LANES) {
            Lanes::gather(self.states.as_slice(), first, &mut self.z);
            let placed = self.evaluator.at(&self.z[..2 * n])?;
            placed.value(state, of_state)?;
            if !(of_torque.is_empty() && stage.others.is_empty()) {
                let [q, v, a] = [0, 1, 2].map(|part| &self.z[part * n..(part + 1) * n]);
                rnea(self.model, &mut self.data, q, v, a, &mut self.u)?;
                if !of_torque.is_empty() {
                    torque.value(&self.u, of_torque)?;
                }
            }
            for (g, rate) in of_stage.iter_mut().zip(&self.rates) {
                let of_joint = self.z[rate.order * n + rate.joint];
                *g = of_joint * Wide::splat(rate.sign()) - Wide::splat(rate.limit);
            }
            if let Some((row, foot)) = stage.foot() {
                let z = [0, 1, 2].map(|part| &self.z[part * n..(part + 1) * n]);
                let g = &mut of_stage[row..row + foot.dim()];
                foot.value(self.model, &mut self.data, z, g)?;
            }
            for (row, other) in stage.others() {
                let begin = curve.breakpoints()[segment];
                for lane in 0..LANES.min(times - first) {
                    let t = begin + own_times[first + lane];
                    let z: Vec<f64> = self.z.iter().chain(&self.u).map(|z| z.0[lane]).collect();
                    let [q, v, a, _, u] = [0, 1, 2, 3, 4].map(|part| &z[part * n..(part + 1) * n]);
                    let mut g = vec![0.0; other.dim()];
                    other.value(&StageInput { t, q, v, a, u }, &mut g)?;
                    for (to, g) in of_stage[row..].iter_mut().zip(g) {
                        to.0[lane] = g;
                    }
                }
            }
            let all = of_state
                .iter()
                .chain(of_torque.iter())
                .chain(of_stage.iter())
                .zip(scales);
            for ((g, scale), values) in all.zip(self.values.chunks_exact_mut(self.stride)) {
                for (value, g) in values[first..first + LANES].iter_mut().zip(g.0) {
                    let scaled = g / scale;
                    // Comparisons would ignore a NaN.
                    *value = if scaled.is_nan() {
                        f64::INFINITY
                    } else {
                        scaled
                    };
                }
            }
        }
        Ok(())
    }
}

/// The largest of values at successive times, or of their absolute values for an equality, and its position in
/// intervals. The maxima of all parabolas through three neighbours are included: near the middle one, and out to an end
/// at the first and last three.
fn maximum(values: &[f64], equality: bool) -> (f64, f64) {
    let (mut largest, mut position) = (f64::NEG_INFINITY, 0.0);
    for (k, value) in values.iter().enumerate() {
        let height = if equality { value.abs() } else { *value };
        if height > largest {
            (largest, position) = (height, k as f64);
        }
    }
    let last = values.len().saturating_sub(3);
    for (k, window) in values.windows(3).enumerate() {
        let sign = if equality { window[1].signum() } else { 1.0 };
        let [a, b, c] = [window[0], window[1], window[2]].map(|value| sign * value);
        let (slope, bend) = (0.5 * (c - a), 2.0 * b - a - c);
        // Within an interval from the middle a parabola is higher by half its bend at most.
        if b + 0.5 * bend <= largest {
            continue;
        }
        let from = if k == 0 { -1.0 } else { -0.5 };
        let to = if k == last { 1.0 } else { 0.5 };
        if bend > 0.0 && slope >= from * bend && slope <= to * bend {
            let shift = slope / bend;
            let height = b + 0.5 * slope * shift;
            if height > largest {
                (largest, position) = (height, (k + 1) as f64 + shift);
            }
        }
    }
    (largest, position)
}
