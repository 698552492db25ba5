//! Helpers of the tests of the direct method.

use aghf::constraint::{Constraint, Constraints};
use aghf::direct::{Direct, DirectSettings, DirectSolution};
use aghf::motion::Problem;

/// The defaults with another degree.
pub fn degree(p: usize) -> DirectSettings {
    DirectSettings { degree: p, ..Default::default() }
}

/// The defaults with segments of this degree.
pub fn size(segments: usize, p: usize) -> DirectSettings {
    DirectSettings { segments, ..degree(p) }
}

/// The direct method of a valid problem.
pub fn solved(problem: &Problem<'_>, settings: &DirectSettings) -> DirectSolution {
    let direct = Direct::new(problem).settings(settings.clone());
    direct.solve().unwrap_or_else(|e| panic!("{e}"))
}

/// The direct method of a valid problem with constraints.
pub fn solved_within<K: Constraint + Send + Sync>(
    problem: &Problem<'_>,
    settings: &DirectSettings,
    constraints: &Constraints<K>,
) -> DirectSolution {
    let direct = Direct::new(problem).settings(settings.clone());
    let found = direct.constraints(constraints).solve();
    found.unwrap_or_else(|e| panic!("{e}"))
}
