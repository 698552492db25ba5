//! What the tests of the relaxation share.

use aghf::motion::Problem;
use aghf::relax::{RelaxSettings, RelaxSolution, relax};

/// The defaults with another degree.
pub fn degree(p: usize) -> RelaxSettings {
    RelaxSettings {
        degree: p,
        ..Default::default()
    }
}

/// The defaults with segments of this degree.
pub fn size(segments: usize, p: usize) -> RelaxSettings {
    RelaxSettings {
        segments,
        ..degree(p)
    }
}

/// The relaxation of a problem that is valid.
pub fn solved(problem: &Problem<'_>, settings: &RelaxSettings) -> RelaxSolution {
    relax(problem, settings, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"))
}
