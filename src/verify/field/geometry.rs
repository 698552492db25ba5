//! Distances from shapes, and the constraints based on them.

use super::constraint_kinds::{centre, contractions, rows};
use super::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::constraint::{CollisionSphere, SelfClearance, SolidClearance};
use crate::error::Result;
use crate::geometry::{Shape, Solid};
use crate::verify::reference::{gradient, jacobian};
use nalgebra::{DMatrix, DVector, Vector3};

/// The number of points per shape. A formal sign is negative at about half of them, so that all cases of a shape occur
/// many times.
const POINTS: u64 = 128;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let identity = |label, statement, claims| Identity {
        label,
        statement,
        convention: "sqrt and the sign are formal; g <= 0 is feasible",
        claims,
    };
    vec![
        identity("distance", "gradient, Hessian and placement", distance),
        identity("solids", "value and contractions", solids),
        identity("self-collision", "value and contractions", self_collision),
    ]
}

/// One of each shape, of random sizes.
fn shapes(p: &RandomInstance) -> [Shape<Gf>; 5] {
    let s = p.extra;
    [
        Shape::Sphere { radius: s[0] },
        Shape::Cuboid { half_extents: Vector3::new(s[1], s[2], s[3]) },
        Shape::Cylinder { radius: s[4], half_length: s[5] },
        Shape::Capsule { radius: s[6], half_length: s[7] },
        Shape::HalfSpace,
    ]
}

/// The shapes, each in the frame of a joint.
fn placed(p: &RandomInstance) -> Vec<Solid<Gf>> {
    let placed = |(shape, joint): (Shape<Gf>, &crate::model::Joint<Gf>)| Solid { placement: *joint.origin(), shape };
    let joints = p.model.joints().iter();
    shapes(p).into_iter().zip(joints).map(placed).collect()
}

fn column(v: &Vector3<Gf>) -> DVector<Gf> {
    DVector::from_column_slice(v.as_slice())
}

fn distance(p: &RandomInstance) -> Result<Vec<Equality>> {
    let mut claims = Vec::new();
    for solid in placed(p) {
        let shape = solid.shape;
        for i in 0..POINTS {
            let at = Vector3::from_fn(|j, _| p.w[j] * Gf::new(3 * i + 1) + p.x[(i as usize + j) % 5]);
            let ours = shape.distance_derivatives(&at);
            let value = shape.distance(&at);
            claims.push(Equality::numbers("value", ours.value, value));
            let by_p = gradient(at.as_slice(), |p| Ok(shape.distance(&Vector3::from_column_slice(p))))?;
            claims.push(Equality::vectors("gradient", &column(&ours.normal), &by_p));
            let by_pp = jacobian(at.as_slice(), |p: &[Jet1]| {
                let near = shape.distance_derivatives(&Vector3::from_column_slice(p));
                Ok(DVector::from_column_slice(near.normal.as_slice()))
            })?;
            let hessian = DMatrix::from_column_slice(3, 3, ours.curvature.as_slice());
            claims.push(Equality::new("Hessian", hessian, by_pp));

            let placement = &solid.placement;
            let there = placement.rotation * at + placement.translation;
            let moved = solid.distance_derivatives(&there);
            claims.push(Equality::numbers("value placed", moved.value, value));
            claims.push(Equality::numbers("value alone", solid.distance(&there), value));
            let turned = placement.rotation * ours.normal;
            let (moved, turned) = (column(&moved.normal), column(&turned));
            claims.push(Equality::vectors("gradient placed", &moved, &turned));
        }
    }
    Ok(claims)
}

/// Balls off the origins of the last body, of one in the middle, of the first one and of the base.
fn balls(p: &RandomInstance) -> Vec<CollisionSphere<Gf>> {
    let (n, s) = (p.dof(), p.extra);
    let bodies = [Some(n - 1), Some(2), Some(0), None];
    let ball = |(i, body)| CollisionSphere {
        body,
        centre: Vector3::new(s[i], s[i + 1], s[i + 2]) * p.w[i],
        radius: p.w[i + 1],
    };
    bodies.into_iter().enumerate().map(ball).collect()
}

/// Uses two balls, which are enough and keep the degrees low.
fn solids(p: &RandomInstance) -> Result<Vec<Equality>> {
    let constraint = SolidClearance { balls: balls(p)[..2].to_vec(), solids: placed(p), names: Vec::new() };
    let mut values = Vec::new();
    for ball in &constraint.balls {
        let c = centre(p, ball)?;
        for solid in &constraint.solids {
            let placement = &solid.placement;
            let local = placement.rotation.transpose() * (c - placement.translation);
            values.push(ball.radius - solid.shape.distance(&local));
        }
    }
    let mut claims = contractions(p, &constraint)?;
    let ours = rows(p, &constraint, p.x.as_slice())?;
    claims.push(Equality::vectors("value", &ours, &values.into()));
    Ok(claims)
}

/// Tests all pairs of balls and of two more on the bodies of the fourth joint, next to the third, and of the second,
/// which carries both.
fn self_collision(p: &RandomInstance) -> Result<Vec<Equality>> {
    let mut balls = balls(p);
    for (i, body) in [3, 1].into_iter().enumerate() {
        balls.push(CollisionSphere {
            body: Some(body),
            centre: Vector3::new(p.w[i], p.x[i], p.extra[i]),
            radius: p.x[i + 2],
        });
    }
    let others = |i: usize| (0..balls.len()).map(move |j| [i, j]);
    let constraint = SelfClearance { pairs: (0..balls.len()).flat_map(others).collect(), balls };
    let mut values = Vec::new();
    for pair in &constraint.pairs {
        let [first, second] = pair.map(|i| &constraint.balls[i]);
        let off = centre(p, first)? - centre(p, second)?;
        let reach = first.radius + second.radius;
        let square = off.x * off.x + off.y * off.y + off.z * off.z;
        values.push(reach * reach - square);
    }
    let mut claims = contractions(p, &constraint)?;
    let ours = rows(p, &constraint, p.x.as_slice())?;
    claims.push(Equality::vectors("value", &ours, &values.into()));
    Ok(claims)
}
