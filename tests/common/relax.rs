//! Helpers of the tests of the relaxation.

use aghf::constraint::{Constraint, Constraints};
use aghf::motion::Problem;
use aghf::relax::{RelaxSettings, RelaxSolution, Relaxation};

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

/// The relaxation of a valid problem.
pub fn solved(problem: &Problem<'_>, settings: &RelaxSettings) -> RelaxSolution {
    let relaxation = Relaxation::new(problem).settings(settings.clone());
    relaxation.solve().unwrap_or_else(|e| panic!("{e}"))
}

/// The relaxation of a valid problem with constraints.
pub fn solved_within<K: Constraint + Sync>(
    problem: &Problem<'_>,
    settings: &RelaxSettings,
    constraints: &Constraints<K>,
) -> RelaxSolution {
    let relaxation = Relaxation::new(problem).settings(settings.clone());
    let found = relaxation.constraints(constraints).solve();
    found.unwrap_or_else(|e| panic!("{e}"))
}
