//! What the rows at the points are, and where a step takes them.

use crate::relax::tuning::SMALLEST_RELAXATION;

/// A share of a step from one iterate to another.
///
/// Slacks are iterates of their own: along a step they change evenly, from what they were to what the rows leave after the whole of it.
/// Where a row leaves less than that at the end of the share, the difference is its relaxation; where it leaves more that is taken.
#[derive(Clone, Debug, Default)]
pub(super) struct Trial {
    /// The rows before the step, and after the whole of it.
    pub before: Vec<f64>,
    pub whole: Vec<f64>,
    pub share: f64,
    /// The relaxations that the share leads to, and what they cost at the price of an excess.
    pub relaxations: Vec<f64>,
    pub price: f64,
}

/// The kind of a row at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Inequality,
    Equality,
    /// An equality where none is asked for: a polynomial can keep it at no more points of a segment than it has free coefficients.
    Idle,
}

/// The kinds of the rows at all points, with as many `collocated` points of each segment as equalities hold at.
pub(super) fn kinds(
    equalities: &[bool],
    points: usize,
    per_segment: usize,
    collocated: usize,
) -> Vec<Kind> {
    let collocated = collocated.clamp(1, per_segment);
    let chosen = (0..collocated).map(|k| (2 * k + 1) * per_segment / (2 * collocated));
    let chosen: Vec<usize> = chosen.collect();
    let at_point = |g: usize| {
        let holds = chosen.contains(&(g % per_segment));
        equalities
            .iter()
            .map(move |equality| match (equality, holds) {
                (false, _) => Kind::Inequality,
                (true, true) => Kind::Equality,
                (true, false) => Kind::Idle,
            })
    };
    (0..points).flat_map(at_point).collect()
}

impl Trial {
    /// A row less its relaxation, of what it is with its margin.
    pub fn row(&mut self, at: usize, raw: f64) -> f64 {
        let before = self.before[at];
        let even = before + self.share * (self.whole[at] - before);
        let h = if before < 0.0 && even < 0.0 {
            raw.min(even.max(0.01 * before))
        } else {
            raw
        };
        let relaxation = raw - h;
        self.relaxations[at] = if relaxation < SMALLEST_RELAXATION {
            0.0
        } else {
            relaxation
        };
        raw - self.relaxations[at]
    }
}
