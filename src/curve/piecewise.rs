//! A curve through the nodes, at any time.

use super::Chebyshev;
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DMatrixView, DVector};

/// A curve $x(t)$ of one polynomial, or of several of the same degree on equal parts of the horizon, through given states at
/// Chebyshev nodes.
///
/// From one part to the next the state $[q; v]$ is continuous; its derivative, and with it acceleration and control, may jump.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The nodes of a part.
    chebyshev: Chebyshev,
    /// Where each part begins, and the end.
    joints: Vec<f64>,
    /// `2 N` by `p + 1` a part: states, one column a node.
    x: DMatrix<f64>,
    /// Their derivatives in time.
    xdot: DMatrix<f64>,
}

impl Curve {
    /// The polynomial through the columns of `x`, `2 N` by `p + 1`, at the nodes of `chebyshev`.
    ///
    /// # Errors
    /// `x` does not have a column for each node, or has an odd number of rows.
    pub fn new(chebyshev: Chebyshev, x: DMatrix<f64>) -> Result<Self> {
        let joints = vec![0.0, chebyshev.horizon()];
        Self::of_parts(chebyshev, joints, x)
    }

    /// `pieces` polynomials on equal parts of `[0, horizon]`: `x` is `2 N` by `p + 1` a part, the states at the nodes of the first
    /// part, then those of the second, and so on. The last state of a part is the first one of the next.
    ///
    /// # Errors
    /// There is no part, or `x` does not have as many columns for each, at least 3 and at most
    /// [`LARGEST_DEGREE`](Chebyshev::LARGEST_DEGREE) + 1; it has an odd number of rows, or the state jumps from one part to the
    /// next; the horizon is not positive and finite.
    pub fn piecewise(horizon: f64, pieces: usize, x: DMatrix<f64>) -> Result<Self> {
        let nodes = x.ncols().checked_div(pieces).ok_or_else(|| {
            let condition = "it is 0, at least 1 is needed";
            Error::input("curve", "pieces", condition)
        })?;
        let chebyshev = Chebyshev::new(nodes.saturating_sub(1), horizon / pieces as f64)?;
        let joints = (0..=pieces).map(|e| horizon * e as f64 / pieces as f64);
        let curve = Self::of_parts(chebyshev, joints.collect(), x)?;
        for part in 1..pieces {
            if curve.x.column(part * nodes - 1) != curve.x.column(part * nodes) {
                let condition = format!("the state jumps where part {part} begins");
                return Err(Error::input("curve", "x", condition));
            }
        }
        Ok(curve)
    }

    fn of_parts(chebyshev: Chebyshev, joints: Vec<f64>, x: DMatrix<f64>) -> Result<Self> {
        let nodes = chebyshev.degree() + 1;
        crate::error::check_length("x", nodes * (joints.len() - 1), x.ncols())?;
        if x.nrows() % 2 == 1 {
            let condition = "an odd number of rows is no state [q; v]";
            return Err(Error::input("curve", "x", condition));
        }
        let mut xdot = DMatrix::zeros(x.nrows(), x.ncols());
        let d = chebyshev.d().transpose();
        for part in 0..joints.len() - 1 {
            let own = x.columns(part * nodes, nodes);
            xdot.columns_mut(part * nodes, nodes).copy_from(&(own * &d));
        }
        Ok(Self {
            chebyshev,
            joints,
            x,
            xdot,
        })
    }

    /// `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.x.nrows() / 2
    }

    /// The nodes of a part, whose own time begins at zero.
    #[must_use]
    pub fn chebyshev(&self) -> &Chebyshev {
        &self.chebyshev
    }

    /// How many parts there are.
    #[must_use]
    pub fn pieces(&self) -> usize {
        self.joints.len() - 1
    }

    /// Where each part begins, s, and where the last one ends: one time more than there are parts.
    #[must_use]
    pub fn joints(&self) -> &[f64] {
        &self.joints
    }

    /// `T`, in s, all parts together.
    #[must_use]
    pub fn horizon(&self) -> f64 {
        self.joints[self.pieces()]
    }

    /// The states at the nodes, `2 N` by `p + 1` a part, part by part.
    #[must_use]
    pub fn x(&self) -> &DMatrix<f64> {
        &self.x
    }

    /// The states at the nodes of one part, `2 N` by `p + 1`.
    ///
    /// # Panics
    /// There is no such part.
    #[must_use]
    pub fn part(&self, part: usize) -> DMatrixView<'_, f64> {
        let nodes = self.chebyshev.degree() + 1;
        self.x.columns(part * nodes, nodes)
    }

    /// The part that a time belongs to: the later one of two that meet there.
    #[must_use]
    pub fn part_at(&self, t: f64) -> usize {
        let inner = &self.joints[1..self.pieces()];
        inner.partition_point(|joint| *joint <= t)
    }

    /// The state $x = [q; v]$ at time `t` in s and its derivative $\dot x$; where two parts meet, that of the later one.
    /// Cost O(N p).
    #[must_use]
    pub fn at(&self, t: f64) -> (DVector<f64>, DVector<f64>) {
        self.at_of(self.part_at(t), t)
    }

    /// The same by the polynomial of one part, which at its end is not yet that of the next.
    ///
    /// # Panics
    /// There is no such part.
    #[must_use]
    pub fn at_of(&self, part: usize, t: f64) -> (DVector<f64>, DVector<f64>) {
        let nodes = self.chebyshev.degree() + 1;
        let mut weights = DVector::zeros(nodes);
        let own = t - self.joints[part];
        self.chebyshev.interpolation(own, &mut weights);
        let at = |x: &DMatrix<f64>| x.columns(part * nodes, nodes) * &weights;
        (at(&self.x), at(&self.xdot))
    }
}
