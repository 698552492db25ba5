//! Algorithm B1 line by line, and the control form.

use super::reference::{Reference, inertia_force, stack};
use super::theorem_b3::{documentation, omega_of, terms};
use super::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, aba_derivatives, bias, mass_matrix_and_rate,
    mass_matrix_product_derivative, rnea_derivatives,
};
use crate::error::Result;
use crate::flow::{AlgorithmB1, ControlForm, TheoremB3};
use crate::model::Model;
use crate::verify::reference::{bias_force, constant, gradient, jacobian, mass, rate, unit, vector};
use nalgebra::{DMatrix, DVector};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let identity = |label, statement, claims| Identity {
        label,
        statement,
        convention: "dF_i/dx_j in row i and column j, [dH/dx w]_ij = sum_k dH_ik/dx_j w_k",
        claims,
    };
    vec![
        identity("Algorithm B1 line 1", "H and Hdot by CRBA_D", line_1),
        identity("Algorithm B1 line 2", "C by RNEA is -H FD_0", line_2),
        identity("Algorithm B1 line 3", "dC/dx by RNEA_D", line_3),
        identity("Algorithm B1 line 4", "Cdot by the chain rule", line_4),
        identity("Algorithm B1 line 5", "dFD_0/dx, H^-1 and FD_0 by ABA_D", line_5),
        identity("Algorithm B1 line 6", "Omega_1, Omega_2 and Omega_3", line_6),
        identity("Algorithm B1 line 7", "RNEA without gravity at rest is H w", line_7),
        identity("Algorithm B1 line 8", "RNEA_D without gravity at rest is dH/dx_P1 w", line_8),
        identity("Algorithm B1 line 9", "omega_4 = 2/k [dH/dx_P1 w]^T H w", line_9),
        identity("Algorithm B1 line 10", "Omega_4 = [omega_4; 0]", line_10),
        identity("Algorithm B1 line 11", "Omega is the flow by definition", line_11),
        identity("control form", "Omega in u is the flow by definition", control_form),
    ]
}

/// RNEA_D at the configuration of the point.
fn rnea_d(p: &RandomInstance, model: &Model<Gf>, v: &[Gf], a: &[Gf]) -> Result<InverseDynamicsDerivatives<Gf>> {
    let mut id = InverseDynamicsDerivatives::new(p.dof());
    rnea_derivatives(model, &mut Data::new(model), p.node().x_p1(), v, a, &mut id)?;
    Ok(id)
}

/// RNEA_D without acceleration: lines 2 and 3.
fn bias_d(p: &RandomInstance) -> Result<InverseDynamicsDerivatives<Gf>> {
    let zero = DVector::zeros(p.dof());
    rnea_d(p, &p.model, p.node().x_p2(), zero.as_slice())
}

/// ABA_D without torque: line 5.
fn aba_d(p: &RandomInstance) -> Result<ForwardDynamicsDerivatives<Gf>> {
    let (n, node) = (p.dof(), p.node());
    let (mut fd, zero) = (ForwardDynamicsDerivatives::new(n), DVector::zeros(n));
    let data = &mut Data::new(&p.model);
    aba_derivatives(&p.model, data, node.x_p1(), node.x_p2(), zero.as_slice(), &mut fd)?;
    Ok(fd)
}

/// CRBA_D: line 1.
fn crba_d(p: &RandomInstance) -> Result<[DMatrix<Gf>; 2]> {
    let (n, node) = (p.dof(), p.node());
    let (mut h, mut hdot) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let data = &mut Data::new(&p.model);
    mass_matrix_and_rate(&p.model, data, node.x_p1(), node.xdot_p1(), &mut h, &mut hdot)?;
    Ok([h, hdot])
}

/// $C$ and $\dot C$: lines 2 to 4.
fn bias_and_rate(p: &RandomInstance) -> Result<[DVector<Gf>; 2]> {
    let (id, node) = (bias_d(p)?, p.node());
    let rate = id.dq * vector(node.xdot_p1()) + id.dv * vector(node.xdot_p2());
    Ok([id.tau, rate])
}

/// RNEA_D without gravity at rest, at the acceleration $\dot x_{P2} - FD_0$: lines 7 and 8.
fn weightless_d(p: &RandomInstance) -> Result<InverseDynamicsDerivatives<Gf>> {
    let w = vector(p.node().xdot_p2()) - aba_d(p)?.a;
    let rest = DVector::zeros(p.dof());
    rnea_d(p, &p.weightless, rest.as_slice(), w.as_slice())
}

/// The quantities of Theorem B3 by the recursions of lines 1 to 8.
fn theorem(p: &RandomInstance) -> Result<TheoremB3<Gf>> {
    let mut t = TheoremB3::new(p.dof());
    [t.h, t.hdot] = crba_d(p)?;
    [t.c, t.cdot] = bias_and_rate(p)?;
    let fd = aba_d(p)?;
    (t.fd0, t.dfd0_dq, t.dfd0_dv) = (fd.a, fd.dq, fd.dv);
    t.dh_dq_w = weightless_d(p)?.dq;
    Ok(t)
}

fn line_1(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, [h, hdot]) = (p.dof(), crba_d(p)?);
    // H column by column from inverse dynamics.
    let columns = |x: &[Jet1]| -> Result<DVector<Jet1>> {
        let mut h = Vec::new();
        for j in 0..n {
            h.extend_from_slice(inertia_force(&p.model, x, &unit(n, j))?.as_slice());
        }
        Ok(DVector::from_vec(h))
    };
    let x = columns(&constant(p.x.as_slice()))?;
    let right = DMatrix::from_iterator(n, n, x.iter().map(|h| h.re));
    let moved = rate(p.x.as_slice(), p.xdot.as_slice(), columns)?;
    Ok(vec![
        Equality::new("H", h, right),
        Equality::new("Hdot", hdot, DMatrix::from_column_slice(n, n, moved.as_slice())),
    ])
}

fn line_2(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (t, node) = (Reference::at(p)?, p.node());
    let mut c = DVector::zeros(p.dof());
    let data = &mut Data::new(&p.model);
    bias(&p.model, data, node.x_p1(), node.x_p2(), c.as_mut_slice())?;
    let right = -(&t.h * t.fd0());
    Ok(vec![Equality::vectors("C", &c, &right), Equality::vectors("C of RNEA_D", &bias_d(p)?.tau, &right)])
}

fn line_3(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, id) = (p.dof(), bias_d(p)?);
    let by_duals = jacobian(p.x.as_slice(), |x| bias_force(&p.model, &x[..n], &x[n..]))?;
    Ok(vec![
        Equality::new("dC/dx_P1", id.dq, by_duals.columns(0, n).into_owned()),
        Equality::new("dC/dx_P2", id.dv, by_duals.columns(n, n).into_owned()),
    ])
}

fn line_4(p: &RandomInstance) -> Result<Vec<Equality>> {
    let [_, left] = bias_and_rate(p)?;
    Ok(vec![Equality::vectors("Cdot", &left, &Reference::at(p)?.cdot)])
}

fn line_5(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, t, fd) = (p.dof(), Reference::at(p)?, aba_d(p)?);
    let [dq, dv] = t.dfd0();
    Ok(vec![
        Equality::new("dFD_0/dx_P1", fd.dq, dq),
        Equality::new("dFD_0/dx_P2", fd.dv, dv),
        Equality::new("H H^-1", &t.h * fd.h_inverse, DMatrix::identity(n, n)),
        Equality::vectors("-H FD_0", &-(&t.h * fd.a), &t.c),
    ])
}

fn line_6(p: &RandomInstance) -> Result<Vec<Equality>> {
    let [one, two, three, _] = terms(p, &mut theorem(p)?);
    let documentation = documentation(&Reference::at(p)?)?;
    Ok(vec![
        Equality::vectors("Omega_1", &one, &documentation[0]),
        Equality::vectors("Omega_2", &two, &documentation[1]),
        Equality::vectors("Omega_3", &three, &documentation[2]),
    ])
}

fn line_7(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    Ok(vec![Equality::vectors("H w", &weightless_d(p)?.tau, &(&t.h * &t.w))])
}

fn line_8(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (t, right) = (Reference::at(p)?, weightless_d(p)?.dq);
    let mut contracted = DMatrix::zeros(t.n, t.n);
    let (data, q) = (&mut Data::new(&p.model), p.node().x_p1());
    mass_matrix_product_derivative(&p.model, data, q, t.w.as_slice(), &mut contracted)?;
    Ok(vec![Equality::new("RNEA_D", t.dh_dq_w(), right), Equality::new("contracted CRBA", t.dh_dq_w(), contracted)])
}

/// Line 9 by the recursions of the lines before.
fn small_omega_4(p: &RandomInstance) -> Result<DVector<Gf>> {
    let id = weightless_d(p)?;
    Ok(id.dq.transpose() * id.tau * (Gf::new(2) / p.k))
}

fn line_9(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let by_q = gradient(p.node().x_p1(), |q| {
        let force = mass(&p.model, q)? * t.w.map(Jet1::constant);
        Ok(force.dot(&force))
    })?;
    let right = by_q * p.k.inverse();
    Ok(vec![Equality::vectors("omega_4", &small_omega_4(p)?, &right)])
}

fn line_10(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = Reference::at(p)?;
    let meaning = t.raise(&t.by_metric()?);
    let stacked = stack(&small_omega_4(p)?, &DVector::zeros(p.dof()));
    let [.., function] = terms(p, &mut theorem(p)?);
    Ok(vec![Equality::vectors("stacked", &stacked, &meaning), Equality::vectors("function", &function, &meaning)])
}

fn line_11(p: &RandomInstance) -> Result<Vec<Equality>> {
    let left = omega_of(p, AlgorithmB1::new(&p.model))?;
    Ok(vec![Equality::vectors("Omega", &left, &Reference::at(p)?.omega()?)])
}

fn control_form(p: &RandomInstance) -> Result<Vec<Equality>> {
    let left = omega_of(p, ControlForm::new(&p.model))?;
    Ok(vec![Equality::vectors("Omega", &left, &Reference::at(p)?.omega()?)])
}
