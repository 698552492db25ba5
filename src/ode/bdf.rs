//! Stiff systems of ordinary differential equations by variable-order, variable-step BDF.

use super::adapter::{Config, Equations, Method, Problem, State};
use diffsol::NalgebraLU;
use diffsol::error::DiffsolError;

/// diffsol's backward differentiation formulas of variable order 1 to 5 and variable step, with the NDF coefficients.
/// The default.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bdf;

impl Method for Bdf {
    type Solver<'p, 'a: 'p> = diffsol::Bdf<'p, Equations<'a>, NalgebraLU<f64>>;

    fn start<'p, 'a>(
        problem: &'p Problem<'a>,
        state: State<'p, 'a, Self>,
    ) -> Result<Self::Solver<'p, 'a>, DiffsolError> {
        problem.bdf_solver(state)
    }

    fn limit_newton_failures<'p, 'a: 'p>(config: &mut Config<'p, 'a, Self>, limit: usize) {
        config.maximum_newton_fails = limit;
    }
}
