//! The motion that a table means, between its samples.

use super::hermite::{Hermite, Model};
use super::rates::Rates;
use super::{Outcome, Row, Trajectory, Worst};
use aghf::error::Result;
use nalgebra::Vector3;

/// The largest difference of an acceleration from the one that a jump leaves, rad/s^2 or m/s^2.
const JUMP: f64 = 1e-3;

/// The number of halvings of intervals in one check: a few seconds of inverse dynamics.
const MAX_HALVINGS: usize = 100_000;

/// The shortest part of an interval in which derived rates are enclosed: their uncertainty does not become smaller.
const MIN_DERIVED: f64 = 1.0 / 16.0;

/// The multiple of the uncertainty of derived rates by which a row fails: the second differences of numbers that are
/// rounded to the same decimal are off by at most about as much as their fourth differences, which are four times the
/// uncertainty.
pub(super) const CAUTION: f64 = 4.0;

/// The motion between the samples.
pub(super) struct Intervals {
    /// The time after the start at which each interval begins, and its duration, s.
    pub times: Vec<[f64; 2]>,
    /// The motions of the joints in each interval.
    pub joints: Vec<Vec<Hermite>>,
    /// The rates of each joint, if they are derived from its positions.
    rates: Option<Vec<Rates>>,
    /// The polynomials in words.
    pub words: String,
}

impl Intervals {
    /// The motion of a table, with `jumps` of accelerations at samples or without.
    pub fn new(trajectory: &Trajectory, jumps: bool) -> Self {
        let Trajectory { times, q, v, a, .. } = trajectory;
        let column = |i: usize| -> Vec<f64> { q.iter().map(|q| q[i]).collect() };
        let joints = || 0..q[0].len();
        let derive = || joints().map(|i| Rates::new(times, &column(i))).collect();
        let rates: Option<Vec<Rates>> = v.is_none().then(derive);
        let mut jumping = 0;
        let mut joint = |k: usize, i: usize| {
            let (ends, interval) = ([k, k + 1], times[k + 1] - times[k]);
            let q = ends.map(|k| q[k][i]);
            if let Some(rates) = &rates {
                let [v, a] = [0, 1].map(|order| ends.map(|k| rates[i].derivatives[k][order]));
                return Hermite::new(q, v, a.map(Some), interval);
            }
            let of = |table: &Option<Vec<Vec<f64>>>| ends.map(|k| table.as_ref().map(|t| t[k][i]));
            let (v, a) = (of(v).map(Option::unwrap_or_default), of(a));
            let whole = Hermite::new(q, v, a, interval);
            let found = if jumps { smoothest(whole, q, v, a, interval) } else { whole };
            jumping += usize::from(found != whole);
            found
        };
        let polynomials: Vec<Vec<Hermite>> =
            (0..times.len() - 1).map(|k| joints().map(|i| joint(k, i)).collect()).collect();
        let mut words = match (v, a) {
            (None, _) => "the quintics through q and the rates of q by five neighbouring samples",
            (_, None) => "the cubics through q and v",
            _ => "the quintics through q, v and a",
        }
        .to_owned();
        if jumping > 0 {
            words +=
                &format!("; of lower degree in {jumping} intervals of a joint, at whose ends its acceleration jumps");
        }
        Self {
            times: (times.windows(2).map(|t| [t[0] - times[0], t[1] - t[0]])).collect(),
            joints: polynomials,
            rates,
            words,
        }
    }

    /// The time after the start, s, at the fraction `s` of interval `k`.
    pub fn time(&self, k: usize, s: f64) -> f64 {
        let [begin, interval] = self.times[k];
        begin + s * interval
    }

    /// The time from the first to the last sample, s.
    pub fn duration(&self) -> f64 {
        self.time(self.joints.len() - 1, 1.0)
    }

    /// The derivatives of this order of all joints at the fraction `s` of interval `k`.
    pub fn at(&self, order: usize, k: usize, s: f64) -> Vec<f64> {
        self.joints[k].iter().map(|joint| joint.at(order, s)).collect()
    }

    /// True if velocities and accelerations are derived from positions.
    pub fn is_derived(&self) -> bool {
        self.rates.is_some()
    }

    /// The uncertainty of the derivative of this order of joint `i` on interval `k`; zero if it is given.
    pub fn error(&self, order: usize, k: usize, i: usize) -> f64 {
        match &self.rates {
            Some(rates) if order > 0 => rates[i].error(k, order),
            _ => 0.0,
        }
    }

    /// Encloses positions, velocities and accelerations on a part of interval `k`, or with [`CAUTION`] at a sample.
    pub fn models(&self, k: usize, part: [f64; 2]) -> [Vec<Model>; 3] {
        let multiple = if part[0] < part[1] { 1.0 } else { CAUTION };
        [0, 1, 2].map(|order| {
            let joints = self.joints[k].iter().enumerate();
            let error = |i: usize| multiple * self.error(order, k, i);
            joints.map(|(i, joint)| joint.model(order, part, error(i))).collect()
        })
    }

    /// The samples, by the intervals that begin there, at which derived rates have samples on both sides.
    pub fn inner(&self) -> impl Iterator<Item = usize> {
        let derived = self.is_derived();
        (2..self.joints.len().saturating_sub(1)).filter(move |_| derived)
    }

    /// The fractions of interval `k` between two times after the start; `None` outside of them.
    pub fn within(&self, k: usize, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
        let [begin, end] = [0.0, 1.0].map(|s| self.time(k, s));
        let share = |t: f64| ((t - begin) / (end - begin)).clamp(0.0, 1.0);
        (from <= end && to >= begin).then(|| [share(from), share(to)])
    }
}

/// The motion through samples of which one may be before a jump of the acceleration and the other after one: without
/// the accelerations that a jump leaves. An acceleration is left by no jump if the motion without it has it.
fn smoothest(whole: Hermite, q: [f64; 2], v: [f64; 2], a: [Option<f64>; 2], interval: f64) -> Hermite {
    let [from, to] = a;
    let others = [[from, None], [None, to], [None, None]];
    let others = others.map(|a| Hermite::new(q, v, a, interval));
    let off = |a: Option<f64>, found: f64| a.map_or(0.0, |a| (a - found).abs());
    if off(to, others[0].at(2, 1.0)) <= JUMP {
        return whole;
    }
    let roughness = |of: &Hermite| {
        let [[least, most], _] = of.bounds(3, [0.0, 1.0]);
        least.abs().max(most.abs())
    };
    let smoother = others.into_iter().reduce(|a, b| if roughness(&b) < roughness(&a) { b } else { a });
    // A jump that is large beside the other changes of the acceleration makes jerks many times as large.
    smoother.filter(|other| 2.0 * roughness(other) < roughness(&whole)).unwrap_or(whole)
}

/// A quantity on a part of an interval.
pub(super) struct Bounded {
    /// The least and the largest values.
    pub hull: [f64; 2],
    /// The values at the beginning, in the middle and at the end with their errors.
    pub values: [[f64; 2]; 3],
}

impl Bounded {
    pub fn of(model: &Model) -> Self {
        let ([c, b, a], variation) = (*model.coefficients(), model.variation());
        Self { hull: [c - variation, c + variation], values: [c - b + a, c, c + b + a].map(|x| [x, model.radius()]) }
    }

    /// The length of a vector.
    pub fn of_length(vector: &Vector3<Model>) -> Self {
        let parts = [vector.x, vector.y, vector.z].map(|model| Self::of(&model));
        let length = |of: [f64; 3]| of[0].hypot(of[1]).hypot(of[2]);
        let largest = parts.each_ref().map(|part| part.hull[0].abs().max(part.hull[1].abs()));
        let values = [0, 1, 2].map(|place| [0, 1].map(|i| length(parts.each_ref().map(|part| part.values[place][i]))));
        let unknown = parts.iter().any(|part| part.hull.iter().any(|bound| bound.is_nan()));
        Self { hull: [0.0, if unknown { f64::NAN } else { length(largest) }], values }
    }
}

/// A quantity with its bounds, unit and place.
pub(super) struct Measured<'a> {
    pub of: Bounded,
    pub bounds: [f64; 2],
    pub unit: &'static str,
    pub place: &'a str,
}

/// The proof of one row.
pub(super) struct Proof<'a> {
    pub row: Row,
    intervals: &'a Intervals,
    /// True if the quantity depends on derived rates.
    pub derived: bool,
    halvings: usize,
}

impl<'a> Proof<'a> {
    pub fn new(row: Row, intervals: &'a Intervals) -> Self {
        Self { row, intervals, derived: intervals.is_derived(), halvings: MAX_HALVINGS }
    }

    /// Takes the values of a quantity on a part of interval `k`. Returns true if nothing more is to be known about it:
    /// all values are within the tolerance, or the row is not passed. Derived rates are certain at inner samples only.
    pub fn settles(
        &mut self,
        k: usize,
        [from, to]: [f64; 2],
        of: &Bounded,
        (bounds, unit): ([f64; 2], &'static str),
        place: impl Fn() -> String,
    ) -> bool {
        let unsure = self.derived && from < to;
        for (s, [value, error]) in [from, 0.5 * (from + to), to].into_iter().zip(of.values) {
            let error = if unsure { f64::INFINITY } else { error };
            let worst = Worst::between(value, bounds, unit, self.intervals.time(k, s));
            self.row.take_within(worst, error, &place);
        }
        let excess = (bounds[0] - of.hull[0]).max(of.hull[1] - bounds[1]);
        // An excess of NaN is not within it.
        self.row.outcome > Outcome::Pass || (excess <= self.row.tolerance && !excess.is_nan())
    }

    /// Halves a part of interval `k` until each is settled. If one is not, the row is undecided, or not checked if that
    /// depends on derived rates.
    pub fn cover(
        &mut self,
        k: usize,
        part: [f64; 2],
        mut settles: impl FnMut(&mut Self, [f64; 2]) -> Result<bool>,
    ) -> Result<()> {
        let mut open = vec![part];
        while let Some([from, to]) = open.pop() {
            if settles(self, [from, to])? {
                continue;
            }
            let middle = 0.5 * (from + to);
            let shortest = if self.derived { MIN_DERIVED } else { 0.0 };
            let last = middle <= from || middle >= to || to - from <= shortest;
            if last || self.halvings == 0 {
                let at_s = self.intervals.time(k, middle);
                self.row.leave(self.derived, at_s);
                return Ok(());
            }
            self.halvings -= 1;
            open.extend([[middle, to], [from, middle]]);
        }
        Ok(())
    }

    /// Proves quantities that enclosures of positions, velocities and accelerations enclose, between two times.
    pub fn enclose<'m>(
        &mut self,
        times: [f64; 2],
        name: impl Fn(&str) -> String,
        mut measure: impl FnMut([&[Model]; 3]) -> Result<Vec<Measured<'m>>>,
    ) -> Result<()> {
        let intervals = self.intervals;
        let mut take = |proof: &mut Self, k: usize, part: [f64; 2]| {
            let [q, v, a] = intervals.models(k, part);
            let mut all = true;
            for Measured { of, bounds, unit, place } in measure([&q, &v, &a])? {
                all &= proof.settles(k, part, &of, (bounds, unit), || name(place));
            }
            Ok(all)
        };
        for k in intervals.inner() {
            if intervals.within(k, times).is_some_and(|[from, _]| from == 0.0) {
                take(self, k, [0.0, 0.0])?;
            }
        }
        for k in 0..intervals.joints.len() {
            if let Some(part) = intervals.within(k, times) {
                self.cover(k, part, |proof, part| take(proof, k, part))?;
            }
        }
        Ok(())
    }
}
