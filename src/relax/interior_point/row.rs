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
    /// One that is not asked for at this point: a polynomial can keep an equality at no more points of a segment than it has coefficients
    /// for itself.
    Idle,
}

impl Kind {
    /// That of a row where it is asked for.
    pub fn of(equality: bool) -> Self {
        if equality {
            Self::Equality
        } else {
            Self::Inequality
        }
    }
}

/// The kinds of the rows at all points, of which there are `segments` times as many as in `collocated`: the points of a segment at which
/// equalities are asked for, and nothing else.
pub(super) fn kinds(equalities: &[bool], collocated: &[bool], segments: usize) -> Vec<Kind> {
    let of_segment = collocated.iter().flat_map(|holds| {
        equalities.iter().map(move |equality| {
            if equality == holds {
                Kind::of(*equality)
            } else {
                Kind::Idle
            }
        })
    });
    let of_segment: Vec<Kind> = of_segment.collect();
    of_segment.repeat(segments)
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
