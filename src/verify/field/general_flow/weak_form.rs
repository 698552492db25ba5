//! The flow in an integral with a test function.

use super::made_up::{Coupled, MatrixAlone, Windy, lagrangian};
use crate::error::Result;
use crate::flow::{AffineLagrangian, ControlForm, Lagrangian, LagrangianFlow, Metric, RightHandSide};
use crate::verify::field::discretisation::numbers;
use crate::verify::field::theorem_b3::omega_of;
use crate::verify::field::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::verify::reference::{rate, variation, vector};
use nalgebra::DVector;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![Identity {
        label: "weak form of the flow",
        statement: "phi . L_x + phidot . L_xdot = d/dt (L_xdot . phi) - phi^T G Omega",
        convention: "any phi and phidot, and any x, xdot and xddot",
        claims: weak_form,
    }]
}

/// Both sides for a Lagrangian in a metric, with $\Omega$ from a right-hand side.
fn sides(
    p: &RandomInstance,
    what: &'static str,
    lagrangian: &impl Lagrangian<Gf>,
    metric: &impl Metric<Gf>,
    flow: impl RightHandSide<Gf, Gf>,
) -> Result<Equality> {
    let (node, model, mut number) = (p.node(), &p.model, numbers(p));
    let m = node.x.len();
    let [phi, phidot] = [(); 2].map(|()| DVector::from_fn(m, |_, _| number()));
    // The left side is the derivative of L along the test function.
    let y = [node.x, node.xdot].concat();
    let along = [phi.as_slice(), phidot.as_slice()].concat();
    let left = rate(&y, &along, |y| {
        let t = Jet1::constant(node.t);
        let value = lagrangian.value(model, t, &y[..m], &y[m..], p.k)?;
        Ok(DVector::from_element(1, value))
    })?[0];
    let v = variation(node, |t, x, xdot| lagrangian.value(model, t, x, xdot, p.k))?;
    let boundary = v.momentum_rate.dot(&phi) + v.by_xdot.dot(&phidot);
    let g = metric.matrix(model, node.t, node.x, p.k)?;
    let omega = omega_of(p, flow)?;
    Ok(Equality::numbers(what, left, boundary - vector(phi.as_slice()).dot(&(g * omega))))
}

fn weak_form(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (model, control) = (&p.model, lagrangian(p)?);
    let metric = MatrixAlone(control.metric());
    let affine = AffineLagrangian { drift: Windy, metric: Coupled };
    let of_control = ControlForm::of(model, control.clone());
    let of_affine = LagrangianFlow::in_metric(model, &affine, &Coupled);
    Ok(vec![
        sides(p, "control form", &control, &metric, of_control)?,
        sides(p, "any metric and drift", &affine, &Coupled, of_affine)?,
    ])
}
