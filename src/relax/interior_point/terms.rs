//! The terms of rows in the merit function.

use super::barrier::{Barrier, Term};
use super::equality::Equalities;
use super::row::Kind;
use crate::relax::tuning::FAR;

/// All data on which the term of a row depends.
#[derive(Clone, Copy)]
pub(super) struct Terms<'a> {
    pub barrier: Barrier,
    pub equalities: &'a Equalities,
    /// The kind of each row at each point.
    pub kinds: &'a [Kind],
    /// The value of a row below which its barrier is constant.
    pub floors: &'a [f64],
}

impl Terms<'_> {
    /// The term of row `row` at index `at` for the value `h`; `None` if the row is idle or its barrier constant.
    #[inline]
    pub fn at(&self, at: usize, row: usize, h: f64) -> Option<Term> {
        match self.kinds[at] {
            Kind::Idle => None,
            Kind::Inequality if h < self.floors[row] => None,
            Kind::Inequality if self.floors[row].is_finite() => {
                Some(Term::Fading(self.barrier.split(h), -h / FAR))
            }
            Kind::Inequality => Some(Term::Barrier(self.barrier.split(h))),
            Kind::Equality => Some(self.equalities.term(at, h)),
        }
    }

    /// The value of a barrier beyond its fade-out distance.
    pub fn faded(&self) -> f64 {
        let (value, of_logarithm) = Term::Fading(self.barrier.split(-FAR), 1.0).value();
        value - self.barrier.mu * of_logarithm.ln()
    }
}
