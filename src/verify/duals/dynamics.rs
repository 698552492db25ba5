//! Checks of the derivatives of the dynamics by dual numbers.

use super::tensors::second_derivatives;
use super::{At, CheckOptions, Finding, Findings, State};
use crate::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, RneaVjp, RneaWeightedHessian, RootWrenchDerivatives,
    aba, aba_derivatives, mass_matrix_and_rate, mass_matrix_product_derivative, rnea_derivatives, rnea_vjp,
    rnea_weighted_hessian, root_wrench, root_wrench_second_order,
};
use crate::error::Result;
use crate::flow::{AlgorithmB1, ControlForm, RightHandSide};
use crate::model::Model;
use crate::scalar::AlgebraOver;
use crate::spatial::Motion;
use crate::verify::reference::{self, entries, jacobian, mass, vector};
use nalgebra::{DMatrix, DVector, Vector3};
use num_dual::Dual64;

/// Compares the derivatives of the dynamics with dual numbers, and the two forms of $\Omega$ with each other.
///
/// # Errors
/// None for a loaded model.
pub fn check_dynamics(model: &Model, options: &CheckOptions) -> Result<Vec<Finding>> {
    check_dynamics_at(model, &options.states(model)?, &options.penalties)
}

/// Performs [`check_dynamics`] at given states, such as those at which terms vanish or coincide.
///
/// # Errors
/// A state does not have `2 N` entries in each of its parts.
pub fn check_dynamics_at(model: &Model, states: &[State], penalties: &[f64]) -> Result<Vec<Finding>> {
    let mut findings = Findings::default();
    for (sample, state) in states.iter().enumerate() {
        state.node().check(model.dof(), 2 * model.dof())?;
        let at = At::new(model, sample, state)?;
        inverse_dynamics(model, at, &mut findings)?;
        forward_dynamics(model, at, &mut findings)?;
        mass_matrix(model, at, &mut findings)?;
        contractions(model, at, &mut findings)?;
        root(model, at, &mut findings)?;
        second_derivatives(model, at, &mut findings)?;
        for k in penalties {
            omega(model, *k, at.under(*k), &mut findings)?;
        }
    }
    Ok(findings.all)
}

fn inverse_dynamics(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let n = model.dof();
    let state = state_of(at);
    let (q, v, a) = split(&state);
    let mut id = InverseDynamicsDerivatives::new(n);
    rnea_derivatives(model, &mut Data::new(model), q, v, a, &mut id)?;
    let expected = jacobian(&state, |state| {
        let (q, v, a) = split(state);
        reference::inverse_dynamics(model, q, v, a)
    })?;
    let ours = [("dq", &id.dq), ("dv", &id.dv), ("da", &id.h)];
    findings.compare_columns(at.direct(), "inverse dynamics", at, &ours, &expected);
    Ok(())
}

fn forward_dynamics(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let n = model.dof();
    // The third part of the state serves as a torque.
    let state = state_of(at);
    let (q, v, tau) = split(&state);
    let mut fd = ForwardDynamicsDerivatives::new(n);
    aba_derivatives(model, &mut Data::new(model), q, v, tau, &mut fd)?;
    let expected = jacobian(&state, |state| {
        let (mut a, (q, v, tau)) = (DVector::zeros(n), split(state));
        aba(model, &mut Data::new(model), q, v, tau, a.as_mut_slice())?;
        Ok(a)
    })?;
    let ours = [("dq", &fd.dq), ("dv", &fd.dv), ("dtau", &fd.h_inverse)];
    findings.compare_columns(at.divided(), "forward dynamics", at, &ours, &expected);
    Ok(())
}

fn mass_matrix(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let n = model.dof();
    let node = at.state.node();
    let (q, w) = (node.x_p1(), node.xdot_p1());
    let (mut h, mut hdot) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    mass_matrix_and_rate(model, &mut Data::new(model), q, w, &mut h, &mut hdot)?;
    let expected = jacobian(q, |q| Ok(entries(&mass(model, q)?)))?;
    let rate = DMatrix::from_column_slice(n, n, (&expected * DVector::from_column_slice(w)).as_slice());
    let tolerance = at.direct();
    findings.compare(tolerance, "mass matrix: rate", at, hdot.as_view(), rate.as_view());

    let mut k = DMatrix::zeros(n, n);
    mass_matrix_product_derivative(model, &mut Data::new(model), q, w, &mut k)?;
    let expected = DMatrix::from_fn(n, n, |i, j| (0..n).map(|m| expected[(i + m * n, j)] * w[m]).sum());
    findings.compare(tolerance, "mass matrix: d(H w)/dq", at, k.as_view(), expected.as_view());
    Ok(())
}

/// Compares the gradient of `w^T ID` with dual numbers of `rnea`, and its Hessian with dual numbers of the products
/// with `rnea_derivatives`.
fn contractions(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let n = model.dof();
    let state = state_of(at);
    let (q, v, a) = split(&state);
    let w = DVector::from_column_slice(at.state.node().xdot_p1());
    let data = &mut Data::new(model);
    let mut gradient = RneaVjp::new(n);
    rnea_vjp(model, data, q, v, a, w.as_slice(), &mut gradient)?;
    let fixed = w.map(Dual64::from);
    let expected = jacobian(&state, |state| {
        let (q, v, a) = split(state);
        let sum = reference::inverse_dynamics(model, q, v, a)?.dot(&fixed);
        Ok(DVector::from_element(1, sum))
    })?;
    let row = |x: &DVector<f64>| DMatrix::from_row_slice(1, n, x.as_slice());
    let (by_q, by_v, by_a) = (row(&gradient.q), row(&gradient.v), row(&gradient.a));
    let ours = [("dq", &by_q), ("dv", &by_v), ("da", &by_a)];
    findings.compare_columns(at.direct(), "w^T ID", at, &ours, &expected);

    let mut hessian = RneaWeightedHessian::new(n);
    rnea_weighted_hessian(model, data, q, v, a, w.as_slice(), &mut hessian)?;
    let expected = jacobian(&state, |state| {
        let (q, v, a) = split(state);
        let mut id = InverseDynamicsDerivatives::new(n);
        rnea_derivatives(model, &mut Data::new(model), q, v, a, &mut id)?;
        let (by_q, by_v) = (id.dq.tr_mul(&fixed), id.dv.tr_mul(&fixed));
        Ok(vector(&[by_q.as_slice(), by_v.as_slice()].concat()))
    })?;
    compare_hessian("w^T ID", &hessian, &expected, at, findings);
    Ok(())
}

/// The derivatives of the wrench of the root, and the Hessian of its product with a motion of the base.
fn root_second_order<S: AlgebraOver<f64>>(
    model: &Model,
    (q, v, a): (&[S], &[S], &[S]),
    base: Motion<S>,
) -> Result<(RootWrenchDerivatives<S>, RneaWeightedHessian<S>)> {
    let n = model.dof();
    let (mut first, mut second) = (RootWrenchDerivatives::new(n), RneaWeightedHessian::new(n));
    let data = &mut Data::new(model);
    root_wrench_second_order(model, data, [q, v, a], |_| base, &mut first, &mut second)?;
    Ok((first, second))
}

/// Compares the Jacobian of the wrench of the root with dual numbers of its value, and the Hessian of its product with
/// a motion of the base with dual numbers of the Jacobian.
fn root(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let state = state_of(at);
    let base = [0.3, -0.7, 0.4, 0.9, -0.2, 0.6];
    let motion = |m: [f64; 6]| Motion::new(Vector3::new(m[0], m[1], m[2]), Vector3::new(m[3], m[4], m[5]));
    let (first, second) = root_second_order(model, split(&state), motion(base))?;
    let expected = jacobian(&state, |state| {
        let (q, v, a) = split(state);
        let force = root_wrench(model, &mut Data::new(model), q, v, a)?;
        Ok(vector(&[force.angular.as_slice(), force.linear.as_slice()].concat()))
    })?;
    let (wrench, ours) = ("root wrench", first.jacobian.as_view());
    findings.compare(at.direct(), wrench, at, ours, expected.as_view());

    let fixed = DVector::from_row_slice(&base).map(Dual64::from);
    let expected = jacobian(&state, |state| {
        let (first, _) = root_second_order(model, split(state), Motion::zero())?;
        Ok(first.jacobian.tr_mul(&fixed))
    })?;
    compare_hessian("m^T root wrench", &second, &expected, at, findings);
    Ok(())
}

/// Compares the blocks of a Hessian in `q`, `v` and `a`.
fn compare_hessian(
    of: &str,
    hessian: &RneaWeightedHessian<f64>,
    expected: &DMatrix<f64>,
    at: At<'_>,
    findings: &mut Findings,
) {
    let n = hessian.qq.nrows();
    let blocks = [
        ("qq", &hessian.qq, 0, 0),
        ("qv", &hessian.qv, 0, n),
        ("vv", &hessian.vv, n, n),
        ("qa", &hessian.qa, 0, 2 * n),
    ];
    for (name, ours, row, column) in blocks {
        let quantity = format!("{of}: second derivatives {name}");
        let expected = expected.view((row, column), (n, n));
        findings.compare(at.direct(), &quantity, at, ours.as_view(), expected);
    }
}

fn omega(model: &Model, k: f64, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let n = model.dof();
    let (mut control, mut b1) = (DMatrix::zeros(2 * n, 1), DMatrix::zeros(2 * n, 1));
    let node = at.state.node();
    ControlForm::new(model).omega(node, k, control.as_mut_slice())?;
    AlgorithmB1::new(model).omega(node, k, b1.as_mut_slice())?;
    for (part, row) in [("Omega_P1", 0), ("Omega_P2", n)] {
        let quantity = format!("{part}: control form and Algorithm B1");
        let (control, b1) = (control.rows(row, n), b1.rows(row, n));
        findings.compare(at.divided_twice(), &quantity, at, control.as_view(), b1.as_view());
    }
    Ok(())
}

/// `q`, `v` and `a`, concatenated.
pub(super) fn state_of(at: At<'_>) -> Vec<f64> {
    let node = at.state.node();
    [node.x, node.xdot_p2()].concat()
}

/// Three parts of equal length.
pub(super) fn split<S>(state: &[S]) -> (&[S], &[S], &[S]) {
    let n = state.len() / 3;
    (&state[..n], &state[n..2 * n], &state[2 * n..])
}
