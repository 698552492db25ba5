//! Polynomials with a bound on their error, vectors of them, and bounds on their values.

use std::ops::{Add, Mul, Neg, Sub};

pub(crate) const UNIT: f64 = f64::EPSILON / 2.0;

pub(crate) const UP: f64 = 1.0 + 1024.0 * UNIT;

pub(crate) const TINY: f64 = f64::MIN_POSITIVE;

/// The assumed error of the sine and the cosine of the platform.
pub(crate) const SIN_COS: f64 = 2.0 * f64::EPSILON;

/// The functions within `r` of the polynomial with the coefficients `c` in s, from -1 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Enclosure<const N: usize> {
    pub(crate) c: [f64; N],
    pub(crate) r: f64,
}

pub(crate) type Ball = Enclosure<1>;

pub(crate) type Tm = Enclosure<10>;

pub(crate) type Vector = [Tm; 3];

pub(crate) type Matrix = [Vector; 3];

impl<const N: usize> Enclosure<N> {
    pub(crate) fn new(x: f64) -> Self {
        Self::within(x, 0.0)
    }
    pub(crate) fn within(x: f64, r: f64) -> Self {
        let mut c = [0.0; N];
        c[0] = x;
        Self { c, r }
    }
    pub(crate) fn size(&self) -> f64 {
        self.c.iter().map(|c| c.abs()).sum()
    }
    pub(crate) fn most(&self) -> f64 {
        (self.size() + self.r) * UP
    }
    pub(crate) fn widened(mut self, by: f64) -> Self {
        self.r = (self.r + by) * UP + TINY;
        self
    }
    pub(crate) fn over(mut self, x: f64) -> Self {
        self.c = self.c.map(|c| c / x);
        self.r /= x.abs();
        self.widened(UNIT * self.size())
    }
    pub(crate) fn scaled(mut self, x: f64) -> Self {
        self.c = self.c.map(|c| c * x);
        self.r *= x.abs();
        self.widened(UNIT * self.size())
    }
    pub(crate) fn turn(mut self) -> (f64, Self) {
        let first = self.c[0];
        self.c[0] = 0.0;
        (first, self)
    }
    pub(crate) fn sin_cos(self) -> (Self, Self) {
        let (first, turn) = self.turn();
        let size = turn.most();
        if !(size <= 1.0 && first.is_finite()) {
            return (Self::within(0.0, 1.0), Self::within(0.0, 1.0));
        }
        let (square, one) = (turn * turn, Self::new(1.0));
        let nested = |odd: f64| {
            (1..=8).rev().fold(one, |sum, k| {
                let n = 2.0 * f64::from(k) + odd;
                one - (square * sum).over(n * (n - 1.0))
            })
        };
        let rest = size.powi(18) / 6e15;
        let (c, s) = (nested(0.0).widened(rest), (turn * nested(1.0)).widened(rest));
        let (sin, cos) = first.sin_cos();
        let (sin, cos) = (Self::within(sin, SIN_COS), Self::within(cos, SIN_COS));
        (sin * c + cos * s, cos * c - sin * s)
    }
    pub(crate) fn inverse_sqrt(self) -> Self {
        let (first, rest) = self.turn();
        let x = rest.over(first);
        let size = x.most();
        if !(size < 0.99 && first > 0.0) {
            return Self::within(0.0, f64::INFINITY);
        }
        let one = Self::new(1.0);
        let series = (1..=16).rev().fold(one, |sum, k| {
            let k = f64::from(k);
            one - (x * sum * Self::new(2.0 * k - 1.0)).over(2.0 * k)
        });
        let series = series.widened(1.01 * size.powi(17) / (1.0 - size));
        // The root is rounded, relative to values of the series of at most 10.
        series.over(first.sqrt()).widened(20.0 * UNIT / first.sqrt())
    }
}
impl<const N: usize> Add for Enclosure<N> {
    type Output = Self;
    fn add(mut self, b: Self) -> Self {
        self.c.iter_mut().zip(b.c).for_each(|(a, b)| *a += b);
        self.widened(b.r + UNIT * self.size())
    }
}
impl<const N: usize> Neg for Enclosure<N> {
    type Output = Self;
    fn neg(mut self) -> Self {
        self.c = self.c.map(|c| -c);
        self
    }
}
impl<const N: usize> Sub for Enclosure<N> {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}
impl<const N: usize> Mul for Enclosure<N> {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let (mut c, mut tail, mut cut) = ([0.0; N], 0.0, 0.0);
        for i in 0..N {
            for j in 0..N - i {
                c[i + j] += self.c[i] * b.c[j];
            }
            cut += self.c[i].abs() * tail;
            tail += b.c[N - 1 - i].abs();
        }
        let size = self.size();
        let errors = (N as f64 + 2.0) * UNIT * size * tail + size * b.r + self.r * (tail + b.r);
        Self { c, r: 0.0 }.widened(cut + errors)
    }
}

pub(crate) fn vector(x: [f64; 3]) -> Vector {
    x.map(Tm::new)
}

pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] + b[i])
}

pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(crate) fn times(a: Vector, k: Tm) -> Vector {
    a.map(|a| a * k)
}

pub(crate) fn dot(a: Vector, b: Vector) -> Tm {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The direction of an axis, with the length one.
pub(crate) fn unit(axis: [f64; 3]) -> Vector {
    let axis = vector(axis);
    times(axis, dot(axis, axis).inverse_sqrt())
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

pub(crate) fn apply(m: Matrix, x: Vector) -> Vector {
    m.map(|row| dot(row, x))
}

pub(crate) fn transpose(m: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

pub(crate) fn product(a: Matrix, b: Matrix) -> Matrix {
    let columns = transpose(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// The rotation about a unit vector by an angle with this sine and cosine.
pub(crate) fn about(a: Vector, (sin, cos): (Tm, Tm)) -> Matrix {
    let versine = Tm::new(1.0) - cos;
    let [x, y, z] = times(a, sin);
    let skew = [[Tm::new(0.0), -z, y], [z, Tm::new(0.0), -x], [-y, x, Tm::new(0.0)]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            // Without the cosine, which would cancel along the axis.
            let one = Tm::new(if i == j { 1.0 } else { 0.0 });
            one + (a[i] * a[j] - one) * versine + skew[i][j]
        })
    })
}

/// The Bernstein coefficients of the powers of s on [-1, 1].
pub(crate) struct Bernstein(Vec<Vec<f64>>);

impl Bernstein {
    pub(crate) fn new(n: usize) -> Self {
        // From s^k of degree m to degree m + 1, with the sign 1, or times s, with -1.
        let raise = |b: &[f64], sign: f64| -> Vec<f64> {
            let m = b.len();
            let at = |i: usize| b.get(i).copied().unwrap_or(0.0);
            let share = |i: usize| i as f64 / m as f64;
            (0..=m).map(|i| share(i) * at(i.wrapping_sub(1)) + sign * share(m - i) * at(i)).collect()
        };
        let (mut power, mut all) = (vec![1.0], Vec::new());
        for k in 0..=n {
            all.push((k..n).fold(power.clone(), |b, _| raise(&b, 1.0)));
            power = raise(&power, -1.0);
        }
        Self(all)
    }

    /// A lower bound on the values, which need not be above `enough`, nor closer than `accuracy` to the least one.
    pub(crate) fn least(&self, c: &[f64], r: f64, enough: f64, accuracy: f64) -> f64 {
        let n = self.0.len() - 1;
        let mut b = vec![0.0; n + 1];
        for (c, power) in c.iter().zip(&self.0) {
            b.iter_mut().zip(power).for_each(|(b, p)| *b += c * p);
        }
        let size: f64 = c.iter().map(|c| c.abs()).sum();
        // The basis, the sums and the averages of 128 halvings, the largest possible number in succession.
        let error = (r + 128.0 * (n + 1) as f64 * f64::EPSILON * size) * UP + TINY;
        let (mut least, mut reached) = (f64::INFINITY, b[0].min(b[n]));
        let (mut open, mut parts) = (vec![b], 1);
        while let Some(mut right) = open.pop() {
            let low = right.iter().copied().fold(f64::INFINITY, f64::min);
            if low - error >= enough || low + accuracy >= reached || parts > 256 {
                least = least.min(low);
                continue;
            }
            let mut left = vec![right[0]];
            for level in 1..=n {
                for i in 0..=n - level {
                    right[i] = 0.5 * (right[i] + right[i + 1]);
                }
                left.push(right[0]);
            }
            reached = reached.min(right[0]).min(right[n]);
            open.extend([left, right]);
            parts += 2;
        }
        // NaN if the error is NaN.
        (least - error).next_down()
    }
}
