//! The kinds of the rows at the points.

/// The kind of a row at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Inequality,
    Equality,
    /// Not enforced at this point: a polynomial can satisfy an equality at no more points of a segment than it has
    /// coefficients of its own.
    Idle,
}

impl Kind {
    /// The kind of an enforced row.
    pub fn of(equality: bool) -> Self {
        if equality {
            Self::Equality
        } else {
            Self::Inequality
        }
    }
}

/// The kinds of the rows at all points of `segments` segments; `collocated` marks the points of one segment at which
/// equalities, and no other rows, are enforced.
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
