//! Stiff systems of ordinary differential equations by an implicit Runge-Kutta method.

use super::adapter::{Config, Equations, Method, Problem, State};
use diffsol::error::DiffsolError;
use diffsol::{NalgebraLU, Sdirk};

/// A singly diagonally implicit Runge-Kutta method of order 3 in four stages, the first explicit, L-stable, of variable step: diffsol's
/// `esdirk34`. Each step starts afresh, where [`Bdf`](super::Bdf) looks back on several.
///
/// It is implicit for the sake of the flow, whose eigenvalues grow with the penalty: an explicit method such as diffsol's `tsit45`
/// would do for the simulation of a robot, but would need steps of the inverse of the largest eigenvalue for the flow.
#[derive(Clone, Copy, Debug, Default)]
pub struct Esdirk34;

impl Method for Esdirk34 {
    type Solver<'p, 'a: 'p> = Sdirk<'p, Equations<'a>, NalgebraLU<f64>>;

    fn start<'p, 'a>(
        problem: &'p Problem<'a>,
        state: State<'p, 'a, Self>,
    ) -> Result<Self::Solver<'p, 'a>, DiffsolError> {
        problem.esdirk34_solver(state)
    }

    fn limit_newton_failures<'p, 'a: 'p>(config: &mut Config<'p, 'a, Self>, limit: usize) {
        config.maximum_newton_fails = limit;
    }
}
