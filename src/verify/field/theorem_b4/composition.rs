//! The chain rule at one node and the composition of the blocks: (B37) to (B44).

use super::law;
use crate::error::Result;
use crate::flow::jacobian::theorem_b4::Quantities;
use crate::scalar::AlgebraOver;
use crate::verify::field::reference::jacobian;
use crate::verify::field::reference_b4::{
    In, Of, all, block, constant, derivative, flow, gathered, omega_1, omega_2, omega_3, omega_4,
    sum,
};
use crate::verify::field::{Equality, F, Identity, Point};
use nalgebra::DMatrix;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![
        law("B37", "Jacobian of a node by blocks", b37),
        law("B38", "dOmega/dx of the flow", |p| {
            block(p, In::X, flow, |t, k| t.domega_dx(k))
        }),
        law("B39", "dOmega/dxdot of the flow", |p| {
            block(p, In::Xdot, flow, |t, k| t.domega_dxdot(k))
        }),
        law("B40", "dOmega/dxddot of the flow is 2 I", |p| {
            block(p, In::Xddot, flow, |t, _| t.domega_dxddot())
        }),
        law("B41", "Jacobian of a node is that of Omega", b41),
        law("B42", "chain rule at a node", b42),
        law("B43", "flow = sum of four terms", b43),
        law("B44", "dOmega/dx is the sum of four", |p| {
            of_terms(p, In::X, |t, k| t.domega_dx(k))
        }),
    ]
}

/// The Jacobian of `f` in $\xi_i$ where `xdot` and `xddot` move along with the entries of `D` and `D^2`.
fn collocated(p: &Point, f: Of) -> Result<DMatrix<F>> {
    let (all, m) = (all(p), 2 * p.dof());
    jacobian(&all[..m], |xi| {
        let mut z = constant(&all);
        for i in 0..m {
            let step = xi[i] - z[i];
            z[i] += step;
            z[m + i] += step.scale(p.extra[0]);
            z[2 * m + i] += step.scale(p.extra[1]);
        }
        f(p, &z)
    })
}

/// $M_0 + D_{ii} M_1 + (D^2)_{ii} M_2$.
fn chain(p: &Point, [x, xdot, xddot]: [DMatrix<F>; 3]) -> DMatrix<F> {
    x + xdot * p.extra[0] + xddot * p.extra[1]
}

fn b37(p: &Point) -> Result<Vec<Equality>> {
    let t = gathered(p)?;
    let blocks = [t.domega_dx(p.k), t.domega_dxdot(p.k), t.domega_dxddot()];
    let left = collocated(p, flow)?;
    Ok(vec![Equality::new("J_Xi", left, chain(p, blocks))])
}

fn b41(p: &Point) -> Result<Vec<Equality>> {
    let (left, right) = (collocated(p, flow)?, collocated(p, sum)?);
    Ok(vec![Equality::new("J_Xi", left, right)])
}

fn b42(p: &Point) -> Result<Vec<Equality>> {
    let by = |part| derivative(p, part, flow);
    let blocks = [by(In::X)?, by(In::Xdot)?, by(In::Xddot)?];
    let left = collocated(p, sum)?;
    Ok(vec![Equality::new("J_Xi", left, chain(p, blocks))])
}

fn b43(p: &Point) -> Result<Vec<Equality>> {
    let z = all(p);
    let column = |x: Vec<F>| DMatrix::from_vec(x.len(), 1, x);
    let terms = column(omega_1(p, &z)?)
        - (column(omega_2(p, &z)?) - column(omega_3(p, &z)?) + column(omega_4(p, &z)?));
    Ok(vec![Equality::new("Omega", column(flow(p, &z)?), terms)])
}

/// The derivative of the flow, and our composition, against the sum of the derivatives of the four terms.
pub(super) fn of_terms(
    p: &Point,
    part: In,
    ours: fn(&Quantities<F>, F) -> DMatrix<F>,
) -> Result<Vec<Equality>> {
    let of = |f: Of| derivative(p, part, f);
    let terms = of(omega_1)? - (of(omega_2)? - of(omega_3)? + of(omega_4)?);
    Ok(vec![
        Equality::new("flow", of(flow)?, terms.clone()),
        Equality::new("blocks", ours(&gathered(p)?, p.k), terms),
    ])
}
