//! Constraints: contractions against dual numbers of the value, swept links, and the constrained flow.

use crate::common::{any_model, assert_refused, assert_right, config, numbers, robot, wave};
use crate::solid_clearance::sizes;
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, Evaluator, PlacedState, SelfClearance, Side,
    SolidClearance, Sphere, SphereClearance, Weights,
};
use aghf::dynamics::forward_kinematics;
use aghf::geometry::{Capsule, Shape, Solid};
use aghf::model::Model;
use aghf::scalar::AlgebraOver;
use aghf::spatial::Placement;
use aghf::verify::duals::{CheckOptions, check_constraints};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

/// Every built-in kind: several balls on every body and one on the base, several spheres, a slanted floor, and bounds
/// on both halves of the state.
fn every_kind(model: &Model) -> Vec<AnyConstraint> {
    let mut balls = CollisionSphere::joint_frames(model);
    for body in 0..model.dof() {
        let offset = 0.1 * body as f64;
        balls.push(CollisionSphere {
            body: Some(body),
            centre: Vector3::new(0.3, -0.2 + offset, 0.1 - offset),
            radius: 0.05 + offset,
        });
    }
    balls.push(CollisionSphere { body: None, centre: Vector3::new(0.5, 0.5, 0.5), radius: 0.1 });
    let sphere = |x, y, z, radius| Sphere { centre: Vector3::new(x, y, z), radius };
    let solids = sizes([0.3, 0.2, 0.5, 0.4]).map(|shape| Solid {
        placement: Placement::new(
            Rotation3::new(Vector3::new(0.4, -0.9, 0.3)).into_inner(),
            Vector3::new(0.3, -0.4, 0.2),
        ),
        shape,
    });
    let count = balls.len();
    let pairs = (0..count).flat_map(|i| [[i, (i + 1) % count], [i, (i * i + 2) % count]]);
    let bound = |entry, side, value| Bound { entry, side, value };
    let m = 2 * model.dof();
    vec![
        AnyConstraint::Spheres(SphereClearance {
            balls: balls.clone(),
            spheres: vec![sphere(0.4, 0.1, -0.7, 0.3), sphere(-1.0, 0.8, 0.5, 1.1)],
        }),
        AnyConstraint::Solids(SolidClearance {
            balls: balls.clone(),
            solids: vec![Solid::half_space(&Vector3::new(2.0, -1.0, 2.0), -0.4)],
            names: Vec::new(),
        }),
        AnyConstraint::Solids(SolidClearance { balls: balls.clone(), solids: solids.into(), names: Vec::new() }),
        AnyConstraint::SelfCollision(SelfClearance { pairs: pairs.collect(), balls }),
        AnyConstraint::Bounds(Bounds(vec![
            bound(0, Side::Upper, 0.7),
            bound(m / 2 - 1, Side::Lower, -0.2),
            bound(m - 1, Side::Upper, 1.5),
            bound(m / 2, Side::Lower, -1.5),
        ])),
        AnyConstraint::Bounds(Bounds::positions(model)),
        AnyConstraint::Bounds(Bounds::velocities(model)),
    ]
}

/// A constraint without its analytic contractions.
pub struct ValueAlone<K>(pub K);

impl<K: Constraint> Constraint for ValueAlone<K> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> aghf::Result<()> {
        self.0.value(at, g)
    }
}

/// Gradient and Hessian with given weights.
pub fn contracted(
    model: &Model,
    constraint: &impl Constraint,
    x: &[f64],
    weights: Weights<'_, f64>,
) -> (DVector<f64>, DMatrix<f64>) {
    let mut evaluator = Evaluator::new(model);
    // Previous use of a workspace must not matter.
    let elsewhere: Vec<f64> = x.iter().map(|x| 0.5 - x).collect();
    let all = Weights { gauss_newton: Some(weights.first_order), ..weights };
    let mut there = evaluator.at(&elsewhere).expect("lengths agree");
    there.weighted_derivatives(constraint, all).expect("same robot");
    let mut here = evaluator.at(x).expect("lengths agree");
    let out = here.weighted_derivatives(constraint, weights).expect("same robot");
    (out.gradient().clone(), out.hessian().clone())
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn derivatives_match_duals(model in any_model(), seed in any::<u64>()) {
        let options = CheckOptions { samples: 1, seed, penalties: vec![1.0] };
        assert_right(&model, check_constraints(&model, &options));
    }

    /// The default derivatives of a constraint equal the analytic ones. The rounding of sums of some thousand products
    /// is far below the bound.
    #[test]
    fn derivatives_of_the_value_alone_are_the_same((model, x) in any_model().prop_flat_map(|model| {
        let n = 2 * model.dof();
        (Just(model), numbers(n))
    })) {
        let all = every_kind(&model);
        for one in all.iter().map(std::slice::from_ref).chain([&all[..]]) {
            let (w, c) = (wave(one.dim(), 0.7), wave(one.dim(), 1.9));
            let weights = Weights { first_order: &w, gauss_newton: Some(&c) };
            let (gradient, hessian) = contracted(&model, &one, &x, weights);
            let (by_jets, by_jets2) = contracted(&model, &ValueAlone(one), &x, weights);
            assert_close!(&gradient, &by_jets, 1e-12);
            assert_close!(&hessian, &by_jets2, 1e-12);
            let (alone, nothing) = contracted(&model, &one, &x, Weights { first_order: &w, gauss_newton: None });
            prop_assert_eq!(alone, gradient);
            prop_assert_eq!(nothing.amax(), 0.0);
        }
    }
}

#[test]
fn a_sphere_by_hand() {
    let model = robot("pendulum_1");
    let balls = vec![CollisionSphere { body: Some(0), centre: Vector3::new(-1.0, 0.0, 0.0), radius: 0.2 }];
    let sphere = Sphere { centre: Vector3::new(0.0, 0.0, 2.0), radius: 0.3 };
    let constraint = SphereClearance { balls, spheres: vec![sphere] };
    // A turn by q about y takes the tip to (-cos q, 0, sin q): |p - c|^2 = 5 - 4 sin q.
    let q = 0.3_f64;
    let mut g = [0.0];
    let mut evaluator = Evaluator::new(&model);
    let x = [q, 0.0];
    evaluator.at(&x).expect("one joint").value(&constraint, &mut g).expect("one row");
    assert_close!(&g, &[0.25 - 5.0 + 4.0 * q.sin()], 1e-14);
    let weights = Weights { first_order: &[2.0], gauss_newton: Some(&[3.0]) };
    let (gradient, hessian) = contracted(&model, &constraint, &x, weights);
    assert_close!(&gradient, &[8.0 * q.cos(), 0.0], 1e-14);
    let expected = -8.0 * q.sin() + 3.0 * 16.0 * q.cos().powi(2);
    assert_close!(&hessian, &[expected, 0.0, 0.0, 0.0], 1e-14);
}

#[test]
fn limits_become_rows() {
    let model = robot("kinova_gen3");
    let finite =
        |f: fn(&aghf::model::Limits) -> f64| model.joints().iter().filter(|j| f(j.limits()).is_finite()).count();
    assert_eq!(Bounds::positions(&model).0.len(), finite(|l| l.lower) + finite(|l| l.upper));
    assert_eq!(Bounds::velocities(&model).0.len(), 2 * finite(|l| l.velocity));
    assert!(finite(|l| l.velocity) > 0);
    let mut x = vec![0.0; 14];
    let speed = model.joints()[0].limits().velocity;
    x[7] = speed + 0.25;
    let bounds = Bounds::velocities(&model);
    let mut g = vec![0.0; bounds.dim()];
    let mut evaluator = Evaluator::new(&model);
    evaluator.at(&x).expect("7 joints").value(&bounds, &mut g).expect("rows");
    assert_close!(&g[..2], &[-2.0 * speed - 0.25, 0.25], 1e-14);
}

/// All points of a capsule are in one of the balls, which protrude no further than necessary.
#[test]
fn balls_cover_a_capsule() {
    let capsule =
        Capsule { body: Some(0), ends: [Vector3::new(0.1, 0.2, -0.3), Vector3::new(0.5, -0.4, 0.6)], radius: 0.1 };
    let [from, to] = capsule.ends;
    let along = (to - from).normalize();
    let across = along.cross(&Vector3::x()).normalize();
    let third = along.cross(&across);
    for spacing in [2.0, 0.3, 0.05] {
        let balls = capsule.balls(spacing).expect("positive");
        assert_eq!(balls.len(), ((to - from).norm() / spacing).ceil() as usize + 1);
        for i in 0..=200 {
            for angle in 0..12 {
                // The side, and both rounded ends.
                let t = f64::from(i) / 200.0 * ((to - from).norm() + 0.2) - 0.1;
                let beyond = (t - t.clamp(0.0, (to - from).norm())).abs();
                let width = (0.01 - beyond * beyond).max(0.0).sqrt();
                let (sin, cos) = (f64::from(angle) * 0.5).sin_cos();
                let p = from + along * t + (across * cos + third * sin) * width;
                let inside = |b: &CollisionSphere| (p - b.centre).norm() <= b.radius + 1e-12;
                assert!(balls.iter().any(inside), "{p} with spacing {spacing}");
            }
        }
        for ball in &balls {
            let h = (balls[1].centre - balls[0].centre).norm();
            assert!((ball.radius.powi(2) - 0.01 - 0.25 * h * h).abs() < 1e-12);
        }
    }
    assert_eq!(capsule.balls(2.0).expect("positive").len(), 2);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_refused(capsule.balls(bad), "spacing");
    }
    let radius = -0.1;
    let inside_out = Capsule { radius, ..capsule };
    assert_refused(inside_out.balls(1.0), "radius");
}

#[test]
fn the_whole_arm_is_swept() {
    for name in ["pendulum_3", "kinova_gen3", "digit_v3_pinned"] {
        let model = robot(name);
        let capsules = Capsule::along_links(&model, 0.05);
        for (i, joint) in model.joints().iter().enumerate() {
            assert!(capsules.iter().any(|c| c.body == Some(i)), "{name}: body {i}");
            let origin = joint.origin().translation;
            let carried = |c: &Capsule| c.body == joint.parent() && c.ends.contains(&origin);
            assert!(joint.parent().is_none() || capsules.iter().any(carried), "{name}: joint {i}");
        }
    }
    let model = robot("kinova_gen3");
    let capsules = Capsule::along_links(&model, 0.05);
    let tool = model.frames().last().expect("it has links");
    assert!(capsules.iter().any(|c| c.body == tool.body && c.ends[1] == tool.placement.translation));
}

/// The exact clearance is that of the nearest of many points, and that of the balls is never larger.
#[test]
fn clearance_is_exact_and_balls_are_conservative() {
    let model = robot("kinova_gen3");
    let q = wave(7, 0.9);
    let mut placements = vec![Placement::identity(); 7];
    forward_kinematics(&model, &q, &mut placements).expect("7 joints");
    for i in 0..20 {
        let at = wave(3, 0.31 * f64::from(i + 1));
        let centre = Vector3::from_column_slice(&at) * 0.8;
        let sphere =
            Solid { placement: Placement::new(Matrix3::identity(), centre), shape: Shape::Sphere { radius: 0.1 } };
        for capsule in Capsule::along_links(&model, 0.06) {
            let nearest = capsule.nearest_ball(&placements, &sphere);
            let nearest = nearest.expect("same robot").expect("in closed form");
            let exact = sphere.distance(&nearest.centre) - nearest.radius;
            let point = |p: Vector3<f64>| {
                let body = &placements[capsule.body.expect("it moves")];
                (body.rotation * p + body.translation - centre).norm()
            };
            let [from, to] = capsule.ends;
            let sampled =
                (0..=10_000).map(|i| point(from + (to - from) * (f64::from(i) * 1e-4))).fold(f64::INFINITY, f64::min);
            // The nearest of the samples is within 1e-4 of a link of at most half a metre.
            assert!((sampled - 0.16 - exact).abs() < 1e-4, "{exact}");
            let balls = capsule.balls(0.05).expect("positive");
            let covered = balls.iter().map(|b| point(b.centre) - b.radius - 0.1).fold(f64::INFINITY, f64::min);
            assert!(covered <= exact + 1e-12 && covered > exact - 0.006, "{covered} for {exact}");
        }
    }
}

#[test]
fn links_are_found_by_name_and_other_robots_are_errors() {
    let model = robot("kinova_gen3");
    let frame = model.frames().last().expect("it has links");
    let ball = CollisionSphere::at_link(&model, &frame.name, 0.1).expect("it is there");
    assert_eq!((ball.body, ball.centre), (frame.body, frame.placement.translation));
    let error = CollisionSphere::at_link(&model, "tail", 0.1).expect_err("no such link");
    assert!(error.to_string().contains("link 'tail': the robot has no link 'tail'"), "{error}");

    let small = robot("pendulum_2");
    let mut evaluator = Evaluator::<f64, f64>::new(&small);
    let x = [0.0; 4];
    let mut here = evaluator.at(&x).expect("two joints");
    let constraint =
        SphereClearance { balls: vec![ball], spheres: vec![Sphere { centre: Vector3::zeros(), radius: 1.0 }] };
    let no_body = "bodies of the robot of a constraint: expected 7 entries, found 2";
    assert_refused(here.value(&constraint, &mut [0.0]), no_body);
    let weights = Weights { first_order: &[1.0], gauss_newton: Some(&[1.0]) };
    assert_refused(here.weighted_derivatives(&constraint, weights), no_body);
    let fifth = Bounds(vec![Bound { entry: 4, side: Side::Upper, value: 0.0 }]);
    let no_entry = "bounded numbers: expected 5 entries, found 4";
    assert_refused(here.weighted_derivatives(&fifth, weights), no_entry);
    let alone = ValueAlone(constraint);
    assert_refused(here.weighted_derivatives(&alone, weights), no_body);
    let no_rows = "expected 0 entries, found 1";
    assert_refused(here.value(&(), &mut [0.0]), no_rows);
    assert_refused(here.weighted_derivatives(&(), weights), no_rows);
}
