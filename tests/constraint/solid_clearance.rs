//! Signed distances from shapes, and the clearance of balls from them.

use crate::common::{assert_refused, config, robot};
use crate::derivatives::contracted;
use aghf::constraint::{
    CollisionSphere, Constraint, Evaluator, Quantity, SolidClearance, Sphere, SphereClearance, Weights,
};
use aghf::geometry::{Distance, FLAT, Shape, Solid};
use aghf::scalar::{AlgebraOver, Jet, Lanes};
use aghf::spatial::Placement;
use nalgebra::{DVector, Matrix3, Rotation3, Vector3};
use num_dual::{Dual64, HyperDual64};
use proptest::prelude::*;

/// One of each shape.
pub fn sizes([a, b, c, r]: [f64; 4]) -> [Shape; 4] {
    [
        Shape::Cuboid { half_extents: Vector3::new(a, b, c) },
        Shape::Cylinder { radius: r, half_length: c },
        Shape::Capsule { radius: r, half_length: c },
        Shape::Sphere { radius: r },
    ]
}

/// The amount by which a point violates the inequalities of a shape, zero on the surface and positive outside; not a
/// distance.
fn beyond(shape: &Shape, p: &Vector3<f64>) -> f64 {
    match shape {
        Shape::Sphere { radius } => p.norm() - radius,
        Shape::Cuboid { half_extents } => (p.abs() - half_extents).max(),
        Shape::Cylinder { radius, half_length } => (p.xy().norm() - radius).max(p.z.abs() - half_length),
        Shape::Capsule { radius, half_length } => {
            let on_axis = Vector3::new(0.0, 0.0, p.z.clamp(-half_length, *half_length));
            (p - on_axis).norm() - radius
        }
        Shape::HalfSpace => p.z,
    }
}

/// The point at which the ray from the centre leaves the shape.
fn on_surface(shape: &Shape, direction: &Vector3<f64>) -> Vector3<f64> {
    let (mut inside, mut outside) = (0.0, 10.0 / direction.norm());
    for _ in 0..60 {
        let middle = 0.5 * (inside + outside);
        if beyond(shape, &(direction * middle)) < 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    direction * inside
}

fn point(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
}

proptest! {
    #![proptest_config(config(256))]

    /// The point at the distance along the gradient is on the surface, and no other surface point is nearer; the sign
    /// tells the inside.
    #[test]
    fn distances_are_attained_and_least(
        size in prop::array::uniform4(0.1..1.0_f64),
        p in point(2.0),
        directions in prop::collection::vec(point(1.0), 50),
    ) {
        for shape in sizes(size) {
            let Distance { value, normal, curvature } = shape.distance_derivatives(&p);
            prop_assert_eq!(value, shape.distance(&p));
            prop_assert_eq!(value < 0.0, beyond(&shape, &p) < 0.0);
            prop_assert!((normal.norm() - 1.0).abs() < 1e-12);
            prop_assert!(beyond(&shape, &(p - normal * value)).abs() < 1e-12);
            for direction in &directions {
                prop_assert!((on_surface(&shape, direction) - p).norm() > value.abs() - 1e-12);
            }
            // Along the normal the distance is linear.
            prop_assert!((curvature * normal).amax() < 1e-9 / value.abs());
            prop_assert!((curvature - curvature.transpose()).amax() < 1e-12 * (1.0 + curvature.amax()));
            prop_assert!(value < 0.0 || curvature.amax() < 1.01 / value);
        }
    }

    #[test]
    fn derivatives_are_those_of_the_value(size in prop::array::uniform4(0.1..1.0_f64), p in point(1.2),
        turn in point(3.0), off in point(1.0)) {
        for shape in sizes(size) {
            let solid = Solid { placement: Placement::new(Rotation3::new(turn).into_inner(), off), shape };
            let ours = solid.distance_derivatives(&p);
            let expected = by_duals(|p| solid.distance(p), &p);
            let scale = 1.0 + expected.curvature.amax();
            prop_assert!((ours.value - expected.value).abs() < 1e-14);
            prop_assert!((ours.normal - expected.normal).amax() < 1e-12);
            prop_assert!((ours.curvature - expected.curvature).amax() < 1e-12 * scale * scale);
        }
    }
}

/// A distance and its derivatives by hyper-dual numbers of the value.
fn by_duals(distance: impl Fn(&Vector3<HyperDual64>) -> HyperDual64, p: &Vector3<f64>) -> Distance<f64> {
    let entry = |i: usize, j: usize| {
        let unit = |k: usize| f64::from(u8::from(k == i));
        let other = |k: usize| f64::from(u8::from(k == j));
        distance(&Vector3::from_fn(|k, _| HyperDual64::new(p[k], unit(k), other(k), 0.0)))
    };
    Distance {
        value: entry(0, 0).re,
        normal: Vector3::from_fn(|i, _| entry(i, i).eps1),
        curvature: Matrix3::from_fn(|i, j| entry(i, j).eps1eps2),
    }
}

/// At centres, on axes, surfaces, edges and corners, and where several faces are equally near, values and derivatives
/// are finite over all scalars; the gradient has length one, so that it leads out.
#[test]
fn nothing_is_undefined() {
    let size = [0.3, 0.3, 0.3, 0.3];
    let steps = [-0.6, -0.3, -1e-13, 0.0, 1e-13, 0.15, 0.3, 0.3 + 1e-13, 0.6];
    for shape in sizes(size).into_iter().chain(sizes([0.0; 4])) {
        for i in 0..9_usize.pow(3) {
            let p = Vector3::new(steps[i % 9], steps[i / 9 % 9], steps[i / 81]);
            let ours = shape.distance_derivatives(&p);
            let duals = by_duals(|p| shape.distance(p), &p);
            let scale = 1.0 + ours.curvature.amax();
            assert!(ours.value.is_finite() && scale.is_finite(), "{shape:?} {p}");
            assert!((ours.normal.norm() - 1.0).abs() < 1e-12, "{shape:?} {p}: {ours:?}");
            assert!((ours.value - duals.value).abs() < 1e-15);
            assert!((ours.normal - duals.normal).amax() < 1e-12, "{shape:?} {p}");
            let off = (ours.curvature - duals.curvature).amax();
            assert!(off < 1e-12 * scale, "{shape:?} {p}: {off}");
            let by_gradient = shape.distance_derivatives(&p.map(|x| Dual64::new(x, 1.0)));
            assert!(by_gradient.curvature.iter().all(|x| x.eps.is_finite()), "{shape:?} {p}");
            let four = shape.distance(&p.map(|x| Lanes([x, 0.0, x, 5.0])));
            assert_eq!((four.0[0], four.0[2]), (ours.value, ours.value));
            assert!(four.0.iter().all(|x| x.is_finite()));
        }
    }
    let single = Shape::Sphere { radius: 0.25_f32 };
    assert_eq!(single.distance(&Vector3::<f32>::zeros()), -0.25);
}

/// Ties go to the first axis on the positive side, and the distance is continuous where a derivative vanishes.
#[test]
fn ties_and_the_flat_part() {
    let [cuboid, cylinder, capsule, ball] = sizes([0.3, 0.3, 0.3, 0.3]);
    for shape in [cuboid, cylinder, capsule, ball] {
        let centre = shape.distance_derivatives(&Vector3::zeros());
        assert_eq!((centre.value, centre.normal), (-0.3, Vector3::x()));
        assert_eq!(centre.curvature, Matrix3::zeros());
        for direction in [Vector3::new(1.0, 2.0, 3.0), Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.6, 0.6, 0.6)] {
            for from in [Vector3::zeros(), Vector3::from_element(0.3), Vector3::new(0.3, 0.0, 0.3)] {
                let at = |t: f64| shape.distance(&(from + direction * t));
                let jump = (at(FLAT * 1.001) - at(FLAT * 0.1)).abs();
                assert!(jump < 10.0 * FLAT, "{shape:?}: {jump}");
            }
        }
    }
    let under_the_top = cuboid.distance_derivatives(&Vector3::<f64>::new(0.1, -0.1, -0.25));
    assert_eq!(under_the_top.normal, -Vector3::z());
    assert!((under_the_top.value + 0.05).abs() < 1e-15);
    let on_the_top = cylinder.distance_derivatives(&Vector3::new(0.1, 0.0, 0.3));
    assert_eq!((on_the_top.value, on_the_top.normal), (0.0, Vector3::z()));
}

/// It is $n \cdot p \le \delta$, and of a segment the lower end is nearest.
#[test]
fn a_half_space_ends_at_its_offset_along_its_normal() {
    for normal in [Vector3::new(2.0, -1.0, 2.0), Vector3::z(), Vector3::new(0.0, 0.0, -3.0)] {
        let solid = Solid::half_space(&normal, 0.4);
        let height = |p: &Vector3<f64>| normal.dot(p) / normal.norm() - 0.4;
        let ends = [Vector3::new(0.3, -0.7, 1.1), Vector3::new(-0.2, 0.5, 0.8)];
        for p in &ends {
            let found = solid.distance_derivatives(p);
            assert!((found.value - height(p)).abs() < 1e-15);
            assert!((found.normal - normal.normalize()).norm() < 1e-15);
            assert_eq!(found.curvature, Matrix3::zeros());
        }
        let lower = if height(&ends[0]) < height(&ends[1]) { ends[0] } else { ends[1] };
        let nearest = solid.nearest_on_segment(&ends).expect("in closed form");
        assert!((nearest - lower).norm() < 1e-15);
    }
}

/// The rows of solid balls are those of spheres, as distances.
#[test]
fn a_solid_ball_is_a_sphere() {
    let model = robot("kinova_gen3");
    let balls = CollisionSphere::joint_frames(&model);
    let balls: Vec<_> = (balls.iter()).map(|ball| CollisionSphere { radius: 0.07, ..*ball }).collect();
    let (centre, radius) = (Vector3::new(0.3, 0.2, 0.5), 0.2);
    let placement = Placement::new(Matrix3::identity(), centre);
    let solids = SolidClearance {
        balls: balls.clone(),
        solids: vec![Solid { placement, shape: Shape::Sphere { radius } }],
        names: Vec::new(),
    };
    let spheres = SphereClearance { balls, spheres: vec![Sphere { centre, radius }] };
    let x = [0.4; 14];
    let mut evaluator = Evaluator::<f64>::new(&model);
    let here = evaluator.at(&x).expect("7 joints");
    let (mut ours, mut squares) = ([0.0; 7], [0.0; 7]);
    here.value(&solids, &mut ours).expect("7 rows");
    here.value(&spheres, &mut squares).expect("7 rows");
    for (ours, square) in ours.iter().zip(squares) {
        assert!((ours - (0.27 - (0.27_f64.powi(2) - square).sqrt())).abs() < 1e-14);
    }
}

#[test]
fn labels_name_the_body_and_the_obstacle() {
    let model = robot("kinova_gen3");
    let ball = CollisionSphere::at_link(&model, "end_effector_link", 0.1).expect("it is there");
    let at = |shape| Solid { placement: Placement::identity(), shape };
    let mut clearance = SolidClearance {
        balls: vec![CollisionSphere { body: None, ..ball }, ball],
        solids: sizes([0.1; 4]).map(at).into(),
        names: Vec::new(),
    };
    let name = |clearance: &SolidClearance, row| clearance.label(row, &model).name;
    let body = name(&clearance, 4).split(" from ").next().map(str::to_owned).expect("a body");
    assert!(body.starts_with("distance of link '"), "{body}");
    for (row, shape) in ["box 0", "cylinder 1", "capsule 2", "sphere 3"].iter().enumerate() {
        assert_eq!(name(&clearance, 4 + row), format!("{body} from {shape}"));
    }
    assert_ne!(name(&clearance, 0), name(&clearance, 4));
    clearance.names = vec!["table".to_owned()];
    assert_eq!(name(&clearance, 4), format!("{body} from 'table'"));
    assert_eq!(name(&clearance, 5), format!("{body} from cylinder 1"));
    assert_eq!(name(&clearance, 8), "row 8 of the constraint");
    let label = clearance.label(1, &model);
    assert_eq!((label.unit, label.quantity), ("m", Quantity::Obstacles));
}

/// A state of three joints.
const X: [f64; 6] = [0.3, -0.8, 0.5, 0.0, 0.0, 0.0];

/// The weight of one row of the second ball alone.
const W: [f64; 12] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0];

/// Three balls, the last on a body that the robot does not have: without weights it is not placed.
fn of_a_missing_body() -> SolidClearance {
    let ball = |body| CollisionSphere { body: Some(body), centre: Vector3::new(0.2, 0.1, 0.0), radius: 0.1 };
    let at = |shape| Solid { placement: Placement::identity(), shape };
    SolidClearance { balls: vec![ball(0), ball(2), ball(7)], solids: sizes([0.1; 4]).map(at).into(), names: Vec::new() }
}

/// Rows are skipped only if both their weights and the weights of their products are zero.
#[test]
fn only_weights_that_vanish_are_left_out() {
    let (model, clearance) = (robot("pendulum_3"), of_a_missing_body());
    let zero = [0.0; 12];
    let (mut w, mut c) = (W, zero);
    let weighted = |first_order, gauss_newton| {
        let weights = Weights { first_order, gauss_newton: Some(gauss_newton) };
        contracted(&model, &clearance, &X, weights)
    };
    let (gradient, hessian) = weighted(&w, &zero);
    assert!(gradient.amax() > 0.1 && hessian.amax() > 0.01);
    c[6] = 1.0;
    let (_, products) = weighted(&zero, &c);
    assert_close!(&products, &(&gradient * gradient.transpose() / 2.25), 1e-14);
    w[11] = 1.0;
    let mut evaluator = Evaluator::<f64>::new(&model);
    let mut here = evaluator.at(&X).expect("3 joints");
    let weights = Weights { first_order: &w, gauss_newton: None };
    assert_refused(here.weighted_derivatives(&clearance, weights), "expected 8 entries, found 3");
}

/// A weight of value zero counts if its derivative is not zero.
#[test]
fn derivatives_of_weights_are_not_left_out() {
    let (model, clearance) = (robot("pendulum_3"), of_a_missing_body());
    let weights = Weights { first_order: &W, gauss_newton: Some(&[0.0; 12]) };
    let (gradient, _) = contracted(&model, &clearance, &X, weights);
    let of_two = SolidClearance { balls: clearance.balls[..2].to_vec(), ..clearance };
    let duals = weighted(&of_two, &W.map(|w| Dual64::new(0.0, w))[..8]);
    let slopes: Vec<f64> = duals.iter().map(|g| g.eps).collect();
    assert_close!(&slopes, &gradient, 1e-14);
    let jets = weighted(&of_two, &W.map(|w| Jet::<f64, 1>::new(0.0, [w]))[..8]);
    let slopes: Vec<f64> = jets.iter().map(|g| g.eps[0]).collect();
    assert_close!(&slopes, &gradient, 1e-14);
}

/// The gradient of a weighted sum, without the products.
fn weighted<S: AlgebraOver<f64>>(clearance: &SolidClearance, w: &[S]) -> DVector<S> {
    let model = robot("pendulum_3");
    let mut evaluator = Evaluator::<f64, S>::new(&model);
    let x = X.map(S::lift);
    let mut here = evaluator.at(&x).expect("3 joints");
    let weights = Weights { first_order: w, gauss_newton: None };
    let sums = here.weighted_derivatives(clearance, weights);
    sums.expect("8 weights").gradient().clone()
}
