//! Algorithm B2: the result of each line against its definition.

use super::dynamics_derivatives::{aba_2d, of_bias, of_inverse_dynamics, of_mass};
use super::wrt::{Wrt, derivative, gathered, unfold};
use super::{Equality, Identity, RandomInstance};
use crate::error::Result;
use crate::flow::jacobian::{NodeBlocks, TheoremB4};
use crate::verify::reference::{
    bias_force, bias_rate, constant, fd_0, inverse_dynamics, jacobian, mass, mass_rate, omega_by_definition,
};
use nalgebra::{DMatrix, DVector};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let line = |label, statement, claims| Identity {
        label,
        statement,
        convention: "the derivative index of a tensor comes last, in the order of the derivatives",
        claims,
    };
    vec![
        line("Algorithm B2 line 1", "CRBA_2D", line_1),
        line("Algorithm B2 line 2", "ABA_D at no force", line_2),
        line("Algorithm B2 line 3", "RNEA gives C", line_3),
        line("Algorithm B2 line 4", "RNEA_D gives dC", line_4),
        line("Algorithm B2 line 5", "Cdot", line_5),
        line("Algorithm B2 line 6", "get_Hdot_D", line_6),
        line("Algorithm B2 line 7", "RNEA_2D at no acceleration", line_7),
        line("Algorithm B2 line 8", "RNEA_2D at FD_0", line_8),
        line("Algorithm B2 line 9", "ABA_2D", aba_2d),
        line("Algorithm B2 line 10", "get_Cdot_D", line_10),
        line("Algorithm B2 line 11", "the Jacobian", line_11),
    ]
}

fn line_1(p: &RandomInstance) -> Result<Vec<Equality>> {
    of_mass(p, p.node().xdot_p1(), &gathered(p)?.mass)
}

fn line_2(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node, fd) = (p.dof(), p.node(), gathered(p)?.fd0);
    let (q, v) = (node.x_p1(), node.x_p2());
    let (fixed_q, fixed_v) = (constant(q), constant(v));
    let force = inverse_dynamics(&p.model, q, v, fd.a.as_slice())?;
    let dq = jacobian(q, |q| fd_0(&p.model, q, &fixed_v))?;
    let dv = jacobian(v, |v| fd_0(&p.model, &fixed_q, v))?;
    let product = mass(&p.model, q)? * &fd.h_inverse;
    Ok(vec![
        Equality::vectors("ID at FD_0", &force, &DVector::zeros(n)),
        Equality::new("dFD_0/dx_P1", fd.dq, dq),
        Equality::new("dFD_0/dx_P2", fd.dv, dv),
        Equality::new("H H^-1", product, DMatrix::identity(n, n)),
    ])
}

/// `C` equals `ID` minus `H a`, for any `a`.
fn line_3(p: &RandomInstance) -> Result<Vec<Equality>> {
    let node = p.node();
    let force = inverse_dynamics(&p.model, node.x_p1(), node.x_p2(), p.w.as_slice())?;
    let right = force - mass(&p.model, node.x_p1())? * &p.w;
    Ok(vec![Equality::vectors("C", &gathered(p)?.c, &right)])
}

fn line_4(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, dc) = (p.dof(), gathered(p)?.dc);
    let by_duals = jacobian(p.node().x, |x| bias_force(&p.model, &x[..n], &x[n..]))?;
    let part = |i: usize| by_duals.columns(i * n, n).into_owned();
    Ok(vec![Equality::new("dC/dx_P1", dc.dq, part(0)), Equality::new("dC/dx_P2", dc.dv, part(1))])
}

fn line_5(p: &RandomInstance) -> Result<Vec<Equality>> {
    let right = bias_rate(&p.at())?;
    Ok(vec![Equality::vectors("Cdot", &gathered(p)?.cdot, &right)])
}

fn line_6(p: &RandomInstance) -> Result<Vec<Equality>> {
    let left = unfold(p.dof(), gathered(p)?.dhdot.entries());
    let right = derivative(p, Wrt::XP1, mass_rate)?;
    Ok(vec![Equality::new("dHdot/dx_P1", left, right)])
}

fn line_7(p: &RandomInstance) -> Result<Vec<Equality>> {
    of_bias(p, &gathered(p)?.d2c)
}

fn line_8(p: &RandomInstance) -> Result<Vec<Equality>> {
    let fd0 = fd_0(&p.model, p.node().x_p1(), p.node().x_p2())?;
    of_inverse_dynamics(p, fd0.as_slice(), &gathered(p)?.d2id)
}

fn line_10(p: &RandomInstance) -> Result<Vec<Equality>> {
    let dcdot = gathered(p)?.dcdot;
    let by = |part| derivative(p, part, bias_rate);
    Ok(vec![
        Equality::new("dCdot/dx_P1", dcdot.dq, by(Wrt::XP1)?),
        Equality::new("dCdot/dx_P2", dcdot.dv, by(Wrt::XP2)?),
    ])
}

fn line_11(p: &RandomInstance) -> Result<Vec<Equality>> {
    let mut found = NodeBlocks::new(p.dof());
    TheoremB4::new(&p.model).blocks(p.node(), p.k, &mut found)?;
    let by = |part| derivative(p, part, omega_by_definition);
    Ok(vec![
        Equality::new("dOmega/dx", found.dx, by(Wrt::X)?),
        Equality::new("dOmega/dxdot", found.dxdot, by(Wrt::Xdot)?),
        Equality::new("dOmega/dxddot", found.dxddot, by(Wrt::Xddot)?),
    ])
}
