//! The public checks find derivatives that are wrong by ten times the bound, in a single place or at a single state.

use crate::common::robot;
use aghf::Result;
use aghf::constraint::{Constraint, PlacedState, WeightedDerivatives, Weights};
use aghf::cost::{HyperDual64, RunningCost, StageDerivatives, StageInput};
use aghf::flow::Node;
use aghf::flow::jacobian::{ControlFormJacobian, NodeBlocks, NodeJacobian};
use aghf::scalar::AlgebraOver;
use aghf::verify::duals::{CheckOptions, Finding, check_all, check_constraint, check_jacobian, check_running_cost};

/// Ten times the bound that the documentation states.
const WRONG: f64 = 1.0 + 1e-8;

fn options(samples: usize) -> CheckOptions {
    CheckOptions { samples, penalties: vec![1.0], ..CheckOptions::default() }
}

fn off(findings: &[Finding]) -> Vec<&str> {
    let off = findings.iter().filter(|f| !f.passes());
    off.map(|f| f.quantity.as_str()).collect()
}

/// $g = x_1^2$ with its first and second derivative multiplied by these numbers.
struct Square([f64; 2]);

impl Constraint for Square {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> Result<()> {
        g[0] = at.x[0] * at.x[0];
        Ok(())
    }

    fn add_weighted_derivatives<S: AlgebraOver<f64>>(
        &self,
        at: &PlacedState<'_, f64, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let (w, c) = (weights.first_order[0], weights.gauss_newton.map_or(S::zero(), |c| c[0]));
        let by_x = at.x[0].scale(2.0);
        let [first, second] = [w * by_x, w.scale(2.0) + c * by_x * by_x];
        out.add_entry(0, first.scale(self.0[0]), second.scale(self.0[1]));
        Ok(())
    }
}

#[test]
fn a_wrong_derivative_of_a_constraint_is_found() {
    let model = robot("pendulum_2");
    let check = |factors| check_constraint(&model, "square", &Square(factors), &options(2)).expect("same robot");
    assert!(off(&check([1.0, 1.0])).is_empty());
    assert_eq!(off(&check([1.0, WRONG])), ["square: weighted Hessian"]);
    let [gradient, hessian] = ["square: weighted gradient", "square: weighted Hessian"];
    // The Hessian is compared with dual numbers of the gradient.
    assert_eq!(off(&check([WRONG, 1.0])), [gradient, hessian]);
    assert_eq!(off(&check([WRONG, WRONG])), [gradient]);
}

/// The square of the first velocity, small compared with one; value alone, value with derivatives, gradient and Hessian
/// are multiplied by these numbers.
struct Small([f64; 4]);

impl RunningCost for Small {
    fn value(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        Ok(self.0[0] * 1e-3 * at.v[0] * at.v[0])
    }

    fn derivatives(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> Result<f64> {
        let (entry, v) = (at.q.len(), at.v[0]);
        out.gradient[entry] = self.0[2] * 2e-3 * v;
        out.hessian[(entry, entry)] = self.0[3] * 2e-3;
        Ok(self.0[1] * 1e-3 * v * v)
    }
}

#[test]
fn a_wrong_derivative_of_a_running_cost_is_found() {
    let model = robot("pendulum_2");
    let truth = |at: &StageInput<'_, HyperDual64>| at.v[0] * at.v[0] * 1e-3;
    let check = |factors| check_running_cost(&model, "small", &Small(factors), truth, &options(2)).expect("same robot");
    assert!(off(&check([1.0; 4])).is_empty());
    for (place, what) in ["value", "value", "gradient", "Hessian"].into_iter().enumerate() {
        let mut factors = [1.0; 4];
        factors[place] = WRONG;
        assert_eq!(off(&check(factors)), [format!("small: {what}")]);
    }
}

/// A Jacobian that is wrong at one of several states.
struct WrongOnce<'m>(ControlFormJacobian<'m, f64, f64>, usize);

impl NodeJacobian for WrongOnce<'_> {
    fn evaluate(&mut self, node: Node<'_, f64>, k: f64, out: &mut NodeBlocks) -> Result<()> {
        self.0.evaluate(node, k, out)?;
        if self.1 == 1 {
            out.dx[(0, 0)] += out.dx.amax();
        }
        self.1 += 1;
        Ok(())
    }
}

#[test]
fn the_worst_state_is_kept() {
    let model = robot("pendulum_2");
    let jacobian = &mut WrongOnce(ControlFormJacobian::new(&model), 0);
    let findings = check_jacobian(&model, "once", jacobian, &options(3)).expect("same robot");
    assert_eq!(off(&findings), ["once: dOmega_P1/dx"]);
    assert!(findings.iter().all(|f| f.passes() || f.sample == 1));
}

/// The mass matrix is well conditioned here, so bounds should be close to those of rounding.
#[test]
fn bounds_are_those_of_rounding() {
    for finding in check_all(&robot("pendulum_2"), &options(2)).expect("a loaded model") {
        let by_differences = finding.quantity.starts_with("difference");
        assert!(by_differences || finding.bound <= 2e-9, "{finding:?}");
    }
}
