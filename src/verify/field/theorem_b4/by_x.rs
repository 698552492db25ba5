//! The derivatives in the state and the quantities: (B45) to (B60).

use super::law;
use crate::error::Result;
use crate::flow::jacobian::theorem_b4::Quantities;
use crate::verify::field::wrt::{Wrt, block, gathered, omega_1, omega_2, omega_3, omega_4};
use crate::verify::field::{Equality, Gf, Identity, RandomInstance};
use crate::verify::reference::{At, alpha_1, alpha_2, capital_gamma, gamma};
use nalgebra::DVector;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![
        law("B45", "dOmega_1/dx", |p| block(p, Wrt::X, omega_1, |t, _| t.domega_1_dx())),
        law("B46", "dOmega_2/dx", |p| block(p, Wrt::X, omega_2, |t, k| t.domega_2_dx(k))),
        law("B47", "dOmega_3/dx", |p| block(p, Wrt::X, omega_3, |t, k| t.domega_3_dx(k))),
        law("B48", "dOmega_4/dx", |p| block(p, Wrt::X, omega_4, |t, k| t.domega_4_dx(k))),
        law("B49", "gamma is a rate of momentum", |p| value(p, gamma, Quantities::gamma)),
        law("B50", "alpha_1 is a gradient in x_P1", |p| value(p, alpha_1, Quantities::alpha_1)),
        law("B51", "alpha_2 is a gradient in x_P2", |p| value(p, alpha_2, Quantities::alpha_2)),
        law("B52", "Gamma is a gradient in x_P1", |p| value(p, capital_gamma, Quantities::capital_gamma)),
        law("B53", "dgamma/dx_P1", |p| block(p, Wrt::XP1, gamma, |t, _| t.dgamma_dx_p1())),
        law("B54", "dgamma/dx_P2", |p| block(p, Wrt::XP2, gamma, |t, _| t.dgamma_dx_p2())),
        law("B55", "dalpha_1/dx_P1", |p| block(p, Wrt::XP1, alpha_1, |t, _| t.dalpha_1_dx_p1())),
        law("B56", "dalpha_2/dx_P1", |p| block(p, Wrt::XP1, alpha_2, |t, _| t.dalpha_2_dx_p1())),
        law("B57", "dalpha_1/dx_P2", |p| block(p, Wrt::XP2, alpha_1, |t, _| t.dalpha_1_dx_p2())),
        law("B58", "dalpha_2/dx_P2", |p| block(p, Wrt::XP2, alpha_2, |t, _| t.dalpha_2_dx_p2())),
        law("B59", "dGamma/dx_P1", |p| block(p, Wrt::XP1, capital_gamma, |t, _| t.dcapital_gamma_dx_p1())),
        law("B60", "dGamma/dx_P2", |p| block(p, Wrt::XP2, capital_gamma, |t, _| t.dcapital_gamma_dx_p2())),
    ]
}

/// Compares a quantity by its formula with its definition.
fn value(
    p: &RandomInstance,
    meaning: fn(&At<'_, Gf, Gf>) -> Result<DVector<Gf>>,
    formula: fn(&Quantities<Gf>) -> DVector<Gf>,
) -> Result<Vec<Equality>> {
    let (left, right) = (formula(&gathered(p)?), meaning(&p.at())?);
    Ok(vec![Equality::vectors("value", &left, &right)])
}
