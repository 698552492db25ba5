//! The violations of constraints along a motion, for reports and for the success criterion.

use super::row_values::Rows;
use crate::constraint::{Constraint, Constraints, TorqueLimits};
use crate::curve::{Bracket, Chebyshev, Curve, bound, maxima};
use crate::error::{Error, Result};
use crate::linalg::multiply;
use crate::model::Model;
use crate::transcription::Shared;
use nalgebra::{DMatrix, DVector};

/// The largest value over time of one row of constraints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The row: those of the state come first, then those of the torque and of the stage.
    pub row: usize,
    /// The row divided by its [scale](Constraints::row_scales), or the absolute value of that for an equality. Negative
    /// if the row is satisfied with a margin, infinite if it is NaN. [`Constraints::excess`] has it in the unit of the
    /// [label](Constraints::label).
    pub by: f64,
    /// The time of the violation, s.
    pub at_s: f64,
}

/// Computes the largest value over time of every row of `constraints` along `curve`, one entry per row, in their order.
///
/// On each segment of the curve the rows are evaluated at `intervals + 1` equally spaced times, both ends included,
/// because the control may jump between segments. A maximum between the times is that of the parabola through three
/// neighbours, with an error of O(h^3) for a spacing of `h`; if it may be a violation, it is refined by parabolas
/// through further values of the row until it is settled. Each entry depends on its row alone. A row that is kept
/// between two times is evaluated at these as well; if the motion is at no time between them, its entry is negative and
/// infinite. Cost per time: O(N p) for the curve, O(N) for the dynamics, and that of the rows.
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
    model.check("curve", curve.dof())?;
    let mut search = LargestRows::new(model, constraints, intervals, |part| part)?;
    let mut motion = OnCurve { curve, table: None, states: DMatrix::zeros(0, 0) };
    Ok(search.along(&mut motion)?.to_vec())
}

/// A motion at times of its segments.
pub(crate) trait Motion {
    /// The number of segments.
    fn segments(&self) -> usize;

    /// The time at which a segment begins, s.
    fn begin(&self, segment: usize) -> f64;

    /// The length of a segment, s.
    fn length(&self, segment: usize) -> f64;

    /// Computes $[q; v; a; \dot a]$ at times of a segment, one after the other; `regular` times are the same parts of
    /// each segment.
    fn states(&mut self, segment: usize, times: &[f64], regular: bool) -> &[f64];
}

/// A search for the largest values of rows along motions, which keeps its memory.
pub(crate) struct LargestRows<'a, K> {
    rows: Rows<'a, K>,
    scales: Vec<f64>,
    equalities: Vec<bool>,
    /// The times between which each row is kept, s.
    kept: Vec<[f64; 2]>,
    /// A function from equal parts of a segment to the parts at which it is evaluated, and the number of intervals.
    part: fn(f64) -> f64,
    intervals: usize,
    /// Rows that cannot exceed this remain at their least value.
    above: f64,
    times: Vec<f64>,
    largest: Vec<Violation>,
    /// The maxima that may be violations, with their segments and rows.
    uncertain: Vec<(usize, usize, Bracket)>,
    own: Vec<(usize, Bracket)>,
}

impl<'a, K: Constraint> LargestRows<'a, K> {
    /// The search at the times to which `part` maps equal parts of a segment.
    ///
    /// # Errors
    /// Those of [`violations`].
    pub fn new(
        model: &'a Model,
        constraints: impl Into<Shared<'a, Constraints<K>>>,
        intervals: usize,
        part: fn(f64) -> f64,
    ) -> Result<Self> {
        let constraints = constraints.into();
        constraints.check(model)?;
        if intervals == 0 {
            let condition = "it is 0 and must be at least 1";
            return Err(Error::input("violations", "intervals", condition));
        }
        let scales = constraints.row_scales();
        let equalities = (0..scales.len()).map(|row| constraints.is_equality(row));
        Ok(Self {
            equalities: equalities.collect(),
            kept: constraints.times(),
            rows: Rows::new(model, constraints, &scales),
            scales,
            part,
            intervals,
            above: f64::NEG_INFINITY,
            times: Vec::new(),
            largest: Vec::new(),
            uncertain: Vec::new(),
            own: Vec::new(),
        })
    }

    /// The same with times that are dense near the ends of each segment, $T (1 - \cos \pi k / K) / 2$. In `k` a
    /// polynomial in time is a sum of cosines with as many half-waves as its degree at most, so that a few times the
    /// degree resolve it, near an end at which the state is fixed too. Rows that cannot exceed zero remain at their
    /// least value.
    ///
    /// # Errors
    /// Those of [`violations`].
    pub fn near_ends(
        model: &'a Model,
        constraints: impl Into<Shared<'a, Constraints<K>>>,
        intervals: usize,
    ) -> Result<Self> {
        let part = |part: f64| 0.5 - 0.5 * (std::f64::consts::PI * part).cos();
        let all = Self::new(model, constraints, intervals, part)?;
        Ok(Self { above: 0.0, ..all })
    }

    /// The parts of a segment at which it is evaluated.
    pub fn parts(&self) -> impl Iterator<Item = f64> {
        (0..=self.intervals).map(|k| (self.part)(k as f64 / self.intervals as f64))
    }

    /// Computes the largest value over time of every row, one entry per row; see [`violations`].
    ///
    /// # Errors
    /// Those of the rows.
    pub fn along(&mut self, motion: &mut impl Motion) -> Result<&[Violation]> {
        let (part, intervals) = (self.part, self.intervals);
        self.largest.clear();
        let least = self.rows.least.iter().enumerate();
        self.largest.extend(least.map(|(row, by)| Violation { row, by: *by, at_s: 0.0 }));
        self.uncertain.clear();
        for segment in 0..motion.segments() {
            let (begin, length) = (motion.begin(segment), motion.length(segment));
            let time = |k: f64| length * part(k / intervals as f64);
            self.times.clear();
            self.times.extend((0..=intervals).map(|k| time(k as f64)));
            let states = motion.states(segment, &self.times, true);
            self.rows.evaluate(states, (begin, &self.times), &self.scales)?;
            for (largest, equality) in self.largest.iter_mut().zip(&self.equalities) {
                let Some(values) = self.rows.of_row(largest.row) else {
                    continue;
                };
                let values = &values[..=intervals];
                if bound(values, *equality) <= self.above {
                    continue;
                }
                let kept = self.kept[largest.row];
                let [sampled, estimate] = if kept.iter().any(|time| time.is_finite()) {
                    [largest_between(values, (begin, &self.times), kept); 2]
                } else {
                    maxima(values, *equality)
                };
                let middle = (estimate.1.round() as usize).clamp(1, (intervals - 1).max(1));
                let mut by_parabola = true;
                for k in (1..intervals).filter(|_| !equality) {
                    let around = [k - 1, k, k + 1];
                    let bracket = Bracket { times: around.map(|k| self.times[k]), values: around.map(|k| values[k]) };
                    let [from, to] = kept.map(|time| time - begin);
                    let is_kept = bracket.times[0] <= to && bracket.times[2] >= from;
                    if is_kept && bracket.is_valid() && bracket.may_exceed(0.0) {
                        self.uncertain.push((segment, largest.row, bracket));
                        by_parabola &= k != middle;
                    }
                }
                let (by, position) = if by_parabola { estimate } else { sampled };
                if by > largest.by {
                    largest.by = by;
                    largest.at_s = begin + time(position);
                }
            }
        }
        self.refine(motion)?;
        self.at_ends_of_times(motion)?;
        Ok(&self.largest)
    }

    /// Evaluates rows that are kept between two times at these.
    fn at_ends_of_times(&mut self, motion: &mut impl Motion) -> Result<()> {
        for segment in 0..motion.segments() {
            let (begin, length) = (motion.begin(segment), motion.length(segment));
            let ends = self.kept.iter().flatten().map(|end| end - begin);
            self.times.clear();
            self.times.extend(ends.filter(|end| (0.0..=length).contains(end)));
            self.times.sort_unstable_by(f64::total_cmp);
            self.times.dedup();
            if self.times.is_empty() {
                continue;
            }
            let states = motion.states(segment, &self.times, false);
            self.rows.evaluate(states, (begin, &self.times), &self.scales)?;
            for largest in &mut self.largest {
                let ends = self.kept[largest.row];
                let Some(values) = self.rows.of_row(largest.row) else {
                    continue;
                };
                for (end, value) in self.times.iter().zip(values) {
                    let at_s = begin + end;
                    if ends.iter().any(|of| of - begin == *end) && *value > largest.by {
                        (largest.by, largest.at_s) = (*value, at_s);
                    }
                }
            }
        }
        Ok(())
    }

    /// Evaluates rows at the estimated times of their maxima, and estimates them again until they are settled.
    fn refine(&mut self, motion: &mut impl Motion) -> Result<()> {
        for segment in 0..motion.segments() {
            let begin = motion.begin(segment);
            let own = self.uncertain.iter().filter(|(at, ..)| *at == segment);
            let own = own.map(|(_, row, bracket)| (*row, *bracket));
            self.own.clear();
            self.own.extend(own);
            if self.own.is_empty() {
                continue;
            }
            for refinement in 0..Bracket::MAX_REFINEMENTS {
                let is_open =
                    |(_, bracket): &(usize, Bracket)| refinement < Bracket::REFINEMENTS || !bracket.is_settled();
                let open = self.own.iter().filter(|of| is_open(of));
                self.times.clear();
                self.times.extend(open.map(|(_, bracket)| bracket.next()));
                if self.times.is_empty() {
                    break;
                }
                let states = motion.states(segment, &self.times, false);
                self.rows.evaluate(states, (begin, &self.times), &self.scales)?;
                let open = self.own.iter_mut().filter(|of| is_open(of));
                for (k, (row, bracket)) in open.enumerate() {
                    let value = self.rows.of_row(*row).map_or(self.rows.least[*row], |of| of[k]);
                    bracket.narrow(self.times[k], value);
                }
            }
            for (row, bracket) in &self.own {
                let (time, height) = bracket.maximum();
                let [from, to] = self.kept[*row];
                let is_kept = (from..=to).contains(&(begin + time));
                if is_kept && height > self.largest[*row].by {
                    (self.largest[*row].by, self.largest[*row].at_s) = (height, begin + time);
                }
            }
        }
        Ok(())
    }
}

/// The largest of values at times after `begin`, between the times at which the row is kept, and its position in
/// intervals.
fn largest_between(values: &[f64], (begin, times): (f64, &[f64]), [from, to]: [f64; 2]) -> (f64, f64) {
    let at = values.iter().zip(times).enumerate();
    let kept = at.filter(|(_, (_, time))| (from..=to).contains(&(begin + **time)));
    kept.fold((f64::NEG_INFINITY, 0.0), |most, (k, (value, _))| if *value > most.0 { (*value, k as f64) } else { most })
}

/// A curve through nodes.
struct OnCurve<'c> {
    curve: &'c Curve,
    /// The weights of the nodes at the regular times, one column per time, in segments of this length.
    table: Option<(f64, DMatrix<f64>)>,
    states: DMatrix<f64>,
}

impl Motion for OnCurve<'_> {
    fn segments(&self) -> usize {
        self.curve.segments()
    }

    fn begin(&self, segment: usize) -> f64 {
        self.curve.breakpoints()[segment]
    }

    fn length(&self, segment: usize) -> f64 {
        self.curve.chebyshev(segment).horizon()
    }

    fn states(&mut self, segment: usize, times: &[f64], regular: bool) -> &[f64] {
        let (curve, chebyshev) = (self.curve, self.curve.chebyshev(segment));
        let n = curve.dof();
        let mut nodes = DMatrix::zeros(4 * n, chebyshev.degree() + 1);
        nodes.rows_mut(0, 2 * n).copy_from(&curve.segment(segment));
        let rates = curve.segment_rates(segment);
        nodes.rows_mut(2 * n, n).copy_from(&rates.rows(n, n));
        let jerks = rates.rows(n, n) * chebyshev.d().transpose();
        nodes.rows_mut(3 * n, n).copy_from(&jerks);
        let further;
        let table = if regular {
            let length = chebyshev.horizon();
            self.table.take_if(|(of, _)| *of != length);
            let new = || (length, interpolation(chebyshev, times));
            &self.table.get_or_insert_with(new).1
        } else {
            further = interpolation(chebyshev, times);
            &further
        };
        self.states = DMatrix::zeros(4 * n, times.len());
        multiply(&nodes, table, &mut self.states);
        self.states.as_slice()
    }
}

/// The largest absolute torque of each joint along `curve`, N m or N, `N` entries, on `intervals` intervals per segment
/// and at the maxima between; see [`violations`].
///
/// # Errors
/// The curve has another number of joints than `model`.
pub fn largest_torques(model: &Model, curve: &Curve, intervals: usize) -> Result<Vec<f64>> {
    // The rows of passive joints are the torques themselves.
    let all = Constraints { state: (), torque: TorqueLimits(vec![Some(0.0); model.dof()]), stage: Default::default() };
    let found = violations(model, curve, &all, intervals)?;
    Ok(found.into_iter().map(|torque| torque.by).collect())
}

/// The largest torque of a passive joint along `curve`, relative to the largest torque of any joint; zero if `limits`
/// have no passive joint. The times are those of [`largest_torques`].
///
/// # Errors
/// The curve has another number of joints than `model`.
pub fn passive_share(model: &Model, curve: &Curve, limits: &TorqueLimits, intervals: usize) -> Result<f64> {
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
