//! A motion as exact polynomials on parts of its segments.

use crate::curve::Curve;
use crate::dynamics::{Data, rnea};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::scalar::{Ball, TaylorModel, Zero};

/// The number of coefficients of enclosures of torques.
pub const ORDER: usize = 9;

/// The number of steps from zero to one on which the ends of intervals are, so that middles and halves are exact.
const STEPS: f64 = (1_u64 << 40) as f64;

/// A polynomial in $s \in [-1, 1]$ and a bound on the error of its values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polynomial {
    /// The coefficients, from degree zero.
    pub coefficients: Vec<f64>,
    /// The bound.
    pub radius: f64,
}

/// An interval of time in a segment: $|x - m| \le w$ where `x` goes from -1 to 1 over the segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The index of the segment.
    pub segment: usize,
    /// The middle `m`.
    pub middle: f64,
    /// The half width `w`.
    pub half: f64,
}

/// The piecewise polynomial motion $q(t)$ with given Chebyshev coefficients, exactly.
#[derive(Clone, Debug)]
pub struct Motion {
    horizon: f64,
    degree: usize,
    /// Per segment, joint and `k`, the Chebyshev coefficients of the `k`-th derivative in `x` over $k!$.
    derivatives: Vec<Vec<Vec<Vec<Ball>>>>,
}

/// A motion on a part: polynomials in $s$, one for each of `N` joints.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Positions, rad or m.
    pub q: Vec<Polynomial>,
    /// Velocities, per s.
    pub v: Vec<Polynomial>,
    /// Accelerations, per s^2.
    pub a: Vec<Polynomial>,
    /// Jerks, per s^3.
    pub jerk: Vec<Polynomial>,
}

impl Part {
    /// A whole segment.
    #[must_use]
    pub fn whole(segment: usize) -> Self {
        Self { segment, middle: 0.0, half: 1.0 }
    }

    /// A short interval about a place. At both ends of a segment Chebyshev polynomials are exact, so that a [`Piece`]
    /// is as accurate at its middle as the coefficients allow.
    #[must_use]
    pub fn about(segment: usize, x: f64) -> Self {
        Self { segment, middle: x, half: 1.0 / f64::from(1 << 20) }
    }

    /// The parts before and after a place between its ends, rounded down to a multiple of $2^{-40}$.
    #[must_use]
    pub fn split(self, x: f64) -> [Self; 2] {
        let ([from, to], x) = (self.ends(), (x * STEPS).floor() / STEPS);
        [[from, x], [x, to]].map(|[from, to]| Self { middle: 0.5 * (from + to), half: 0.5 * (to - from), ..self })
    }

    /// The ends, `x` from -1 to 1.
    #[must_use]
    pub fn ends(self) -> [f64; 2] {
        [self.middle - self.half, self.middle + self.half]
    }
}

impl Polynomial {
    /// The polynomial with coefficients in these intervals.
    fn of(balls: &[Ball]) -> Self {
        let radii: Ball = balls.iter().map(|b| Ball::constant(b.radius())).fold(Ball::zero(), |sum, r| sum + r);
        Self { coefficients: balls.iter().map(|b| b.coefficients()[0]).collect(), radius: radii.magnitude() }
    }

    /// The polynomial cut to `N` coefficients.
    #[must_use]
    pub fn model<const N: usize>(&self) -> TaylorModel<N> {
        TaylorModel::new(&self.coefficients, self.radius)
    }

    /// The value at `s = 0`.
    #[must_use]
    pub fn middle(&self) -> Ball {
        let value = self.coefficients.first().copied().unwrap_or_default();
        Ball::new(&[value], self.radius)
    }
}

impl<const N: usize> From<TaylorModel<N>> for Polynomial {
    fn from(of: TaylorModel<N>) -> Self {
        Self { coefficients: of.coefficients().to_vec(), radius: of.radius() }
    }
}

impl Motion {
    /// The motion of a curve: its positions. Cost O(N p^2) per segment.
    ///
    /// # Errors
    /// The curve has parts of different lengths, each of which has a certificate of its own.
    pub fn of_curve(curve: &Curve) -> Result<Self> {
        if curve.parts() > 1 {
            let condition = format!("it has {} parts, one is certified at a time", curve.parts());
            return Err(Error::input("motion", "curve", condition));
        }
        let segment = |e| {
            let all = curve.coefficients(e);
            (0..curve.dof()).map(|i| all.row(i).iter().copied().collect()).collect()
        };
        let coefficients: Vec<_> = (0..curve.segments()).map(segment).collect();
        let (horizon, degree) = (curve.horizon(), curve.degree());
        Ok(Self::of_coefficients(horizon, degree, &coefficients))
    }

    /// The motion with these coefficients per segment and joint, `p + 1` each.
    ///
    /// # Errors
    /// There is no segment, a list has another length than the first one, or a number is not finite.
    pub fn new(horizon: f64, coefficients: &[Vec<Vec<f64>>]) -> Result<Self> {
        let refuse = |condition: &str| Err(Error::input("motion", "coefficients", condition));
        let Some(first) = coefficients.first() else {
            return refuse("there is no segment");
        };
        let length = first.first().map_or(0, Vec::len);
        let same = |segment: &Vec<Vec<f64>>| segment.len() == first.len() && segment.iter().all(|c| c.len() == length);
        if length == 0 || !coefficients.iter().all(same) {
            return refuse("each segment and joint needs the same number of coefficients");
        }
        let mut all = coefficients.iter().flatten().flatten();
        if !(horizon.is_finite() && horizon > 0.0 && all.all(|c| c.is_finite())) {
            return refuse("finite numbers and a positive horizon are needed");
        }
        Ok(Self::of_coefficients(horizon, length - 1, coefficients))
    }

    fn of_coefficients(horizon: f64, degree: usize, coefficients: &[Vec<Vec<f64>>]) -> Self {
        let joint = |c: &Vec<f64>| {
            let mut all = vec![c.iter().map(|c| Ball::constant(*c)).collect::<Vec<_>>()];
            for k in 1..=degree {
                all.push(derivative(&all[k - 1], k));
            }
            all
        };
        Self { horizon, degree, derivatives: coefficients.iter().map(|all| all.iter().map(joint).collect()).collect() }
    }

    /// The Chebyshev coefficients of the derivative of each position in `x` on a segment, `p` each.
    ///
    /// # Panics
    /// `segment` is out of range.
    #[must_use]
    pub fn rates(&self, segment: usize) -> Vec<&[Ball]> {
        let joints = self.derivatives[segment].iter();
        joints.map(|derivatives| derivatives[1].as_slice()).collect()
    }

    /// The number of segments.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.derivatives.len()
    }

    /// The degree `p` of positions.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The horizon `T`, s.
    #[must_use]
    pub fn horizon(&self) -> f64 {
        self.horizon
    }

    /// The time, s, rounded, at `s` of a part.
    #[must_use]
    pub fn time(&self, part: Part, s: f64) -> f64 {
        let within = 0.5 * (1.0 + part.middle + part.half * s);
        (part.segment as f64 + within) * self.horizon / self.segments() as f64
    }

    /// The motion on a part: $\sum_k s^k w^k q^{(k)}(m) / k!$, and its derivatives. Cost O(N p^2).
    ///
    /// # Panics
    /// The segment of the part does not exist.
    #[must_use]
    pub fn piece(&self, part: Part) -> Piece {
        let at_middle = chebyshev(part.middle, self.degree);
        let expand = |derivatives: &Vec<Vec<Ball>>| -> Vec<Ball> {
            let sum = |c: &Vec<Ball>| {
                let terms = c.iter().zip(&at_middle).map(|(c, t)| *c * *t);
                terms.fold(Ball::zero(), |sum, term| sum + term)
            };
            let mut power = Ball::constant(1.0);
            let mut expanded = Vec::with_capacity(derivatives.len());
            for c in derivatives {
                expanded.push(sum(c) * power);
                power *= Ball::constant(part.half);
            }
            expanded
        };
        let segments = Ball::constant(2.0 * self.segments() as f64);
        let rate = segments.divided_by(self.horizon).divided_by(part.half);
        let differentiate = |of: &Vec<Ball>| -> Vec<Ball> {
            let terms = of.iter().enumerate().skip(1);
            terms.map(|(k, c)| *c * Ball::constant(k as f64) * rate).collect()
        };
        let mut all: Vec<_> = self.derivatives[part.segment].iter().map(expand).collect();
        let [q, v, a, jerk] = std::array::from_fn(|order| {
            if order > 0 {
                all = all.iter().map(differentiate).collect();
            }
            all.iter().map(|balls| Polynomial::of(balls)).collect()
        });
        Piece { q, v, a, jerk }
    }
}

/// The Chebyshev coefficients of the derivative, divided by `k`.
fn derivative(of: &[Ball], k: usize) -> Vec<Ball> {
    let n = of.len() - 1;
    let mut found = vec![Ball::zero(); n + 2];
    for j in (1..=n).rev() {
        found[j - 1] = found[j + 1] + of[j] * Ball::constant(2.0 * j as f64);
    }
    found.truncate(n);
    if let Some(first) = found.first_mut() {
        *first = first.divided_by(2.0);
    }
    found.iter().map(|c| c.divided_by(k as f64)).collect()
}

/// The Chebyshev polynomials up to degree `n` at `x`, by the formulas for products, whose errors grow only with the
/// square of the degree.
fn chebyshev(x: f64, n: usize) -> Vec<Ball> {
    let x = Ball::constant(x);
    let one = Ball::constant(1.0);
    let mut all = vec![one, x];
    for j in 2..=n {
        let product = all[j / 2] * all[j - j / 2];
        let less = if j % 2 == 0 { one } else { x };
        all.push(product + product - less);
    }
    all
}

impl Piece {
    /// The motion with positions that deviate by at most `by`, rad or m, for each joint by itself.
    #[must_use]
    pub fn widened(&self, by: f64) -> Self {
        let mut wide = self.clone();
        for position in &mut wide.q {
            let sum = Ball::constant(position.radius) + Ball::constant(by);
            position.radius = sum.magnitude();
        }
        wide
    }

    /// Encloses positions, velocities and accelerations.
    #[must_use]
    pub fn models(&self) -> [Vec<TaylorModel<ORDER>>; 3] {
        [&self.q, &self.v, &self.a].map(|all| all.iter().map(Polynomial::model).collect())
    }

    /// Encloses the torques of inverse dynamics, `N` entries, N m or N. `data` is scratch. Cost O(N).
    ///
    /// # Errors
    /// The model has another number of joints.
    pub fn torques(&self, model: &Model, data: &mut Data<TaylorModel<ORDER>>) -> Result<Vec<TaylorModel<ORDER>>> {
        let [q, v, a] = self.models();
        let mut torques = vec![TaylorModel::zero(); model.dof()];
        rnea(model, data, &q, &v, &a, &mut torques)?;
        Ok(torques)
    }
}
