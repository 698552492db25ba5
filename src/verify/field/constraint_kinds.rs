//! Every kind of constraint: its rows, and its contractions against nested duals of these.

use super::reference::jacobian;
use super::{Claim, F, Identity, J, Point};
use crate::constraint::TorqueLimits;
use crate::constraint::{
    Ball, Bound, Bounds, BuiltIn, Constraint, Contraction, Evaluator, HalfSpace, HalfSpaceBalls,
    Side, Sphere, SphereBalls, State, Weights,
};
use crate::dynamics::forward_kinematics;
use crate::error::Result;
use crate::flow::Penalty;
use crate::flow::{ControlCost, Penalised, TorquePenalty, penalty};
use crate::scalar::Over;
use crate::spatial::Placement;
use nalgebra::{DMatrix, DVector, Vector3};
use num_traits::Zero;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let identity = |label, statement, claims| Identity {
        label,
        statement,
        convention: "g <= 0 is feasible; w weighs rows, c products of their gradients",
        claims,
    };
    vec![
        identity("spheres", "value and contractions", spheres),
        identity("half-space", "value and contractions", half_space),
        identity("bounds", "value and contractions", bounds),
        identity("constraints by duals", "contractions of a set", by_duals),
        identity("torque limits", "a cost and its derivatives", torque),
    ]
}

/// The constraints of the proofs: two spheres and a half-space for a ball off the origin of every body and one of the base,
/// bounds on both halves of the state, and limits on every third torque.
pub(super) type Set = Penalised<Vec<BuiltIn<F>>, F>;

pub(super) fn set(p: &Point) -> Set {
    let (n, s) = (p.dof(), p.spare);
    let balls: Vec<_> = (0..=n)
        .map(|i| Ball {
            body: (i < n).then_some(i),
            centre: Vector3::new(s[0], s[1], s[2]) * p.w[i % n],
            radius: p.w[(i + 1) % n],
        })
        .collect();
    let sphere = |i: usize| Sphere {
        centre: Vector3::new(s[i], s[i + 1], s[i + 2]),
        radius: s[i + 3],
    };
    let bound = |entry, side, i: usize| Bound {
        entry,
        side,
        value: s[i],
    };
    let half_space = HalfSpace {
        normal: Vector3::new(s[2], s[0], s[1]),
        offset: s[4],
    };
    Penalised {
        state: vec![
            BuiltIn::Spheres(SphereBalls {
                balls: balls.clone(),
                spheres: vec![sphere(0), sphere(3)],
            }),
            BuiltIn::HalfSpace(HalfSpaceBalls { balls, half_space }),
            BuiltIn::Bounds(Bounds(vec![
                bound(0, Side::Upper, 0),
                bound(n - 1, Side::Lower, 1),
                bound(n, Side::Lower, 2),
                bound(2 * n - 1, Side::Upper, 3),
            ])),
        ],
        penalty: pair(p),
        torque: TorquePenalty {
            limits: TorqueLimits((0..n).map(|i| (i % 3 == 0).then_some(p.w[i])).collect()),
            penalty: Penalty {
                k_cons: s[7],
                c_cons: s[4],
            },
        },
    }
}

/// Their penalty.
pub(super) fn pair(p: &Point) -> Penalty<F> {
    Penalty {
        k_cons: p.spare[5],
        c_cons: p.spare[6],
    }
}

/// The rows of a constraint at `x`.
pub(super) fn rows<S: Over<F>>(
    p: &Point,
    constraint: &impl Constraint<F>,
    x: &[S],
) -> Result<Vec<S>> {
    let mut g = vec![S::zero(); constraint.rows()];
    let mut evaluator = Evaluator::new(&p.model);
    evaluator.at(x)?.value(constraint, &mut g)?;
    Ok(g)
}

/// A constraint without its analytic contractions.
struct ValueAlone<K>(K);

impl<K: Constraint<F>> Constraint<F> for ValueAlone<K> {
    fn rows(&self) -> usize {
        self.0.rows()
    }

    fn value<S: Over<F>>(&self, at: &State<'_, F, S>, g: &mut [S]) -> Result<()> {
        self.0.value(at, g)
    }
}

/// The contractions of a constraint with arbitrary weights against nested duals of its rows.
fn contractions(p: &Point, constraint: &impl Constraint<F>) -> Result<Vec<Claim>> {
    let x = p.x.as_slice();
    let weight = |from: &DVector<F>, j: usize| from[j % from.len()] * F::new(j as u64 + 1);
    let count = constraint.rows();
    let w: Vec<F> = (0..count).map(|j| weight(&p.xdot, j)).collect();
    let c: Vec<F> = (0..count).map(|j| weight(&p.xddot, j)).collect();
    let mut evaluator = Evaluator::new(&p.model);
    let mut contract = |c| -> Result<Contraction<F>> {
        let weights = Weights { w: &w, c };
        Ok(evaluator.at(x)?.contract(constraint, weights)?.clone())
    };
    let (both, alone) = (contract(Some(&c))?, contract(None)?);

    let by_x = jacobian(x, |x| rows(p, constraint, x))?;
    let weighted = by_x.tr_mul(&DVector::from_column_slice(&w));
    let mut second = jacobian(x, |x: &[J]| {
        let by_x = jacobian(x, |x| rows(p, constraint, x))?;
        let sum = |i| {
            w.iter()
                .enumerate()
                .fold(J::zero(), |s, (j, w)| s + by_x[(j, i)].scale(*w))
        };
        Ok((0..x.len()).map(sum).collect())
    })?;
    second += by_x.transpose() * DMatrix::from_diagonal(&DVector::from_vec(c)) * &by_x;
    let nothing = DMatrix::zeros(x.len(), x.len());
    Ok(vec![
        Claim::vectors("gradient", both.gradient(), &weighted),
        Claim::new("Hessian", both.hessian().clone(), second),
        Claim::vectors("gradient alone", alone.gradient(), &weighted),
        Claim::new("no Hessian", alone.hessian().clone(), nothing),
    ])
}

/// The contractions of the constraint number `which` of the set, and its rows against `values`.
fn kind(p: &Point, which: usize, values: Vec<F>) -> Result<Vec<Claim>> {
    let constraint = &set(p).state[which];
    let rows = DVector::from_vec(rows(p, constraint, p.x.as_slice())?);
    let mut claims = contractions(p, constraint)?;
    claims.push(Claim::vectors("value", &rows, &DVector::from_vec(values)));
    Ok(claims)
}

/// The centre of a ball in the base frame.
fn centre(p: &Point, ball: &Ball<F>) -> Result<Vector3<F>> {
    let mut placements = vec![Placement::identity(); p.dof()];
    forward_kinematics(&p.model, p.node().x_p1(), &mut placements)?;
    let moved = |b: usize| placements[b].rotation * ball.centre + placements[b].translation;
    Ok(ball.body.map_or(ball.centre, moved))
}

fn spheres(p: &Point) -> Result<Vec<Claim>> {
    let set = set(p);
    let mut values = Vec::new();
    if let BuiltIn::Spheres(SphereBalls { balls, spheres }) = &set.state[0] {
        for ball in balls {
            let c = centre(p, ball)?;
            values.extend(spheres.iter().map(|sphere| {
                let reach = ball.radius + sphere.radius;
                let off = c - sphere.centre;
                reach * reach - off.x * off.x - off.y * off.y - off.z * off.z
            }));
        }
    }
    kind(p, 0, values)
}

fn half_space(p: &Point) -> Result<Vec<Claim>> {
    let set = set(p);
    let mut values = Vec::new();
    if let BuiltIn::HalfSpace(HalfSpaceBalls { balls, half_space }) = &set.state[1] {
        for ball in balls {
            let height = half_space.normal.dot(&centre(p, ball)?);
            values.push(ball.radius + half_space.offset - height);
        }
    }
    kind(p, 1, values)
}

fn bounds(p: &Point) -> Result<Vec<Claim>> {
    let (n, s, x) = (p.dof(), p.spare, &p.x);
    let values = vec![
        x[0] - s[0],
        s[1] - x[n - 1],
        s[2] - x[n],
        x[2 * n - 1] - s[3],
    ];
    kind(p, 2, values)
}

fn by_duals(p: &Point) -> Result<Vec<Claim>> {
    let state = set(p).state;
    let mut claims = contractions(p, &state)?;
    claims.extend(contractions(p, &(ValueAlone(&state[..]), &state[2]))?);
    Ok(claims)
}

/// A control cost without its analytic derivatives.
struct CostAlone(TorquePenalty<F>);

impl ControlCost<F> for CostAlone {
    fn value<S: Over<F>>(&self, joint: usize, u: S) -> S {
        self.0.value(joint, u)
    }
}

fn torque(p: &Point) -> Result<Vec<Claim>> {
    let torque = set(p).torque;
    let Penalty { k_cons, c_cons } = torque.penalty;
    let mut claims = Vec::new();
    for (i, u) in p.x.iter().take(p.dof()).enumerate() {
        let b = |g: F| penalty(g, k_cons, c_cons);
        let sum = torque.limits.0[i].map_or(F::zero(), |limit| b(*u - limit) + b(-*u - limit));
        claims.push(Claim::numbers("value", torque.value(i, *u), sum));
        let column = |d: [F; 3]| DVector::from_column_slice(&d);
        let ours = column(torque.derivatives(i, *u));
        let by_duals = column(CostAlone(torque.clone()).derivatives(i, *u));
        claims.push(Claim::vectors("derivatives", &ours, &by_duals));
    }
    Ok(claims)
}
