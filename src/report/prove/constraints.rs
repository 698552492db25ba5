//! (A1) to (A4): constraints as penalties.

use super::truth::{JJ, Truth, effort, gradient, rate, variation};
use super::{Claim, F, Identity, Point};
use crate::aghf::{
    Constraint, activation, activation_slope, constrained_lagrangian, penalty, penalty_slope,
    subtract_penalties,
};
use crate::dynamics::forward_kinematics;
use crate::error::Result;
use crate::scalar::{Ldlt, Over, Scalar};
use crate::spatial::Placement;
use nalgebra::{DVector, Vector3};
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
        identity("A2", "b = k_cons g^2 S and its slope", a2),
        identity("A3", "S = (1 + tanh(c g)) / 2 and its slope", a3),
        identity("A4", "the flow of Lcons is Omega - G^-1 sum db/dx", a4),
    ]
}

fn k_cons(p: &Point) -> F {
    p.spare[5]
}

fn c_cons(p: &Point) -> F {
    p.spare[6]
}

/// A sphere that every body frame has to stay out of, and a limit on the squared speed of every joint.
fn constraints<S: Over<F>>(p: &Point, x: &[S]) -> Result<Vec<S>> {
    let (q, v) = x.split_at(p.dof());
    let mut placements = vec![Placement::identity(); q.len()];
    forward_kinematics(&p.model, q, &mut placements)?;
    let centre = Vector3::new(p.spare[0], p.spare[1], p.spare[2]).map(S::lift);
    let spheres = placements.iter().map(|placement| {
        let offset = placement.translation - centre;
        S::lift(p.spare[3]) - offset.dot(&offset)
    });
    let limits = v.iter().map(|v| *v * *v - S::lift(p.spare[4]));
    Ok(spheres.chain(limits).collect())
}

/// $L_{cons}$ over any scalar.
fn constrained<S: Over<F>>(p: &Point, x: &[S], xdot: &[S]) -> Result<S> {
    let g = constraints(p, x)?;
    Ok(constrained_lagrangian(
        effort(p, x, xdot)?,
        g,
        k_cons(p),
        c_cons(p),
    ))
}

fn half() -> F {
    F::from_f64(0.5)
}

fn a1(p: &Point) -> Result<Vec<Claim>> {
    let left = constrained(p, p.x.as_slice(), p.xdot.as_slice())?;
    let (truth, mut right) = (Truth::at(p)?, F::zero());
    for g in constraints(p, p.x.as_slice())? {
        let s = half() + half() * (c_cons(p) * g).tanh();
        right += k_cons(p) * g * g * s;
    }
    let slip = truth.slip();
    right += slip.dot(&(truth.metric() * &slip));
    Ok(vec![Claim::numbers("Lcons", left, right)])
}

fn a2(p: &Point) -> Result<Vec<Claim>> {
    let (k, c, mut claims) = (k_cons(p), c_cons(p), Vec::new());
    for g in constraints(p, p.x.as_slice())? {
        let s = half() * (F::one() + (g * c).tanh());
        claims.push(Claim::numbers("b", penalty(g, k, c), k * g * g * s));
        let slope = rate(&[g], &[F::one()], |g| Ok(vec![penalty(g[0], k, c)]))?;
        claims.push(Claim::numbers("b'", slope[0], penalty_slope(g, k, c)));
    }
    let at_zero = penalty_slope(F::zero(), k, c);
    claims.push(Claim::numbers("b' on the boundary", at_zero, F::zero()));
    Ok(claims)
}

fn a3(p: &Point) -> Result<Vec<Claim>> {
    let (g, c) = (p.spare[7], c_cons(p));
    let slope = rate(&[g], &[F::one()], |g| Ok(vec![activation(g[0], c)]))?[0];
    let (s, tanh) = (activation(g, c), (c * g).tanh());
    let logistic = (c + c) * s * (F::one() - s);
    Ok(vec![
        Claim::numbers("S'", slope, activation_slope(g, c)),
        Claim::numbers("S' printed", slope, c * half() * (F::one() - tanh * tanh)),
        Claim::numbers("S' = 2 c S (1 - S)", slope, logistic),
        Claim::numbers("S(g) + S(-g)", s + activation(-g, c), F::one()),
        Claim::numbers("S(0)", activation(F::zero(), c), half()),
    ])
}

fn a4(p: &Point) -> Result<Vec<Claim>> {
    let (truth, x) = (Truth::at(p)?, p.x.as_slice());
    let of_constrained = variation(p, |x: &[JJ], xdot: &[JJ]| constrained(p, x, xdot))?;
    let left = truth.raise(&(of_constrained.momentum_rate - of_constrained.by_x));

    let mut omega = DVector::zeros(2 * p.dof());
    truth.theorem().omega(p.node(), p.k, omega.as_mut_slice())?;
    let gradients = (0..2 * p.dof()).map(|j| gradient(x, |x| Ok(constraints(p, x)?[j])));
    let gradients = gradients.collect::<Result<Vec<_>>>()?;
    let values = constraints(p, x)?;
    let constraints: Vec<_> = values.iter().zip(&gradients).map(constraint).collect();
    let mut h = Ldlt::new(p.dof());
    h.factorise(&truth.h);
    let penalties = [p.k, k_cons(p), c_cons(p)];
    subtract_penalties(&h, &constraints, penalties, omega.as_mut_slice())?;
    Ok(vec![
        Claim::vectors(
            "dLcons/dxdot",
            &of_constrained.by_xdot,
            &truth.variation()?.by_xdot,
        ),
        Claim::vectors("flow", &left, &omega),
    ])
}

fn constraint<'a>((value, gradient): (&F, &'a DVector<F>)) -> Constraint<'a, F> {
    Constraint {
        value: *value,
        gradient: gradient.as_slice(),
    }
}
