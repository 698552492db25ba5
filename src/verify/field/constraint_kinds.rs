//! Every kind of constraint: its rows, and its contractions against nested dual numbers of the rows.

use super::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, Constraints, Evaluator, FrameRow, FrameRows,
    PlacedState, RowForm, Side, SolidClearance, Sphere, SphereClearance, TorqueLimits, WeightedDerivatives, Weights,
};
use crate::dynamics::forward_kinematics;
use crate::error::Result;
use crate::flow::{ControlCost, Penalised, Penalty, PenaltyWeights, TorquePenalty, penalty};
use crate::geometry::{Shape, Solid};
use crate::model::Frame;
use crate::scalar::{AlgebraOver, Tanh};
use crate::spatial::Placement;
use crate::verify::reference::{jacobian, vector};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use num_traits::{One, Zero};

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
        identity("frames", "value and contractions", frames),
        identity("constraints by duals", "contractions of a set", by_duals),
        identity("torque limits", "a cost and its derivatives", torque),
    ]
}

/// The constraints of the proofs: two spheres and a half-space for a ball off the origin of every body and one of the
/// base, bounds on both halves of the state, and limits on every third torque.
pub(super) type Set = Penalised<Vec<AnyConstraint<Gf>>, Gf>;

pub(super) fn set(p: &RandomInstance) -> Set {
    let (n, s) = (p.dof(), p.extra);
    let balls: Vec<_> = (0..=n)
        .map(|i| CollisionSphere {
            body: (i < n).then_some(i),
            centre: Vector3::new(s[0], s[1], s[2]) * p.w[i % n],
            radius: p.w[(i + 1) % n],
        })
        .collect();
    let sphere = |i: usize| Sphere { centre: Vector3::new(s[i], s[i + 1], s[i + 2]), radius: s[i + 3] };
    let bound = |index, side, i: usize| Bound { entry: index, side, value: s[i] };
    // Only the last axis of a half-space counts, so that the others may be any.
    let mut axes = Matrix3::from_element(s[3]);
    axes.set_column(2, &Vector3::new(s[2], s[0], s[1]));
    let half_space = Solid { placement: Placement::new(axes, Vector3::new(s[4], s[1], s[5])), shape: Shape::HalfSpace };
    Penalised {
        constraints: Constraints {
            state: vec![
                AnyConstraint::Spheres(SphereClearance { balls: balls.clone(), spheres: vec![sphere(0), sphere(3)] }),
                AnyConstraint::Solids(SolidClearance { balls, solids: vec![half_space], names: Vec::new() }),
                AnyConstraint::Bounds(Bounds(vec![
                    bound(0, Side::Upper, 0),
                    bound(n - 1, Side::Lower, 1),
                    bound(n, Side::Lower, 2),
                    bound(2 * n - 1, Side::Upper, 3),
                ])),
            ],
            torque: TorqueLimits((0..n).map(|i| (i % 3 == 0).then_some(p.w[i])).collect()),
            stage: Default::default(),
        },
        weights: PenaltyWeights { state: pair(p), torque: Penalty { k_cons: s[7], c_cons: s[4] } },
    }
}

/// Their penalty.
pub(super) fn pair(p: &RandomInstance) -> Penalty<Gf> {
    Penalty { k_cons: p.extra[5], c_cons: p.extra[6] }
}

/// The rows of a constraint at `x`.
pub(super) fn rows<S: AlgebraOver<Gf>>(
    p: &RandomInstance,
    constraint: &impl Constraint<Gf>,
    x: &[S],
) -> Result<DVector<S>> {
    let mut g = DVector::zeros(constraint.dim());
    let mut evaluator = Evaluator::new(&p.model);
    evaluator.at(x)?.value(constraint, g.as_mut_slice())?;
    Ok(g)
}

/// A constraint without its analytic contractions.
struct ValueAlone<K>(K);

impl<K: Constraint<Gf>> Constraint<Gf> for ValueAlone<K> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn value<S: AlgebraOver<Gf>>(&self, at: &PlacedState<'_, Gf, S>, g: &mut [S]) -> Result<()> {
        self.0.value(at, g)
    }
}

/// The contractions of a constraint with arbitrary weights against nested duals of its rows.
pub(super) fn contractions(p: &RandomInstance, constraint: &impl Constraint<Gf>) -> Result<Vec<Equality>> {
    let x = p.x.as_slice();
    let weight = |from: &DVector<Gf>, j: usize| from[j % from.len()] * Gf::new(j as u64 + 1);
    let count = constraint.dim();
    let w: Vec<Gf> = (0..count).map(|j| weight(&p.xdot, j)).collect();
    let c: Vec<Gf> = (0..count).map(|j| weight(&p.xddot, j)).collect();
    let mut evaluator = Evaluator::new(&p.model);
    let mut contract = |c| -> Result<WeightedDerivatives<Gf>> {
        let weights = Weights { first_order: &w, gauss_newton: c };
        Ok(evaluator.at(x)?.weighted_derivatives(constraint, weights)?.clone())
    };
    let (both, alone) = (contract(Some(&c))?, contract(None)?);

    let by_x = jacobian(x, |x| rows(p, constraint, x))?;
    let weighted = by_x.tr_mul(&vector(&w));
    let mut second = jacobian(x, |x: &[Jet1]| {
        let by_x = jacobian(x, |x| rows(p, constraint, x))?;
        Ok(by_x.tr_mul(&vector(&w).map(Jet1::constant)))
    })?;
    second += by_x.transpose() * DMatrix::from_diagonal(&DVector::from_vec(c)) * &by_x;
    let nothing = DMatrix::zeros(x.len(), x.len());
    Ok(vec![
        Equality::vectors("gradient", both.gradient(), &weighted),
        Equality::new("Hessian", both.hessian().clone(), second),
        Equality::vectors("gradient alone", alone.gradient(), &weighted),
        Equality::new("no Hessian", alone.hessian().clone(), nothing),
    ])
}

/// The contractions of the constraint number `which` of the set, and its rows against `values`.
fn kind(p: &RandomInstance, which: usize, values: Vec<Gf>) -> Result<Vec<Equality>> {
    let constraint = &set(p).constraints.state[which];
    let rows = rows(p, constraint, p.x.as_slice())?;
    let mut claims = contractions(p, constraint)?;
    claims.push(Equality::vectors("value", &rows, &DVector::from_vec(values)));
    Ok(claims)
}

/// The centre of a ball in the base frame.
pub(super) fn centre(p: &RandomInstance, ball: &CollisionSphere<Gf>) -> Result<Vector3<Gf>> {
    let mut placements = vec![Placement::identity(); p.dof()];
    forward_kinematics(&p.model, p.node().x_p1(), &mut placements)?;
    let moved = |b: usize| placements[b].rotation * ball.centre + placements[b].translation;
    Ok(ball.body.map_or(ball.centre, moved))
}

fn spheres(p: &RandomInstance) -> Result<Vec<Equality>> {
    let set = set(p);
    let mut values = Vec::new();
    if let AnyConstraint::Spheres(SphereClearance { balls, spheres }) = &set.constraints.state[0] {
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

fn half_space(p: &RandomInstance) -> Result<Vec<Equality>> {
    let set = set(p);
    let mut values = Vec::new();
    if let AnyConstraint::Solids(SolidClearance { balls, solids, .. }) = &set.constraints.state[1] {
        let Placement { rotation, translation } = &solids[0].placement;
        let normal = rotation.column(2);
        for ball in balls {
            let height = normal.dot(&centre(p, ball)?) - normal.dot(translation);
            values.push(ball.radius - height);
        }
    }
    kind(p, 1, values)
}

fn bounds(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, s, x) = (p.dof(), p.extra, &p.x);
    let values = vec![x[0] - s[0], s[1] - x[n - 1], s[2] - x[n], x[2 * n - 1] - s[3]];
    kind(p, 2, values)
}

/// Frames of the last body and of one on another branch in the base, in each other, in a body that carries them, and
/// of the base in a body, with arbitrary rows.
fn frames(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, s) = (p.dof(), p.extra);
    let frame = |name: &str, body, i: usize| Frame::new(name, body, *p.model.joints()[i % n].origin());
    let row = |i: usize| FrameRow {
        constant: s[i],
        position: Vector3::new(s[i + 1], s[i + 2], p.w[i]),
        rotation: Matrix3::from_fn(|j, k| p.xdot[i + j] * p.xddot[j + k] + s[k]),
        square: p.w[i + 1],
        scale: s[i + 3],
        what: "row",
        unit: "",
        form: RowForm::Linear,
        is_equality: false,
    };
    let bodies = [[Some(n - 1), None], [Some(2), Some(3)], [Some(3), Some(n - 1)], [Some(2), Some(0)], [None, Some(3)]];
    let mut claims = Vec::new();
    for (i, [body, of]) in bodies.into_iter().enumerate() {
        let constraint = FrameRows {
            frame: frame("frame", body, i),
            reference: frame("reference", of, i + 1),
            rows: (0..3).map(row).collect(),
        };
        let values = values_of_frame(p, &constraint)?;
        let ours = rows(p, &constraint, p.x.as_slice())?;
        claims.push(Equality::vectors("value", &ours, &values.into()));
        claims.extend(contractions(p, &constraint)?);
    }
    Ok(claims)
}

/// The rows on a frame by 4 by 4 matrices.
fn values_of_frame(p: &RandomInstance, of: &FrameRows<Gf>) -> Result<Vec<Gf>> {
    let mut placements = vec![Placement::identity(); p.dof()];
    forward_kinematics(&p.model, p.node().x_p1(), &mut placements)?;
    let homogeneous = |placement: &Placement<Gf>| {
        let mut matrix = DMatrix::identity(4, 4);
        (matrix.view_mut((0, 0), (3, 3))).copy_from(&placement.rotation);
        (matrix.view_mut((0, 3), (3, 1))).copy_from(&placement.translation);
        matrix
    };
    let place = |frame: &Frame<Gf>| {
        let body = frame.body.map_or(DMatrix::identity(4, 4), |b| homogeneous(&placements[b]));
        body * homogeneous(&frame.placement)
    };
    // The inverse has the transposed rotation.
    let reference = place(&of.reference);
    let mut inverse = DMatrix::identity(4, 4);
    let turned = reference.view((0, 0), (3, 3)).transpose();
    let off = &turned * reference.view((0, 3), (3, 1)) * -Gf::one();
    (inverse.view_mut((0, 0), (3, 3))).copy_from(&turned);
    (inverse.view_mut((0, 3), (3, 1))).copy_from(&off);
    let relative = inverse * place(&of.frame);
    let value = |row: &FrameRow<Gf>| {
        let mut sum = row.constant;
        for i in 0..3 {
            let d = relative[(i, 3)];
            sum += row.position[i] * d + row.square * d * d;
            for j in 0..3 {
                sum += row.rotation[(i, j)] * relative[(i, j)];
            }
        }
        sum
    };
    Ok(of.rows.iter().map(value).collect())
}

fn by_duals(p: &RandomInstance) -> Result<Vec<Equality>> {
    let state = set(p).constraints.state;
    let mut claims = contractions(p, &state)?;
    claims.extend(contractions(p, &(ValueAlone(&state[..]), &state[2]))?);
    Ok(claims)
}

/// A control cost without its analytic derivatives.
struct CostAlone(TorquePenalty<Gf>);

impl ControlCost<Gf> for CostAlone {
    fn value<S: AlgebraOver<Gf> + Tanh>(&self, t: S, joint: usize, u: S) -> S {
        self.0.value(t, joint, u)
    }
}

fn torque(p: &RandomInstance) -> Result<Vec<Equality>> {
    let torque = set(p).torque_penalty();
    let Penalty { k_cons, c_cons } = torque.penalty;
    let mut claims = Vec::new();
    for (i, u) in p.x.iter().take(p.dof()).enumerate() {
        let b = |g: Gf| penalty(g, k_cons, c_cons);
        let sum = torque.limits.0[i].map_or(Gf::zero(), |limit| b(*u - limit) + b(-*u - limit));
        claims.push(Equality::numbers("value", torque.value(p.t, i, *u), sum));
        let column = |d: [Gf; 3]| vector(&d);
        let ours = column(torque.derivatives(p.t, i, *u));
        let by_duals = column(CostAlone(torque.clone()).derivatives(p.t, i, *u));
        claims.push(Equality::vectors("derivatives", &ours, &by_duals));
    }
    Ok(claims)
}
