//! The derivatives in the rates of the state and the relations between them: (B61) to (B80).

use super::composition::of_terms;
use super::law;
use crate::error::Result;
use crate::verify::field::wrt::{
    NodeFunction, Wrt, block, derivative, gathered, omega_1, omega_2, omega_3, omega_4, unfold,
};
use crate::verify::field::{Equality, Identity, RandomInstance};
use crate::verify::reference::{alpha_1, alpha_2, bias_rate, capital_gamma, entries, gamma, jacobian, mass, mass_rate};
use nalgebra::DMatrix;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let mut identities = blocks();
    identities.extend(parts());
    identities.extend(relations());
    identities
}

fn blocks() -> Vec<Identity> {
    vec![
        law("B61", "dOmega/dxdot is the sum of four", |p| of_terms(p, Wrt::Xdot, |t, k| t.domega_dxdot(k))),
        law("B62", "dOmega_1/dxdot", |p| block(p, Wrt::Xdot, omega_1, |t, _| t.domega_1_dxdot())),
        law("B63", "dOmega_2/dxdot", |p| block(p, Wrt::Xdot, omega_2, |t, k| t.domega_2_dxdot(k))),
        law("B64", "dOmega_3/dxdot", |p| block(p, Wrt::Xdot, omega_3, |t, k| t.domega_3_dxdot(k))),
        law("B65", "dOmega_4/dxdot", |p| block(p, Wrt::Xdot, omega_4, |t, k| t.domega_4_dxdot(k))),
    ]
}

fn parts() -> Vec<Identity> {
    vec![
        law("B66", "dalpha_1/dxdot_P2", |p| block(p, Wrt::XdotP2, alpha_1, |t, _| t.dalpha_1_dxdot_p2())),
        law("B67", "dalpha_2/dxdot_P2", |p| block(p, Wrt::XdotP2, alpha_2, |t, _| t.dalpha_2_dxdot_p2())),
        law("B68", "dgamma/dxdot_P1, not simplified", |p| {
            block(p, Wrt::XdotP1, gamma, |t, _| t.dgamma_dxdot_p1_unsimplified())
        }),
        law("B69", "dgamma/dxdot_P2, not simplified", |p| {
            block(p, Wrt::XdotP2, gamma, |t, _| t.dgamma_dxdot_p2_unsimplified())
        }),
        law("B70", "dGamma/dxdot_P2", |p| block(p, Wrt::XdotP2, capital_gamma, |t, _| t.dcapital_gamma_dxdot_p2())),
    ]
}

fn relations() -> Vec<Identity> {
    vec![
        law("B71", "Hdot by the chain rule", b71),
        law("B72", "Cdot by the chain rule", b72),
        law("B73", "dH/dx_P1 is symmetric", b73),
        law("B74", "dHdot/dxdot_P1 = dH/dx_P1", b74),
        law("B75", "dCdot/dxdot_P1 = dC/dx_P1", |p| {
            block(p, Wrt::XdotP1, bias_rate, |t, _| t.dcdot_dxdot_p1().clone())
        }),
        law("B76", "dgamma/dxdot_P1", |p| block(p, Wrt::XdotP1, gamma, |t, _| t.dgamma_dxdot_p1())),
        law("B77", "dgamma/dxdot_P2", b77),
        law("B78", "dOmega/dxddot, not simplified", |p| {
            block(p, Wrt::Xddot, omega_1, |t, _| t.domega_dxddot_unsimplified())
        }),
        law("B79", "dgamma/dxddot_P2 = H^T H", |p| block(p, Wrt::XddotP2, gamma, |t, _| t.dgamma_dxddot_p2())),
        law("B80", "dOmega_1/dxddot = 2 I", |p| block(p, Wrt::Xddot, omega_1, |t, _| t.domega_dxddot())),
    ]
}

fn b71(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (t, n) = (gathered(p)?, p.dof());
    let left = DMatrix::from_column_slice(n, n, mass_rate(&p.at())?.as_slice());
    let right = t.mass.dq.times_third(&t.xdot_p1);
    Ok(vec![Equality::new("Hdot", left, right)])
}

fn b72(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = gathered(p)?;
    let left = bias_rate(&p.at())?;
    let right = &t.dc.dq * &t.xdot_p1 + &t.dc.dv * &t.xdot_p2;
    Ok(vec![Equality::vectors("Cdot", &left, &right)])
}

/// Compares the tensor of `H^T` by dual numbers with the one of `H` here.
fn b73(p: &RandomInstance) -> Result<Vec<Equality>> {
    let right = jacobian(p.node().x_p1(), |q| Ok(entries(&mass(&p.model, q)?.transpose())))?;
    let left = unfold(p.dof(), gathered(p)?.mass.dq.entries());
    Ok(vec![Equality::new("dH/dx_P1", left, right)])
}

fn b74(p: &RandomInstance) -> Result<Vec<Equality>> {
    let left = unfold(p.dof(), gathered(p)?.dhdot_dxdot_p1().entries());
    let right = derivative(p, Wrt::XdotP1, mass_rate)?;
    Ok(vec![Equality::new("dHdot/dxdot_P1", left, right)])
}

/// Includes the step without a label, $\partial \dot C / \partial \dot x_{P2} = \partial C / \partial x_{P2}$.
fn b77(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = gathered(p)?;
    let (dgamma, dcdot) = (t.dgamma_dxdot_p2(), t.dcdot_dxdot_p2().clone());
    let by = |f: NodeFunction| derivative(p, Wrt::XdotP2, f);
    Ok(vec![
        Equality::new("dgamma/dxdot_P2", dgamma, by(gamma)?),
        Equality::new("dCdot/dxdot_P2", dcdot, by(bias_rate)?),
    ])
}
