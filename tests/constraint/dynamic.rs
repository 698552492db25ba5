//! Constraints behind pointers.

use crate::common::constraint::Slow;
use crate::common::direct::solved_within;
use crate::common::scenario::Scenario;
use aghf::constraint::{
    AnyConstraint, Bounds, CollisionSphere, Constraint, Constraints, DynConstraint, Evaluator, Sphere, SphereClearance,
    TorqueLimits, Weights,
};
use aghf::direct::DirectSettings;
use aghf::flow::jacobian::JacobianKind;
use aghf::flow::{Flow, FlowSettings, Penalised, Penalty, PenaltyWeights};
use aghf::model::{Model, random_tree};
use nalgebra::Vector3;
use num_dual::HyperDual64;

fn spheres(model: &Model) -> SphereClearance {
    SphereClearance {
        balls: CollisionSphere::joint_frames(model),
        spheres: vec![Sphere { centre: Vector3::new(0.4, 0.1, -0.7), radius: 0.3 }],
    }
}

fn wave(count: usize, f: f64) -> Vec<f64> {
    (0..count).map(|i| (f * (i as f64 + 1.0)).sin()).collect()
}

/// Value, row scales, gradient and Hessian.
fn everything(model: &Model, constraint: &impl Constraint, x: &[f64]) -> Vec<f64> {
    let rows = constraint.dim();
    let (w, c) = (wave(rows, 0.7), wave(rows, 1.9));
    let mut g = vec![0.0; rows];
    let mut evaluator = Evaluator::new(model);
    let mut here = evaluator.at(x).expect("lengths agree");
    here.value(constraint, &mut g).expect("same robot");
    let weights = Weights { first_order: &w, gauss_newton: Some(&c) };
    let sums = here.weighted_derivatives(constraint, weights);
    let sums = sums.expect("same robot");
    g.extend(constraint.row_scales());
    g.extend(sums.gradient());
    g.extend(sums.hessian());
    g
}

/// Boxed constraints, and lists of them, have the same rows and derivatives as unboxed ones, to the last bit; an
/// unsupported scalar is an error that names it.
#[test]
fn a_boxed_constraint_is_the_same() {
    let model = random_tree(4, 3).expect("there are joints");
    let bounds = Bounds(vec![]);
    let x = wave(2 * model.dof(), 0.9);
    let bare = (spheres(&model), (Slow(0.5), bounds.clone()));
    let boxed: Vec<Box<dyn DynConstraint>> = vec![Box::new(spheres(&model)), Box::new(Slow(0.5)), Box::new(bounds)];
    let listed = vec![AnyConstraint::Spheres(spheres(&model)), AnyConstraint::Other(Box::new(Slow(0.5)))];
    let truth = everything(&model, &bare, &x);
    assert!(truth.iter().filter(|x| **x != 0.0).count() > 20);
    assert_eq!(everything(&model, &boxed, &x), truth);
    assert_eq!(everything(&model, &boxed.clone(), &x), truth);
    assert_eq!(everything(&model, &listed, &x), truth);

    let moving: Vec<_> = x.iter().map(|x| HyperDual64::from(*x)).collect();
    let mut evaluator = Evaluator::new(&model);
    let here = evaluator.at(&moving).expect("lengths agree");
    let mut g = vec![HyperDual64::from(0.0); bare.dim()];
    here.value(&bare, &mut g).expect("without a pointer");
    let error = here.value(&boxed, &mut g).expect_err("not among them");
    assert!(error.to_string().contains("HyperDual"), "{error}");
    assert!(error.to_string().contains("Lanes<f64, 4>"), "{error}");
}

fn penalised<K>(state: K, weights: PenaltyWeights) -> Penalised<K> {
    let torque = TorqueLimits(vec![]);
    let constraints = Constraints { state, torque, stage: Default::default() };
    Penalised { constraints, weights }
}

/// The flow, with every Jacobian, and the direct method give the same results for boxed constraints as for unboxed
/// ones.
#[test]
fn flow_and_direct_take_boxed_constraints() {
    let scenario = Scenario::load("pendulum_1_swingup");
    let problem = scenario.problem();
    let penalty = Penalty { k_cons: 1e3, c_cons: 50.0 };
    let weights = PenaltyWeights { state: penalty, torque: penalty };
    let none = || TorqueLimits(vec![]);
    let list = |limit| vec![Box::new(Slow(limit)) as Box<dyn DynConstraint>];
    let curve = |settings: &FlowSettings, boxed: bool| {
        let flow = Flow::new(&problem, settings.clone());
        let solution = if boxed {
            flow.constraints(&penalised(list(9.0), weights)).run()
        } else {
            flow.constraints(&penalised(Slow(9.0), weights)).run()
        };
        let solution = solution.expect("sound");
        assert_eq!(solution.failure, None);
        solution.curve
    };
    for (name, kind) in JacobianKind::by_name() {
        let settings = FlowSettings { jacobian: kind, ..FlowSettings::new(9, 1e3, 1.0) };
        assert_eq!(curve(&settings, true).x(), curve(&settings, false).x(), "{name}");
    }
    let settings = DirectSettings { degree: 8, starts: 1, ..DirectSettings::constrained() };
    let boxed = Constraints { state: list(30.0), torque: none(), stage: Default::default() };
    let bare = Constraints { state: Slow(30.0), torque: none(), stage: Default::default() };
    let boxed = solved_within(&problem, &settings, &boxed);
    let bare = solved_within(&problem, &settings, &bare);
    assert_eq!(boxed.curve.x(), bare.curve.x());
}
