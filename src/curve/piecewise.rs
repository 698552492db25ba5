//! A curve through states at nodes, evaluated at any time.

use super::Chebyshev;
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DMatrixView, DVector};

/// A curve $x(t)$ of one polynomial, or of several of the same degree on equal segments of the horizon or of each of
/// its parts, through given states at Chebyshev nodes.
///
/// From one segment to the next the state $[q; v]$ is continuous; its derivative, and with it acceleration and control,
/// may jump.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The nodes of a segment of each part.
    parts: Vec<Chebyshev>,
    /// The beginning of each segment, and the end of the last one.
    breakpoints: Vec<f64>,
    /// States, `2 N` by `p + 1` per segment, one column per node.
    x: DMatrix<f64>,
    /// Their derivatives in time.
    xdot: DMatrix<f64>,
}

impl Curve {
    /// Interpolates the columns of `x`, `2 N` by `p + 1`, at the nodes of `chebyshev` by a polynomial.
    ///
    /// # Errors
    /// The number of columns is not the number of nodes, or the number of rows is odd.
    pub fn new(chebyshev: Chebyshev, x: DMatrix<f64>) -> Result<Self> {
        let breakpoints = vec![0.0, chebyshev.horizon()];
        Self::of_segments(vec![chebyshev], breakpoints, x)
    }

    /// Interpolates by `segments` polynomials on equal segments of `[0, horizon]`: `x` is `2 N` by `p + 1` per segment,
    /// the states at the nodes of the first segment, then those of the second, and so on. The last state of a segment
    /// is the first one of the next.
    ///
    /// # Errors
    /// There is no segment; `x` does not have the same number of columns per segment, from 3 to
    /// [`MAX_DEGREE`](Chebyshev::MAX_DEGREE) + 1; its number of rows is odd; the state jumps between segments;
    /// or the horizon is not positive and finite.
    pub fn piecewise(horizon: f64, segments: usize, x: DMatrix<f64>) -> Result<Self> {
        let nodes = x.ncols().checked_div(segments).ok_or_else(|| {
            let condition = "it is 0 and must be at least 1";
            Error::input("curve", "segments", condition)
        })?;
        let chebyshev = Chebyshev::new(nodes.saturating_sub(1), horizon / segments as f64)?;
        let breakpoints = (0..=segments).map(|e| horizon * e as f64 / segments as f64);
        Self::of_segments(vec![chebyshev], breakpoints.collect(), x)?.continuous()
    }

    /// Interpolates by as many polynomials on equal segments of each part of the horizon, whose lengths may differ, in
    /// s; `x` as in [`piecewise`](Self::piecewise).
    ///
    /// # Errors
    /// The parts do not share the segments, or as [`piecewise`](Self::piecewise).
    pub fn in_parts(lengths: &[f64], segments: usize, x: DMatrix<f64>) -> Result<Self> {
        let (count, refuse) = (lengths.len(), |condition| Error::input("curve", "parts", condition));
        if count == 0 || segments == 0 || !segments.is_multiple_of(count) {
            return Err(refuse(format!("there are {count} for {segments} segments")));
        }
        let (degree, own) = ((x.ncols() / segments).saturating_sub(1), segments / count);
        let (mut parts, mut breakpoints, mut begin) = (Vec::new(), vec![0.0], 0.0);
        for length in lengths {
            parts.push(Chebyshev::new(degree, length / own as f64)?);
            breakpoints.extend((1..=own).map(|e| begin + length * e as f64 / own as f64));
            begin += length;
        }
        Self::of_segments(parts, breakpoints, x)?.continuous()
    }

    /// Refuses a state that jumps between segments.
    fn continuous(self) -> Result<Self> {
        let nodes = self.degree() + 1;
        for segment in 1..self.segments() {
            if self.x.column(segment * nodes - 1) != self.x.column(segment * nodes) {
                let condition = format!("the state jumps where segment {segment} begins");
                return Err(Error::input("curve", "x", condition));
            }
        }
        Ok(self)
    }

    fn of_segments(parts: Vec<Chebyshev>, breakpoints: Vec<f64>, x: DMatrix<f64>) -> Result<Self> {
        let nodes = parts[0].degree() + 1;
        crate::error::check_length("x", nodes * (breakpoints.len() - 1), x.ncols())?;
        if x.nrows() % 2 == 1 {
            let condition = "an odd number of rows is no state [q; v]";
            return Err(Error::input("curve", "x", condition));
        }
        let mut xdot = DMatrix::zeros(x.nrows(), x.ncols());
        let of_part = (breakpoints.len() - 1) / parts.len();
        for (part, chebyshev) in parts.iter().enumerate() {
            let d = chebyshev.d().transpose();
            for segment in part * of_part..(part + 1) * of_part {
                let own = x.columns(segment * nodes, nodes);
                xdot.columns_mut(segment * nodes, nodes).copy_from(&(own * &d));
            }
        }
        Ok(Self { parts, breakpoints, x, xdot })
    }

    /// The number of joints `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.x.nrows() / 2
    }

    /// The nodes of a segment, in time from its beginning.
    ///
    /// # Panics
    /// `segment` is out of range.
    #[must_use]
    pub fn chebyshev(&self, segment: usize) -> &Chebyshev {
        &self.parts[segment * self.parts.len() / self.segments()]
    }

    /// The degree `p` of each segment.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.parts[0].degree()
    }

    /// The time of the whole curve if all parts were as long as one, s.
    ///
    /// # Panics
    /// `part` is out of range.
    #[must_use]
    pub fn horizon_of(&self, part: usize) -> f64 {
        let (parts, own) = (self.parts.len(), self.segments() / self.parts.len());
        let [begin, end] = [part, part + 1].map(|k| self.breakpoints[k * own]);
        parts as f64 * (end - begin)
    }

    /// The same shape in another time.
    ///
    /// # Errors
    /// The horizon is not positive and finite.
    pub fn stretched(&self, horizon: f64) -> Result<Self> {
        let (n, mut x) = (self.dof(), self.x.clone());
        x.rows_mut(n, n).scale_mut(self.horizon() / horizon);
        let parts = self.parts();
        if parts == 1 {
            return Self::piecewise(horizon, self.segments(), x);
        }
        let factor = horizon / self.horizon() / parts as f64;
        let lengths: Vec<_> = (0..parts).map(|k| factor * self.horizon_of(k)).collect();
        Self::in_parts(&lengths, self.segments(), x)
    }

    /// The number of parts whose lengths may differ.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// The number of segments.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.breakpoints.len() - 1
    }

    /// The time at which each segment begins, s, and the end of the last one: one more time than segments.
    #[must_use]
    pub fn breakpoints(&self) -> &[f64] {
        &self.breakpoints
    }

    /// The horizon `T` of all segments, in s.
    #[must_use]
    pub fn horizon(&self) -> f64 {
        self.breakpoints[self.segments()]
    }

    /// The states at the nodes, `2 N` by `p + 1` per segment, segment by segment.
    #[must_use]
    pub fn x(&self) -> &DMatrix<f64> {
        &self.x
    }

    /// The coefficients $c_k$ of one segment, `2 N` by `p + 1`: on $[t_e, t_e + h]$ it is
    /// $x(t) = \sum_k c_k T_k(2 (t - t_e) / h - 1)$ with the Chebyshev polynomials $T_k$. Cost O($N p^2$).
    ///
    /// # Panics
    /// `segment` is out of range.
    #[must_use]
    pub fn coefficients(&self, segment: usize) -> DMatrix<f64> {
        self.chebyshev(segment).coefficients(&self.segment(segment).into_owned())
    }

    /// The states at the nodes of one segment, `2 N` by `p + 1`.
    ///
    /// # Panics
    /// `segment` is out of range.
    #[must_use]
    pub fn segment(&self, segment: usize) -> DMatrixView<'_, f64> {
        let nodes = self.degree() + 1;
        self.x.columns(segment * nodes, nodes)
    }

    /// The derivatives in time of the states at the nodes of one segment, `2 N` by `p + 1`.
    ///
    /// # Panics
    /// `segment` is out of range.
    #[must_use]
    pub fn segment_rates(&self, segment: usize) -> DMatrixView<'_, f64> {
        let nodes = self.degree() + 1;
        self.xdot.columns(segment * nodes, nodes)
    }

    /// The segment that contains a time, the later one at a breakpoint.
    #[must_use]
    pub fn segment_at(&self, t: f64) -> usize {
        let inner = &self.breakpoints[1..self.segments()];
        inner.partition_point(|breakpoint| *breakpoint <= t)
    }

    /// Evaluates the state $x = [q; v]$ at time `t` in s and its derivative $\dot x$, of the later segment at a
    /// breakpoint. Cost O(N p).
    #[must_use]
    pub fn at(&self, t: f64) -> (DVector<f64>, DVector<f64>) {
        self.at_in(self.segment_at(t), t)
    }

    /// Evaluates the polynomial of one segment, also at its end.
    ///
    /// # Panics
    /// `segment` is out of range.
    #[must_use]
    pub fn at_in(&self, segment: usize, t: f64) -> (DVector<f64>, DVector<f64>) {
        let nodes = self.degree() + 1;
        let mut weights = DVector::zeros(nodes);
        let own = t - self.breakpoints[segment];
        self.chebyshev(segment).interpolation(own, &mut weights);
        let at = |x: &DMatrix<f64>| x.columns(segment * nodes, nodes) * &weights;
        (at(&self.x), at(&self.xdot))
    }
}
