//! The test of configurations for collisions and limits.

use crate::constraint::{Constraint, Evaluator};
use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::{LANES, Wide};

/// The test whether configurations are free: every row of a constraint is within its bound at `(q, v = 0)`.
#[derive(Debug)]
pub struct Checker<'a, K: ?Sized> {
    constraint: &'a K,
    evaluator: Evaluator<'a, f64, Wide>,
    /// The largest motion of a joint between two checked configurations of a line.
    resolution: f64,
    /// The largest value of each row that counts as free.
    bounds: Vec<f64>,
    scales: Vec<f64>,
    /// $[q; 0]$ of several configurations, and the rows there.
    x: Vec<Wide>,
    g: Vec<Wide>,
    checks: usize,
}

impl<'a, K: Constraint + ?Sized> Checker<'a, K> {
    /// Prepares the test for the rows of `constraint`, with lines checked whenever a joint has moved by `resolution`,
    /// rad or m, which is positive.
    ///
    /// # Errors
    /// The constraint fails at the configuration zero, such as one with another number of joints.
    pub fn new(model: &'a Model, constraint: &'a K, resolution: f64) -> Result<Self> {
        let (rows, zero) = (constraint.dim(), Wide::splat(0.0));
        let mut scales = vec![1.0; rows];
        constraint.row_scales(&mut scales);
        let mut checker = Self {
            constraint,
            evaluator: Evaluator::new(model),
            resolution,
            bounds: vec![0.0; rows],
            scales,
            x: vec![zero; 2 * model.dof()],
            g: vec![zero; rows],
            checks: 0,
        };
        checker.evaluate()?;
        Ok(checker)
    }

    /// Requires every row to be `margin` inside its bound, in its unit, or as far inside as at both `ends` if that is
    /// less.
    ///
    /// # Errors
    /// An end does not have `N` entries.
    pub fn keep(&mut self, margin: f64, ends: [&[f64]; 2]) -> Result<()> {
        for (bound, scale) in self.bounds.iter_mut().zip(&self.scales) {
            *bound = -margin * scale;
        }
        for end in ends {
            self.place(&[end])?;
            for (bound, g) in self.bounds.iter_mut().zip(&self.g) {
                *bound = bound.max(g.0[0]);
            }
        }
        Ok(())
    }

    /// The row that a configuration violates most, and the violation in the unit of the row: negative if all rows are
    /// satisfied. A row that is NaN has an infinite violation; without rows the violation is minus infinity.
    ///
    /// # Errors
    /// `q` does not have `N` entries.
    pub fn worst(&mut self, q: &[f64]) -> Result<(usize, f64)> {
        self.place(&[q])?;
        let mut worst = (0, f64::NEG_INFINITY);
        for (row, (g, scale)) in self.g.iter().zip(&self.scales).enumerate() {
            let by = g.0[0] / scale;
            let by = if by.is_nan() { f64::INFINITY } else { by };
            if by > worst.1 {
                worst = (row, by);
            }
        }
        Ok(worst)
    }

    /// Returns true if a configuration is free.
    ///
    /// # Errors
    /// `q` does not have `N` entries.
    pub fn is_free(&mut self, q: &[f64]) -> Result<bool> {
        self.are_free(&[q])
    }

    /// Returns true if the checked points of the straight line between two configurations, without its beginning, are
    /// free. They are checked in van der Corput order, widely spaced points first, so that collisions are found early.
    ///
    /// # Errors
    /// A configuration does not have `N` entries.
    pub fn is_line_free(&mut self, from: &[f64], to: &[f64]) -> Result<bool> {
        let moves = from.iter().zip(to).map(|(a, b)| (b - a).abs());
        let steps = (moves.fold(0.0, f64::max) / self.resolution)
            .ceil()
            .max(1.0) as usize;
        let bits = steps.next_power_of_two().trailing_zeros();
        let reversed = |i: usize| {
            i.reverse_bits()
                .checked_shr(usize::BITS - bits)
                .unwrap_or(0)
        };
        let order = (0..1 << bits).map(reversed).filter(|k| *k < steps);
        // The end first, because it is most often not free.
        let mut shares = order.map(|k| (steps - k) as f64 / steps as f64).peekable();
        while shares.peek().is_some() {
            let mut count = 0;
            let mut last = 1.0;
            for lane in 0..LANES {
                if let Some(share) = shares.next() {
                    (last, count) = (share, lane + 1);
                }
                for ((x, a), b) in self.x.iter_mut().zip(from).zip(to) {
                    x.0[lane] = a + last * (b - a);
                }
            }
            self.checks += count;
            self.evaluate()?;
            if !self.all_kept() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns true if all configurations are free.
    ///
    /// # Errors
    /// A configuration does not have `N` entries.
    pub fn are_free<Q: AsRef<[f64]>>(&mut self, all: &[Q]) -> Result<bool> {
        for some in all.chunks(LANES) {
            self.place(some)?;
            if !self.all_kept() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The number of configurations checked so far.
    #[must_use]
    pub fn checks(&self) -> usize {
        self.checks
    }

    /// Evaluates the rows at one to four configurations; unused lanes hold the last one.
    fn place<Q: AsRef<[f64]>>(&mut self, some: &[Q]) -> Result<()> {
        let n = self.x.len() / 2;
        for lane in 0..LANES {
            let q = some[lane.min(some.len() - 1)].as_ref();
            check_length("q", n, q.len())?;
            for (x, q) in self.x.iter_mut().zip(q) {
                x.0[lane] = *q;
            }
        }
        self.checks += some.len();
        self.evaluate()
    }

    fn evaluate(&mut self) -> Result<()> {
        let placed = self.evaluator.at(&self.x)?;
        placed.value(self.constraint, &mut self.g)
    }

    fn all_kept(&self) -> bool {
        let mut rows = self.g.iter().zip(&self.bounds);
        // False for NaN.
        rows.all(|(g, bound)| g.0.iter().all(|g| g <= bound))
    }
}
