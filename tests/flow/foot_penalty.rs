//! The rows of a standing foot in the published flow.

use crate::common::{assert_refused, point_mass, tree};
use aghf::constraint::{Bounds, Constraints, RateLimit, StageConstraints, StandingFoot, TorqueLimits};
use aghf::curve::Curve;
use aghf::dynamics::Data;
use aghf::flow::jacobian::{CentralDifference, ForwardDual, JacobianKind, NodeBlocks, NodeJacobian};
use aghf::flow::{Flow, FlowSettings, FootPenalty, Node, Penalised, Penalty, PenaltyWeights};
use aghf::model::Model;
use aghf::motion::Problem;
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A sole 1 m below the base, 0.3 m long about 0.1 m.
fn foot(weight: f64) -> StandingFoot {
    StandingFoot {
        name: "left".to_owned(),
        sole: Placement::new(Matrix3::identity(), Vector3::new(0.1, 0.0, -1.0)),
        half_length: 0.15,
        half_width: 0.1,
        friction: 0.5,
        torsion: Some(0.05),
        weight,
    }
}

fn penalised(stage: StageConstraints, k_cons: f64) -> Penalised<Bounds> {
    let penalty = Penalty { k_cons, c_cons: 200.0 };
    Penalised {
        constraints: Constraints { state: Bounds(Vec::new()), torque: TorqueLimits(Vec::new()), stage },
        weights: PenaltyWeights { state: penalty, torque: penalty },
    }
}

fn standing(foot: StandingFoot) -> StageConstraints {
    StageConstraints { foot: Some(foot), ..StageConstraints::NONE }
}

/// The largest row along a curve.
fn worst(model: &Model, foot: &StandingFoot, curve: &Curve) -> f64 {
    let (mut data, mut g) = (Data::new(model), vec![0.0; foot.dim()]);
    let times = (0..=100).map(|i| curve.horizon() * f64::from(i) / 100.0);
    let largest = times.map(|time| {
        let (x, xdot) = curve.at(time);
        let n = model.dof();
        let [q, v, a] = [&x.as_slice()[..n], &x.as_slice()[n..], &xdot.as_slice()[n..]];
        foot.value(model, &mut data, [q, v, a], &mut g).expect("rows");
        g.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    });
    largest.fold(f64::NEG_INFINITY, f64::max)
}

/// A mass that starts fast pushes the centre of pressure off its sole; with the rows as penalties it starts slower,
/// with any Jacobian.
#[test]
fn a_mass_stays_on_its_sole() {
    let model = point_mass(&[Vector3::x()]).with_gravity(Vector3::new(0.0, 0.0, -10.0));
    let problem = Problem::new(&model, vec![0.0; 2], vec![0.2, 0.0], 1.4).expect("valid");
    let foot = foot(10.0);
    let run = |k_cons: f64, kind: JacobianKind| {
        let constraints = penalised(standing(foot.clone()), k_cons);
        let settings = FlowSettings { jacobian: kind, ..FlowSettings::new(12, 1e4, 1e3) };
        let flow = Flow::new(&problem, settings).constraints(&constraints);
        let solution = flow.run().expect("good input");
        assert_eq!(solution.failure, None, "{kind:?}");
        solution.curve
    };
    let free = run(1e-9, JacobianKind::ControlForm);
    let kept = run(1e3, JacobianKind::ControlForm);
    let [before, after] = [&free, &kept].map(|curve| worst(&model, &foot, curve));
    assert!(before > 0.01 && after < 0.2 * before, "{before} and {after}");
    for (name, kind) in JacobianKind::by_name() {
        let other = run(1e3, kind);
        assert!((other.x() - kept.x()).amax() < 1e-3, "{name}");
    }
}

/// The Jacobian of the terms by dual numbers is that by differences, for robots whose wrench depends on everything.
#[test]
fn jacobians_of_the_terms_agree() {
    let mut rng = ChaCha8Rng::seed_from_u64(37);
    for (n, seed) in [(2, 1), (4, 3)] {
        let (model, foot) = (tree(n, seed), foot(30.0));
        let mut state = || -> Vec<f64> { (0..2 * n).map(|_| rng.random_range(-1.0..1.0)).collect() };
        let [x, xdot, xddot] = [state(), state(), state()];
        let node = Node { t: 0.3, x: &x, xdot: &xdot, xddot: &xddot };
        let penalty = Penalty { k_cons: 2.0, c_cons: 1.5 };
        let [mut duals, mut differences] = [(); 2].map(|()| NodeBlocks::new(n));
        ForwardDual::of(FootPenalty::new(&model, &foot, penalty), n)
            .evaluate(node, 7.0, &mut duals)
            .expect("sizes agree");
        CentralDifference::of(FootPenalty::new(&model, &foot, penalty), n)
            .evaluate(node, 7.0, &mut differences)
            .expect("sizes agree");
        for (a, b) in duals.all().into_iter().zip(differences.all()) {
            assert!((a - b).amax() <= 1e-6 * (1.0 + a.amax()), "{n}: {a} {b}");
        }
        assert!(duals.dxddot.amax() > 1e-6);
    }
}

/// Other rows of $(t, q, v, a, u)$ are refused beside a foot.
#[test]
fn other_rows_are_refused() {
    let model = point_mass(&[Vector3::x()]);
    let problem = Problem::new(&model, vec![0.0; 2], vec![0.2, 0.0], 1.4).expect("valid");
    let stage = StageConstraints { rates: RateLimit::both(2, 0, 1.0).to_vec(), ..standing(foot(10.0)) };
    let constraints = penalised(stage, 1.0);
    let flow = Flow::new(&problem, FlowSettings::new(6, 1e2, 1.0)).constraints(&constraints);
    assert_refused(flow.run(), "the published one also a foot that stands");
}
