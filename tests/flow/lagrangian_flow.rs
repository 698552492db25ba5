//! The flow beyond the paper's: weights, dual trajectories, costs in time, metrics and drifts.

use crate::common::{assert_refused, node, robot, robots, wave};
use aghf::constraint::{Bounds, Constraints, TorqueLimits};
use aghf::curve::Chebyshev;
use aghf::flow::jacobian::{CentralDifference, ControlFormJacobian, ForwardDual, NodeBlocks, NodeJacobian};
use aghf::flow::{
    ActuationMetric, ActuationWeights, AffineLagrangian, Collocation, ControlCost, ControlDual, ControlForm,
    ControlLagrangian, DualTrajectory, FreeDynamics, Lagrangian, LagrangianFlow, Metric, Node, Penalised, Penalty,
    PenaltyWeights, RightHandSide, StateCost, StateCostTerm, Sum, WithStateCost,
};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Tanh};
use nalgebra::{DMatrix, DVector};

fn parts(n: usize) -> [Vec<f64>; 3] {
    [0.7, 1.3, 2.1].map(|f| wave(2 * n, f))
}

fn omega_of(mut rhs: impl RightHandSide<f64, f64>, node: Node<'_, f64>) -> Vec<f64> {
    let mut omega = vec![0.0; node.x.len()];
    rhs.omega(node, 3.0, &mut omega).expect("lengths agree");
    omega
}

fn blocks_of(mut jacobian: impl NodeJacobian, node: Node<'_, f64>) -> NodeBlocks {
    let mut blocks = NodeBlocks::new(node.x.len() / 2);
    jacobian.evaluate(node, 3.0, &mut blocks).expect("lengths agree");
    blocks
}

fn weights(of: &[f64]) -> ActuationWeights {
    ActuationWeights::diagonal(of.to_vec()).expect("none is zero")
}

/// A cost that vanishes but does not report it.
#[derive(Clone)]
struct Nothing;

impl ControlCost for Nothing {
    fn value<S: AlgebraOver<f64> + Tanh>(&self, _: S, _: usize, _: S) -> S {
        S::zero()
    }
}

/// Unit weights, zero trajectories and a zero cost give the bits of the paper's flow, though not by its shorter path.
#[test]
fn the_paper_is_a_special_case_bit_for_bit() {
    for model in robots() {
        let n = model.dof();
        let parts = parts(n);
        let still = DualTrajectory::new(2.0, DMatrix::zeros(n, 4)).expect("it has columns");
        let spelt_out = ControlLagrangian { weights: weights(&vec![1.0; n]), slip_dual: Some(still.clone()), cost: () };
        let paper = omega_of(ControlForm::new(&model), node(&parts));
        let ours = omega_of(ControlForm::of(&model, spelt_out.clone()), node(&parts));
        assert_eq!(ours, paper);
        let of_paper = blocks_of(ControlFormJacobian::new(&model), node(&parts));
        let ours = ControlFormJacobian::of(&model, spelt_out.clone());
        assert_eq!(blocks_of(ours, node(&parts)), of_paper);

        let dual = ControlDual(still);
        assert!(dual.is_zero());
        let with_dual = ControlForm::with_cost(&model, dual);
        assert_eq!(omega_of(with_dual, node(&parts)), paper);
        // With a cost, the factor of xddot is multiplied explicitly.
        let with_cost = omega_of(ControlForm::with_cost(&model, Nothing), node(&parts));
        assert_eq!(with_cost, paper);
    }
}

/// A cost that grows with time.
struct Late;

impl ControlCost for Late {
    fn value<S: AlgebraOver<f64> + Tanh>(&self, t: S, _: usize, u: S) -> S {
        t * t * u * u * u
    }
}

/// A Lagrangian of two joints with a weight, a dual trajectory and a cost in time.
fn in_time() -> ControlLagrangian<f64, &'static Late> {
    let columns = DMatrix::from_fn(2, 3, |i, j| (i + 2 * j) as f64 + 0.5);
    ControlLagrangian {
        weights: weights(&[1.0, 30.0]),
        slip_dual: Some(DualTrajectory::new(2.0, columns).expect("it has columns")),
        cost: &Late,
    }
}

/// By central differences of a right-hand side at some time, independent of dual numbers.
#[test]
fn time_is_held_fixed_in_the_jacobian() {
    let (model, parts) = (robot("pendulum_2"), parts(2));
    let at = Node { t: 1.3, ..node(&parts) };
    let right = CentralDifference::of(ControlForm::of(&model, in_time()), 2);
    let by_duals = ForwardDual::of(ControlForm::of(&model, in_time()), 2);
    let ours = blocks_of(ControlFormJacobian::of(&model, in_time()), at);
    let (right, by_duals) = (blocks_of(right, at), blocks_of(by_duals, at));
    for (ours, by_duals, right) in [
        (&ours.dx, &by_duals.dx, &right.dx),
        (&ours.dxdot, &by_duals.dxdot, &right.dxdot),
        (&ours.dxddot, &by_duals.dxddot, &right.dxddot),
    ] {
        assert_close!(ours, by_duals, 1e-11);
        assert_close!(ours, right, 1e-7);
    }
}

/// By the definition, and by the rate of $\partial L / \partial \dot x$ along a parabola of states through the node,
/// with differences in time.
#[test]
fn time_moves_in_the_flow() {
    let (model, parts, lagrangian) = (robot("pendulum_2"), parts(2), in_time());
    let at = Node { t: 1.3, ..node(&parts) };
    let metric = lagrangian.metric();
    let by_definition = LagrangianFlow::in_metric(&model, &lagrangian, &metric);
    let of_control = omega_of(ControlForm::of(&model, lagrangian.clone()), at);
    assert_close!(&omega_of(by_definition, at), &of_control, 1e-12);
    let step = 1e-4;
    let value = |t: f64, x: &[f64], xdot: &[f64]| lagrangian.value(&model, 1.3 + t, x, xdot, 3.0).expect("fits");
    let momentum = |t: f64, i: usize| {
        let moved = |x: &[f64], rate: &[f64], second: &[f64]| -> Vec<f64> {
            let terms = x.iter().zip(rate).zip(second);
            terms.map(|((x, v), a)| x + t * v + 0.5 * t * t * a).collect()
        };
        let x = moved(&parts[0], &parts[1], &parts[2]);
        let mut xdot = moved(&parts[1], &parts[2], &[0.0; 4]);
        xdot[i] += step;
        let above = value(t, &x, &xdot);
        xdot[i] -= 2.0 * step;
        (above - value(t, &x, &xdot)) / (2.0 * step)
    };
    let gradient = |i: usize| {
        let value = |by: f64| {
            let mut x = parts[0].clone();
            x[i] += by;
            value(0.0, &x, &parts[1])
        };
        (value(step) - value(-step)) / (2.0 * step)
    };
    let expression = (0..4).map(|i| {
        let rate = (momentum(step, i) - momentum(-step, i)) / (2.0 * step);
        rate - gradient(i)
    });
    let mut omega: Vec<f64> = expression.collect();
    metric.raise(&model, 1.3, &parts[0], 3.0, &mut omega).expect("fits");
    assert_close!(&of_control, &omega, 1e-4);
}

/// The affine Lagrangian of the free dynamics in the weighted metric is the weighted effort, and has the same flow.
#[test]
fn the_affine_lagrangian_of_the_free_dynamics_is_the_effort() {
    let model = robot("pendulum_3");
    let parts = parts(3);
    for of in [[1.0, 1.0, 1.0], [1.0, 0.5, 30.0]] {
        let control: ControlLagrangian = ControlLagrangian { weights: weights(&of), ..ControlLagrangian::default() };
        let affine = AffineLagrangian { drift: FreeDynamics, metric: control.metric() };
        let value = |l: &dyn Fn() -> aghf::Result<f64>| l().expect("fits");
        let [x, xdot, _] = &parts;
        let of_affine = value(&|| affine.value(&model, 0.0, x, xdot, 3.0));
        let of_control = value(&|| control.value(&model, 0.0, x, xdot, 3.0));
        assert_close!(&[of_affine], &[of_control], 1e-12);
        let ours = LagrangianFlow::in_metric(&model, &affine, control.metric());
        let right = omega_of(ControlForm::of(&model, control.clone()), node(&parts));
        assert_close!(&omega_of(ours, node(&parts)), &right, 1e-9);
    }
}

/// A state cost, and constraints as penalties, in the weighted metric, against the definition and against dual numbers.
#[test]
fn terms_of_the_state_in_the_metric_with_weights() {
    struct Place;
    impl StateCost for Place {
        fn value<S: AlgebraOver<f64> + Tanh>(&self, _: &Model, t: S, x: &[S]) -> aghf::Result<S> {
            let shifted = x.iter().map(|x| *x + t);
            Ok(shifted.fold(S::zero(), |sum, x| sum + x * x * x))
        }
    }
    let model = robot("pendulum_2");
    let parts = parts(2);
    let at = Node { t: 0.8, ..node(&parts) };
    let control: ControlLagrangian =
        ControlLagrangian { weights: weights(&[1.0, 30.0]), ..ControlLagrangian::default() };
    let whole = WithStateCost { lagrangian: &control, cost: Place };
    let definition = LagrangianFlow::in_metric(&model, &whole, control.metric());
    let term = || StateCostTerm::new(&model, control.weights.clone(), Place);
    let sum = Sum::new(ControlForm::of(&model, control.clone()), term());
    assert_close!(&omega_of(sum, at), &omega_of(definition, at), 1e-11);
    let by_duals = ForwardDual::of(StateCostTerm::new(&model, control.weights.clone(), Place), 2);
    assert_close!(&blocks_of(term(), at).dx, &blocks_of(by_duals, at).dx, 1e-11);

    let penalty = Penalty { k_cons: 3.0, c_cons: 0.7 };
    let constraints = Penalised {
        constraints: Constraints {
            state: Bounds::positions(&model),
            torque: TorqueLimits(vec![Some(0.5), None]),
            stage: Default::default(),
        },
        weights: PenaltyWeights { state: penalty, torque: penalty },
    };
    let ours = blocks_of(constraints.jacobian_of(&model, control.clone()), at);
    let flow = constraints.right_hand_side_of(&model, control.clone());
    let by_duals = blocks_of(ForwardDual::of(flow, 2), at);
    assert_close!(&ours.dx, &by_duals.dx, 1e-11);
    assert_close!(&ours.dxdot, &by_duals.dxdot, 1e-11);
    assert_close!(&ours.dxddot, &by_duals.dxddot, 1e-11);
}

#[test]
fn a_node_of_a_collocation_knows_its_time() {
    let chebyshev = Chebyshev::new(6, 2.5).expect("a degree");
    let collocation = Collocation::<f64, f64>::new(&chebyshev, &[0.0; 4], &[1.0; 4]).expect("as long");
    let times: Vec<f64> = (0..=6).map(|i| collocation.node(i).t).collect();
    assert_eq!(times, chebyshev.times());
}

#[test]
fn what_does_not_fit_is_refused() {
    let zero = ActuationWeights::diagonal(vec![1.0, 0.0]);
    assert_refused(zero, "weights: weight of joint 1: it is zero, the metric would be singular");
    let lambda = DualTrajectory::new(1.0, DMatrix::zeros(2, 1)).expect("a column");
    let model = robot("pendulum_3");
    let parts = parts(3);
    let refused = |lagrangian: ControlLagrangian, words: &str| {
        let mut omega = [0.0; 6];
        let flow = ControlForm::of(&model, lagrangian.clone()).omega(node(&parts), 1.0, &mut omega);
        assert_refused(flow, words);
        let mut jacobian = ControlFormJacobian::of(&model, lagrangian.clone());
        let jacobian = jacobian.evaluate(node(&parts), 1.0, &mut NodeBlocks::new(3));
        assert_refused(jacobian, words);
        let value = lagrangian.value(&model, 0.0, &parts[0], &parts[1], 1.0);
        assert_refused(value, words);
    };
    let two_weights = ControlLagrangian { weights: weights(&[1.0, 2.0]), ..ControlLagrangian::default() };
    refused(two_weights, "weights: expected 3 entries, found 2");
    let two_components = ControlLagrangian { slip_dual: Some(lambda), ..ControlLagrangian::default() };
    let words = "components of the dual of the slip: expected 3 entries, found 2";
    refused(two_components, words);
    let metric = ActuationMetric { weights: weights(&[1.0; 2]) };
    let matrix = metric.matrix(&model, 0.0, &parts[0], 1.0);
    assert_refused(matrix, "weights: expected 3 entries, found 2");
}

/// A user-defined metric needs only its matrix.
#[test]
fn a_metric_by_its_matrix_is_inverted() {
    struct Mass;
    impl Metric for Mass {
        fn matrix<S: AlgebraOver<f64> + Tanh>(&self, model: &Model, t: S, x: &[S], k: f64) -> aghf::Result<DMatrix<S>> {
            let g = ActuationMetric::default().matrix(model, t, x, k)?;
            let n = g.nrows();
            Ok(g * (S::one() + t) + DMatrix::identity(n, n))
        }
    }
    let model = robot("pendulum_2");
    let (x, force) = (wave(4, 0.7), wave(4, 1.3));
    let mut raised = force.clone();
    Mass.raise(&model, 0.5, &x, 3.0, &mut raised).expect("fits");
    let g = Mass.matrix(&model, 0.5, &x, 3.0).expect("fits");
    assert_close!(&(g * DVector::from_vec(raised)), &force, 1e-12);
    let short = Mass.raise(&model, 0.5, &x, 3.0, &mut [0.0; 3]);
    assert_refused(short, "force: expected 4 entries, found 3");
}
