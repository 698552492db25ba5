//! Dual trajectories and the step of their multipliers.

use super::made_up::{trajectory, weights};
use crate::error::Result;
use crate::flow::{ControlCost, ControlDual, ControlLagrangian, DualTrajectory, Lagrangian};
use crate::scalar::{AlgebraOver, Jet};
use crate::verify::field::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::verify::reference::{Variation, dual, gradient, inverse_dynamics, variation, vector};
use nalgebra::{DMatrix, DVector};
use num_traits::{One, Zero};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![
        Identity {
            label: "dual trajectory",
            statement: "the recurrence of Clenshaw is the sum of Chebyshev polynomials, and duals its rate",
            convention: "T_k at s = 2 t / T - 1; dT_k/ds = k U_(k-1)",
            claims: clenshaw,
        },
        Identity {
            label: "dual cost of the control",
            statement: "derivatives of lambda(t) u in u and t",
            convention: "those of ControlCost, by hand and by duals of the value",
            claims: control_dual,
        },
        Identity {
            label: "step of the multipliers",
            statement: "L with (lambda, rho) and L with (lambda + rho c, 0) have the same Euler-Lagrange expression",
            convention: "c = (xdot_P1 - x_P2, u_i of the second half of the joints); rho = 2 k, 2 w_i",
            claims: step,
        },
    ]
}

fn two() -> Gf {
    Gf::one() + Gf::one()
}

fn clenshaw(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (lambda, n) = (trajectory(p, 0)?, p.dof());
    let s = p.t * two() / p.extra[0] - Gf::one();
    // Polynomials of both kinds by their recurrence.
    let (mut first, mut second) = (vec![Gf::one(), s], vec![Gf::one(), s + s]);
    for k in 2..lambda.coefficients().ncols() {
        first.push((s + s) * first[k - 1] - first[k - 2]);
        second.push((s + s) * second[k - 1] - second[k - 2]);
    }
    let mut slopes = vec![Gf::zero()];
    for k in 1..first.len() {
        let degree = (0..k).fold(Gf::zero(), |sum, _| sum + Gf::one());
        slopes.push(degree * second[k - 1] * two() / p.extra[0]);
    }
    let ours = |part: usize| DVector::from_fn(n, |i, _| lambda.value_and_rate(i, p.t)[part]);
    let alone = DVector::from_fn(n, |i, _| lambda.value(i, p.t));
    let values = lambda.coefficients() * vector(&first);
    Ok(vec![
        Equality::vectors("value", &ours(0), &values),
        Equality::vectors("value alone", &alone, &values),
        Equality::vectors("rate", &ours(1), &(lambda.coefficients() * vector(&slopes))),
    ])
}

fn control_dual(p: &RandomInstance) -> Result<Vec<Equality>> {
    let cost = ControlDual(trajectory(p, 0)?);
    let mut claims = Vec::new();
    for (i, u) in p.w.iter().enumerate() {
        let slope = |t: Jet1, u: Gf| -> Result<Jet1> {
            let moving = Jet::new(Jet1::constant(u), [Jet1::one()]);
            Ok(cost.value(Jet::constant(t), i, moving).eps[0])
        };
        let by_t = gradient(&[p.t], |t| slope(t[0], *u))?[0];
        let [first, second, third] = cost.derivatives(p.t, i, *u);
        let [rate, second_rate] = cost.rates(p.t, i, *u);
        claims.push(Equality::numbers("l'", first, slope(Jet1::constant(p.t), *u)?.re));
        claims.push(Equality::numbers("rate of l'", rate, by_t));
        let higher = vector(&[second, third, second_rate]);
        claims.push(Equality::vectors("higher", &higher, &DVector::zeros(3)));
    }
    Ok(claims)
}

/// The joints that are passive: the second half.
fn is_passive(p: &RandomInstance, joint: usize) -> bool {
    2 * joint >= p.dof()
}

/// `c` at $[t; x; \dot x]$: the slip, then the control at passive joints and zero at the others.
fn violation<S: AlgebraOver<Gf>>(p: &RandomInstance, x: &[S], xdot: &[S]) -> Result<DVector<S>> {
    let n = p.dof();
    let u = inverse_dynamics(&p.model, &x[..n], &x[n..], &xdot[n..])?;
    Ok(DVector::from_fn(2 * n, |i, _| match i.checked_sub(n) {
        None => xdot[i] - x[n + i],
        Some(joint) if is_passive(p, joint) => u[joint],
        Some(_) => S::zero(),
    }))
}

fn step(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node, model) = (p.dof(), p.node(), &p.model);
    let (slip_dual, of_control) = (trajectory(p, 0)?, trajectory(p, 50)?);
    // The components of actuated joints have no effect.
    let passive = DMatrix::from_fn(n, 4, |i, degree| {
        let here = if is_passive(p, i) { Gf::one() } else { Gf::zero() };
        here * of_control.coefficients()[(i, degree)]
    });
    let control_dual = DualTrajectory::new(p.extra[0], passive)?;
    let augmented = ControlLagrangian {
        weights: weights(p)?,
        slip_dual: Some(slip_dual.clone()),
        cost: ControlDual(control_dual.clone()),
    };
    let with_penalty = variation(node, |t, x, xdot| augmented.value(model, t, x, xdot, p.k))?;

    // lambda + rho c and its rate along the curve at this time, and the linear function of time with these.
    let moving = violation(p, &dual(node.x, node.xdot), &dual(node.xdot, node.xddot))?;
    let stepped = |i: usize| -> [Gf; 2] {
        let (rho, [lambda, rate]) = match i.checked_sub(n) {
            None => (two() * p.k, slip_dual.value_and_rate(i, node.t)),
            Some(joint) => {
                let dual = control_dual.value_and_rate(joint, node.t);
                (two() * p.w[joint], dual)
            }
        };
        [lambda + rho * moving[i].re, rate + rho * moving[i].eps[0]]
    };
    let without = variation(node, |t, x, xdot| {
        let u = inverse_dynamics(model, &x[..n], &x[n..], &xdot[n..])?;
        let c = violation(p, x, xdot)?;
        let motors = (0..n).filter(|i| !is_passive(p, *i));
        let effort = motors.fold(Zero::zero(), |sum, i| sum + (u[i] * u[i]).scale(p.w[i]));
        Ok((0..2 * n).fold(effort, |sum, i| {
            let ([lambda, rate], elapsed) = (stepped(i), t - AlgebraOver::lift(node.t));
            sum + (elapsed.scale(rate) + AlgebraOver::lift(lambda)) * c[i]
        }))
    })?;
    let expression = |v: &Variation<Gf>| &v.momentum_rate - &v.by_x;
    Ok(vec![
        Equality::vectors("momentum", &with_penalty.by_xdot, &without.by_xdot),
        Equality::vectors("Euler-Lagrange expression", &expression(&with_penalty), &expression(&without)),
    ])
}
