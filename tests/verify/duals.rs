//! The public checker accepts correct derivatives, and reports wrong ones with their place and state.

mod general_flow;

use crate::common::{robot, robots, tree};
use aghf::flow::jacobian::{ControlFormJacobian, ForwardDual, JacobianKind, NodeBlocks, NodeJacobian};
use aghf::flow::{AghfLagrangian, AlgorithmB1, LagrangianFlow, Node};
use aghf::model::{JointKind, JointSpec, Limits, Model, random_tree};
use aghf::spatial::{Inertia, Placement};
use aghf::verify::duals::{
    BOUND, CheckOptions, Finding, MAX_BOUND, MAX_BOUND_MULTIPLIED, MAX_DIFFERENCE_BOUND, State, check_all,
    check_direct, check_jacobian,
};
use nalgebra::{Matrix3, Vector3};

fn options(samples: usize, seed: u64) -> CheckOptions {
    CheckOptions { samples, seed, ..CheckOptions::default() }
}

#[test]
fn everything_passes_on_every_robot() {
    let trees = (0..4).map(|seed| tree(6, seed));
    for model in robots().into_iter().chain(trees) {
        let findings = check_all(&model, &options(3, 5)).expect("a loaded model");
        let off: Vec<&Finding> = findings.iter().filter(|f| !f.passes()).collect();
        assert!(off.is_empty(), "{}: {off:?}", model.name());
        for (name, _) in JacobianKind::by_name() {
            assert!(findings.iter().any(|f| f.quantity.starts_with(name)), "{name} is not checked");
        }
        for what in [
            "spheres: weighted Hessian",
            "solids: weighted Hessian",
            "self-collision: weighted gradient",
            "self-collision: weighted Hessian",
            "bounds: weighted Hessian",
            "control_form with constraints: dOmega_P2/dxddot",
            "theorem_b4 with constraints: dOmega_P1/dx",
            "Omega on a curve, weak form: gradient of the effort",
            "weak form: L",
            "weak form: dL/dx_P2",
            "weak form: Hessian, rows of xdot_P2",
        ] {
            let finding = findings.iter().find(|f| f.quantity == what);
            assert!(finding.is_some(), "{what} is not checked");
        }
    }
}

/// The gradient of the effort is the flow in the weak form, for any penalty.
#[test]
fn the_direct_method_goes_where_the_flow_goes() {
    let trees = (0..4).map(|seed| tree(6, seed));
    for model in robots().into_iter().chain(trees) {
        let findings = check_direct(&model, &options(2, 5)).expect("a loaded model");
        assert_eq!(findings.len(), 3);
        for finding in findings {
            assert!(finding.passes(), "{}: {finding:?}", model.name());
        }
    }
}

/// Joints about y or z, in a chain or all on the base, each with the mass and the size of its body.
fn turning(axis: Vector3<f64>, chain: bool, bodies: &[(f64, f64)]) -> Model {
    let specs = bodies.iter().enumerate().map(|(i, (mass, size))| JointSpec {
        name: format!("joint_{i}"),
        kind: JointKind::Continuous,
        parent: i.checked_sub(1).filter(|_| chain),
        origin: Placement::new(Matrix3::identity(), Vector3::new(0.13 * i as f64, -0.22, 0.023)),
        axis,
        inertia: Inertia::from_com(
            *mass,
            Vector3::x() * if chain { *size } else { 0.0 },
            Matrix3::identity() * (mass * size * size),
        ),
        limits: Limits::NONE,
    });
    Model::from_joints("turning", specs.collect()).expect("there are joints")
}

/// Rounding passes where derivatives vanish, as for rotors about vertical axes, and where a heavy arm carries a light
/// finger, with a condition number of the mass matrix of 1e8.
#[test]
fn rounding_is_no_error() {
    let rotors = turning(Vector3::z(), false, &[(0.005, 0.07), (0.005, 0.07), (0.005, 0.07)]);
    let arm = turning(Vector3::y(), true, &[(20.0, 0.5), (5.0, 0.4), (0.1, 0.1), (0.01, 0.005)]);
    for model in [rotors, arm] {
        let findings = check_all(&model, &options(5, 3)).expect("a loaded model");
        let off: Vec<&Finding> = findings.iter().filter(|f| !f.passes()).collect();
        assert!(off.is_empty(), "{off:?}");
        // A bound that is too large would accept every error.
        for finding in findings {
            let largest = match finding.quantity.as_str() {
                q if q.starts_with("difference") => MAX_DIFFERENCE_BOUND,
                q if q.starts_with("Omega on a curve") => MAX_BOUND_MULTIPLIED,
                _ => MAX_BOUND,
            };
            assert!(finding.bound <= largest, "{finding:?}");
        }
    }
}

/// Two ball joints in a chain, each of three hinges through one point with a body on the last: the mass matrix is
/// singular wherever the first and the third hinge of a ball joint are parallel, and a curve of a few radians meets
/// such a configuration.
#[test]
fn a_curve_across_a_singular_mass_matrix_is_no_error() {
    let specs = (0..6_usize).map(|i| {
        let mass = if i % 3 == 2 { 1.0 } else { 0.0 };
        JointSpec {
            name: format!("hinge_{i}"),
            kind: JointKind::Continuous,
            parent: i.checked_sub(1),
            origin: Placement::new(Matrix3::identity(), Vector3::x() * if i == 3 { 0.4 } else { 0.0 }),
            axis: if i % 3 == 1 { Vector3::y() } else { Vector3::z() },
            inertia: Inertia::from_com(
                mass,
                Vector3::new(0.1, 0.2, -0.1),
                Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.25)) * mass,
            ),
            limits: Limits::NONE,
        }
    });
    let model = Model::from_joints("two ball joints", specs.collect()).expect("there are joints");
    for finding in check_direct(&model, &options(20, 1)).expect("a loaded model") {
        assert!(finding.passes(), "{finding:?}");
        // Allowed near such a configuration, but still small enough to detect errors.
        assert!(finding.bound <= 1e-6, "{finding:?}");
    }
}

/// A Jacobian with one wrong entry in one block.
struct OneWrong<'m> {
    right: ControlFormJacobian<'m, f64, f64>,
    entry: (usize, usize),
    by: f64,
}

impl NodeJacobian for OneWrong<'_> {
    fn evaluate(&mut self, node: Node<'_, f64>, k: f64, out: &mut NodeBlocks) -> aghf::Result<()> {
        self.right.evaluate(node, k, out)?;
        out.dx[self.entry] += self.by;
        Ok(())
    }
}

#[test]
fn a_wrong_entry_is_found() {
    let model = robot("kinova_gen3");
    // In the rows with 1 / k, where it is small beside the others, and a NaN anywhere.
    for (entry, by, block) in [((2, 5), 1e-12, "P1/dx"), ((9, 3), f64::NAN, "P2/dx"), ((0, 0), f64::INFINITY, "P1/dx")]
    {
        let mut wrong = OneWrong { right: ControlFormJacobian::new(&model), entry, by };
        let options = CheckOptions { penalties: vec![1e9], ..options(2, 1) };
        let findings = check_jacobian(&model, "wrong", &mut wrong, &options).expect("same robot");
        assert_eq!(findings.iter().filter(|f| !f.passes()).count(), 1);
        for finding in &findings {
            let hit = finding.quantity == format!("wrong: dOmega_{block}");
            assert_eq!(finding.passes(), !hit, "{finding:?}");
            if hit {
                let row = if entry.0 < 7 { entry.0 } else { entry.0 - 7 };
                assert_eq!(finding.entry, (row, entry.1));
                assert_eq!(finding.state, State::random(&model, 1, finding.sample));
            }
        }
    }
}

#[test]
fn states_are_reproducible_and_within_limits() {
    let model = robot("digit_v3_pinned");
    let state = State::random(&model, 3, 4);
    assert_eq!(state, State::random(&model, 3, 4));
    assert_ne!(state, State::random(&model, 3, 5));
    assert_ne!(state, State::random(&model, 4, 4));
    // Numbers that vanish or coincide hide terms and swapped arguments.
    let mut all = [&state.x[..], &state.xdot, &state.xddot, &[state.t]].concat();
    let count = all.len();
    all.sort_by(f64::total_cmp);
    all.dedup();
    assert!(all.len() == count && !all.contains(&0.0));
    for sample in 0..50 {
        let state = State::random(&model, 1, sample);
        for (q, joint) in state.x.iter().zip(model.joints()) {
            let limits = joint.limits();
            assert!((limits.lower..=limits.upper).contains(q), "{} at {q}", joint.name());
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_findings() {
    let model = robot("pendulum_3");
    let run = |seed| check_all(&model, &options(4, seed)).expect("a loaded model");
    assert_eq!(run(9), run(9));
    assert_ne!(run(9), run(10));
}

/// The flow of a Lagrangian by its definition is that of Theorem B3, and so is its Jacobian, by third derivatives.
#[test]
fn the_definition_gives_the_same_flow() {
    fn jacobian_of(model: &Model, k: f64, state: &State) -> [NodeBlocks; 2] {
        let n = model.dof();
        let (mut one, mut two) = (NodeBlocks::new(n), NodeBlocks::new(n));
        let mut definition = ForwardDual::of(LagrangianFlow::new(model, AghfLagrangian), n);
        definition.evaluate(state.node(), k, &mut one).expect("same robot");
        ForwardDual::of(AlgorithmB1::new(model), n).evaluate(state.node(), k, &mut two).expect("same robot");
        [one, two]
    }
    for model in [robot("pendulum_3"), robot("kinova_gen3"), random_tree(5, 1).expect("five joints")] {
        for k in [1.0, 1e6] {
            let [a, b] = jacobian_of(&model, k, &State::random(&model, 2, 0));
            assert_close!(&a.dx, &b.dx, 10.0 * BOUND);
            assert_close!(&a.dxdot, &b.dxdot, 10.0 * BOUND);
            assert_close!(&a.dxddot, &b.dxddot, 100.0 * BOUND);
        }
    }
}
