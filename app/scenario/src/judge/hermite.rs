//! The motion of a joint between two samples.

use aghf::scalar::TaylorModel;

/// The number of coefficients of a polynomial.
const COUNT: usize = 6;

/// Polynomials of degree two in time with a bound on their error.
pub(super) type Model = TaylorModel<3>;

/// The Hermite polynomial of one joint between two samples, in the fraction `s` of the time between them, from 0 to 1:
/// the one of least degree that has their positions and velocities and those of their accelerations that are given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hermite {
    /// The coefficients of the powers of `s`.
    coefficients: [f64; COUNT],
    /// The time between the samples, s.
    interval: f64,
}

impl Hermite {
    /// The polynomial from positions `q`, velocities `v` and accelerations `a` at both ends, `interval` seconds apart:
    /// a quintic, without one acceleration a quartic, without both a cubic.
    #[must_use]
    pub fn new(q: [f64; 2], v: [f64; 2], a: [Option<f64>; 2], interval: f64) -> Self {
        let v = v.map(|v| v * interval);
        let [way, faster] = [q[1] - q[0] - v[0], v[1] - v[0]];
        let a = a.map(|a| a.map(|a| a * interval * interval));
        let [a, b] = match a {
            [Some(a), Some(b)] => [a, b],
            [Some(a), None] => [a, 6.0 * faster - 12.0 * way + a],
            [None, Some(b)] => [b - 6.0 * faster + 12.0 * way, b],
            [None, None] => [6.0 * way - 2.0 * faster, 4.0 * faster - 6.0 * way],
        };
        let (way, faster, b) = (way - 0.5 * a, faster - a, b - a);
        Self {
            coefficients: [
                q[0],
                v[0],
                0.5 * a,
                10.0 * way - 4.0 * faster + 0.5 * b,
                -15.0 * way + 7.0 * faster - b,
                6.0 * way - 3.0 * faster + 0.5 * b,
            ],
            interval,
        }
    }

    /// The coefficients in `u` of the derivative of this order in time at `s = origin + scale * u`.
    fn derivative(&self, order: usize, [origin, scale]: [f64; 2]) -> [f64; COUNT] {
        let mut c = self.coefficients;
        for _ in 0..order {
            for j in 1..COUNT {
                c[j - 1] = j as f64 * c[j] / self.interval;
            }
            c[COUNT - 1] = 0.0;
        }
        for i in 0..COUNT - 1 {
            for j in (i..COUNT - 1).rev() {
                c[j] += origin * c[j + 1];
            }
        }
        let mut power = 1.0;
        for c in &mut c {
            *c *= power;
            power *= scale;
        }
        c
    }

    /// The derivative of this order in time at `s`: 0 for the position, 1 for the velocity, 2 for the acceleration, 3
    /// for the jerk.
    #[must_use]
    pub fn at(&self, order: usize, s: f64) -> f64 {
        self.derivative(order, [s, 0.0])[0]
    }

    /// The least and the largest Bernstein coefficients of the derivative of this order, up to three, on a part of the
    /// interval, between which its values are, and the values at the ends of the part, the first and the last ones.
    #[must_use]
    pub fn bounds(&self, order: usize, [from, to]: [f64; 2]) -> [[f64; 2]; 2] {
        let mut c = self.derivative(order, [from, to - from]);
        let degree = COUNT - 1 - order;
        // In the Bernstein basis the coefficient i is the sum over j <= i of binom(i, j) / binom(degree, j) c_j: the
        // division first, then the sums of Pascal's triangle.
        let mut binomial = 1.0;
        for (j, c) in c.iter_mut().enumerate().take(degree + 1) {
            *c /= binomial;
            binomial *= (degree - j) as f64 / (j + 1) as f64;
        }
        for i in 0..degree {
            for j in (i..degree).rev() {
                c[j + 1] += c[j];
            }
        }
        let all = &c[..=degree];
        // A minimum would lose NaN.
        let least = all.iter().copied().reduce(|a, b| if a <= b { a } else { b });
        let most = all.iter().copied().reduce(|a, b| if a >= b { a } else { b });
        let hull = [least, most].map(|bound| bound.unwrap_or(f64::NAN));
        [hull, [c[0], c[degree]]]
    }

    /// Encloses the derivative of this order on a part of the interval, as a polynomial on [-1, 1] there, with values
    /// that may be off by `error`.
    pub(super) fn model(&self, order: usize, [from, to]: [f64; 2], error: f64) -> Model {
        let part = [0.5 * (from + to), 0.5 * (to - from)];
        Model::new(&self.derivative(order, part), error)
    }

    /// A bound on the distance of the joint from its position at the middle of `range` anywhere in it: a bound on its
    /// speed there times half of the duration.
    #[must_use]
    pub fn way_from_middle(&self, range: [f64; 2]) -> f64 {
        let [[least, most], _] = self.bounds(1, range);
        let way = least.abs().max(most.abs()) * self.interval * 0.5 * (range[1] - range[0]);
        // After an overflow there is no finite bound.
        if least.is_nan() || most.is_nan() || way.is_nan() { f64::INFINITY } else { way }
    }
}
