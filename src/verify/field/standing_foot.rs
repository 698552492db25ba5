//! The rows of a standing foot.

use super::constraint_kinds::pair;
use super::reference::{Reference, effort};
use super::theorem_b3::omega_of;
use super::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::constraint::{FootDerivatives, FootWeights, StandingFoot};
use crate::dynamics::{Data, root_wrench};
use crate::error::Result;
use crate::flow::{FootPenalty, Penalty, constrained_lagrangian};
use crate::scalar::{AlgebraOver, Tanh};
use crate::verify::reference::{jacobian, omega_by_theorem_b3, variation, vector};
use nalgebra::{DMatrix, DVector};
use num_traits::One;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![
        Identity {
            label: "standing foot",
            statement: "value and contractions",
            convention: "g <= 0 is feasible; s weighs gradients, w second derivatives, c products of gradients",
            claims: foot,
        },
        Identity {
            label: "standing foot in the flow",
            statement: "the flow of L + sum b(g_j) is Omega and the terms of the rows",
            convention: "g <= 0 is feasible; tanh is formal, its derivative is 1 - tanh^2",
            claims: flow,
        },
    ]
}

/// The paper's Lagrangian with the penalties of the rows.
fn constrained<S: AlgebraOver<Gf> + Tanh>(p: &RandomInstance, x: &[S], xdot: &[S]) -> Result<S> {
    let Penalty { k_cons, c_cons } = pair(p);
    let rows = rows(p, &[x, &xdot[p.dof()..]].concat())?;
    let own = effort(p, x, xdot)?;
    Ok(constrained_lagrangian(own, rows.iter().copied(), k_cons, c_cons))
}

fn flow(p: &RandomInstance) -> Result<Vec<Equality>> {
    let v = variation(p.node(), |_, x, xdot| constrained(p, x, xdot))?;
    let left = Reference::at(p)?.raise(&(v.momentum_rate - v.by_x));
    let foot = sole(p);
    let terms = omega_of(p, FootPenalty::new(&p.model, &foot, pair(p)))?;
    let right = omega_by_theorem_b3(&p.at())? + terms;
    Ok(vec![Equality::vectors("flow", &left, &right)])
}

/// A sole anywhere on the base, whose axes are those of a joint.
fn sole(p: &RandomInstance) -> StandingFoot<Gf> {
    let [half_length, half_width, friction, torsion, weight, ..] = p.extra;
    StandingFoot {
        name: String::new(),
        sole: *p.model.joints()[1].origin(),
        half_length,
        half_width,
        friction,
        torsion: Some(torsion),
        weight,
    }
}

fn rows<S: AlgebraOver<Gf>>(p: &RandomInstance, z: &[S]) -> Result<DVector<S>> {
    let (n, foot) = (p.dof(), sole(p));
    let mut g = DVector::zeros(foot.dim());
    let z = [0, 1, 2].map(|part| &z[part * n..(part + 1) * n]);
    foot.value(&p.model, &mut Data::new(&p.model), z, g.as_mut_slice())?;
    Ok(g)
}

/// The rows by their definition: moment and force in the axes of the sole, about its middle.
fn by_definition(p: &RandomInstance) -> Result<DVector<Gf>> {
    let (node, foot) = (p.node(), sole(p));
    let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
    let wrench = root_wrench(&p.model, &mut Data::new(&p.model), q, v, a)?;
    let (axes, at) = (foot.sole.rotation.transpose(), foot.sole.translation);
    let share = foot.weight.inverse();
    let m = axes * (wrench.angular - at.cross(&wrench.linear)) * share;
    let f = axes * wrench.linear * share;
    let (l, b, mu) = (foot.half_length, foot.half_width, foot.friction);
    let torsion = p.extra[3];
    let friction = f.x * f.x + f.y * f.y - mu * mu * f.z * f.z;
    let two = Gf::one() + Gf::one();
    Ok(vector(&[
        -f.z,
        -m.y - l * f.z,
        m.y - l * f.z,
        m.x - b * f.z,
        -m.x - b * f.z,
        -m.z - torsion * f.z,
        m.z - torsion * f.z,
        friction * (two * mu).inverse(),
    ]))
}

fn foot(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node, foot) = (p.dof(), p.node(), sole(p));
    let parts = [node.x_p1(), node.x_p2(), node.xdot_p2()];
    let z = parts.concat();
    let weight = |from: &DVector<Gf>| -> Vec<Gf> {
        let each = (0..foot.dim()).map(|j| from[j % from.len()] * Gf::new(j as u64 + 1));
        each.collect()
    };
    let (slopes, multipliers, curvatures) = (weight(&p.w), weight(&p.xdot), weight(&p.xddot));
    let mut out = FootDerivatives::new(n);
    let weights = FootWeights { slopes: &slopes, multipliers: &multipliers, curvatures: &curvatures };
    let data = &mut Data::new(&p.model);
    foot.weighted_derivatives(&p.model, data, parts, weights, &mut out)?;

    let by_z = jacobian(&z, |z| rows(p, z))?;
    let fixed = vector(&multipliers).map(Jet1::constant);
    let mut second = jacobian(&z, |z: &[Jet1]| Ok(jacobian(z, |z| rows(p, z))?.tr_mul(&fixed)))?;
    second += by_z.transpose() * DMatrix::from_diagonal(&vector(&curvatures)) * &by_z;
    Ok(vec![
        Equality::vectors("g", &rows(p, &z)?, &by_definition(p)?),
        Equality::vectors("gradient", &out.gradient, &by_z.tr_mul(&vector(&slopes))),
        Equality::new("Hessian", out.hessian, second),
    ])
}
