//! Labels of rows, and their violations along a motion.

use crate::common::constraint::{Held, in_bodies};
use crate::common::{assert_refused, robot, slider, wave};
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, Constraints, ConvexClearance, Evaluator, Quantity,
    RowLabel, Side, SolidClearance, Sphere, SphereClearance, TorqueLimits,
};
use aghf::curve::{Chebyshev, Curve};
use aghf::geometry::Solid;
use aghf::model::Model;
use aghf::motion::{Violation, sample, violations};
use nalgebra::{DMatrix, Vector3};

fn assert_close_to(a: f64, b: f64, bound: f64) {
    assert!((a - b).abs() <= bound, "{a} is not {b}");
}

fn upper(entry: usize, value: f64) -> Bound {
    Bound { entry, side: Side::Upper, value }
}

fn lower(entry: usize, value: f64) -> Bound {
    Bound { entry, side: Side::Lower, value }
}

fn of_state<K>(state: K) -> Constraints<K> {
    Constraints { state, torque: TorqueLimits(Vec::new()), stage: Default::default() }
}

/// A curve of one joint in 2 s with these positions and velocities over time, which need not be consistent.
fn curve(q: impl Fn(f64) -> f64, v: impl Fn(f64) -> f64) -> Curve {
    let chebyshev = Chebyshev::new(4, 2.0).expect("a good degree");
    let times = chebyshev.times().to_vec();
    let x = DMatrix::from_fn(2, 5, |i, k| if i == 0 { q(times[k]) } else { v(times[k]) });
    Curve::new(chebyshev, x).expect("sizes agree")
}

/// A curve with these positions and zero velocity.
fn at_rest(q: impl Fn(f64) -> f64) -> Curve {
    curve(q, |_| 0.0)
}

/// The first row alone.
fn first<K: Constraint>(curve: &Curve, constraints: &Constraints<K>, intervals: usize) -> Violation {
    let all = violations(&slider(2.0), curve, constraints, intervals).expect("same robot");
    assert_eq!(all[0].row, 0);
    all[0]
}

/// The interpolation is exact for a parabola, so ten intervals suffice for its maximum: between two times, and next to
/// the ends, where no sample has a lower neighbour on either side.
#[test]
fn a_peak_between_two_times_is_found() {
    for top in [1.07, 0.03, 1.96] {
        let bump = at_rest(|t| 0.5 - (t - top).powi(2));
        let found = first(&bump, &of_state(Bounds(vec![upper(0, 0.4)])), 10);
        assert_close_to(found.by, 0.1, 1e-12);
        assert_close_to(found.at_s, top, 1e-9);
        let dent = at_rest(|t| (t - top).powi(2) - 0.5);
        let found = first(&dent, &of_state(Bounds(vec![lower(0, -0.4)])), 10);
        assert_close_to(found.by, 0.1, 1e-12);
    }
    // A cubic between the times, if it is a violation: three values are 5e-4 off.
    let skew = at_rest(|t| 0.5 - (t - 1.07).powi(2) - 0.2 * (t - 1.07).powi(3));
    let found = first(&skew, &of_state(Bounds(vec![upper(0, 0.4)])), 10);
    assert_close_to(found.by, 0.1, 2e-6);
    // A satisfied row has a margin, and a linear row is largest at an end.
    let slope = at_rest(|t| 0.1 * t);
    let found = first(&slope, &of_state(Bounds(vec![upper(0, 0.5)])), 7);
    assert_close_to(found.by, -0.3, 1e-15);
    assert_eq!(found.at_s, 2.0);
}

#[test]
fn an_equality_is_violated_by_its_absolute_value() {
    let held = of_state(Held(0.2));
    let sine = at_rest(|t| 0.2 - 0.3 * (1.0 - (t - 1.07).powi(2)));
    let found = first(&sine, &held, 10);
    assert_close_to(found.by, 0.3, 1e-12);
    assert_close_to(found.at_s, 1.07, 1e-9);
    let above = first(&at_rest(|t| 0.2 + 0.05 * t), &held, 10);
    assert_close_to(above.by, 0.1, 1e-15);
    assert!(first(&at_rest(|_| 0.2), &held, 10).by.abs() < 1e-15);
}

/// The control jumps between segments, and both sides count.
#[test]
fn each_segment_has_both_its_ends() {
    let chebyshev = Chebyshev::new(2, 1.0).expect("a good degree");
    // The speed rises as 1.5 t^2 and falls by 2 a second, so the force on 2 kg is 6 N just before 1 s and -4 N after
    // that.
    let speeds = chebyshev.times().iter().map(|t| 1.5 * t * t);
    let falling = chebyshev.times().iter().map(|t| 1.5 - 2.0 * t);
    let speeds: Vec<f64> = speeds.chain(falling).collect();
    let x = DMatrix::from_fn(2, 6, |i, k| if i == 0 { 0.0 } else { speeds[k] });
    let curve = Curve::piecewise(2.0, 2, x).expect("it is continuous");
    let kept = Constraints { state: (), torque: TorqueLimits(vec![Some(5.0)]), stage: Default::default() };
    let found = violations(&slider(2.0), &curve, &kept, 4).expect("same robot");
    assert_close_to(found[0].by, 6.0 - 5.0, 1e-12);
    assert_close_to(found[0].at_s, 1.0, 1e-12);
    assert_close_to(found[1].by, 4.0 - 5.0, 1e-12);
    assert!(found[1].at_s >= 1.0);
    let passive = Constraints { state: (), torque: TorqueLimits(vec![Some(0.0)]), stage: Default::default() };
    let found = violations(&slider(2.0), &curve, &passive, 4).expect("same robot");
    assert_eq!(found.len(), 1);
    assert_close_to(found[0].by, 6.0, 1e-12);
}

/// Every kind of row on an arm, some of them violated.
fn every_kind() -> (Model, Curve, Vec<AnyConstraint>, TorqueLimits) {
    let model = robot("kinova_gen3");
    let n = model.dof();
    let mut balls = CollisionSphere::joint_frames(&model);
    balls.iter_mut().for_each(|ball| ball.radius = 0.04);
    let state = vec![
        AnyConstraint::Spheres(SphereClearance {
            balls: balls.clone(),
            spheres: [0.3, 0.6, 0.9].map(|z| Sphere { centre: Vector3::new(0.2, 0.1, z), radius: 0.1 }).to_vec(),
        }),
        AnyConstraint::Other(Box::new((Held(0.1), Bounds(vec![upper(n, 0.4)])))),
        AnyConstraint::Solids(SolidClearance {
            balls,
            solids: vec![Solid::half_space(&Vector3::z(), 0.2)],
            names: Vec::new(),
        }),
        AnyConstraint::Bounds(Bounds::positions(&model)),
        AnyConstraint::Bounds(Bounds::velocities(&model)),
    ];
    let amplitudes = wave(2 * n * 9 * 2, 0.7);
    // Neighbouring segments share the state at their breakpoint.
    let x = DMatrix::from_fn(2 * n, 18, |i, k| amplitudes[i * 18 + if k > 8 { k - 1 } else { k }]);
    let curve = Curve::piecewise(3.0, 2, x).expect("it is continuous");
    (model.clone(), curve, state, TorqueLimits::of(&model))
}

/// Evaluating one row at many times without SIMD lanes gives the same result.
#[test]
fn rows_of_an_arm_are_those_at_many_times() {
    let (model, curve, state, torque) = every_kind();
    let all = Constraints { state, torque, stage: Default::default() };
    let found = violations(&model, &curve, &all, 1000).expect("same robot");
    assert_eq!(found.len(), all.dim());
    let (scales, states) = (all.row_scales(), all.state.dim());
    let mut worst = vec![f64::NEG_INFINITY; all.dim()];
    let mut evaluator = Evaluator::new(&model);
    for s in sample(&model, &curve, 4000).expect("same robot") {
        let mut g = vec![0.0; all.dim()];
        let x = [s.q, s.v].concat();
        let placed = evaluator.at(&x).expect("sizes agree");
        placed.value(&all.state, &mut g[..states]).expect("same robot");
        all.torque.value(&s.u, &mut g[states..]).expect("same robot");
        for (row, worst) in worst.iter_mut().enumerate() {
            let h = g[row] / scales[row];
            *worst = worst.max(if all.is_equality(row) { h.abs() } else { h });
        }
    }
    assert!(worst.iter().any(|h| *h > 0.0) && worst.iter().any(|h| *h < 0.0));
    for (found, worst) in found.iter().zip(&worst) {
        let name = all.label(found.row, &model).name;
        // 4000 times find a maximum to within about 1e-5; at a jump of the control they contain one side only.
        let jump = if found.row >= states { f64::INFINITY } else { 0.0 };
        let room = 1e-4 * (1.0 + worst.abs());
        assert!(found.by >= worst - room, "{name}: {} {worst}", found.by);
        assert!(found.by <= worst + room + jump, "{name}: {} {worst}", found.by);
        assert!((0.0..=3.0).contains(&found.at_s), "{name}");
    }
}

/// Rows of convex bodies are exact from a quarter of their cutoff on, and otherwise no larger than they are.
#[test]
fn rows_of_bodies_are_exact_near_their_bounds() {
    let (model, curve, ..) = every_kind();
    let above = |height: f64, far: f64| ConvexClearance {
        far,
        ..in_bodies(&model, vec![Solid::half_space(&Vector3::z(), height)])
    };
    // Heights at which a row begins at its cutoff and comes within a twentieth of its bound.
    let far = 0.2;
    let (begin, worst) = of_bodies(&model, &curve, &above(0.0, 10.0));
    let rows = begin.iter().zip(&worst);
    let heights = rows.filter(|(begin, worst)| *worst - *begin > far);
    let mut heights: Vec<f64> = heights.map(|(_, worst)| -0.05 * far - worst).collect();
    assert!(heights.len() > 2, "{worst:?}");
    heights.truncate(3);
    let (mut outside, mut at_cutoff) = (0, 0);
    for height in heights.into_iter().chain([0.25]) {
        let bodies = above(height, far);
        let bounds = AnyConstraint::Bounds(Bounds::positions(&model));
        let all = of_state(vec![bounds, AnyConstraint::Convex(bodies.clone())]);
        let found = violations(&model, &curve, &all, 1000).expect("same robot");
        let first = all.state[0].dim();
        let (_, worst) = of_bodies(&model, &curve, &bodies);
        let near = -0.25 * far;
        for (found, worst) in found[first..first + bodies.dim()].iter().zip(&worst) {
            let off = found.by - worst;
            // At a kink a maximum between the times is missed by their distance.
            let least = if *worst > near { -1e-3 } else { -far };
            assert!((least..1e-3).contains(&off), "{found:?} {worst}");
            outside += usize::from(*worst > 0.0);
            at_cutoff += usize::from(*worst == -far);
        }
    }
    assert!(outside > 0 && at_cutoff > 0, "{outside} {at_cutoff}");
}

/// The value of each row at the start, and the largest one at many times.
fn of_bodies(model: &Model, curve: &Curve, bodies: &ConvexClearance) -> (Vec<f64>, Vec<f64>) {
    let (mut begin, mut worst) = (None, vec![-bodies.far; bodies.dim()]);
    let mut evaluator = Evaluator::new(model);
    for s in sample(model, curve, 4000).expect("same robot") {
        let (x, mut g) = ([s.q, s.v].concat(), vec![0.0; bodies.dim()]);
        let placed = evaluator.at(&x).expect("sizes agree");
        placed.value(bodies, &mut g).expect("same robot");
        for (worst, g) in worst.iter_mut().zip(&g) {
            *worst = worst.max(*g);
        }
        begin.get_or_insert(g);
    }
    (begin.expect("there are times"), worst)
}

/// The result of a row is independent of its position, to the last bit.
#[test]
fn the_order_of_constraints_changes_nothing() {
    let (model, curve, state, torque) = every_kind();
    let dims: Vec<usize> = state.iter().map(Constraint::dim).collect();
    let mut turned = state.clone();
    turned.rotate_left(2);
    let of = |state| {
        let all = Constraints { state, torque: torque.clone(), stage: Default::default() };
        let found = violations(&model, &curve, &all, 501).expect("same robot");
        let label = |v: &Violation| (all.label(v.row, &model), v.by.to_bits(), v.at_s.to_bits());
        found.iter().map(label).collect::<Vec<_>>()
    };
    let (mut ours, theirs) = (of(state), of(turned));
    let rows: usize = dims.iter().sum();
    ours[..rows].rotate_left(dims[0] + dims[1]);
    assert_eq!(ours, theirs);
}

#[test]
fn labels_name_joint_and_unit() {
    let (model, _, state, torque) = every_kind();
    let all = Constraints { state, torque, stage: Default::default() };
    let joints = model.joints();
    let label = |row| {
        let RowLabel { name, unit, quantity, joint, .. } = all.label(row, &model);
        (name, unit, quantity, joint)
    };
    let (link, joint) = (&model.frames()[1].name, joints[0].name());
    let n = model.dof();
    assert_eq!(model.frames()[1].body, Some(0));
    let distance = format!("distance of link '{link}' from sphere 2");
    assert_eq!(label(2), (distance, "m", Quantity::Obstacles, None));
    let behind_a_pointer = format!("row 0 of {}", model.name());
    assert_eq!(label(3 * n), (behind_a_pointer, "rad", Quantity::Position, Some(0)));
    let speed = format!("upper velocity limit of joint '{joint}'");
    assert_eq!(label(3 * n + 1), (speed, "rad/s", Quantity::Velocity, Some(0)));
    let height = format!("distance of link '{link}' from half-space 0");
    assert_eq!(label(3 * n + 2), (height, "m", Quantity::Obstacles, None));
    let position = format!("lower position limit of joint '{joint}'");
    assert_eq!(label(4 * n + 2), (position, "rad", Quantity::Position, Some(0)));
    let last = joints[n - 1].name();
    let torque = format!("lower torque limit of joint '{last}'");
    assert_eq!(label(all.dim() - 1), (torque, "N m", Quantity::Torque, Some(n - 1)));
    let equalities: Vec<_> = (0..all.dim()).filter(|row| all.is_equality(*row)).collect();
    assert_eq!(equalities, [3 * n]);
    // A row beyond the last one is a number in the last part.
    let beyond = all.label(all.dim(), &model).name;
    assert_eq!(beyond, "row 0 of the constraint");
    // A list is a constraint, and so are pairs and references.
    let pair = (&all.state[2..3], (&all.state[1], ()));
    assert_eq!([n, n + 1, 0].map(|row| pair.row_set(row).is_equality), [true, false, false]);
}

#[test]
fn a_sliding_joint_has_metres_and_newtons() {
    let model = slider(1.0);
    let bounds = Bounds(vec![upper(0, 1.0), lower(1, -1.0), upper(2, 0.0)]);
    let expected = [
        ("upper position limit of joint 'slider'", "m"),
        ("lower velocity limit of joint 'slider'", "m/s"),
        ("row 2 of the constraint", ""),
    ];
    let expected = expected.map(|(name, unit)| (name.to_owned(), unit));
    let labels = (0..3).map(|row| bounds.label(row, &model));
    let labels: Vec<_> = labels.map(|label| (label.name, label.unit)).collect();
    assert_eq!(labels, expected);
    let limits = TorqueLimits(vec![Some(3.0)]);
    let label = limits.label(0, &model);
    assert_eq!(label.name, "upper force limit of joint 'slider'");
    assert_eq!(label.unit, "N");
    let passive = TorqueLimits(vec![Some(0.0)]).label(0, &model);
    assert_eq!(passive.name, "force of the passive joint 'slider'");
}

#[test]
fn a_passive_joint_is_one_row() {
    let limits = TorqueLimits(vec![Some(2.0), Some(0.0), None, Some(1.0)]);
    assert_eq!(limits.dim(), 5);
    let mut g = [0.0; 5];
    limits.value(&[3.0, -4.0, 9.0, 0.5], &mut g).expect("sizes agree");
    assert_eq!(g, [1.0, -5.0, -4.0, -0.5, -1.5]);
    let equal: Vec<_> = (0..6).filter(|row| limits.is_equality(*row)).collect();
    assert_eq!(equal, [2]);
    let model = slider(1.0);
    assert!(TorqueLimits(vec![Some(0.0)]).check(&model).is_ok());
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = TorqueLimits(vec![Some(bad)]).check(&model);
        assert_refused(refused, "joint 'slider': torque limit: it is");
    }
}

#[test]
fn what_is_wrong_is_refused() {
    let (model, curve) = (slider(1.0), at_rest(|_| 0.0));
    let bounds = of_state(Bounds(vec![upper(0, 1.0)]));
    let none = violations(&model, &curve, &bounds, 0);
    assert_refused(none, "violations: intervals: it is 0 and must be at least 1");
    let other = violations(&robot("kinova_gen3"), &curve, &bounds, 10);
    assert_refused(other, "curve: expected 7 entries, found 1");
    let limits = Constraints { state: (), torque: TorqueLimits(vec![Some(1.0); 2]), stage: Default::default() };
    let other = violations(&model, &curve, &limits, 10);
    assert_refused(other, "torque limits: expected 1 entries, found 2");
    let beyond = of_state(Bounds(vec![upper(2, 1.0)]));
    let beyond = violations(&model, &curve, &beyond, 10);
    assert_refused(beyond, "bounded numbers: expected 3 entries, found 2");
    // NaN counts as a violation.
    let found = first(&at_rest(|_| f64::NAN), &bounds, 10);
    assert_eq!(found.by, f64::INFINITY);
}
