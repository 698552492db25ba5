//! A maximum over time between three values.

/// The fraction of a bracket within which a vertex is too near to the middle to narrow it.
const NEARLY: f64 = 0.05;

/// Three times of which the middle one has the largest value of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bracket {
    pub times: [f64; 3],
    pub values: [f64; 3],
}

impl Bracket {
    /// The number of further values by which a maximum is refined: enough for the corner of an obstacle that is passed
    /// in a tenth of an interval.
    pub const REFINEMENTS: usize = 4;

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
        if height > self.values[end] {
            (time, height)
        } else {
            (self.times[end], self.values[end])
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn refined(f: impl Fn(f64) -> f64, times: [f64; 3]) -> (f64, f64) {
        let values = times.map(&f);
        let mut bracket = Bracket { times, values };
        assert!(bracket.is_valid());
        for _ in 0..Bracket::REFINEMENTS {
            let time = bracket.next();
            assert!(bracket.times[0] < time && time < bracket.times[2]);
            bracket.narrow(time, f(time));
            assert!(bracket.is_valid(), "{bracket:?}");
        }
        bracket.vertex()
    }

    /// A smooth maximum is found to the accuracy of the second parabola, wherever it is between the times.
    #[test]
    fn a_smooth_maximum() {
        for top in [0.55, 0.9, 1.0, 1.3, 1.49] {
            let (time, height) = refined(
                |t| (t - top).cos() + 0.2 * (t - top).powi(3),
                [0.0, 1.0, 2.0],
            );
            assert!((time - top).abs() < 1e-2, "{time} {top}");
            assert!((height - 1.0).abs() < 1e-4, "{height}");
        }
    }

    /// The distance from a corner that is passed in a tenth of an interval, where the first parabola is far off.
    #[test]
    fn a_corner() {
        for top in [0.6, 1.2, 1.4] {
            let f = |t: f64| -((t - top).powi(2) + 0.01_f64).sqrt();
            let first = Bracket {
                times: [0.0, 1.0, 2.0],
                values: [0.0, 1.0, 2.0].map(f),
            };
            let (_, height) = refined(f, first.times);
            let (before, after) = (first.vertex().1 + 0.1, height + 0.1);
            assert!(
                after.abs() < 0.02 && after.abs() < 0.2 * before.abs(),
                "{before} {after}"
            );
        }
    }

    /// A maximum between an end and its neighbour is seen from the end, one beyond it is not.
    #[test]
    fn a_maximum_at_an_end() {
        let of = |top: f64| {
            let times = [0.0, 1.0, 2.0];
            let values = times.map(|t| -(t - top).powi(2));
            Bracket { times, values }
        };
        assert_eq!(of(1.75).at_end(2), (1.75, 0.0));
        assert_eq!(of(0.25).at_end(0), (0.25, 0.0));
        assert_eq!(of(2.5).at_end(2), (2.0, -0.25));
        assert_eq!(of(-1.0).at_end(0), (0.0, -1.0));
    }

    /// A row far below its bound is not refined, one whose neighbours fall steeply is.
    #[test]
    fn maxima_that_may_exceed_a_bound() {
        let of = |values| Bracket {
            times: [0.0, 1.0, 2.0],
            values,
        };
        assert!(!of([-1.1, -1.0, -1.1]).may_exceed(0.0));
        assert!(of([-2.0, -1.0, -1.5]).may_exceed(0.0));
        assert!(!of([1.0, 0.0, -1.0]).is_valid() && !of([f64::NEG_INFINITY, 0.0, -1.0]).is_valid());
    }
}
