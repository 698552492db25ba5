//! The dynamics and the right-hand side of the flow do not allocate once their workspace exists.

use crate::common::robot;
use aghf::constraint::{
    Bounds, CollisionSphere, Constraint, Constraints, Evaluator, Sphere, SphereClearance, TorqueLimits, Weights,
};
use aghf::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, aba, aba_derivatives, bias, crba, frame_jacobian,
    mass_matrix_and_rate, rnea, rnea_derivatives,
};
use aghf::flow::jacobian::{JacobianKind, NodeBlocks};
use aghf::flow::{AlgorithmB1, ControlForm, Node, Penalised, Penalty, PenaltyWeights, RightHandSide};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Tanh};
use nalgebra::{DMatrix, Vector3};
use num_dual::DualSVec64;

/// The number of allocations of `work`.
fn allocations(work: impl FnOnce() -> aghf::Result<()>) -> u64 {
    let mut result = Ok(());
    let count = allocation_counter::measure(|| result = work()).count_total;
    result.expect("lengths agree");
    count
}

/// Asserts that `work` does not allocate.
fn assert_none(name: &str, work: impl FnOnce() -> aghf::Result<()>) {
    assert_eq!(allocations(work), 0, "{name}");
}

fn wave<S: AlgebraOver<f64>>(m: usize) -> Vec<S> {
    (0..m).map(|i| S::from_f64((0.7 * i as f64).sin())).collect()
}

fn nothing_is_allocated<S: AlgebraOver<f64> + Tanh>() {
    let model = robot("digit_v3_pinned");
    by_the_dynamics::<S>(&model);
    by_the_flow::<S>(&model);
}

fn by_the_dynamics<S: AlgebraOver<f64> + Tanh>(model: &Model) {
    let n = model.dof();
    let (q, v, a, mut tau) = (wave::<S>(n), wave(n), wave(n), wave(n));
    let (mut h, mut hdot) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let mut id = InverseDynamicsDerivatives::new(n);
    let mut fd = ForwardDynamicsDerivatives::new(n);
    let (tip, mut jacobian) = (&model.frames()[model.frames().len() - 1], DMatrix::zeros(6, n));
    let data = &mut Data::new(model);
    assert_none("rnea", || rnea(model, data, &q, &v, &a, &mut tau));
    assert_none("bias", || bias(model, data, &q, &v, &mut tau));
    assert_none("aba", || aba(model, data, &q, &v, &a, &mut tau));
    assert_none("crba", || crba(model, data, &q, &mut h));
    assert_none("mass_matrix_and_rate", || mass_matrix_and_rate(model, data, &q, &v, &mut h, &mut hdot));
    assert_none("frame_jacobian", || frame_jacobian(model, data, &q, tip, &mut jacobian));
    assert_none("rnea_derivatives", || rnea_derivatives(model, data, &q, &v, &a, &mut id));
    assert_none("aba_derivatives", || aba_derivatives(model, data, &q, &v, &a, &mut fd));
}

fn by_the_flow<S: AlgebraOver<f64> + Tanh>(model: &Model) {
    let n = 2 * model.dof();
    let (x, xdot, xddot, mut omega) = (wave::<S>(n), wave(n), wave(n), wave(n));
    let node = Node { t: S::from_f64(0.0), x: &x, xdot: &xdot, xddot: &xddot };
    let mut control = ControlForm::new(model);
    assert_none("control form", || control.omega(node, 3.0, &mut omega));
    let mut b1 = AlgorithmB1::new(model);
    assert_none("Algorithm B1", || b1.omega(node, 3.0, &mut omega));

    let balls = CollisionSphere::joint_frames(model);
    let spheres = vec![Sphere { centre: Vector3::zeros(), radius: 0.5 }];
    let penalty = Penalty { k_cons: 3.0, c_cons: 2.0 };
    let constraints = Penalised {
        constraints: Constraints {
            state: (SphereClearance { balls, spheres }, Bounds::positions(model)),
            torque: TorqueLimits::of(model),
            stage: Default::default(),
        },
        weights: PenaltyWeights { state: penalty, torque: penalty },
    };
    let mut constrained = constraints.right_hand_side(model);
    constrained.omega(node, 3.0, &mut omega).expect("lengths agree");
    assert_none("constrained flow", || constrained.omega(node, 3.0, &mut omega));
    by_constraints(model, &constraints.constraints.state, &x);
}

fn by_constraints<S: AlgebraOver<f64> + Tanh>(model: &Model, state: &impl Constraint, x: &[S]) {
    let rows = state.dim();
    let (mut g, mut evaluator) = (wave(rows), Evaluator::new(model));
    let (w, c) = (wave(rows), wave(rows));
    let weights = Weights { first_order: &w, gauss_newton: Some(&c) };
    assert_none("constraints", || {
        let mut here = evaluator.at(x)?;
        here.value(state, &mut g)?;
        here.weighted_derivatives(state, weights)?;
        Ok(())
    });
}

/// The Jacobians of the flow, except that of Theorem B4, which is documented to allocate. The control form has five
/// products of large matrices, each of which `nalgebra` packs into its own buffer.
#[test]
fn jacobians_allocate_nothing_of_their_own() {
    let model = robot("digit_v3_pinned");
    let n = model.dof();
    let [x, xdot, xddot] = [0.7, 1.3, 2.1].map(|f| crate::common::wave(2 * n, f));
    let node = Node { t: 0.0, x: &x, xdot: &xdot, xddot: &xddot };
    let mut out = NodeBlocks::new(n);
    for (kind, packed) in [(JacobianKind::ControlForm, 5), (JacobianKind::Dual, 0), (JacobianKind::Difference, 0)] {
        let mut jacobian = kind.build(&model);
        let made = allocations(|| jacobian.evaluate(node, 3.0, &mut out));
        assert_eq!(made, packed, "{kind:?}");
    }
}

#[test]
fn nothing_is_allocated_over_f64() {
    nothing_is_allocated::<f64>();
}

#[test]
fn nothing_is_allocated_over_duals() {
    nothing_is_allocated::<DualSVec64<8>>();
}

/// The counter counts allocations.
#[test]
fn an_allocation_shows() {
    let made = allocations(|| {
        std::hint::black_box(vec![0.0; 10]);
        Ok(())
    });
    assert_eq!(made, 1);
}
