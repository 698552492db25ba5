//! (A1) to (A4): constraints as penalties, and the constrained flow with limits on the torque.

use super::constraint_kinds::{pair, rows, set};
use super::reference::{JJ, Reference, effort, rate, variation};
use super::reference_b4::{In, derivative, node};
use super::{Equality, F, Identity, J, Point};
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::flow::Penalty;
use crate::flow::jacobian::{ControlFormJacobian, NodeBlocks, NodeJacobian, TheoremB4};
use crate::flow::{
    RightHandSide, Sum, activation, activation_slope, constrained_lagrangian, penalty,
    penalty_curvature, penalty_slope,
};
use crate::scalar::{AlgebraOver, Scalar, Tanh};
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
        identity(
            "constrained Jacobian",
            "its three blocks",
            constrained_jacobian,
        ),
    ]
}

/// $L_{cons}$ over any scalar, the torque left out unless asked for.
fn constrained<S: AlgebraOver<F> + Tanh>(
    p: &Point,
    torque: bool,
    x: &[S],
    xdot: &[S],
) -> Result<S> {
    let (set, n) = (set(p), p.dof());
    let Penalty { k_cons, c_cons } = set.weights.state;
    let g = rows(p, &set.constraints.state, x)?;
    let lagrangian = constrained_lagrangian(effort(p, x, xdot)?, g, k_cons, c_cons);
    if !torque {
        return Ok(lagrangian);
    }
    let mut u = vec![S::zero(); n];
    let data = &mut Data::new(&p.model);
    rnea(&p.model, data, &x[..n], &x[n..], &xdot[n..], &mut u)?;
    let mut g = vec![S::zero(); set.constraints.torque.dim()];
    set.constraints.torque.value(&u, &mut g)?;
    let Penalty { k_cons, c_cons } = set.weights.torque;
    Ok(constrained_lagrangian(lagrangian, g, k_cons, c_cons))
}

fn half() -> F {
    F::from_f64(0.5)
}

fn a1(p: &Point) -> Result<Vec<Equality>> {
    let left = constrained(p, false, p.x.as_slice(), p.xdot.as_slice())?;
    let (reference, mut right) = (Reference::at(p)?, F::zero());
    let Penalty { k_cons, c_cons } = pair(p);
    for g in rows(p, &set(p).constraints.state, p.x.as_slice())? {
        let s = half() + half() * (c_cons * g).tanh();
        right += k_cons * g * g * s;
    }
    let slip = reference.slip();
    right += slip.dot(&(reference.metric() * &slip));
    Ok(vec![Equality::numbers("Lcons", left, right)])
}

fn a2(p: &Point) -> Result<Vec<Equality>> {
    let (
        Penalty {
            k_cons: k,
            c_cons: c,
        },
        mut claims,
    ) = (pair(p), Vec::new());
    for g in rows(p, &set(p).constraints.state, p.x.as_slice())? {
        let s = half() * (F::one() + (g * c).tanh());
        claims.push(Equality::numbers("b", penalty(g, k, c), k * g * g * s));
        let at = |i: usize| pair(p).derivatives(g)[i];
        claims.push(Equality::numbers("b once more", penalty(g, k, c), at(0)));
        let one = [F::one()];
        let slope = rate(&[g], &one, |g| Ok(vec![penalty(g[0], k, c)]))?[0];
        claims.push(Equality::numbers("b'", slope, penalty_slope(g, k, c)));
        let curvature = rate(&[g], &one, |g| Ok(vec![penalty_slope(g[0], k, c)]))?[0];
        claims.push(Equality::numbers(
            "b''",
            curvature,
            penalty_curvature(g, k, c),
        ));
        let third = rate(&[g], &one, |g| Ok(vec![penalty_curvature(g[0], k, c)]))?[0];
        claims.push(Equality::numbers("b'''", third, at(3)));
    }
    let at_zero = penalty_slope(F::zero(), k, c);
    claims.push(Equality::numbers("b' on the boundary", at_zero, F::zero()));
    let at_zero = penalty_curvature(F::zero(), k, c);
    claims.push(Equality::numbers("b'' on the boundary", at_zero, k));
    Ok(claims)
}

fn a3(p: &Point) -> Result<Vec<Equality>> {
    let (g, c) = (p.extra[7], pair(p).c_cons);
    let slope = rate(&[g], &[F::one()], |g| Ok(vec![activation(g[0], c)]))?[0];
    let (s, tanh) = (activation(g, c), (c * g).tanh());
    let logistic = (c + c) * s * (F::one() - s);
    Ok(vec![
        Equality::numbers("S'", slope, activation_slope(g, c)),
        Equality::numbers("S' printed", slope, c * half() * (F::one() - tanh * tanh)),
        Equality::numbers("S' = 2 c S (1 - S)", slope, logistic),
        Equality::numbers("S(g) + S(-g)", s + activation(-g, c), F::one()),
        Equality::numbers("S(0)", activation(F::zero(), c), half()),
    ])
}

fn a4(p: &Point) -> Result<Vec<Equality>> {
    let reference = Reference::at(p)?;
    let of_constrained = variation(p, |x: &[JJ], xdot: &[JJ]| constrained(p, false, x, xdot))?;
    let left = reference.raise(&(of_constrained.momentum_rate - of_constrained.by_x));

    let (mut omega, mut of_state) = (DVector::zeros(2 * p.dof()), DVector::zeros(2 * p.dof()));
    reference
        .theorem()
        .omega(p.node(), p.k, omega.as_mut_slice())?;
    let mut penalties = set(p);
    penalties.constraints.torque.0.clear();
    let terms = &mut penalties.state_penalty(&p.model);
    terms.omega(p.node(), p.k, of_state.as_mut_slice())?;
    Ok(vec![
        Equality::vectors(
            "dLcons/dxdot",
            &of_constrained.by_xdot,
            &reference.variation()?.by_xdot,
        ),
        Equality::vectors("flow", &left, &(omega + of_state)),
    ])
}

fn flow(p: &Point) -> Result<Vec<Equality>> {
    let (reference, set) = (Reference::at(p)?, set(p));
    let v = variation(p, |x: &[JJ], xdot: &[JJ]| constrained(p, true, x, xdot))?;
    let left = reference.raise(&(v.momentum_rate - v.by_x));
    let omega = |rhs: &mut dyn RightHandSide<F, F>| -> Result<DVector<F>> {
        let mut omega = DVector::zeros(2 * p.dof());
        rhs.omega(p.node(), p.k, omega.as_mut_slice())?;
        Ok(omega)
    };
    let whole = omega(&mut set.right_hand_side(&p.model))?;
    let of_torque = crate::flow::ControlForm::of_cost(&p.model, set.torque_penalty());
    let terms = omega(&mut Sum::new(of_torque, set.state_penalty(&p.model)))?;
    let mut paper = DVector::zeros(2 * p.dof());
    reference
        .theorem()
        .omega(p.node(), p.k, paper.as_mut_slice())?;
    Ok(vec![
        Equality::vectors("control form", &left, &whole),
        Equality::vectors("Theorem B3 and the terms", &left, &(paper + terms)),
    ])
}

/// The right-hand side that the Jacobians are of.
fn right_hand_side(p: &Point, z: &[J]) -> Result<Vec<J>> {
    let mut omega = vec![J::zero(); 2 * p.dof()];
    let set = set(p);
    set.right_hand_side(&p.model)
        .omega(node(z), p.k, &mut omega)?;
    Ok(omega)
}

fn constrained_jacobian(p: &Point) -> Result<Vec<Equality>> {
    let (set, model) = (set(p), &p.model);
    let whole = ControlFormJacobian::with_cost(model, set.torque_penalty());
    let of_torque = ControlFormJacobian::of_cost(model, set.torque_penalty());
    let on_b4 = Sum::new(TheoremB4::new(model), of_torque);
    let mut claims = Vec::new();
    let mut claim = |jacobian: &mut dyn NodeJacobian<F, F>| -> Result<()> {
        let mut out = NodeBlocks::new(p.dof());
        jacobian.evaluate(p.node(), p.k, &mut out)?;
        for (what, part, ours) in [
            ("dx", In::X, out.dx),
            ("dxdot", In::Xdot, out.dxdot),
            ("dxddot", In::Xddot, out.dxddot),
        ] {
            claims.push(Equality::new(
                what,
                ours,
                derivative(p, part, right_hand_side)?,
            ));
        }
        Ok(())
    };
    claim(&mut Sum::new(whole, set.state_penalty(model)))?;
    claim(&mut Sum::new(on_b4, set.state_penalty(model)))?;
    Ok(claims)
}
