//! The kinds of the rows at the points.

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
