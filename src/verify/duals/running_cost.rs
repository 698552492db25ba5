//! Checks of the derivatives of user-defined running costs.

use super::{At, BOUND, CheckOptions, Finding, Findings, Tolerance, VANISHING};
use crate::cost::{AutodiffCost, HyperDual64, RunningCost, StageDerivatives, StageInput};
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::model::Model;
use nalgebra::DMatrix;

/// Compares value, gradient and Hessian of a [`RunningCost`] with analytic derivatives with hyper-dual numbers of the
/// same cost as a closure, at random states with their control. `name` is the prefix of the names of the quantities.
///
/// # Errors
/// Those of the cost.
pub fn check_running_cost(
    model: &Model,
    name: &str,
    by_hand: &impl RunningCost,
    closure: impl Fn(&StageInput<'_, HyperDual64>) -> HyperDual64,
    options: &CheckOptions,
) -> Result<Vec<Finding>> {
    let n = model.dof();
    let by_duals = AutodiffCost::new(closure);
    let tolerance = Tolerance { bound: BOUND, floor: VANISHING };
    let (mut data, mut u) = (Data::new(model), vec![0.0; n]);
    let mut findings = Findings::default();
    for (sample, state) in options.states(model)?.iter().enumerate() {
        let at = At::new(model, sample, state)?;
        let node = state.node();
        let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
        rnea(model, &mut data, q, v, a, &mut u)?;
        let input = StageInput { t: 0.1 * sample as f64, q, v, a, u: &u };
        let mut ours = StageDerivatives::new(n);
        let mut expected = StageDerivatives::new(n);
        let value = by_hand.derivatives(&input, &mut ours)?;
        let expected_value = by_duals.derivatives(&input, &mut expected)?;
        let alone = by_hand.value(&input)?;
        let row = |x: &[f64]| DMatrix::from_row_slice(1, x.len(), x);
        for (what, ours, expected) in [
            ("value", row(&[alone, value]), row(&[expected_value; 2])),
            ("gradient", row(ours.gradient.as_slice()), row(expected.gradient.as_slice())),
            ("Hessian", ours.hessian, expected.hessian),
        ] {
            let quantity = format!("{name}: {what}");
            findings.compare(tolerance, &quantity, at, ours.as_view(), expected.as_view());
        }
    }
    Ok(findings.all)
}
