//! (B5) to (B16): the right-hand side of the flow, and its terms in the velocity of the curve.

use super::reference::{Reference, blocks, effort, inertia_force, stack, two};
use super::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::dynamics::{Data, aba, rnea};
use crate::error::Result;
use crate::flow::{AlgorithmB1, ControlForm, Node, RightHandSide, TheoremB3, lagrangian_of_control};
use crate::linalg::Ldlt;
use crate::verify::reference::{constant, f_d, gradient, gradient_and_rate, omega_by_theorem_b3, omega_terms, unit};
use nalgebra::{DMatrix, DVector};
use num_traits::Zero;

/// An identity of Theorem B3 or its proof.
pub(super) fn identity(
    label: &'static str,
    statement: &'static str,
    claims: fn(&RandomInstance) -> Result<Vec<Equality>>,
) -> Identity {
    Identity { label, statement, convention: "dF^T/dx is (dF/dx)^T, [dH/dx w]_ij = sum_k dH_ik/dx_j w_k", claims }
}

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![
        identity("B5", "flow = Omega_1 - (Omega_2 - Omega_3 + Omega_4)", b5),
        identity("B6", "Omega_1 = G^-1 d/dt dL/dxdot", b6),
        identity("B7", "Omega_2: through FD_0", b7),
        identity("B8", "Omega_3: through x_P2 in F_d", b8),
        identity("B9", "Omega_4: through G", b9),
        identity("B10", "flow = G^-1 (d/dt dL/dxdot - dL/dx)", b10),
        identity("B11", "L = (xdot - F_d)^T G (xdot - F_d)", b11),
        identity("B12", "G = Fbar^-T K Fbar^-1", b12),
        identity("B13", "2 G = d^2 L / dxdot^2", b13),
        identity("B14", "dL/dxdot = 2 G (xdot - F_d)", b14),
        identity("B15", "d/dt dL/dxdot", b15),
        identity("B16", "G^-1 d/dt dL/dxdot", b16),
    ]
}

/// The value of a right-hand side at an instance.
pub(super) fn omega_of(p: &RandomInstance, mut rhs: impl RightHandSide<Gf, Gf>) -> Result<DVector<Gf>> {
    let mut omega = DVector::zeros(2 * p.dof());
    rhs.omega(p.node(), p.k, omega.as_mut_slice())?;
    Ok(omega)
}

/// The terms of Theorem B3 from its quantities.
pub(super) fn terms(p: &RandomInstance, t: &mut TheoremB3<Gf>) -> [DVector<Gf>; 4] {
    let (node, k): (Node<'_, Gf>, Gf) = (p.node(), p.k);
    let mut terms = [(); 4].map(|()| DVector::zeros(2 * p.dof()));
    t.omega_1(node, &mut terms[0]);
    t.omega_2(node, k, &mut terms[1]);
    t.omega_3(node, k, &mut terms[2]);
    t.omega_4(node, k, &mut terms[3]);
    terms
}

/// The definitions of the terms of Theorem B3: $G^{-1}$ times the rate of $\partial L / \partial \dot x$, and times
/// gradients of `L` in `x` through $FD_0$, through $x_{P2}$ (with the opposite sign) and through $G$, everything else
/// held constant.
pub(super) fn documentation(reference: &Reference<'_>) -> Result<[DVector<Gf>; 4]> {
    let (n, k) = (reference.n, reference.p.k);
    let xdot = reference.p.xdot.map(Jet1::constant);
    let h = reference.h.map(Jet1::constant);
    let through_fd0 = reference.by_f_d(|fd| {
        let force = &h * (xdot.rows(n, n) - fd.rows(n, n));
        force.dot(&force)
    })?;
    let through_x_p2 = reference.by_f_d(|fd| {
        let slip = xdot.rows(0, n) - fd.rows(0, n);
        slip.dot(&slip) * Jet1::constant(k)
    })?;
    Ok([
        reference.raise(&reference.variation()?.momentum_rate),
        reference.raise(&through_fd0),
        -reference.raise(&through_x_p2),
        reference.raise(&reference.by_metric()?),
    ])
}

/// Term `i` of Theorem B3 against its definition.
fn term(p: &RandomInstance, what: &'static str, i: usize) -> Result<Vec<Equality>> {
    let left = &documentation(&Reference::at(p)?)?[i];
    let right = &omega_terms(&p.at())?[i];
    Ok(vec![Equality::vectors(what, left, right)])
}

fn b5(p: &RandomInstance) -> Result<Vec<Equality>> {
    let left = Reference::at(p)?.omega()?;
    let right = omega_by_theorem_b3(&p.at())?;
    Ok(vec![Equality::vectors("Omega", &left, &right)])
}

fn b6(p: &RandomInstance) -> Result<Vec<Equality>> {
    term(p, "Omega_1", 0)
}

fn b7(p: &RandomInstance) -> Result<Vec<Equality>> {
    term(p, "Omega_2", 1)
}

fn b8(p: &RandomInstance) -> Result<Vec<Equality>> {
    term(p, "Omega_3", 2)
}

fn b9(p: &RandomInstance) -> Result<Vec<Equality>> {
    term(p, "Omega_4", 3)
}

fn b10(p: &RandomInstance) -> Result<Vec<Equality>> {
    let left = Reference::at(p)?.omega()?;
    let algorithm = omega_of(p, AlgorithmB1::new(&p.model))?;
    let control = omega_of(p, ControlForm::new(&p.model))?;
    Ok(vec![Equality::vectors("Algorithm B1", &left, &algorithm), Equality::vectors("control form", &left, &control)])
}

fn b11(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (reference, node) = (Reference::at(p)?, p.node());
    let slip = reference.slip();
    let explicit = slip.dot(&(reference.metric() * &slip));
    let by_definition = effort(p, node.x, node.xdot)?;
    let mut u = vec![Gf::zero(); p.dof()];
    let data = &mut Data::new(&p.model);
    rnea(&p.model, data, node.x_p1(), node.x_p2(), node.xdot_p2(), &mut u)?;
    let of_control = lagrangian_of_control(node.xdot_p1(), node.x_p2(), &u, p.k)?;
    Ok(vec![
        Equality::numbers("lagrangian", explicit, by_definition),
        Equality::numbers("lagrangian of the control", explicit, of_control),
    ])
}

/// $H^{-1}$ column by column from ABA: the change of the acceleration by each unit torque.
fn h_inverse(p: &RandomInstance) -> Result<DMatrix<Gf>> {
    let (n, node) = (p.dof(), p.node());
    let fd0 = f_d(&p.model, node.x)?.rows(n, n).into_owned();
    let mut inverse = DMatrix::zeros(n, n);
    for j in 0..n {
        let mut a = DVector::zeros(n);
        let (data, tau) = (&mut Data::new(&p.model), unit(n, j));
        aba(&p.model, data, node.x_p1(), node.x_p2(), &tau, a.as_mut_slice())?;
        inverse.set_column(j, &(a - &fd0));
    }
    Ok(inverse)
}

fn b12(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, reference) = (p.dof(), Reference::at(p)?);
    let (zero, identity) = (DMatrix::zeros(n, n), DMatrix::identity(n, n));
    let fbar = blocks([[&identity, &zero], [&zero, &h_inverse(p)?]]);
    let mut factors = Ldlt::new(2 * n);
    factors.factorise(&fbar);
    let mut inverse = DMatrix::identity(2 * n, 2 * n);
    factors.solve_columns(&mut inverse);
    let k = blocks([[&(&identity * p.k), &zero], [&zero, &identity]]);
    let left = inverse.transpose() * k * inverse;
    Ok(vec![Equality::new("G", left, reference.metric())])
}

fn b13(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, reference) = (p.dof(), Reference::at(p)?);
    let along = stack(&DVector::zeros(2 * n), &p.xddot);
    let at = stack(&p.x, &p.xdot);
    let [_, rates] = gradient_and_rate(at.as_slice(), along.as_slice(), |x, xdot| effort(p, x, xdot))?;
    let right = reference.metric() * &p.xddot * two();
    let left = rates.rows(2 * n, 2 * n).into_owned();
    // The block H^T H again, from inverse dynamics: the gradient of |H w|^2 in w is 2 H^T H w.
    let by_w = gradient(reference.w.as_slice(), |w| {
        let force = inertia_force(&p.model, &constant(p.x.as_slice()), w)?;
        Ok(force.dot(&force))
    })?;
    Ok(vec![
        Equality::vectors("2 G d", &left, &right),
        Equality::vectors("2 H^T H w", &by_w, &(reference.hth() * &reference.w * two())),
    ])
}

fn b14(p: &RandomInstance) -> Result<Vec<Equality>> {
    let reference = Reference::at(p)?;
    let [xdot_p1, xdot_p2, ..] = reference.rates();
    let left = reference.variation()?.by_xdot;
    let middle = reference.metric() * reference.slip() * two();
    let ht = reference.h.transpose();
    let right =
        stack(&((xdot_p1 - reference.x_p2()) * p.k), &(&ht * &reference.h * xdot_p2 + ht * &reference.c)) * two();
    Ok(vec![Equality::vectors("2 G (xdot - F_d)", &left, &middle), Equality::vectors("blocks", &left, &right)])
}

/// $\gamma$: half the second block of (B15).
fn gamma(reference: &Reference<'_>) -> DVector<Gf> {
    let [_, xdot_p2, _, xddot_p2] = reference.rates();
    let (ht, hdot_t) = (reference.h.transpose(), reference.hdot.transpose());
    (&hdot_t * &reference.h + &ht * &reference.hdot) * xdot_p2
        + &ht * &reference.h * xddot_p2
        + hdot_t * &reference.c
        + ht * &reference.cdot
}

fn b15(p: &RandomInstance) -> Result<Vec<Equality>> {
    let reference = Reference::at(p)?;
    let [_, xdot_p2, xddot_p1, _] = reference.rates();
    let right = stack(&((xddot_p1 - xdot_p2) * p.k), &gamma(&reference)) * two();
    let left = reference.variation()?.momentum_rate;
    Ok(vec![Equality::vectors("d/dt dL/dxdot", &left, &right)])
}

fn b16(p: &RandomInstance) -> Result<Vec<Equality>> {
    let reference = Reference::at(p)?;
    let [_, xdot_p2, xddot_p1, _] = reference.rates();
    let right = stack(&(xddot_p1 - xdot_p2), &reference.solve_hth(&gamma(&reference))) * two();
    let left = reference.raise(&reference.variation()?.momentum_rate);
    Ok(vec![Equality::vectors("Omega_1", &left, &right)])
}
