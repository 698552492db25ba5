//! Stiff systems of ordinary differential equations by an implicit Runge-Kutta method.

use super::adapter::{Config, Equations, Method, Problem, State};
use diffsol::error::DiffsolError;
use diffsol::{NalgebraLU, Sdirk};

/// diffsol's singly diagonally implicit Runge-Kutta method `esdirk34` of order 3 in four stages, the first explicit,
/// L-stable, with variable step. Each step is independent of earlier ones, unlike those of [`Bdf`](super::Bdf).
///
/// The method is implicit because of the flow, whose eigenvalues grow with the penalty: an explicit method such as
/// diffsol's `tsit45` would suffice for the simulation of a robot, but for the flow its steps would be limited by the
/// inverse of the largest eigenvalue.
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
