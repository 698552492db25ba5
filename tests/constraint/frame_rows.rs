//! Rows on the placement of a frame.

use crate::common::{any_model, assert_refused, config, numbers, robot, wave};
use crate::derivatives::{ValueAlone, contracted};
use aghf::constraint::{AnyConstraint, Constraint, Evaluator, FrameRows, Weights};
use aghf::model::{Frame, Model};
use aghf::scalar::{LANES, Lanes, Wide};
use aghf::spatial::Placement;
use nalgebra::{Rotation3, UnitVector3, Vector3};
use proptest::prelude::*;
use std::f64::consts::PI;

fn placement(turn: [f64; 3], off: [f64; 3]) -> Placement<f64> {
    let rotation = Rotation3::new(Vector3::from(turn)).into_inner();
    Placement::new(rotation, Vector3::from(off))
}

/// Rows of every kind on a frame of a body in a reference of another.
fn every_row([body, of]: [Option<usize>; 2]) -> FrameRows {
    let frame = Frame::new("tool", body, placement([0.3, -0.8, 0.4], [0.1, 0.2, -0.3]));
    let reference = placement([1.0, 0.2, -0.7], [-0.2, 0.4, 0.1]);
    let rows = FrameRows::new(&frame, Frame::new("goal", of, reference));
    let (axis, to) = (Vector3::new(1.0, -0.4, 0.2), Vector3::new(0.3, 0.5, -2.0));
    let (lower, upper) = (Vector3::new(-0.1, 0.2, f64::NEG_INFINITY), Vector3::new(0.3, 0.2, 0.4));
    let rows = rows.at_origin().oriented().in_box(&lower, &upper);
    let rows = rows.and_then(|rows| rows.within_distance(0.3)?.within_angle(0.4)?.axis_along(&axis, &to));
    rows.and_then(|rows| rows.axis_within(&to, &axis, 0.2)).expect("bounds and angles")
}

fn values(model: &Model, constraint: &FrameRows, x: &[f64]) -> Vec<f64> {
    let mut g = vec![0.0; constraint.dim()];
    let mut evaluator = Evaluator::new(model);
    evaluator.at(x).expect("its state").value(constraint, &mut g).expect("its rows");
    g
}

/// The scaled rows of a frame of the base, at a placement in the reference.
fn scaled(rows: impl Fn(FrameRows) -> aghf::Result<FrameRows>, there: Placement<f64>) -> Vec<f64> {
    let reference = placement([0.5, -1.1, 0.7], [0.3, 0.1, -0.6]);
    let frame = Frame::new("tool", None, reference.compose(&there));
    let rows = rows(FrameRows::new(&frame, Frame::new("goal", None, reference))).expect("its rows");
    let scales = rows.row_scales();
    let g = values(&robot("pendulum_1"), &rows, &[0.0; 2]);
    g.iter().zip(&scales).map(|(g, scale)| g / scale).collect()
}

/// The excess of the only row over its bound.
fn excess(rows: impl Fn(FrameRows) -> aghf::Result<FrameRows>, there: Placement<f64>) -> f64 {
    let frame = Frame::new("tool", None, there);
    let goal = Frame::new("goal", None, Placement::identity());
    let one = rows(FrameRows::new(&frame, goal)).expect("its row");
    let scale = one.row_scales();
    let model = robot("pendulum_1");
    let g = values(&model, &one, &[0.0; 2]);
    one.label(0, &model).form.excess(g[0] / scale[0], scale[0])
}

fn unit() -> impl Strategy<Value = Vector3<f64>> {
    let vector = prop::array::uniform3(-1.0..1.0_f64).prop_map(Vector3::from);
    vector.prop_filter("it has a direction", |v| v.norm() > 0.1).prop_map(|v| v.normalize())
}

proptest! {
    #![proptest_config(config(48))]

    /// On any two bodies, behind the list of constraints or not, alone or with others: derivatives are those of dual
    /// numbers, and four states at once have the rows and derivatives of each.
    #[test]
    fn derivatives_are_those_of_the_value((model, x, bodies) in any_model().prop_flat_map(|model| {
        let n = model.dof();
        let body = || prop::option::of(0..n);
        (Just(model), numbers(2 * n), (body(), body()))
    })) {
        let rows = every_row([bodies.0, bodies.1]);
        let (w, c) = (wave(rows.dim(), 0.7), wave(rows.dim(), 1.9));
        let weights = Weights { first_order: &w, gauss_newton: Some(&c) };
        let (gradient, hessian) = contracted(&model, &AnyConstraint::Frame(rows.clone()), &x, weights);
        let (by_jets, by_jets2) = contracted(&model, &ValueAlone(&rows), &x, weights);
        assert_close!(&gradient, &by_jets, 1e-12);
        assert_close!(&hessian, &by_jets2, 1e-12);
        let alone = contracted(&model, &rows, &x, Weights { gauss_newton: None, ..weights });
        assert_close!(&alone.0, &gradient, 1e-14);
        prop_assert_eq!(alone.1.amax(), 0.0);

        let state = |lane: usize| x.iter().map(move |x| x * (1.0 + lane as f64)).collect::<Vec<_>>();
        let wide: Vec<Wide> = (0..x.len()).map(|i| Lanes(std::array::from_fn(|lane| state(lane)[i]))).collect();
        let splat = |from: &[f64]| from.iter().map(|x| Wide::splat(*x)).collect::<Vec<_>>();
        let mut evaluator = Evaluator::<f64, Wide>::new(&model);
        let mut here = evaluator.at(&wide).expect("its state");
        let mut g = splat(&w);
        here.value(&rows, &mut g).expect("its rows");
        let (w, c) = (splat(&w), splat(&c));
        let weights_of_all = Weights { first_order: &w, gauss_newton: Some(&c) };
        let sums = here.weighted_derivatives(&rows, weights_of_all).expect("its rows");
        for lane in 0..LANES {
            let one: Vec<f64> = g.iter().map(|g| g.0[lane]).collect();
            assert_close!(&one, &values(&model, &rows, &state(lane)), 1e-13);
            let hessian: Vec<f64> = sums.hessian().iter().map(|h| h.0[lane]).collect();
            assert_close!(&hessian, &contracted(&model, &rows, &state(lane), weights).1, 1e-12);
        }
    }

    /// Scaled rows are lengths and angles: exactly for positions, to first order at the boundary for angles.
    #[test]
    fn scaled_rows_are_lengths_and_angles(
        e in unit(), n in unit(), angle in 0.0..PI, d in unit(), bound in 0.05..3.0_f64, power in -290..290_i32
    ) {
        let turned = |by: f64| placement((e * by).into(), (d * 0.7).into());
        let there = turned(angle);
        assert_close!(&scaled(|rows| Ok(rows.at_origin()), there), (d * 0.7).iter(), 1e-14);
        let by_sin = scaled(|rows| Ok(rows.oriented()), there);
        assert_close!(&by_sin[..3], (e * angle.sin()).iter(), 1e-14);
        prop_assert_eq!(by_sin[3] > 0.0, angle > PI / 3.0);
        let within = |rows: FrameRows| rows.within_angle(bound);
        prop_assert_eq!(scaled(within, there)[0] > 0.0, angle > bound);
        let slope = (scaled(within, turned(bound + 1e-6))[0] - scaled(within, turned(bound - 1e-6))[0]) / 2e-6;
        prop_assert!((slope - 1.0).abs() < 1e-6);
        let distance = scaled(|rows| rows.within_distance(0.5), there)[0];
        prop_assert!((distance - (0.49 - 0.25)).abs() < 1e-14);
        // The excess is right far beyond the bound too; cosines have half of the digits.
        prop_assert!((excess(within, there) - (angle - bound)).abs() < 1e-7);
        let far = excess(|rows| rows.within_distance(bound), there);
        prop_assert!((far - (0.7 - bound)).abs() < 1e-14);

        // The axis n turned by `angle` about an axis across it.
        let across = UnitVector3::new_normalize(n.cross(&e));
        let tilted = Placement::new(Rotation3::from_axis_angle(&across, angle).into_inner(), d);
        // Vectors of any length, whose squares may overflow or vanish.
        let long = [power, -power].map(|power| n * 10.0_f64.powi(power));
        let along = scaled(|rows| rows.axis_along(&long[0], &long[1]), tilted);
        let [first, second, opposite] = along[..] else { panic!("{along:?}") };
        prop_assert!((first.hypot(second) - angle.sin()).abs() < 1e-13);
        prop_assert_eq!(opposite > 0.0, angle > PI / 3.0);
        let tilt = excess(|rows| rows.axis_within(&n, &n, bound), tilted);
        prop_assert!((tilt - (angle - bound)).abs() < 1e-7);
        prop_assert_eq!(scaled(|rows| rows.axis_within(&n, &n, bound), tilted)[0] > 0.0, angle > bound);
    }
}

/// The sum of squares of the violations leads from every angle to zero.
#[test]
fn violations_grow_to_half_a_turn() {
    let e = Vector3::new(1.0, -2.0, 0.5).normalize();
    let violation = |angle: f64, axis: bool| {
        let rows = move |rows: FrameRows| {
            if axis { rows.axis_along(&Vector3::z(), &Vector3::z()) } else { Ok(rows.oriented()) }
        };
        let axis = if axis { Vector3::y() } else { e };
        let g = scaled(rows, placement((axis * angle).into(), [0.0; 3]));
        let (last, equalities) = g.split_last().expect("it has rows");
        equalities.iter().map(|g| g * g).sum::<f64>() + last.max(0.0).powi(2)
    };
    for axis in [false, true] {
        assert!(violation(0.0, axis) < 1e-30);
        for i in 1..=100 {
            let at = |i: i32| violation(PI * f64::from(i) * 0.01, axis);
            assert!(at(i) > at(i - 1));
        }
    }
}

#[test]
fn boxes_planes_and_lines() {
    let (inf, at) = (f64::INFINITY, placement([0.1, 0.2, 0.3], [0.5, -0.2, 0.1]));
    let rows = |lower: [f64; 3], upper: [f64; 3]| scaled(|rows| rows.in_box(&lower.into(), &upper.into()), at);
    assert_close!(&rows([-1.0; 3], [0.3; 3]), &[0.2, -1.5, -0.5, -0.8, -0.2, -1.1], 1e-15);
    assert_close!(&rows([-inf, -inf, 0.2], [inf, inf, 0.2]), &[-0.1], 1e-15);
    assert_close!(&rows([0.1, 0.2, -inf], [0.1, 0.2, 0.0]), &[0.4, -0.4, 0.1], 1e-15);
    let frame = Frame::new("tool", None, at);
    let none = FrameRows::new(&frame, Frame::new("goal", Some(0), at));
    let line = none.in_box(&Vector3::new(0.1, 0.2, -inf), &Vector3::new(0.1, 0.2, inf));
    let line = line.expect("a line");
    assert_eq!([0, 1, 2].map(|row| line.row_set(row).is_equality), [true, true, false]);
    let model = robot("pendulum_1");
    let label = line.label(1, &model);
    assert_eq!((&*label.name, label.unit), ("position along y of frame 'tool' in frame 'goal'", "m"));
    assert_eq!(line.label(2, &model).name, "row 2 of the constraint");
}

#[test]
fn what_no_frame_keeps_is_refused() {
    let rows = || every_row([Some(0), None]);
    let (zero, z) = (Vector3::zeros(), Vector3::z());
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_refused(rows().within_distance(bad), "frame 'tool': largest distance: it is");
    }
    for bad in [0.0, -1.0, PI, f64::NAN] {
        assert_refused(rows().within_angle(bad), "frame 'tool': largest angle: it is");
        assert_refused(rows().axis_within(&z, &z, bad), "and must be an angle between 0 and pi");
    }
    assert_refused(rows().axis_along(&zero, &z), "frame 'tool': axis: (0, 0, 0) has length zero");
    let large = Vector3::new(f64::NAN, 0.0, 1.0);
    assert_refused(rows().axis_within(&z, &large, 0.1), "direction: (NaN, 0, 1) has length zero");
    for (lower, upper) in [(1.0, 0.0), (f64::NAN, 1.0), (f64::INFINITY, f64::INFINITY)] {
        let found = rows().in_box(&Vector3::from_element(lower), &Vector3::from_element(upper));
        assert_refused(found, "frame 'tool': bounds of the position: the lower bound");
    }
    let model = robot("pendulum_2");
    let mut evaluator = Evaluator::<f64>::new(&model);
    let here = evaluator.at(&[0.0; 4]).expect("two joints");
    let far = every_row([Some(5), None]);
    assert_refused(here.value(&far, &mut vec![0.0; far.dim()]), "expected 6 entries, found 2");
}
