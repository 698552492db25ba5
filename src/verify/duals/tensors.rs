//! Checks of the explicit tensors of second derivatives by dual numbers of the first ones.

use super::dynamics::{split, state_of};
use super::{At, Findings, Tolerance};
use crate::dynamics::{
    Data, ForwardDynamicsDerivatives, ForwardDynamicsSecondDerivatives, InverseDynamicsDerivatives,
    InverseDynamicsSecondDerivatives, MassMatrixDerivatives, aba_derivatives, aba_second_derivatives, crba,
    crba_second_derivatives, rnea_derivatives, rnea_second_derivatives,
};
use crate::error::Result;
use crate::linalg::Tensor3;
use crate::model::Model;
use crate::verify::reference::{self, constant, entries, jacobian, vector};
use nalgebra::{DMatrix, DMatrixView, DVector};
use num_dual::{Dual64, HyperDual64};

/// Compares the second derivatives of inverse and forward dynamics and of the mass matrix.
pub(super) fn second_derivatives(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    inverse_dynamics(model, at, findings)?;
    forward_dynamics(model, at, findings)?;
    mass_matrix(model, at, findings)
}

fn inverse_dynamics(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let n = model.dof();
    let state = state_of(at);
    let (q, v, a) = split(&state);
    let mut second = InverseDynamicsSecondDerivatives::new(n);
    rnea_second_derivatives(model, &mut Data::new(model), q, v, a, &mut second)?;
    let a = constant(a);
    let expected = jacobian(&state[..2 * n], |state| {
        let (q, v) = state.split_at(n);
        let mut id = InverseDynamicsDerivatives::new(n);
        rnea_derivatives(model, &mut Data::new(model), q, v, &a, &mut id)?;
        Ok(all([&id.dq, &id.dv, &id.h]))
    })?;
    let blocks = [
        ("dqdq", &second.dqdq, 0, 0),
        ("dqdv", &second.dqdv, 0, n),
        ("dvdv", &second.dvdv, 1, n),
        ("dadq", &second.dadq, 2, 0),
    ];
    compare(at.direct(), "inverse dynamics", at, &blocks, &expected, findings);
    Ok(())
}

/// Compares the second derivatives of forward dynamics at a given torque.
fn forward_dynamics(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let n = model.dof();
    let state = state_of(at);
    let (q, v, tau) = split(&state);
    let mut fd = ForwardDynamicsDerivatives::new(n);
    let mut id = InverseDynamicsSecondDerivatives::new(n);
    let mut second = ForwardDynamicsSecondDerivatives::new(n);
    aba_derivatives(model, &mut Data::new(model), q, v, tau, &mut fd)?;
    rnea_second_derivatives(model, &mut Data::new(model), q, v, fd.a.as_slice(), &mut id)?;
    aba_second_derivatives(&fd, &id, &mut second)?;
    let tau = constant(tau);
    let expected = jacobian(&state[..2 * n], |state| {
        let (q, v) = state.split_at(n);
        let mut fd = ForwardDynamicsDerivatives::new(n);
        aba_derivatives(model, &mut Data::new(model), q, v, &tau, &mut fd)?;
        Ok(all([&fd.dq, &fd.dv]))
    })?;
    let blocks = [("dqdq", &second.dqdq, 0, 0), ("dqdv", &second.dqdv, 0, n), ("dvdv", &second.dvdv, 1, n)];
    compare(at.divided(), "forward dynamics", at, &blocks, &expected, findings);
    Ok(())
}

fn mass_matrix(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let n = model.dof();
    let node = at.state.node();
    let (q, w) = (node.x_p1(), node.xdot_p1());
    let mut mass = MassMatrixDerivatives::new(n);
    crba_second_derivatives(model, &mut Data::new(model), q, w, &mut mass)?;
    let expected = jacobian(q, |q| Ok(entries(&reference::mass(model, q)?)))?;
    findings.compare(at.direct(), "mass matrix: dH/dq", at, unfold(&mass.dq, n), expected.as_view());
    let ours = DMatrixView::from_slice(mass.dqdq.entries(), n.pow(3), n);
    let expected = mass_matrix_by_hyper_duals(model, q)?;
    findings.compare(at.direct(), "mass matrix: d2H/dqdq", at, ours, expected.as_view());
    Ok(())
}

/// All second derivatives of the mass matrix, those in one joint in one column. They are symmetric, so that half are
/// computed.
fn mass_matrix_by_hyper_duals(model: &Model, q: &[f64]) -> Result<DMatrix<f64>> {
    let n = model.dof();
    let mut q: Vec<HyperDual64> = q.iter().map(|q| HyperDual64::from(*q)).collect();
    let mut h = DMatrix::zeros(n, n);
    let mut expected = DMatrix::zeros(n.pow(3), n);
    let data = &mut Data::new(model);
    for l in 0..n {
        q[l].eps2 = 1.0;
        for k in 0..=l {
            q[k].eps1 = 1.0;
            crba(model, data, &q, &mut h)?;
            q[k].eps1 = 0.0;
            for (k, l) in [(k, l), (l, k)] {
                let mut column = expected.column_mut(l);
                let slice = column.as_mut_slice()[k * n * n..][..n * n].iter_mut();
                slice.zip(&h).for_each(|(entry, h)| *entry = h.eps1eps2);
            }
        }
        q[l].eps2 = 0.0;
    }
    Ok(expected)
}

/// Compares named tensors with blocks of the derivatives `expected` of the concatenated matrices of first derivatives.
/// A block is given by the number of the matrix and its first column.
fn compare(
    tolerance: Tolerance,
    of: &str,
    at: At<'_>,
    blocks: &[(&str, &Tensor3<f64>, usize, usize)],
    expected: &DMatrix<f64>,
    findings: &mut Findings,
) {
    let n = at.state.x.len() / 2;
    for (name, tensor, block, column) in blocks {
        let quantity = format!("{of}: d2/{name}");
        let expected = expected.view((block * n * n, *column), (n * n, n));
        findings.compare(tolerance, &quantity, at, unfold(tensor, n), expected);
    }
}

/// The entries of concatenated matrices in column-major order.
fn all<const M: usize>(matrices: [&DMatrix<Dual64>; M]) -> DVector<Dual64> {
    vector(&matrices.map(DMatrix::as_slice).concat())
}

/// A tensor as a matrix with one column per value of the last index.
fn unfold(tensor: &Tensor3<f64>, n: usize) -> DMatrixView<'_, f64> {
    DMatrixView::from_slice(tensor.entries(), n * n, n)
}
