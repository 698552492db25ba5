//! Checks of the derivatives of constraints and of the Jacobians of the constrained flow by dual numbers.

use super::dynamics::{split, state_of};
use super::{At, BOUND, CheckOptions, Finding, Findings, State, Tolerance, VANISHING, compare_jacobians};
use crate::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, Constraints, Evaluator, FootDerivatives, FootWeights,
    FrameRows, SelfClearance, Side, SolidClearance, Sphere, SphereClearance, StandingFoot, TorqueLimits, Weights,
};
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::flow::jacobian::JacobianKind;
use crate::flow::{Penalised, Penalty, PenaltyWeights};
use crate::geometry::{Capsule, Shape, Solid};
use crate::model::{Frame, Model};
use crate::spatial::Placement;
use crate::verify::reference::{gradient, jacobian};
use nalgebra::{DMatrix, Rotation3, Vector3};
use num_dual::Dual64;

/// Compares the weighted derivatives of every kind of constraint with dual numbers, and the analytic Jacobians of the
/// constrained flow with dual numbers of its right-hand side. The constraints are derived from the first random state,
/// so that on any robot about half of the rows are violated there.
///
/// # Errors
/// None for a loaded model.
pub fn check_constraints(model: &Model, options: &CheckOptions) -> Result<Vec<Finding>> {
    let made_up = made_up(model, &State::random(model, options.seed, 0))?;
    let states = options.states(model)?;
    let mut findings = Findings::default();
    for (sample, state) in states.iter().enumerate() {
        let at = At::new(model, sample, state)?;
        for (name, constraint) in KINDS.iter().zip(&made_up.constraints.state) {
            contractions(model, name, constraint, at, &mut findings)?;
        }
        standing_foot(model, at, &mut findings)?;
    }
    let mut all = findings.all;
    for (name, kind) in JacobianKind::by_name() {
        // Dual numbers are the reference, and central differences are for comparison only.
        if let JacobianKind::ControlForm | JacobianKind::TheoremB4 = kind {
            all.extend(compare_jacobians(
                model,
                &format!("{name} with constraints"),
                &mut *kind.build_constrained(model, &made_up),
                &mut *JacobianKind::Dual.build_constrained(model, &made_up),
                &states,
                &options.penalties,
            )?);
        }
    }
    Ok(all)
}

/// Compares the weighted derivatives of a constraint, analytic or by default, with dual numbers of its value and of its
/// gradient at random states. `name` is the prefix of the quantities.
///
/// # Errors
/// The constraint refers to a joint or body that the robot does not have.
pub fn check_constraint(
    model: &Model,
    name: &str,
    constraint: &impl Constraint,
    options: &CheckOptions,
) -> Result<Vec<Finding>> {
    let mut findings = Findings::default();
    for (sample, state) in options.states(model)?.iter().enumerate() {
        let at = At::new(model, sample, state)?;
        contractions(model, name, constraint, at, &mut findings)?;
    }
    Ok(findings.all)
}

/// The tolerance: without divisions, entries that are small relative to metres and radians may be rounding errors.
const TOLERANCE: Tolerance = Tolerance { bound: BOUND, floor: VANISHING };

/// The kinds of constraints on the state, in the order of their construction.
const KINDS: [&str; 6] = ["spheres", "solids", "self-collision", "bounds", "frame", "frame in a frame"];

/// A box, a cylinder, a capsule, a ball and a half-space about `mean`, rotated, of sizes in proportion to `reach`.
fn solids(mean: &Vector3<f64>, reach: f64) -> Vec<Solid> {
    let size = |part: f64| part * reach;
    let shapes = [
        Shape::Cuboid { half_extents: Vector3::new(size(0.3), size(0.15), size(0.2)) },
        Shape::Cylinder { radius: size(0.25), half_length: size(0.2) },
        Shape::Capsule { radius: size(0.15), half_length: size(0.3) },
        Shape::Sphere { radius: size(0.3) },
        Shape::HalfSpace,
    ];
    let place = |(i, shape): (usize, Shape)| {
        let wave = |f: f64| (f * (i as f64 + 1.0)).sin();
        let axis = Vector3::new(wave(0.7), wave(1.3), wave(2.1));
        let off = Vector3::new(wave(2.9), wave(1.7), wave(0.5)) * size(0.4);
        Solid { placement: Placement::new(Rotation3::new(axis).into_inner(), mean + off), shape }
    };
    shapes.into_iter().enumerate().map(place).collect()
}

/// Rows of every kind on a frame of a body in a reference of another one.
fn frame_rows(bodies: [Option<usize>; 2], mean: &Vector3<f64>, reach: f64) -> Result<AnyConstraint> {
    let axes = [Vector3::new(0.4, -0.8, 0.3), Vector3::new(-0.2, 0.5, 1.0)];
    let place = |i: usize, off| Placement::new(Rotation3::new(axes[i]).into_inner(), off);
    let frame = Frame::new("frame", bodies[0], place(0, axes[1] * (0.1 * reach)));
    let reference = Frame::new("reference", bodies[1], place(1, *mean));
    let side = Vector3::from_element(0.3 * reach);
    let rows = FrameRows::new(&frame, reference).at_origin().oriented();
    let rows = rows.in_box(&-side, &side)?.within_distance(0.7 * reach)?;
    let rows = rows.axis_along(&axes[0], &axes[1])?;
    let rows = rows.axis_within(&axes[1], &axes[0], 0.8)?;
    Ok(AnyConstraint::Frame(rows.within_angle(1.2)?))
}

/// Some pairs of balls of different bodies, neighbours in the tree and others.
fn pairs(balls: &[CollisionSphere]) -> Vec<[usize; 2]> {
    let count = balls.len();
    let partners = |i: usize| [1, 2, count / 2].map(|step| [i, (i + step) % count]);
    let differ = |[i, j]: &[usize; 2]| balls[*i].body != balls[*j].body;
    (0..count).flat_map(partners).filter(differ).collect()
}

/// Balls of every kind on any robot.
fn made_up_balls(model: &Model) -> Result<Vec<CollisionSphere>> {
    let mut balls = CollisionSphere::joint_frames(model);
    for capsule in Capsule::along_links(model, 0.05) {
        let length = (capsule.ends[1] - capsule.ends[0]).norm();
        balls.extend(capsule.balls(length.max(0.1))?);
    }
    // A ball off the axis of the last joint, because with a single joint all others are on the axis and do not move,
    // and one on the base.
    for body in [model.dof().checked_sub(1), None] {
        balls.push(CollisionSphere { body, centre: Vector3::new(0.1, -0.2, 0.3), radius: 0.1 });
    }
    Ok(balls)
}

/// Constraints of every kind on any robot.
fn made_up(model: &Model, state: &State) -> Result<Penalised<Vec<AnyConstraint>>> {
    let n = model.dof();
    let node = state.node();
    let balls = made_up_balls(model)?;
    let mut evaluator = Evaluator::new(model);
    let here = evaluator.at(node.x)?;
    let (mut mean, mut reach) = (Vector3::zeros(), 0.1_f64);
    for ball in &balls {
        let p = here.state().point(ball.body, &ball.centre)?;
        mean += p / balls.len() as f64;
        reach = reach.max(p.norm());
    }
    let sphere = |x, y, z, part| Sphere { centre: mean + Vector3::new(x, y, z) * reach, radius: part * reach };
    let near = |index: usize| Bound {
        entry: index,
        side: if index.is_multiple_of(2) { Side::Upper } else { Side::Lower },
        value: state.x[index] + 0.3 * (index as f64).sin(),
    };
    let mut u = vec![0.0; n];
    let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
    rnea(model, &mut Data::new(model), q, v, a, &mut u)?;
    let largest = u.iter().fold(1.0_f64, |m, u| m.max(u.abs()));
    let limit = |(i, u): (usize, &f64)| (i % 4 != 1).then(|| u.abs() + largest * (0.1 * (i as f64).sin() + 0.02));
    Ok(Penalised {
        constraints: Constraints {
            state: vec![
                AnyConstraint::Spheres(SphereClearance {
                    balls: balls.clone(),
                    spheres: vec![sphere(0.3, 0.1, -0.2, 0.5), sphere(-0.2, -0.3, 0.1, 0.4)],
                }),
                AnyConstraint::Solids(SolidClearance {
                    balls: balls.clone(),
                    solids: solids(&mean, reach),
                    names: Vec::new(),
                }),
                AnyConstraint::SelfCollision(SelfClearance { pairs: pairs(&balls), balls }),
                AnyConstraint::Bounds(Bounds((0..2 * n).map(near).collect())),
                frame_rows([n.checked_sub(1), None], &mean, reach)?,
                frame_rows([n.checked_sub(1), n.checked_sub(2)], &mean, reach)?,
            ],
            torque: TorqueLimits(u.iter().enumerate().map(limit).collect()),
            stage: Default::default(),
        },
        weights: PenaltyWeights {
            state: Penalty { k_cons: 10.0, c_cons: 2.0 },
            torque: Penalty { k_cons: 2.0, c_cons: 1.0 / largest },
        },
    })
}

/// Compares weighted sums of derivatives: the gradient with dual numbers of the rows, the Hessian including the
/// products of gradients with dual numbers of a gradient whose weights change with the rows,
/// $w_j + c_j (g_j(x) - g_j)$.
fn contractions(
    model: &Model,
    name: &str,
    constraint: &impl Constraint,
    at: At<'_>,
    findings: &mut Findings,
) -> Result<()> {
    let (x, rows) = (at.state.node().x, constraint.dim());
    let wave = |f: f64| (1..=rows).map(move |j| (f * j as f64).sin()).collect::<Vec<_>>();
    let (w, c) = (wave(0.7), wave(1.9));
    let mut evaluator = Evaluator::new(model);
    let mut here = evaluator.at(x)?;
    let mut g = vec![0.0; rows];
    here.value(constraint, &mut g)?;
    let weights = Weights { first_order: &w, gauss_newton: Some(&c) };
    let ours = here.weighted_derivatives(constraint, weights)?;

    let expected = gradient(x, |x| {
        let mut evaluator = Evaluator::new(model);
        let mut g = vec![Dual64::from(0.0); rows];
        evaluator.at(x)?.value(constraint, &mut g)?;
        let sum = g.iter().zip(&w).fold(Dual64::from(0.0), |sum, (g, w)| sum + *g * *w);
        Ok(sum)
    })?;
    let row = DMatrix::from_row_slice(1, x.len(), ours.gradient().as_slice());
    let quantity = format!("{name}: weighted gradient");
    let expected = expected.transpose();
    findings.compare(TOLERANCE, &quantity, at, row.as_view(), expected.as_view());

    let expected = jacobian(x, |x| {
        let mut evaluator = Evaluator::new(model);
        let mut here = evaluator.at(x)?;
        let mut moved = vec![Dual64::from(0.0); rows];
        here.value(constraint, &mut moved)?;
        for (moved, ((w, c), g)) in moved.iter_mut().zip(w.iter().zip(&c).zip(&g)) {
            *moved = (*moved - *g) * *c + *w;
        }
        let weights = Weights { first_order: &moved, gauss_newton: None };
        let gradient = here.weighted_derivatives(constraint, weights)?.gradient();
        Ok(gradient.clone_owned())
    })?;
    let quantity = format!("{name}: weighted Hessian");
    findings.compare(TOLERANCE, &quantity, at, ours.hessian().as_view(), expected.as_view());
    Ok(())
}

/// Compares the weighted derivatives of the rows of a standing foot in the same way.
fn standing_foot(model: &Model, at: At<'_>, findings: &mut Findings) -> Result<()> {
    let state = state_of(at);
    let axis = Vector3::new(0.4, -0.8, 0.3);
    let mass = model.mass() + model.base_inertia().mass;
    let foot = StandingFoot {
        name: String::new(),
        sole: Placement::new(Rotation3::new(axis).into_inner(), axis * 0.2),
        half_length: 0.12,
        half_width: 0.05,
        friction: 0.6,
        torsion: Some(0.03),
        weight: mass * (1.0 + model.gravity().norm()),
    };
    let wave = |f: f64| (1..=foot.dim()).map(move |j| (f * j as f64).sin()).collect::<Vec<_>>();
    let (w, c) = (wave(0.7), wave(1.9));
    let (q, v, a) = split(&state);
    let mut g = vec![0.0; foot.dim()];
    foot.value(model, &mut Data::new(model), [q, v, a], &mut g)?;
    let mut ours = FootDerivatives::new(model.dof());
    let weights = FootWeights { slopes: &w, multipliers: &w, curvatures: &c };
    foot.weighted_derivatives(model, &mut Data::new(model), [q, v, a], weights, &mut ours)?;

    let rows = |z: [&[Dual64]; 3]| -> Result<Vec<Dual64>> {
        let mut g = vec![Dual64::from(0.0); foot.dim()];
        foot.value(model, &mut Data::new(model), z, &mut g)?;
        Ok(g)
    };
    let expected = gradient(&state, |state| {
        let (q, v, a) = split(state);
        let weighted = rows([q, v, a])?.into_iter().zip(&w);
        Ok(weighted.fold(Dual64::from(0.0), |sum, (g, w)| sum + g * *w))
    })?;
    let row = DMatrix::from_row_slice(1, state.len(), ours.gradient.as_slice());
    let (tolerance, name) = (at.direct(), "foot: weighted gradient");
    let expected = expected.transpose();
    findings.compare(tolerance, name, at, row.as_view(), expected.as_view());

    let expected = jacobian(&state, |state| {
        let (q, v, a) = split(state);
        let mut moved = rows([q, v, a])?;
        for (moved, ((w, c), g)) in moved.iter_mut().zip(w.iter().zip(&c).zip(&g)) {
            *moved = (*moved - *g) * *c + *w;
        }
        let zeros = vec![Dual64::from(0.0); foot.dim()];
        let weights = FootWeights { slopes: &moved, multipliers: &zeros, curvatures: &zeros };
        let mut out = FootDerivatives::new(model.dof());
        foot.weighted_derivatives(model, &mut Data::new(model), [q, v, a], weights, &mut out)?;
        Ok(out.gradient)
    })?;
    let (name, hessian) = ("foot: weighted Hessian", ours.hessian.as_view());
    findings.compare(tolerance, name, at, hessian, expected.as_view());
    Ok(())
}
