//! Comparison of Jacobians of the right-hand side.

use super::{At, CheckOptions, DIFFERENCE_BOUND, Finding, Findings, MAX_DIFFERENCE_BOUND, State, Tolerance};
use crate::error::Result;
use crate::flow::jacobian::{CentralDifference, ForwardDual, JacobianKind, Jacobians, NodeBlocks, NodeJacobian};
use crate::flow::{AlgorithmB1, Node};
use crate::model::Model;
use nalgebra::DMatrix;

/// Compares a Jacobian with dual numbers of the control form at random states: the worst of each block at each penalty,
/// separately for the rows of $\Omega_{P1}$ and $\Omega_{P2}$. `name` is the prefix of the names of the blocks.
///
/// # Errors
/// `jacobian` has another number of joints than `model`.
pub fn check_jacobian(
    model: &Model,
    name: &str,
    jacobian: &mut dyn NodeJacobian,
    options: &CheckOptions,
) -> Result<Vec<Finding>> {
    check_jacobian_at(model, name, jacobian, &options.states(model)?, &options.penalties)
}

/// Performs [`check_jacobian`] at given states, such as those at which terms vanish or coincide.
///
/// # Errors
/// `jacobian` has another number of joints than `model`, or a state does not have `2 N` entries in each of its parts.
pub fn check_jacobian_at(
    model: &Model,
    name: &str,
    jacobian: &mut dyn NodeJacobian,
    states: &[State],
    penalties: &[f64],
) -> Result<Vec<Finding>> {
    let expected = &mut ForwardDual::new(model);
    compare_jacobians(model, name, jacobian, expected, states, penalties)
}

pub(super) fn compare_jacobians(
    model: &Model,
    name: &str,
    jacobian: &mut dyn NodeJacobian,
    expected: &mut dyn NodeJacobian,
    states: &[State],
    penalties: &[f64],
) -> Result<Vec<Finding>> {
    let n = model.dof();
    let mut findings = Findings::default();
    let mut look = |at: At<'_>, ours: &NodeBlocks, expected: &NodeBlocks| {
        for (part, row) in [("Omega_P1", 0), ("Omega_P2", n)] {
            for (by, a, b) in pairs(ours, expected) {
                let quantity = format!("{name}: d{part}/{by}");
                let (a, b) = (a.rows(row, n), b.rows(row, n));
                let tolerance = at.divided_twice();
                findings.compare(tolerance, &quantity, at, a.as_view(), b.as_view());
            }
        }
    };
    each_pair(model, jacobian, expected, states, penalties, &mut look)?;
    Ok(findings.all)
}

/// The step of central differences at an argument up to one.
const STEP: f64 = 7.4e-4;

/// Checks central differences with a larger bound: they lose entries that are small relative to the largest one of all
/// blocks. They are not compared at states where they are meaningless.
pub(super) fn check_differences(model: &Model, name: &str, options: &CheckOptions) -> Result<Vec<Finding>> {
    let mut findings = Findings::default();
    let jacobian = &mut CentralDifference::new(model);
    let duals = &mut ForwardDual::new(model);
    let mut look = |at: At<'_>, ours: &NodeBlocks, expected: &NodeBlocks| {
        let pairs = pairs(ours, expected);
        let largest = pairs.iter().fold(0.0_f64, |m, (_, _, b)| m.max(b.amax()));
        // The mass matrix loses rank over a distance of about one over the root of its condition number, and the
        // truncation is of order four in the step over that distance.
        let bound = DIFFERENCE_BOUND + 30.0 * (STEP * STEP * at.condition()).powi(2);
        if bound > MAX_DIFFERENCE_BOUND {
            return;
        }
        for (by, a, b) in pairs {
            let quantity = format!("{name}: dOmega/{by}");
            let tolerance = Tolerance { floor: largest, bound };
            findings.compare(tolerance, &quantity, at, a.as_view(), b.as_view());
        }
    };
    let states = options.states(model)?;
    each_pair(model, jacobian, duals, &states, &options.penalties, &mut look)?;
    Ok(findings.all)
}

/// The blocks of two Jacobians with the names of their variables.
fn pairs<'a>(a: &'a NodeBlocks, b: &'a NodeBlocks) -> [(&'static str, &'a DMatrix<f64>, &'a DMatrix<f64>); 3] {
    [("dx", &a.dx, &b.dx), ("dxdot", &a.dxdot, &b.dxdot), ("dxddot", &a.dxddot, &b.dxddot)]
}

/// Evaluates two Jacobians at all states and penalties and passes the results to `look`.
fn each_pair(
    model: &Model,
    jacobian: &mut dyn NodeJacobian,
    expected: &mut dyn NodeJacobian,
    states: &[State],
    penalties: &[f64],
    look: &mut dyn FnMut(At<'_>, &NodeBlocks, &NodeBlocks),
) -> Result<()> {
    let (mut a, mut b) = (NodeBlocks::new(model.dof()), NodeBlocks::new(model.dof()));
    for (sample, state) in states.iter().enumerate() {
        state.node().check(model.dof(), 2 * model.dof())?;
        let at = At::new(model, sample, state)?;
        for k in penalties {
            jacobian.evaluate(state.node(), *k, &mut a)?;
            expected.evaluate(state.node(), *k, &mut b)?;
            look(at.under(*k), &a, &b);
        }
    }
    Ok(())
}

/// The Jacobian of Algorithm B1 with the exact $d\Omega / d\ddot x = 2 I$ (B80): multiplying by $H H$ and dividing by
/// it again would lose most digits of these known numbers.
pub(super) struct Printed<J>(pub J);

impl<J: NodeJacobian> NodeJacobian for Printed<J> {
    fn evaluate(&mut self, node: Node<'_, f64>, k: f64, out: &mut NodeBlocks) -> Result<()> {
        self.0.evaluate(node, k, out)?;
        out.dxddot.fill(0.0);
        out.dxddot.fill_diagonal(2.0);
        Ok(())
    }
}

/// Checks every Jacobian of a list with [`check_jacobian`]. Two built-in ones are compared differently: differences
/// with a separate bound, and dual numbers of the control form, which are the reference for the others, with dual
/// numbers of Algorithm B1.
///
/// # Errors
/// An implementation refuses the model.
pub fn check_jacobians(model: &Model, jacobians: &Jacobians, options: &CheckOptions) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for name in jacobians.names() {
        let jacobian = &mut *jacobians.build(name, model)?;
        findings.extend(match name.parse() {
            Ok(JacobianKind::Difference) => check_differences(model, name, options)?,
            Ok(JacobianKind::Dual) => {
                let as_printed = ForwardDual::of(AlgorithmB1::new(model), model.dof());
                let expected = &mut Printed(as_printed);
                compare_jacobians(model, name, jacobian, expected, &options.states(model)?, &options.penalties)?
            }
            _ => check_jacobian(model, name, jacobian, options)?,
        });
    }
    Ok(findings)
}
