//! The chain rule at one node and the composition of the blocks: (B37) to (B44).

use super::law;
use crate::error::Result;
use crate::flow::jacobian::theorem_b4::Quantities;
use crate::scalar::AlgebraOver;
use crate::verify::field::wrt::{NodeFunction, Wrt, block, derivative, gathered, omega_1, omega_2, omega_3, omega_4};
use crate::verify::field::{Equality, Gf, Identity, RandomInstance};
use crate::verify::reference::{At, constant, jacobian, omega_by_definition, omega_by_theorem_b3, omega_terms};
use nalgebra::DMatrix;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![
        law("B37", "Jacobian of a node by blocks", b37),
        law("B38", "dOmega/dx of the flow", |p| block(p, Wrt::X, omega_by_definition, |t, k| t.domega_dx(k))),
        law("B39", "dOmega/dxdot of the flow", |p| block(p, Wrt::Xdot, omega_by_definition, |t, k| t.domega_dxdot(k))),
        law("B40", "dOmega/dxddot of the flow is 2 I", |p| {
            block(p, Wrt::Xddot, omega_by_definition, |t, _| t.domega_dxddot())
        }),
        law("B41", "Jacobian of a node is that of Omega", b41),
        law("B42", "chain rule at a node", b42),
        law("B43", "flow = sum of four terms", b43),
        law("B44", "dOmega/dx is the sum of four", |p| of_terms(p, Wrt::X, |t, k| t.domega_dx(k))),
    ]
}

/// The Jacobian of `f` in $\xi_i$ if `xdot` and `xddot` change with the entries of `D` and `D^2`.
fn collocated(p: &RandomInstance, f: NodeFunction) -> Result<DMatrix<Gf>> {
    let (z, m) = (p.z(), 2 * p.dof());
    jacobian(&z[..m], |xi| {
        let mut z = constant(&z);
        for i in 0..m {
            let step = xi[i] - z[i];
            z[i] += step;
            z[m + i] += step.scale(p.extra[0]);
            z[2 * m + i] += step.scale(p.extra[1]);
        }
        f(&At::new(&p.model, &z, p.k))
    })
}

/// $M_0 + D_{ii} M_1 + (D^2)_{ii} M_2$.
fn chain(p: &RandomInstance, [x, xdot, xddot]: [DMatrix<Gf>; 3]) -> DMatrix<Gf> {
    x + xdot * p.extra[0] + xddot * p.extra[1]
}

fn b37(p: &RandomInstance) -> Result<Vec<Equality>> {
    let t = gathered(p)?;
    let blocks = [t.domega_dx(p.k), t.domega_dxdot(p.k), t.domega_dxddot()];
    let left = collocated(p, omega_by_definition)?;
    Ok(vec![Equality::new("J_Xi", left, chain(p, blocks))])
}

fn b41(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (left, right) = (collocated(p, omega_by_definition)?, collocated(p, omega_by_theorem_b3)?);
    Ok(vec![Equality::new("J_Xi", left, right)])
}

fn b42(p: &RandomInstance) -> Result<Vec<Equality>> {
    let by = |part| derivative(p, part, omega_by_definition);
    let blocks = [by(Wrt::X)?, by(Wrt::Xdot)?, by(Wrt::Xddot)?];
    let left = collocated(p, omega_by_theorem_b3)?;
    Ok(vec![Equality::new("J_Xi", left, chain(p, blocks))])
}

fn b43(p: &RandomInstance) -> Result<Vec<Equality>> {
    let [one, two, three, four] = omega_terms(&p.at())?;
    let (left, right) = (omega_by_definition(&p.at())?, one - (two - three + four));
    Ok(vec![Equality::vectors("Omega", &left, &right)])
}

/// Compares the derivative of `omega_by_definition`, and the composition of the library, with the sum of the
/// derivatives of the four terms.
pub(super) fn of_terms(
    p: &RandomInstance,
    part: Wrt,
    ours: fn(&Quantities<Gf>, Gf) -> DMatrix<Gf>,
) -> Result<Vec<Equality>> {
    let of = |f: NodeFunction| derivative(p, part, f);
    let terms = of(omega_1)? - (of(omega_2)? - of(omega_3)? + of(omega_4)?);
    Ok(vec![
        Equality::new("flow", of(omega_by_definition)?, terms.clone()),
        Equality::new("blocks", ours(&gathered(p)?, p.k), terms),
    ])
}
