//! Piecewise polynomials with continuous derivatives.

use super::gauss_legendre;
use super::hermite::{hermite, legendre_slope};
use super::legendre::legendre;
use nalgebra::{DMatrix, DVector};

/// Polynomials of one degree on equal segments of normalised time $\tau = t / T \in [0, 1]$, joined with continuous
/// value and slope, with continuous second derivative as well, or with continuous value alone.
///
/// Each breakpoint, both ends included, has `k` functions, each with one unit derivative there: the second derivative
/// if it is continuous (`k` = 3 instead of 2), the slope unless it may jump (`k` = 1), and the value. They are the
/// Hermite polynomials of degree
/// $2 k - 1$ on both sides. Each segment also has `degree + 1 - 2 k` bubbles, which vanish with `k - 1` derivatives at
/// both of its ends. For `k` = 2 they are $(1 - s^2)^2 P_n^{(2, 2)}(s)$ on `s` in `[-1, 1]`, scaled. By Rodrigues'
/// formula their second derivatives are Legendre polynomials,
///
/// $$ \frac{d^2}{ds^2} (1 - s^2)^2 P_n^{(2,2)}(s) = 4 (n + 1) (n + 2) P_{n+2}(s), $$
///
/// and they are scaled to have orthonormal second derivatives. These are also orthogonal to those of the cubics, and a
/// smaller degree has fewer bubbles. For `k` = 3 they are $(1 - s^2)^3 P_n^{(3, 3)}(s)$, with second derivatives
/// $P_{n+2} - P_{n+4}$ of unit norm, orthogonal with the weight $1 / (1 - s^2)$. For `k` = 1 their slopes are the
/// Legendre polynomials $P_1, P_2, \dots$ of unit norm.
///
/// Functions are numbered along time: those of breakpoint 0, the bubbles of segment 0, those of breakpoint 1, and so
/// on, so that segment `e` owns the `degree + 1` functions from `e (degree + 1 - k)` on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Basis {
    segments: usize,
    degree: usize,
    continuity: Continuity,
}

/// The derivatives that are continuous between segments, and those that are unknown at the ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Continuity {
    /// True if the second derivative is continuous.
    pub acceleration: bool,
    /// True if a continuous second derivative is zero at the start, and at the end.
    pub rest: [bool; 2],
    /// True if the slope at the end is unknown.
    pub free_final_velocity: bool,
    /// True if the value at the end is unknown.
    pub free_final_position: bool,
    /// True if the slope may jump, as that of a state does; it is then unknown at both ends.
    pub corners: bool,
}

impl Continuity {
    /// The continuity of a state $x(t)$ between fixed ends: its rate may jump.
    pub const STATE: Self = Self {
        acceleration: false,
        rest: [false; 2],
        free_final_velocity: false,
        free_final_position: false,
        corners: true,
    };

    /// The number of functions per breakpoint.
    pub(crate) fn order(self) -> usize {
        match self.corners {
            true => 1,
            false => 2 + usize::from(self.acceleration),
        }
    }

    /// The smallest degree with an unknown on a single segment between fixed ends.
    pub(crate) fn smallest_degree(self) -> usize {
        2 * self.order()
    }
}

/// A configuration and its first two derivatives in normalised time.
pub(crate) type Local = [DVector<f64>; 3];

impl Basis {
    /// The number of segments from which on [`finer`](Self::finer) raises the degree, and the degree up to which it
    /// does.
    const MANY: usize = 16;

    /// The sequence of degrees from 9 on: powers of two, and those times one and a half.
    pub(crate) fn degrees() -> impl Iterator<Item = usize> {
        let doubling = (4..).flat_map(|i| [1 << i, 3 << (i - 1)]);
        std::iter::once(9).chain(doubling)
    }

    /// The degrees before `degree`, ascending: the lowest, or `degree` if that is lower, then those of the sequence
    /// between.
    pub(crate) fn degrees_below(degree: usize, lowest: usize) -> impl Iterator<Item = usize> {
        let below = Self::degrees().take_while(move |between| *between < degree);
        let above = below.filter(move |between| *between > lowest);
        std::iter::once(degree.min(lowest)).chain(above)
    }

    /// The numbers of segments before `segments`, ascending: each divides the next, so that its breakpoints remain.
    pub(crate) fn fewer_segments(segments: usize) -> impl Iterator<Item = usize> {
        let fewer = |n: &usize| (2..=*n).find(|d| n.is_multiple_of(*d)).map(|d| n / d);
        let mut all: Vec<_> = std::iter::successors(fewer(&segments), fewer).collect();
        all.reverse();
        all.into_iter()
    }

    /// The next finer basis: twice the segments up to [`MANY`](Self::MANY) of them, then a higher degree up to 16, then
    /// twice the segments again. `None` above `largest`, the degree times the number of segments.
    pub(crate) fn finer(&self, largest: usize) -> Option<Self> {
        let (segments, degree) = (self.segments, self.degree);
        let (segments, degree) = if segments < Self::MANY || degree >= Self::MANY {
            (2 * segments, degree)
        } else {
            (segments, (degree + degree / 2).min(Self::MANY))
        };
        let finer = Self::new(segments, degree, self.continuity);
        (segments * degree <= largest).then_some(finer)
    }

    /// `segments` segments of degree `degree`, at least 4, 6 if the second derivative is continuous, or 2 if the slope
    /// may jump.
    #[must_use]
    pub fn new(segments: usize, degree: usize, continuity: Continuity) -> Self {
        Self {
            segments,
            degree,
            continuity,
        }
    }

    /// The number of segments.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// The degree of each segment.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The continuity between segments, and the unknowns at the ends.
    #[must_use]
    pub fn continuity(&self) -> Continuity {
        self.continuity
    }

    /// The number of functions, those of the boundary conditions included.
    #[must_use]
    pub fn count(&self) -> usize {
        self.value(self.segments) + 1
    }

    /// The function with unit value at a breakpoint.
    pub(crate) fn value(&self, breakpoint: usize) -> usize {
        self.first(breakpoint) + self.continuity.order() - 1
    }

    /// The function with unit slope at a breakpoint, where that is continuous.
    pub(crate) fn slope(&self, breakpoint: usize) -> usize {
        self.value(breakpoint) - 1
    }

    /// The functions whose coefficients are given velocities at the ends.
    pub(crate) fn fixed_slopes(&self) -> impl Iterator<Item = usize> + use<> {
        let ends = match self.continuity.corners {
            true => Vec::new(),
            false => vec![self.slope(0), self.slope(self.segments)],
        };
        let fixed = 2 - usize::from(self.continuity.free_final_velocity);
        ends.into_iter().take(fixed)
    }

    /// The functions with unknown coefficients, ascending: all but slope and value at the start, those at the end
    /// unless they are free, and second derivatives at rest.
    #[must_use]
    pub fn free(&self) -> Vec<usize> {
        let (last, ends) = (self.segments, self.continuity);
        let slopes: Vec<_> = self.fixed_slopes().collect();
        let fixed = [
            (self.value(0), true),
            (self.first(0), ends.acceleration && ends.rest[0]),
            (self.value(last), !ends.free_final_position),
            (self.first(last), ends.acceleration && ends.rest[1]),
        ];
        let is_free = |f: &usize| !fixed.contains(&(*f, true)) && !slopes.contains(f);
        (0..self.count()).filter(is_free).collect()
    }

    /// The first function of segment `e`, and of breakpoint `e`.
    pub(crate) fn first(&self, e: usize) -> usize {
        e * (self.degree + 1 - self.continuity.order())
    }

    /// Half the length of a segment.
    pub(crate) fn half(&self) -> f64 {
        0.5 / self.segments as f64
    }

    /// The normalised time at `s` in `[-1, 1]` on segment `e`.
    pub(crate) fn time(&self, e: usize, s: f64) -> f64 {
        self.half() * ((2 * e + 1) as f64 + s)
    }

    /// The functions of one segment at `s` in `[-1, 1]`: value and first three derivatives in $\tau$, one column per
    /// function.
    pub(crate) fn local(&self, s: f64) -> DMatrix<f64> {
        let (half, k) = (self.half(), self.continuity.order());
        let mut p = vec![0.0; self.degree + 1];
        legendre(s, &mut p);
        let slopes: Vec<f64> = (0..=self.degree).map(|j| legendre_slope(&p, j)).collect();
        // The bubble of a continuous slope with second derivative P_j.
        let bubble = |j: usize| {
            let twice = (2 * j) as f64;
            let upper = (p[j + 2] - p[j]) / (twice + 3.0);
            let lower = (p[j] - p[j - 2]) / (twice - 1.0);
            let slope = (p[j + 1] - p[j - 1]) / (twice + 1.0);
            let value = (upper - lower) / (twice + 1.0);
            [value, slope, p[j], slopes[j]]
        };
        let mut table = DMatrix::zeros(4, self.degree + 1);
        for f in 0..=self.degree {
            let (scale, in_s) = if f < k || f + k > self.degree {
                let of_end = (f + 2 * k).saturating_sub(self.degree + 1);
                let index = if f < k { f } else { of_end };
                let (power, in_s) = hermite(k, index, s);
                (half.powi(power as i32), in_s)
            } else if k == 1 {
                let twice = 2.0 * f as f64 + 1.0;
                let value = (p[f + 1] - p[f - 1]) / twice;
                let in_s = [value, p[f], slopes[f], legendre_slope(&slopes, f)];
                ((0.5 * twice).sqrt() * half.sqrt(), in_s)
            } else if k == 2 {
                let norm = ((2.0 * f as f64 + 1.0) / 2.0).sqrt();
                (norm * half.powf(1.5), bubble(f))
            } else {
                let (one, other) = (bubble(f - 1), bubble(f + 1));
                let squares = 2.0 / (2.0 * f as f64 - 1.0) + 2.0 / (2.0 * f as f64 + 3.0);
                let difference = [0, 1, 2, 3].map(|d| one[d] - other[d]);
                (squares.sqrt().recip() * half.powf(1.5), difference)
            };
            for (d, x) in in_s.into_iter().enumerate() {
                table[(d, f)] = scale * x / half.powi(d as i32);
            }
        }
        table
    }

    /// The segment at a normalised time, with its functions there as by [`local`](Self::local).
    pub(crate) fn functions_at(&self, time: f64) -> (usize, DMatrix<f64>) {
        let e = ((time * self.segments as f64) as usize).min(self.segments - 1);
        let s = time / self.half() - (2 * e + 1) as f64;
        (e, self.local(s))
    }

    /// Evaluates the curve with these coefficients, `N` by [`count`](Self::count), at a normalised time.
    pub(crate) fn evaluate(&self, coefficients: &DMatrix<f64>, time: f64) -> Local {
        let (e, table) = self.functions_at(time);
        let own = coefficients.columns(self.first(e), self.degree + 1);
        [0, 1, 2].map(|d| own * table.row(d).transpose())
    }

    /// The coefficients of a curve: the derivatives of the breakpoints are interpolated, and between them the second
    /// derivative is the best approximation, for a continuous second derivative with the weight $1 / (1 - s^2)$, or the
    /// slope if that may jump. Exact for curves in the basis, if the breakpoints of the curve are among its own.
    pub(crate) fn fit(&self, dof: usize, mut curve: impl FnMut(f64) -> Local) -> DMatrix<f64> {
        let mut coefficients = DMatrix::zeros(dof, self.count());
        let k = self.continuity.order();
        for e in 0..=self.segments {
            let [value, slope, second] = curve(e as f64 / self.segments as f64);
            if k > 2 {
                coefficients.set_column(self.first(e), &second);
            }
            if k > 1 {
                coefficients.set_column(self.slope(e), &slope);
            }
            coefficients.set_column(self.value(e), &value);
        }
        let (nodes, weights) = gauss_legendre(self.degree + 1);
        let mut bubbles = DMatrix::zeros(dof, self.count());
        for (s, weight) in nodes.iter().zip(weights) {
            let table = self.local(*s);
            for e in 0..self.segments {
                let [_, slope, second] = curve(self.time(e, *s));
                let (order, mut highest) = match k {
                    1 => (1, slope),
                    _ => (2, second),
                };
                // The second derivatives of cubics are orthogonal to those of the bubbles, as slopes of lines are.
                let mut weight = weight * self.half();
                if k > 2 {
                    let own = coefficients.columns(self.first(e), self.degree + 1);
                    highest -= own * table.row(2).transpose();
                    weight /= 1.0 - s * s;
                }
                for f in k..=self.degree - k {
                    let by = weight * table[(order, f)] / self.weighted_square(f);
                    let mut column = bubbles.column_mut(self.first(e) + f);
                    column.axpy(by, &highest, 1.0);
                }
            }
        }
        coefficients + bubbles
    }

    /// The integral of the square of the highest derivative in [`fit`](Self::fit) of a bubble, with its weight.
    fn weighted_square(&self, f: usize) -> f64 {
        let m = f as f64;
        match self.continuity.order() {
            1 | 2 => 1.0,
            // $P_{m-1} - P_{m+1} = (2 m + 1) (1 - s^2) P_m' / (m (m + 1))$, whose weighted square is that of $P_m'$.
            _ => {
                let unscaled = 2.0 * (2.0 * m + 1.0) / (m * (m + 1.0));
                unscaled / (2.0 / (2.0 * m - 1.0) + 2.0 / (2.0 * m + 3.0))
            }
        }
    }
}
