//! The constrained flow (A4): its right-hand side against the definition, its Jacobians against duals of it.

use crate::common::{assert_refused, config, model_and_node, node, robot, solve_bound, wave};
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, Constraints, Evaluator, Side, SolidClearance, Sphere,
    SphereClearance, TorqueLimits,
};
use aghf::dynamics::{Data, rnea};
use aghf::flow::jacobian::{JacobianKind, NodeBlocks, NodeJacobian};
use aghf::flow::{
    AghfLagrangian, AlgorithmB1, ControlCost, ControlForm, Lagrangian, LagrangianFlow, Penalised, Penalty,
    PenaltyWeights, RightHandSide, Sum, TorquePenalty, constrained_lagrangian, penalty,
};
use aghf::geometry::Solid;
use aghf::model::{Model, random_tree};
use aghf::scalar::{AlgebraOver, Tanh};
use nalgebra::Vector3;
use proptest::prelude::*;

/// Several spheres, a slanted floor, bounds on both halves of the state, and limits on most torques, so close that
/// about half of the rows are violated, with penalties of the size of the effort so that no term is negligible.
fn penalised(model: &Model, parts: &[Vec<f64>; 3]) -> Penalised<(Vec<AnyConstraint>, Bounds)> {
    let n = model.dof();
    let mut balls = CollisionSphere::joint_frames(model);
    balls.push(CollisionSphere { body: Some(n - 1), centre: Vector3::new(0.3, -0.2, 0.1), radius: 0.2 });
    let spheres = [(0.3, 0.2, -0.4, 0.9), (-0.5, 0.1, 0.3, 0.7)]
        .map(|(x, y, z, radius)| Sphere { centre: Vector3::new(x, y, z), radius });
    let state = vec![
        AnyConstraint::Spheres(SphereClearance { balls: balls.clone(), spheres: spheres.to_vec() }),
        AnyConstraint::Solids(SolidClearance {
            balls,
            solids: vec![Solid::half_space(&Vector3::new(2.0, -1.0, 2.0), 0.1)],
            names: Vec::new(),
        }),
    ];
    let near = |entry, side| Bound { entry, side, value: parts[0][entry] + 0.1 };
    let bounds = Bounds(vec![
        near(0, Side::Upper),
        near(n - 1, Side::Lower),
        near(n, Side::Lower),
        near(2 * n - 1, Side::Upper),
    ]);
    let (mut u, at) = (vec![0.0; n], node(parts));
    let (q, v, a) = (at.x_p1(), at.x_p2(), at.xdot_p2());
    rnea(model, &mut Data::new(model), q, v, a, &mut u).expect("lengths agree");
    let limit = |(i, u): (usize, &f64)| (i % 3 != 1).then(|| (u.abs() - 0.3 + 0.2 * i as f64).max(0.1));
    Penalised {
        constraints: Constraints {
            state: (state, bounds),
            torque: TorqueLimits(u.iter().enumerate().map(limit).collect()),
            stage: Default::default(),
        },
        weights: PenaltyWeights {
            state: Penalty { k_cons: 20.0, c_cons: 1.5 },
            torque: Penalty { k_cons: 3.0, c_cons: 0.7 },
        },
    }
}

/// $L_{cons}$ of (A1), with the rows of the torque written out.
impl<K: Constraint> Lagrangian for Wrapped<'_, K> {
    fn value<S: AlgebraOver<f64> + Tanh>(&self, model: &Model, t: S, x: &[S], xdot: &[S], k: f64) -> aghf::Result<S> {
        let all = self.0;
        let n = model.dof();
        let mut evaluator = Evaluator::new(model);
        let mut g = vec![S::zero(); all.constraints.state.dim()];
        evaluator.at(x)?.value(&all.constraints.state, &mut g)?;
        let mut u = vec![S::zero(); n];
        rnea(model, &mut Data::new(model), &x[..n], &x[n..], &xdot[n..], &mut u)?;
        let mut torque = vec![S::zero(); all.constraints.torque.dim()];
        all.constraints.torque.value(&u, &mut torque)?;
        let effort = AghfLagrangian.value(model, t, x, xdot, k)?;
        let Penalty { k_cons, c_cons } = all.weights.state;
        let of_state = constrained_lagrangian(effort, g, k_cons, c_cons);
        let Penalty { k_cons, c_cons } = all.weights.torque;
        Ok(constrained_lagrangian(of_state, torque, k_cons, c_cons))
    }
}

struct Wrapped<'a, K>(&'a Penalised<K>);

/// Asserts that both halves of the rows agree, each relative to its own largest entry.
fn assert_halves(what: &str, a: &[f64], b: &[f64], rows: usize, bound: f64) {
    for half in 0..2 {
        let of = |x: &[f64]| -> Vec<f64> {
            let own = |(i, _): &(usize, &f64)| (i % rows) / (rows / 2) == half;
            x.iter().enumerate().filter(own).map(|(_, x)| *x).collect()
        };
        let (a, b) = (of(a), of(b));
        let size = b.iter().fold(f64::MIN_POSITIVE, |m, b| m.max(b.abs()));
        let error = a.iter().zip(&b).fold(0.0_f64, |m, (a, b)| {
            let d = (a - b).abs();
            if d <= m { m } else { d }
        });
        assert!(error <= bound * size, "{what}, half {half}: off by {error:e} of {size:e}, bound {bound:e}");
    }
}

/// The Jacobian at a node.
fn blocks(jacobian: &mut dyn NodeJacobian, parts: &[Vec<f64>; 3], k: f64) -> NodeBlocks {
    let mut out = NodeBlocks::new(parts[0].len() / 2);
    jacobian.evaluate(node(parts), k, &mut out).expect("lengths agree");
    out
}

fn check_everything(model: &Model, parts: &[Vec<f64>; 3]) {
    let m = 2 * model.dof();
    let constraints = &penalised(model, parts);
    // Rounding errors, as for the flow without constraints.
    let bound = solve_bound(model, &parts[0], 1e-10);
    for k in [1.0, 1e7] {
        let omega = |rhs: &mut dyn RightHandSide<f64, f64>| {
            let mut omega = vec![0.0; m];
            rhs.omega(node(parts), k, &mut omega).expect("lengths agree");
            omega
        };
        let truth = omega(&mut LagrangianFlow::new(model, &Wrapped(constraints)));
        let ours = omega(&mut constraints.right_hand_side(model));
        assert_halves("Omega", &ours, &truth, m, bound);
        // The same terms added to Theorem B4.
        let of_torque = ControlForm::of_cost(model, constraints.torque_penalty());
        let terms = Sum::new(of_torque, constraints.state_penalty(model));
        let b1 = omega(&mut Sum::new(AlgorithmB1::new(model), terms));
        assert_halves("Omega by Algorithm B1", &b1, &truth, m, 10.0 * bound);

        let build = |kind: JacobianKind| kind.build_constrained(model, constraints);
        let duals = blocks(&mut *build(JacobianKind::Dual), parts, k);
        for (kind, bound) in [(JacobianKind::ControlForm, bound), (JacobianKind::TheoremB4, 10.0 * bound)] {
            let jacobian = &mut *build(kind);
            blocks(jacobian, &[parts[1].clone(), parts[2].clone(), parts[0].clone()], 3.0);
            let ours = blocks(jacobian, parts, k);
            for (name, ours, duals) in [
                ("dx", &ours.dx, &duals.dx),
                ("dxdot", &ours.dxdot, &duals.dxdot),
                ("dxddot", &ours.dxddot, &duals.dxddot),
            ] {
                let what = format!("{}, {kind:?} at k = {k}: {name}", model.name());
                assert_halves(&what, ours.as_slice(), duals.as_slice(), m, bound);
            }
        }
    }
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn right_hand_side_and_jacobians_are_right((model, parts) in model_and_node()) {
        // Digit has its own test.
        prop_assume!(model.dof() < 12);
        check_everything(&model, &parts);
    }
}

#[test]
fn digit_with_constraints() {
    let model = robot("digit_v3_pinned");
    check_everything(&model, &[0.7, 1.3, 2.1].map(|f| wave(44, f)));
}

/// Central differences are accurate unless activations are steep relative to their steps.
#[test]
fn differences_come_close() {
    let model = robot("kinova_gen3");
    let parts = [0.7, 1.3, 2.1].map(|f| wave(14, f));
    let constraints = &penalised(&model, &parts);
    let of = |kind: JacobianKind| blocks(&mut *kind.build_constrained(&model, constraints), &parts, 1.0);
    let (differences, duals) = (of(JacobianKind::Difference), of(JacobianKind::Dual));
    assert_halves("dx", differences.dx.as_slice(), duals.dx.as_slice(), 14, 1e-4);
    assert_halves("dxdot", differences.dxdot.as_slice(), duals.dxdot.as_slice(), 14, 1e-4);
}

/// The default derivatives of a cost equal the analytic ones.
#[test]
fn costs_by_their_values() {
    struct ValueAlone(TorquePenalty);
    impl ControlCost for ValueAlone {
        fn value<S: AlgebraOver<f64> + Tanh>(&self, _: S, joint: usize, u: S) -> S {
            let Penalty { k_cons, c_cons } = self.0.penalty;
            let limit = S::from_f64(self.0.limits.0[joint].unwrap_or(0.0));
            penalty(u - limit, k_cons, c_cons) + penalty(-u - limit, k_cons, c_cons)
        }
    }
    let limits = TorqueLimits(vec![Some(1.0), None]);
    let torque = TorquePenalty { limits, penalty: Penalty { k_cons: 2.0, c_cons: 0.8 } };
    for u in [-1.7, -0.4, 0.0, 0.6, 1.0, 2.3] {
        let ours = torque.derivatives(0.0, 0, u);
        assert_close!(&ours, &ValueAlone(torque.clone()).derivatives(0.0, 0, u), 1e-14);
        let step = 1e-5;
        let value = |u| ControlCost::value(&torque, 0.0, 0, u);
        let slope = (value(u + step) - value(u - step)) / (2.0 * step);
        assert_close!(&ours[..1], &[slope], 1e-8);
        assert_close!(&torque.derivatives(0.0, 1, u), &[0.0; 3], 0.0);
    }
    // For a passive joint the penalty is quadratic.
    let passive = TorquePenalty { limits: TorqueLimits(vec![Some(0.0)]), penalty: torque.penalty };
    for u in [-1.3, 0.4] {
        assert_close!(&[ControlCost::value(&passive, 0.0, 0, u)], &[2.0 * u * u], 1e-14);
        assert_close!(&passive.derivatives(0.0, 0, u), &[4.0 * u, 4.0, 0.0], 1e-13);
    }
    assert!(!torque.is_zero());
    assert!(ControlCost::<f64>::is_zero(&()));
    let none = TorqueLimits::<f64>::of(&random_tree(3, 1).expect("three joints"));
    assert_eq!((none.dim(), none.0.len()), (0, 3));
    let kinova = robot("kinova_gen3");
    assert_eq!(TorqueLimits::of(&kinova).0[0], Some(kinova.joints()[0].limits().effort));
    let two = none.value(&[0.0; 2], &mut []);
    assert_refused(two, "u: expected 3 entries, found 2");
    let a_row = none.value(&[0.0; 3], &mut [0.0]);
    assert_refused(a_row, "g: expected 0 entries, found 1");
}
