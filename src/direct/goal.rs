//! A goal that is a set of final configurations.

use crate::constraint::AnyConstraint;
use crate::curve::Curve;
use crate::error::{Error, Result, check_length};
use crate::motion::Problem;

/// A goal that is a set: the final configuration is an unknown, which keeps the rows of one of several alternatives.
#[derive(Clone, Debug)]
pub struct GoalSet {
    /// The constraints on the final configuration, at least one alternative. Their rows are those of
    /// [`Constraint`](crate::constraint::Constraint), at zero velocity.
    pub alternatives: Vec<Vec<AnyConstraint>>,
    /// The first guesses of the final configuration, at least one: start `k` ends at entry `k` modulo their number, and
    /// starts beyond that number are bent. The guesses need not be in the set.
    pub ends: Vec<GoalEnd>,
}

/// A first guess of the final configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct GoalEnd {
    /// The configuration, rad or m, `N` entries.
    pub q: Vec<f64>,
    /// The index of the alternative whose rows are kept.
    pub alternative: usize,
}

impl GoalSet {
    /// The goal with one alternative, that of an end, and this end alone.
    #[must_use]
    pub fn with_end(&self, end: &GoalEnd) -> Self {
        Self {
            alternatives: vec![self.alternatives[end.alternative].clone()],
            ends: vec![GoalEnd { q: end.q.clone(), alternative: 0 }],
        }
    }

    /// The first guess of a start.
    pub(super) fn end(&self, start: usize) -> &GoalEnd {
        &self.ends[start % self.ends.len()]
    }

    /// The alternative of the end next to that of a curve.
    pub(super) fn nearest(&self, curve: &Curve) -> usize {
        let (end, _) = curve.at(curve.horizon());
        let distance = |of: &GoalEnd| {
            let squares = of.q.iter().zip(&end).map(|(a, b)| (a - b) * (a - b));
            squares.sum::<f64>()
        };
        let ends = self.ends.iter();
        let nearest = ends.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(0, |end| end.alternative)
    }

    /// Checks the numbers of entries.
    ///
    /// # Errors
    /// There is no end, an end does not have `N` finite entries, or there is no alternative with its index.
    pub fn check(&self, problem: &Problem<'_>) -> Result<()> {
        let refuse = |condition: String| Err(Error::input("settings", "goal", condition));
        if self.ends.is_empty() {
            return refuse("there is no first guess of the final configuration".to_owned());
        }
        for (i, GoalEnd { q, alternative }) in self.ends.iter().enumerate() {
            check_length("final configuration", problem.model().dof(), q.len())?;
            if !q.iter().all(|q| q.is_finite()) {
                return refuse(format!("a number of end {i} is not finite"));
            }
            if *alternative >= self.alternatives.len() {
                return refuse(format!("end {i} is of alternative {alternative}, which is missing"));
            }
        }
        Ok(())
    }
}
