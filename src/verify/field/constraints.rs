//! (A1) to (A4): constraints as penalties, and the constrained flow with limits on the torque.

use super::constraint_kinds::{Set, pair, rows, set};
use super::reference::{Reference, effort};
use super::theorem_b3::omega_of;
use super::wrt::{Wrt, derivative};
use super::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::error::Result;
use crate::flow::jacobian::{ControlFormJacobian, NodeBlocks, NodeJacobian, TheoremB4};
use crate::flow::{
    Penalty, RightHandSide, Sum, activation, activation_slope, constrained_lagrangian, penalty, penalty_curvature,
    penalty_slope,
};
use crate::scalar::{AlgebraOver, Scalar, Tanh};
use crate::verify::reference::{At, gradient, inverse_dynamics, omega_by_theorem_b3, variation};
use nalgebra::DVector;
use num_traits::{One, Zero};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let identity = |label, statement, claims| Identity {
        label,
        statement,
        convention: "g <= 0 is feasible; tanh is formal, its derivative is 1 - tanh^2",
        claims,
    };
    vec![
        identity("A1", "Lcons = L + sum b(g_j)", a1),
        identity("A2", "b = k_cons g^2 S and its derivatives", a2),
        identity("A3", "S = (1 + tanh(c g)) / 2 and its slope", a3),
        identity("A4", "the flow of Lcons is Omega - G^-1 sum db/dx", a4),
        identity("constrained flow", "flow of Lcons with torque limits", flow),
        identity("constrained Jacobian", "its three blocks", constrained_jacobian),
    ]
}

/// $L_{cons}$ over any scalar, with the torque limits only if `torque` is true.
fn constrained<S: AlgebraOver<Gf> + Tanh>(p: &RandomInstance, torque: bool, x: &[S], xdot: &[S]) -> Result<S> {
    let (set, n) = (set(p), p.dof());
    let Penalty { k_cons, c_cons } = set.weights.state;
    let g = rows(p, &set.constraints.state, x)?;
    let lagrangian = constrained_lagrangian(effort(p, x, xdot)?, g.iter().copied(), k_cons, c_cons);
    if !torque {
        return Ok(lagrangian);
    }
    let u = inverse_dynamics(&p.model, &x[..n], &x[n..], &xdot[n..])?;
    let mut g = vec![S::zero(); set.constraints.torque.dim()];
    set.constraints.torque.value(u.as_slice(), &mut g)?;
    let Penalty { k_cons, c_cons } = set.weights.torque;
    Ok(constrained_lagrangian(lagrangian, g, k_cons, c_cons))
}

fn half() -> Gf {
    Gf::from_f64(0.5)
}

fn a1(p: &RandomInstance) -> Result<Vec<Equality>> {
    let left = constrained(p, false, p.x.as_slice(), p.xdot.as_slice())?;
    let (reference, mut right) = (Reference::at(p)?, Gf::zero());
    let Penalty { k_cons, c_cons } = pair(p);
    for &g in &rows(p, &set(p).constraints.state, p.x.as_slice())? {
        let s = half() + half() * (c_cons * g).tanh();
        right += k_cons * g * g * s;
    }
    let slip = reference.slip();
    right += slip.dot(&(reference.metric() * &slip));
    Ok(vec![Equality::numbers("Lcons", left, right)])
}

fn a2(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (Penalty { k_cons: k, c_cons: c }, mut claims) = (pair(p), Vec::new());
    for &g in &rows(p, &set(p).constraints.state, p.x.as_slice())? {
        let s = half() * (Gf::one() + (g * c).tanh());
        claims.push(Equality::numbers("b", penalty(g, k, c), k * g * g * s));
        let at = |i: usize| pair(p).derivatives(g)[i];
        claims.push(Equality::numbers("b once more", penalty(g, k, c), at(0)));
        let slope = gradient(&[g], |g| Ok(penalty(g[0], k, c)))?[0];
        claims.push(Equality::numbers("b'", slope, penalty_slope(g, k, c)));
        let curvature = gradient(&[g], |g| Ok(penalty_slope(g[0], k, c)))?[0];
        claims.push(Equality::numbers("b''", curvature, penalty_curvature(g, k, c)));
        let third = gradient(&[g], |g| Ok(penalty_curvature(g[0], k, c)))?[0];
        claims.push(Equality::numbers("b'''", third, at(3)));
    }
    let at_zero = penalty_slope(Gf::zero(), k, c);
    claims.push(Equality::numbers("b' on the boundary", at_zero, Gf::zero()));
    let at_zero = penalty_curvature(Gf::zero(), k, c);
    claims.push(Equality::numbers("b'' on the boundary", at_zero, k));
    Ok(claims)
}

fn a3(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (g, c) = (p.extra[7], pair(p).c_cons);
    let slope = gradient(&[g], |g| Ok(activation(g[0], c)))?[0];
    let (s, tanh) = (activation(g, c), (c * g).tanh());
    let logistic = (c + c) * s * (Gf::one() - s);
    Ok(vec![
        Equality::numbers("S'", slope, activation_slope(g, c)),
        Equality::numbers("S' printed", slope, c * half() * (Gf::one() - tanh * tanh)),
        Equality::numbers("S' = 2 c S (1 - S)", slope, logistic),
        Equality::numbers("S(g) + S(-g)", s + activation(-g, c), Gf::one()),
        Equality::numbers("S(0)", activation(Gf::zero(), c), half()),
    ])
}

fn a4(p: &RandomInstance) -> Result<Vec<Equality>> {
    let reference = Reference::at(p)?;
    let of_constrained = variation(p.node(), |_, x, xdot| constrained(p, false, x, xdot))?;
    let left = reference.raise(&(of_constrained.momentum_rate - of_constrained.by_x));

    let omega = omega_by_theorem_b3(&p.at())?;
    let mut penalties = set(p);
    penalties.constraints.torque.0.clear();
    let of_state = omega_of(p, penalties.state_penalty(&p.model))?;
    Ok(vec![
        Equality::vectors("dLcons/dxdot", &of_constrained.by_xdot, &reference.variation()?.by_xdot),
        Equality::vectors("flow", &left, &(omega + of_state)),
    ])
}

fn flow(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (reference, set) = (Reference::at(p)?, set(p));
    let v = variation(p.node(), |_, x, xdot| constrained(p, true, x, xdot))?;
    let left = reference.raise(&(v.momentum_rate - v.by_x));
    let whole = omega_of(p, set.right_hand_side(&p.model))?;
    let of_torque = crate::flow::ControlForm::of_cost(&p.model, set.torque_penalty());
    let terms = omega_of(p, Sum::new(of_torque, set.state_penalty(&p.model)))?;
    let paper = omega_by_theorem_b3(&p.at())?;
    Ok(vec![
        Equality::vectors("control form", &left, &whole),
        Equality::vectors("Theorem B3 and the terms", &left, &(paper + terms)),
    ])
}

/// The right-hand side whose Jacobians are tested.
fn right_hand_side(set: &Set, at: &At<'_, Gf, Jet1>) -> Result<DVector<Jet1>> {
    let mut omega = DVector::zeros(at.node.x.len());
    let mut flow = set.right_hand_side(at.model);
    flow.omega(at.node, at.k, omega.as_mut_slice())?;
    Ok(omega)
}

fn constrained_jacobian(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (set, model) = (set(p), &p.model);
    let whole = ControlFormJacobian::with_cost(model, set.torque_penalty());
    let of_torque = ControlFormJacobian::of_cost(model, set.torque_penalty());
    let on_b4 = Sum::new(TheoremB4::new(model), of_torque);
    let mut claims = Vec::new();
    let mut claim = |jacobian: &mut dyn NodeJacobian<Gf, Gf>| -> Result<()> {
        let mut out = NodeBlocks::new(p.dof());
        jacobian.evaluate(p.node(), p.k, &mut out)?;
        for (what, part, ours) in
            [("dx", Wrt::X, out.dx), ("dxdot", Wrt::Xdot, out.dxdot), ("dxddot", Wrt::Xddot, out.dxddot)]
        {
            let right = derivative(p, part, |at| right_hand_side(&set, at))?;
            claims.push(Equality::new(what, ours, right));
        }
        Ok(())
    };
    claim(&mut Sum::new(whole, set.state_penalty(model)))?;
    claim(&mut Sum::new(on_b4, set.state_penalty(model)))?;
    Ok(claims)
}
