//! Piecewise polynomials with a continuous first derivative.

use super::gauss_legendre;
use super::legendre::legendre;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Polynomials of one degree on equal segments of normalised time $\tau = t / T \in [0, 1]$, joined with continuous
/// value and slope.
///
/// Each breakpoint, both ends included, has two functions, one with unit slope and one with unit value there: the
/// Hermite cubics on both sides. Each segment also has `degree - 3` bubbles, which vanish with their slope at both of
/// its ends: $(1 - s^2)^2 P_n^{(2, 2)}(s)$ on `s` in `[-1, 1]`, scaled. By Rodrigues' formula their second derivatives
/// are Legendre polynomials,
///
/// $$ \frac{d^2}{ds^2} (1 - s^2)^2 P_n^{(2,2)}(s) = 4 (n + 1) (n + 2) P_{n+2}(s), $$
///
/// and they are scaled to have orthonormal second derivatives. These are also orthogonal to those of the cubics, and a
/// smaller degree has fewer bubbles.
///
/// Functions are numbered along time: those of breakpoint 0, the bubbles of segment 0, those of breakpoint 1, and so
/// on, so that segment `e` owns the `degree + 1` functions from `e (degree - 1)` on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Basis {
    segments: usize,
    degree: usize,
    free_final_velocity: bool,
}

/// A configuration and its first two derivatives in normalised time.
pub(crate) type Local = [DVector<f64>; 3];

impl Basis {
    /// The number of segments from which on [`finer`](Self::finer) raises the degree, and the degree up to which it
    /// does.
    const MANY: usize = 16;
    /// The smallest degree with an unknown on a single segment.
    pub(crate) const SMALLEST_DEGREE: usize = 4;

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
        let finer = Self::new(segments, degree, self.free_final_velocity);
        (segments * degree <= largest).then_some(finer)
    }

    /// `segments` segments of degree `degree`, at least 4.
    #[must_use]
    pub fn new(segments: usize, degree: usize, free_final_velocity: bool) -> Self {
        Self {
            segments,
            degree,
            free_final_velocity,
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

    /// Returns true if the slope at the end is unknown.
    #[must_use]
    pub fn free_final_velocity(&self) -> bool {
        self.free_final_velocity
    }

    /// The number of functions, those of the boundary conditions included.
    #[must_use]
    pub fn count(&self) -> usize {
        self.segments * (self.degree - 1) + 2
    }

    /// The functions with unknown coefficients: all but slope and value at the start, value at the end, and slope at
    /// the end unless it is free.
    #[must_use]
    pub fn free(&self) -> Range<usize> {
        2..self.count() - if self.free_final_velocity { 1 } else { 2 }
    }

    /// The first function of segment `e`.
    pub(crate) fn first(&self, e: usize) -> usize {
        e * (self.degree - 1)
    }

    /// Half the length of a segment.
    pub(crate) fn half(&self) -> f64 {
        0.5 / self.segments as f64
    }

    /// The normalised time at `s` in `[-1, 1]` on segment `e`.
    pub(crate) fn time(&self, e: usize, s: f64) -> f64 {
        self.half() * ((2 * e + 1) as f64 + s)
    }

    /// The functions of one segment at `s` in `[-1, 1]`: value, first and second derivative in $\tau$, one column per
    /// function.
    pub(crate) fn local(&self, s: f64) -> DMatrix<f64> {
        let (last, half) = (self.degree, self.half());
        let mut p = vec![0.0; self.degree + 1];
        legendre(s, &mut p);
        let (s2, s3) = (s * s, s * s * s);
        let mut table = DMatrix::zeros(3, self.degree + 1);
        for f in 0..=last {
            let (scale, in_s) = match f {
                0 => (
                    half / 4.0,
                    [1.0 - s - s2 + s3, -1.0 - 2.0 * s + 3.0 * s2, -2.0 + 6.0 * s],
                ),
                1 => (0.25, [2.0 - 3.0 * s + s3, -3.0 + 3.0 * s2, 6.0 * s]),
                _ if f == last - 1 => (
                    half / 4.0,
                    [-1.0 - s + s2 + s3, -1.0 + 2.0 * s + 3.0 * s2, 2.0 + 6.0 * s],
                ),
                _ if f == last => (0.25, [2.0 + 3.0 * s - s3, 3.0 - 3.0 * s2, -6.0 * s]),
                k => {
                    let twice = (2 * k) as f64;
                    let norm = ((twice + 1.0) / 2.0).sqrt();
                    let upper = (p[k + 2] - p[k]) / (twice + 3.0);
                    let lower = (p[k] - p[k - 2]) / (twice - 1.0);
                    let slope = (p[k + 1] - p[k - 1]) / (twice + 1.0);
                    let value = (upper - lower) / (twice + 1.0);
                    (norm * half.powf(1.5), [value, slope, p[k]])
                }
            };
            for (d, x) in in_s.into_iter().enumerate() {
                table[(d, f)] = scale * x / half.powi(d as i32);
            }
        }
        table
    }

    /// Evaluates the curve with these coefficients, `N` by [`count`](Self::count), at a normalised time.
    pub(crate) fn evaluate(&self, coefficients: &DMatrix<f64>, time: f64) -> Local {
        let e = ((time * self.segments as f64) as usize).min(self.segments - 1);
        let s = time / self.half() - (2 * e + 1) as f64;
        let own = coefficients.columns(self.first(e), self.degree + 1);
        let table = self.local(s);
        [0, 1, 2].map(|d| own * table.row(d).transpose())
    }

    /// The coefficients of a curve: value and slope at the breakpoints are interpolated, and between them the second
    /// derivative is the best approximation. Exact for curves in the basis, if the breakpoints of the curve are among
    /// its own.
    pub(crate) fn fit(&self, dof: usize, mut curve: impl FnMut(f64) -> Local) -> DMatrix<f64> {
        let mut coefficients = DMatrix::zeros(dof, self.count());
        for e in 0..=self.segments {
            let [value, slope, _] = curve(e as f64 / self.segments as f64);
            coefficients.set_column(self.first(e), &slope);
            coefficients.set_column(self.first(e) + 1, &value);
        }
        let (nodes, weights) = gauss_legendre(self.degree + 1);
        for (s, weight) in nodes.iter().zip(weights) {
            let table = self.local(*s);
            for e in 0..self.segments {
                let [_, _, second] = curve(self.time(e, *s));
                for k in 2..self.degree - 1 {
                    let by = weight * self.half() * table[(2, k)];
                    coefficients
                        .column_mut(self.first(e) + k)
                        .axpy(by, &second, 1.0);
                }
            }
        }
        coefficients
    }
}
