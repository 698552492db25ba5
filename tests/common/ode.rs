//! Systems of differential equations for the tests of the integrator.

use aghf::ode::{Bdf, Failure, Integrator, Ode, Statistics, Tolerance};
use nalgebra::DMatrix;

/// A system from two closures that records the largest s evaluated and counts its calls.
pub struct System<F, J> {
    pub dim: usize,
    pub rhs: F,
    pub jacobian: J,
    pub furthest: f64,
    pub calls: usize,
    pub jacobians: usize,
}

pub fn system<F, J>(dim: usize, rhs: F, jacobian: J) -> System<F, J>
where
    F: FnMut(f64, &[f64], &mut [f64]),
    J: FnMut(f64, &[f64], &mut DMatrix<f64>),
{
    System { dim, rhs, jacobian, furthest: f64::NEG_INFINITY, calls: 0, jacobians: 0 }
}

impl<F, J> Ode for System<F, J>
where
    F: FnMut(f64, &[f64], &mut [f64]),
    J: FnMut(f64, &[f64], &mut DMatrix<f64>),
{
    fn dim(&self) -> usize {
        self.dim
    }
    fn rhs(&mut self, s: f64, y: &[f64], dy: &mut [f64]) {
        assert!(y.iter().all(|y| y.is_finite()));
        self.furthest = self.furthest.max(s);
        self.calls += 1;
        (self.rhs)(s, y, dy);
    }
    fn jacobian(&mut self, s: f64, y: &[f64], jac: &mut DMatrix<f64>) {
        assert!(jac.shape() == (self.dim, self.dim) && jac.iter().all(|x| *x == 0.0));
        self.furthest = self.furthest.max(s);
        self.jacobians += 1;
        (self.jacobian)(s, y, jac);
    }
}

pub fn oscillator() -> impl Ode {
    system(2, oscillate, oscillate_jacobian)
}

pub fn oscillate(_s: f64, y: &[f64], dy: &mut [f64]) {
    dy.copy_from_slice(&[y[1], -y[0]]);
}

pub fn oscillate_jacobian(_s: f64, _y: &[f64], jac: &mut DMatrix<f64>) {
    jac[(0, 1)] = 1.0;
    jac[(1, 0)] = -1.0;
}

pub fn both(tolerance: f64) -> Tolerance {
    Tolerance { relative: tolerance, absolute: tolerance }
}

pub type Observed = Vec<(f64, Vec<f64>)>;

pub fn solve(
    system: &mut impl Ode,
    s0: f64,
    y0: &[f64],
    outputs: &[f64],
    tolerance: Tolerance,
) -> (Result<Statistics, Failure>, Observed) {
    solve_by(&mut Bdf, system, s0, y0, outputs, tolerance)
}

pub fn solve_by(
    integrator: &mut dyn Integrator,
    system: &mut impl Ode,
    s0: f64,
    y0: &[f64],
    outputs: &[f64],
    tolerance: Tolerance,
) -> (Result<Statistics, Failure>, Observed) {
    let mut seen = Vec::new();
    let result = integrator.integrate(system, s0, y0, outputs, tolerance, &mut |s, y| {
        seen.push((s, y.to_vec()));
    });
    (result, seen)
}

/// The largest difference from the exact solution over all outputs.
pub fn error(seen: &Observed, exact: impl Fn(f64) -> Vec<f64>) -> f64 {
    let of = |(s, y): &(f64, Vec<f64>)| {
        let pairs = y.iter().zip(exact(*s));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    seen.iter().map(of).fold(0.0, f64::max)
}
