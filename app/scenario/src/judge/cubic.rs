//! The motion between two samples.

/// The Hermite cubic of one joint between two samples, which has their positions and velocities, in the fraction `s` of
/// the time between them, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    /// The coefficients of the powers of `s`.
    coefficients: [f64; 4],
    /// The time between the samples, s.
    interval: f64,
}

impl Cubic {
    /// The cubic from positions `q` and velocities `v` at both ends, `interval` seconds apart.
    #[must_use]
    pub fn new(q: [f64; 2], v: [f64; 2], interval: f64) -> Self {
        let way = q[1] - q[0];
        let [from, to] = v.map(|v| v * interval);
        Self {
            coefficients: [
                q[0],
                from,
                3.0 * way - 2.0 * from - to,
                from + to - 2.0 * way,
            ],
            interval,
        }
    }

    /// The position at `s`.
    #[must_use]
    pub fn position(&self, s: f64) -> f64 {
        let [a, b, c, d] = self.coefficients;
        a + s * (b + s * (c + s * d))
    }

    /// The velocity at `s`.
    #[must_use]
    pub fn velocity(&self, s: f64) -> f64 {
        let [_, b, c, d] = self.coefficients;
        (b + s * (2.0 * c + s * 3.0 * d)) / self.interval
    }

    /// The acceleration at `s`.
    #[must_use]
    pub fn acceleration(&self, s: f64) -> f64 {
        let [_, _, c, d] = self.coefficients;
        (2.0 * c + 6.0 * d * s) / (self.interval * self.interval)
    }

    /// The fraction at which the velocity has its extremum, if that is inside `range`.
    #[must_use]
    pub fn fastest(&self, range: [f64; 2]) -> Option<f64> {
        let [_, _, c, d] = self.coefficients;
        let s = -c / (3.0 * d);
        (s > range[0] && s < range[1]).then_some(s)
    }

    /// The fractions at which the joint reverses between the samples: the zeros of the velocity, each `None` if
    /// outside.
    #[must_use]
    pub fn turns(&self) -> [Option<f64>; 2] {
        let [_, b, c, d] = self.coefficients;
        // 3 d s^2 + 2 c s + b = 0, without cancellation.
        let root = (c * c - 3.0 * b * d).sqrt();
        let sum = -(c + root.copysign(c));
        [sum / (3.0 * d), b / sum].map(|s| (s > 0.0 && s < 1.0).then_some(s))
    }

    /// A bound on the distance of the joint from its position at the middle of `range` anywhere in it: its largest
    /// speed there times half of the duration.
    #[must_use]
    pub fn way_from_middle(&self, range: [f64; 2]) -> f64 {
        let fastest = self.fastest(range).unwrap_or(range[0]);
        let speeds = [range[0], range[1], fastest].map(|s| self.velocity(s).abs());
        // After an overflow there is no finite bound.
        let larger = |most: f64, x: f64| {
            if x.is_nan() {
                f64::INFINITY
            } else {
                most.max(x)
            }
        };
        let speed = speeds.into_iter().fold(0.0, larger);
        speed * self.interval * 0.5 * (range[1] - range[0])
    }
}
