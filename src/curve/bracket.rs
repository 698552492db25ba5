//! Maxima over time between values.

use std::array::from_fn;

/// The number of values that are compared at a time.
const LANES: usize = 4;

/// The fraction of a bracket within which a vertex is too close to the middle to narrow the bracket.
const NEARLY: f64 = 0.05;

/// The height of a settled vertex above the middle value, relative to the height of the middle above the lower end. For
/// a parabola whose vertex is within [`NEARLY`] of the middle it is at most a hundredth.
const SETTLED: f64 = 0.02;

/// Three times of which the middle one has the largest value of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bracket {
    pub times: [f64; 3],
    pub values: [f64; 3],
}

impl Bracket {
    /// The number of further values by which a maximum is refined: enough for passing the corner of an obstacle in a
    /// tenth of an interval.
    pub const REFINEMENTS: usize = 4;

    /// The largest number of further values if the vertex does not settle, as beside a step: they halve the bracket
    /// about ten times.
    pub const MAX_REFINEMENTS: usize = 24;

    /// Returns true if a function that is concave between the times may exceed a bound there.
    pub fn may_exceed(&self, bound: f64) -> bool {
        let [a, b, c] = self.values;
        b + (2.0 * b - a - c) > bound
    }

    /// Returns true if the middle value is the largest.
    pub fn is_valid(&self) -> bool {
        let [a, b, c] = self.values;
        a <= b && c <= b && a.is_finite() && c.is_finite()
    }

    /// The vertex of the parabola through the values: time and height.
    pub fn vertex(&self) -> (f64, f64) {
        let ([r, s, t], [a, b, c]) = (self.times, self.values);
        // Of the divided differences in the distance from the middle.
        let (left, right) = ((a - b) / (r - s), (c - b) / (t - s));
        let bend = (right - left) / (t - r);
        let slope = left - bend * (r - s);
        if bend < 0.0 {
            let shift = (-0.5 * slope / bend).clamp(r - s, t - s);
            (s + shift, b + 0.5 * slope * shift)
        } else {
            (s, b)
        }
    }

    /// The maximum next to the first or last of the times, `end` 0 or 2, which has the largest value: time and height.
    pub fn at_end(&self, end: usize) -> (f64, f64) {
        let (time, height) = self.vertex();
        if height > self.values[end] { (time, height) } else { (self.times[end], self.values[end]) }
    }

    /// Returns true if the vertex is only slightly above the middle value, as it is for a smooth maximum once that is
    /// refined, and is not a violation unless the middle is one: beside a step no value would confirm it.
    pub fn is_settled(&self) -> bool {
        let ([a, b, c], (_, height)) = (self.values, self.vertex());
        height - b <= SETTLED * (b - a.min(c)) && (b > 0.0 || height <= 0.0)
    }

    /// The maximum: time and height. It is the vertex if that [is settled](Self::is_settled), otherwise the middle: a
    /// row that is the largest of several functions may have a step between the times, and all its values are then far
    /// below the parabola.
    pub fn maximum(&self) -> (f64, f64) {
        if self.is_settled() { self.vertex() } else { (self.times[1], self.values[1]) }
    }

    /// The next time at which the row is evaluated: the vertex, or the middle of the longer side if that is nearly the
    /// middle time.
    pub fn next(&self) -> f64 {
        let ([r, s, t], (vertex, _)) = (self.times, self.vertex());
        if (vertex - s).abs() > NEARLY * (t - r) {
            vertex
        } else if s - r > t - s {
            0.5 * (r + s)
        } else {
            0.5 * (s + t)
        }
    }

    /// Narrows the bracket by the value at another time in it.
    pub fn narrow(&mut self, time: f64, value: f64) {
        let side = usize::from(time > self.times[1]);
        if value > self.values[1] {
            // The middle becomes the other end.
            (self.times[2 - 2 * side], self.values[2 - 2 * side]) = (self.times[1], self.values[1]);
            (self.times[1], self.values[1]) = (time, value);
        } else {
            (self.times[2 * side], self.values[2 * side]) = (time, value);
        }
    }
}

/// An upper bound of the [`maxima`] of values and of those that [`Bracket::may_exceed`] asks for, computed for many of
/// them side by side.
pub(crate) fn bound(values: &[f64], equality: bool) -> f64 {
    let height = |value: f64| if equality { value.abs() } else { value };
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let mut most = [f64::NEG_INFINITY; LANES];
    let mut rest = values;
    while let Some(near) = rest.first_chunk::<{ LANES + 2 }>() {
        let above: [_; LANES] = from_fn(|k| height(3.0 * near[k + 1] - near[k] - near[k + 2]));
        most = from_fn(|k| larger(most[k], larger(height(near[k]), above[k])));
        rest = &rest[LANES..];
    }
    let windows = rest.windows(3).map(|near| 3.0 * near[1] - near[0] - near[2]);
    let others = rest.iter().copied().chain(windows).map(height);
    most.into_iter().chain(others).fold(f64::NEG_INFINITY, larger)
}

/// The largest of values at successive times, or of their absolute values for an equality, and its position in
/// intervals; then the largest of these and of the maxima of all parabolas through three neighbours: near the middle
/// one, and out to an end at the first and last three.
pub(crate) fn maxima(values: &[f64], equality: bool) -> [(f64, f64); 2] {
    let (mut largest, mut position) = (f64::NEG_INFINITY, 0.0);
    for (k, value) in values.iter().enumerate() {
        let height = if equality { value.abs() } else { *value };
        if height > largest {
            (largest, position) = (height, k as f64);
        }
    }
    let sampled = (largest, position);
    let last = values.len().saturating_sub(3);
    for (k, window) in values.windows(3).enumerate() {
        let sign = if equality { window[1].signum() } else { 1.0 };
        let [a, b, c] = [window[0], window[1], window[2]].map(|value| sign * value);
        let (slope, bend) = (0.5 * (c - a), 2.0 * b - a - c);
        // Within an interval from the middle a parabola is higher by at most half its second difference.
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
    [sampled, (largest, position)]
}
