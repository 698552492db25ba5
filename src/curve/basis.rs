//! Piecewise polynomials with continuous derivatives.

use super::hermite::{hermite, legendre_slope};
use super::legendre::legendre;
use nalgebra::DMatrix;

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
    pub(super) segments: usize,
    pub(super) degree: usize,
    pub(super) continuity: Continuity,
}

/// The derivatives that are continuous between segments, and those that are unknown at the ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Continuity {
    /// True if the second derivative is continuous.
    pub acceleration: bool,
    /// True if a continuous second derivative is given at the start, and at the end, as at rest.
    pub fixed_accelerations: [bool; 2],
    /// True if the slope at the end is unknown.
    pub free_final_velocity: bool,
    /// True if the value at the end is unknown.
    pub free_final_position: bool,
    /// True if the slope may jump, as that of a state does; it is then unknown at both ends.
    pub corners: bool,
    /// True if value and slope at the start are unknown.
    pub free_start: bool,
}

impl Continuity {
    /// The continuity of a state $x(t)$ between fixed ends: its rate may jump.
    pub const STATE: Self = Self {
        acceleration: false,
        fixed_accelerations: [false; 2],
        free_final_velocity: false,
        free_final_position: false,
        corners: true,
        free_start: false,
    };

    /// The number of functions per breakpoint.
    pub(crate) fn order(self) -> usize {
        if self.corners { 1 } else { 2 + usize::from(self.acceleration) }
    }

    /// The smallest degree with an unknown on a single segment between fixed ends.
    pub(crate) fn smallest_degree(self) -> usize {
        2 * self.order()
    }
}

/// The functions of one segment at a point, and memory for them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Functions {
    /// Legendre polynomials and their slopes.
    p: Vec<f64>,
    slopes: Vec<f64>,
    /// Value and first three derivatives in normalised time, one column per function, and one row.
    pub table: DMatrix<f64>,
    pub transposed: DMatrix<f64>,
}

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
        Self { segments, degree, continuity }
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

    /// The functions whose coefficients are given velocities at the ends, each with its end, 0 or 1.
    pub(crate) fn fixed_slopes(&self) -> impl Iterator<Item = (usize, usize)> + use<'_> {
        let ends = self.continuity;
        let free = [ends.free_start, ends.free_final_velocity];
        let fixed = [0, 1].into_iter().filter(move |end| !free[*end] && !ends.corners);
        fixed.map(|end| (self.slope(end * self.segments), end))
    }

    /// The functions whose coefficients are given accelerations at the ends, each with its end, 0 or 1.
    pub(crate) fn fixed_accelerations(&self) -> impl Iterator<Item = (usize, usize)> + use<'_> {
        let ends = self.continuity;
        let fixed = [0, 1].into_iter().filter(move |end| ends.acceleration && ends.fixed_accelerations[*end]);
        fixed.map(|end| (self.first(end * self.segments), end))
    }

    /// The functions with unknown coefficients, ascending: all but slope and value at the start and at the end, unless
    /// they are free, and given second derivatives.
    #[must_use]
    pub fn free(&self) -> Vec<usize> {
        let (last, ends) = (self.segments, self.continuity);
        let given: Vec<_> = self.fixed_slopes().chain(self.fixed_accelerations()).map(|(f, _)| f).collect();
        let fixed = [(self.value(0), !ends.free_start), (self.value(last), !ends.free_final_position)];
        let is_free = |f: &usize| !fixed.contains(&(*f, true)) && !given.contains(f);
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
        let mut functions = Functions::default();
        self.functions_in(s, &mut functions);
        functions.table
    }

    /// Computes the functions of one segment at `s` in `[-1, 1]`.
    pub(crate) fn functions_in(&self, s: f64, functions: &mut Functions) {
        let (half, k) = (self.half(), self.continuity.order());
        let Functions { p, slopes, table, transposed } = functions;
        p.resize(self.degree + 1, 0.0);
        legendre(s, p);
        slopes.clear();
        slopes.extend((0..=self.degree).map(|j| legendre_slope(p, j)));
        if table.ncols() != self.degree + 1 {
            *table = DMatrix::zeros(4, self.degree + 1);
            *transposed = DMatrix::zeros(self.degree + 1, 4);
        }
        // The bubble of a continuous slope with second derivative P_j.
        let bubble = |j: usize| {
            let twice = (2 * j) as f64;
            let upper = (p[j + 2] - p[j]) / (twice + 3.0);
            let lower = (p[j] - p[j - 2]) / (twice - 1.0);
            let slope = (p[j + 1] - p[j - 1]) / (twice + 1.0);
            let value = (upper - lower) / (twice + 1.0);
            [value, slope, p[j], slopes[j]]
        };
        for f in 0..=self.degree {
            let (scale, in_s) = if f < k || f + k > self.degree {
                let of_end = (f + 2 * k).saturating_sub(self.degree + 1);
                let index = if f < k { f } else { of_end };
                let (power, in_s) = hermite(k, index, s);
                (half.powi(power as i32), in_s)
            } else if k == 1 {
                let twice = 2.0 * f as f64 + 1.0;
                let value = (p[f + 1] - p[f - 1]) / twice;
                let in_s = [value, p[f], slopes[f], legendre_slope(slopes, f)];
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
        table.transpose_to(transposed);
    }

    /// The segment at a normalised time, with its functions there as by [`local`](Self::local).
    pub(crate) fn functions_at(&self, time: f64) -> (usize, DMatrix<f64>) {
        let mut functions = Functions::default();
        (self.functions_at_in(time, &mut functions), functions.table)
    }

    /// Computes the functions at a normalised time; returns the segment.
    pub(super) fn functions_at_in(&self, time: f64, functions: &mut Functions) -> usize {
        let e = ((time * self.segments as f64) as usize).min(self.segments - 1);
        let s = time / self.half() - (2 * e + 1) as f64;
        self.functions_in(s, functions);
        e
    }
}
