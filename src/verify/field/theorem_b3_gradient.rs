//! (B17) to (B36): the gradient of the Lagrangian in the state, and the sum of all terms.

use super::reference::{Reference, blocks, contract, inertia_force, stack, two};
use super::theorem_b3::identity;
use super::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::error::Result;
use crate::flow::{AlgorithmB1, lagrangian_of_control};
use crate::verify::reference::{entries, inverse_dynamics, jacobian, omega_terms, unit, variation};
use nalgebra::{DMatrix, DVector};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![
        identity("B17", "dL/dx by the product rule", b17),
        identity("B18", "dL/dx expanded", b18),
        identity("B19", "dL/dx with G symmetric", b19),
        identity("B20", "dL/dx grouped", b20),
        identity("B21", "2 dF_d^T/dx G F_d", b21),
        identity("B22", "2 dF_d^T/dx G xdot", b22),
        identity("B23", "2 dF_d^T/dx G (F_d - xdot)", b23),
        identity("B24", "G^-1 times that = Omega_2 - Omega_3", b24),
        identity("B25", "dL/dx through G: the tensor dG/dx", b25),
        identity("B26", "dL/dx through G: row by row", b26),
        identity("B27", "dL/dx through G: only FD_0 is left of F_d", b27),
        identity("B28", "d(H^T H)/dx_P2 = 0", b28),
        identity("B29", "dL/dx through G: its upper half", b29),
        identity("B30", "beta_i", b30),
        identity("B31", "beta_i by the product rule", b31),
        identity("B32", "the two terms of beta_i are equal", b32),
        identity("B33", "beta_i = 2 [dH/dx_i w]^T H w", b33),
        identity("B34", "dL/dx through G = 2 [dH/dx_P1 w]^T H w", b34),
        identity("B35", "G^-1 times that = Omega_4", b35),
        identity("B36", "flow = Omega_1 - (Omega_2 - Omega_3 + Omega_4)", b36),
    ]
}

/// Compares `dL/dx` by dual numbers with an expression.
fn by_x(p: &RandomInstance, right: impl Fn(&Reference<'_>) -> Result<DVector<Gf>>) -> Result<Vec<Equality>> {
    let reference = Reference::at(p)?;
    let left = reference.variation()?.by_x;
    Ok(vec![Equality::vectors("dL/dx", &left, &right(&reference)?)])
}

/// `(xdot - F_d)^T dG/dx (xdot - F_d)`.
fn through_metric(reference: &Reference<'_>) -> Result<DVector<Gf>> {
    Ok(contract(&reference.slip(), &reference.dmetric()?, &reference.slip()))
}

fn b17(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_x(p, |t| {
        let (slip, g) = (t.slip(), t.metric());
        let first = -(t.dfd.transpose() * &g * &slip);
        let third = (slip.transpose() * g * -&t.dfd).transpose();
        Ok(first + through_metric(t)? + third)
    })
}

fn b18(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_x(p, |t| {
        let (xdot, g, dt) = (&t.p.xdot, t.metric(), t.dfd.transpose());
        let first = -(&dt * &g * xdot) + dt * &g * &t.fd;
        let fourth = -(xdot.transpose() * &g * &t.dfd).transpose();
        let fifth = (t.fd.transpose() * g * &t.dfd).transpose();
        Ok(first + through_metric(t)? + fourth + fifth)
    })
}

fn b19(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_x(p, |t| {
        let (xdot, g, dt) = (&t.p.xdot, t.metric(), t.dfd.transpose());
        let (by_xdot, by_fd) = (&dt * &g * xdot, &dt * &g * &t.fd);
        Ok(-&by_xdot + &by_fd + through_metric(t)? - by_xdot + by_fd)
    })
}

fn b20(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_x(p, |t| {
        let force = t.dfd.transpose() * t.metric();
        let drift = &force * &t.fd * two() - force * &t.p.xdot * two();
        Ok(drift + through_metric(t)?)
    })
}

/// `(dF_d/dx)^T` in the blocks of (B21).
fn drift_blocks(t: &Reference<'_>) -> DMatrix<Gf> {
    let (zero, identity) = (DMatrix::zeros(t.n, t.n), DMatrix::identity(t.n, t.n));
    let [dq, dv] = t.dfd0().map(|d| d.transpose());
    blocks([[&zero, &dq], [&identity, &dv]])
}

fn b21(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let g = t.metric().map(Jet1::constant);
    // With G held fixed this is the gradient of F_d^T G F_d.
    let left = t.by_f_d(|fd| fd.dot(&(&g * fd)))?;
    let [dq, dv] = t.dfd0().map(|d| d.transpose() * t.h.transpose() * &t.c);
    let right = stack(&-dq, &(t.x_p2() * p.k - dv)) * two();
    Ok(vec![
        Equality::new("dF_d^T/dx", t.dfd.transpose(), drift_blocks(&t)),
        Equality::vectors("middle", &left, &(drift_blocks(&t) * t.metric() * &t.fd * two())),
        Equality::vectors("right", &left, &right),
    ])
}

fn b22(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let [xdot_p1, xdot_p2, ..] = t.rates();
    let momentum = (t.metric() * &p.xdot * two()).map(Jet1::constant);
    // With G and xdot held fixed this is the gradient of 2 F_d^T G xdot.
    let left = t.by_f_d(|fd| fd.dot(&momentum))?;
    let [dq, dv] = t.dfd0().map(|d| d.transpose() * t.hth() * &xdot_p2);
    let right = stack(&dq, &(xdot_p1 * p.k + dv)) * two();
    let middle = drift_blocks(&t) * t.metric() * &p.xdot * two();
    Ok(vec![Equality::vectors("middle", &left, &middle), Equality::vectors("right", &left, &right)])
}

/// `dFD_0^T/dx_P1 f` and `dFD_0^T/dx_P2 f` with `f = H^T (2 C + 2 H xdot_P2)`.
fn drift_forces(t: &Reference<'_>) -> [DVector<Gf>; 2] {
    let [_, xdot_p2, ..] = t.rates();
    let force = t.h.transpose() * (&t.c * two() + &t.h * xdot_p2 * two());
    t.dfd0().map(|d| d.transpose() * &force)
}

/// `2 k (xdot_P1 - x_P2)`.
fn slip_force(t: &Reference<'_>) -> DVector<Gf> {
    let [xdot_p1, ..] = t.rates();
    (xdot_p1 - t.x_p2()) * (t.p.k * two())
}

/// The gradient of `(xdot - F_d)^T G (xdot - F_d)` at constant `G`.
fn through_drift(t: &Reference<'_>) -> Result<DVector<Gf>> {
    let (g, xdot) = (t.metric().map(Jet1::constant), t.p.xdot.map(Jet1::constant));
    t.by_f_d(|fd| (&xdot - fd).dot(&(&g * (&xdot - fd))))
}

fn b23(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let [by_q, by_v] = drift_forces(&t);
    let right = stack(&-by_q, &-by_v) - stack(&DVector::zeros(t.n), &slip_force(&t));
    Ok(vec![Equality::vectors("sum", &through_drift(&t)?, &right)])
}

fn b24(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let (g, dt) = (t.metric(), t.dfd.transpose());
    let second = (t.fd.transpose() * &g * &t.dfd).transpose();
    let printed = &dt * &g * &t.fd + second - dt * g * &p.xdot * two();
    let [by_q, by_v] = drift_forces(&t);
    let omega_2 = stack(&(by_q * -p.k.inverse()), &-t.solve_hth(&by_v));
    let omega_3 = stack(&DVector::zeros(t.n), &t.solve_hth(&slip_force(&t)));
    let right = omega_2 - omega_3;
    Ok(vec![
        Equality::vectors("printed left side", &t.raise(&printed), &right),
        Equality::vectors("gradient", &t.raise(&through_drift(&t)?), &right),
    ])
}

/// Compares `dL/dx` through `G` alone, by dual numbers of inverse dynamics, with an expression.
fn by_metric(p: &RandomInstance, right: impl Fn(&Reference<'_>) -> Result<DVector<Gf>>) -> Result<Vec<Equality>> {
    let reference = Reference::at(p)?;
    let left = reference.by_metric()?;
    Ok(vec![Equality::vectors("through G", &left, &right(&reference)?)])
}

fn b25(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_metric(p, through_metric)
}

fn b26(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_metric(p, |t| {
        let (slip, dhth, zero) = (t.slip(), t.dhth()?, DMatrix::zeros(t.n, t.n));
        Ok(DVector::from_fn(2 * t.n, |i, _| {
            let slice = blocks([[&zero, &zero], [&zero, &dhth[i]]]);
            (slip.transpose() * slice * &slip)[0]
        }))
    })
}

fn b27(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_metric(p, |t| Ok(contract(&t.w, &t.dhth()?, &t.w)))
}

fn b28(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, t) = (p.dof(), Reference::at(p)?);
    // H from inverse dynamics, whose arguments include the velocity.
    let derivative = jacobian(p.x.as_slice(), |x| {
        let columns: Result<Vec<_>> = (0..n).map(|j| inertia_force(&p.model, x, &unit(n, j))).collect();
        let h = DMatrix::from_columns(&columns?);
        Ok(entries(&(h.transpose() * h)))
    })?;
    let by_q: Vec<_> = t.dhth()?[..n].iter().flat_map(|d| d.as_slice().to_vec()).collect();
    let by_q = DMatrix::from_vec(n * n, n, by_q);
    Ok(vec![
        Equality::new("by x_P1", derivative.columns(0, n).into_owned(), by_q),
        Equality::new("by x_P2", derivative.columns(n, n).into_owned(), DMatrix::zeros(n * n, n)),
    ])
}

fn b29(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_metric(p, |t| {
        let upper = contract(&t.w, &t.dhth()?[..t.n], &t.w);
        Ok(stack(&upper, &DVector::zeros(t.n)))
    })
}

fn b30(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let beta = DVector::from_iterator(2 * t.n, t.dhth()?.iter().map(|d| (t.w.transpose() * d * &t.w)[0]));
    Ok(vec![Equality::vectors("beta", &t.by_metric()?, &beta)])
}

/// An expression in `dH/dx_i` for every `i`.
fn by_slice(t: &Reference<'_>, f: impl Fn(&DMatrix<Gf>) -> Gf) -> DVector<Gf> {
    DVector::from_iterator(t.dh.len(), t.dh.iter().map(f))
}

fn b31(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let (w, hw) = (&t.w, &t.h * &t.w);
    let right = by_slice(&t, |d| w.dot(&(d.transpose() * &hw)) + w.dot(&(t.h.transpose() * d * w)));
    let left = contract(&t.w, &t.dhth()?, &t.w);
    Ok(vec![Equality::vectors("beta", &left, &right)])
}

fn b32(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let left = by_slice(&t, |d| t.w.dot(&(t.h.transpose() * d * &t.w)));
    let right = by_slice(&t, |d| t.w.dot(&(d.transpose() * &t.h * &t.w)));
    // Each is half of the gradient.
    let half = t.by_metric()? * two().inverse();
    Ok(vec![Equality::vectors("transposed", &left, &right), Equality::vectors("half of beta", &half, &right)])
}

fn b33(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let hw = &t.h * &t.w;
    let left = contract(&t.w, &t.dhth()?, &t.w);
    let middle = by_slice(&t, |d| t.w.dot(&(d.transpose() * &hw)) * two());
    let right = by_slice(&t, |d| (d * &t.w).dot(&hw) * two());
    Ok(vec![Equality::vectors("middle", &left, &middle), Equality::vectors("right", &left, &right)])
}

/// `[2 [dH/dx_P1 w]^T H w; 0]`.
fn contracted(t: &Reference<'_>) -> DVector<Gf> {
    let upper = t.dh_dq_w().transpose() * &t.h * &t.w * two();
    stack(&upper, &DVector::zeros(t.n))
}

fn b34(p: &RandomInstance) -> Result<Vec<Equality>> {
    by_metric(p, |t| Ok(contracted(t)))
}

fn b35(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let right = contracted(&t) * p.k.inverse();
    Ok(vec![
        Equality::vectors("printed left side", &t.raise(&through_metric(&t)?), &right),
        Equality::vectors("gradient", &t.raise(&t.by_metric()?), &right),
    ])
}

fn b36(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, t) = (p.dof(), Reference::at(p)?);
    let by_control = variation(p.node(), |_, x, xdot| {
        let u = inverse_dynamics(&p.model, &x[..n], &x[n..], &xdot[n..])?;
        lagrangian_of_control(&xdot[..n], &x[n..], u.as_slice(), p.k)
    })?;
    let left = t.raise(&(by_control.momentum_rate - by_control.by_x));
    let [one, two, three, four] = omega_terms(&p.at())?;
    let sum = one - (two - three + four);
    let algorithm = super::theorem_b3::omega_of(p, AlgorithmB1::new(&p.model))?;
    Ok(vec![Equality::vectors("flow", &left, &sum), Equality::vectors("Omega", &sum, &algorithm)])
}
