//! The right-hand side of the flow and its Jacobians at one node, on robots of 2 to 128 joints.
//!
//! `cargo bench --bench flow` measures and prints the medians in microseconds at the end.

mod common;

use aghf::constraint::{CollisionSphere, Constraints, Sphere, SphereClearance, TorqueLimits};
use aghf::flow::jacobian::{JacobianKind, NodeBlocks, NodeJacobian};
use aghf::flow::{AlgorithmB1, ControlForm, Node, Penalised, Penalty, PenaltyWeights, RightHandSide};
use aghf::geometry::Capsule;
use aghf::model::Model;
use common::{Times, criterion, measure, models, report, wave};
use criterion::Criterion;
use nalgebra::Vector3;
use std::hint::black_box;

/// The penalty; it changes no time.
const K: f64 = 1e7;

/// Robots up to this size also get the Jacobians that are no match for large ones.
const MAX_FOR_ALL: usize = 22;

fn main() {
    let mut criterion = criterion();
    let mut times = Times::new();
    for model in &models() {
        let n = model.dof();
        let (x, xdot, xddot) = (wave(2 * n, 0.7), wave(2 * n, 1.3), wave(2 * n, 2.1));
        let node = Node { t: 0.0, x: &x, xdot: &xdot, xddot: &xddot };
        let mut omega = vec![0.0; 2 * n];
        let mut control = ControlForm::<f64, f64>::new(model);
        measure(&mut criterion, &mut times, "omega control_form", n, || {
            control.omega(black_box(node), K, &mut omega).expect("lengths agree");
        });
        let mut b1 = AlgorithmB1::<f64, f64>::new(model);
        measure(&mut criterion, &mut times, "omega algorithm-b1", n, || {
            b1.omega(black_box(node), K, &mut omega).expect("lengths agree");
        });
        let mut blocks = NodeBlocks::new(n);
        if n <= MAX_FOR_ALL {
            constrained(&mut criterion, &mut times, model, node);
        }
        for (name, kind) in JacobianKind::by_name() {
            if n > MAX_FOR_ALL && kind != JacobianKind::ControlForm {
                continue;
            }
            let mut jacobian = kind.build(model);
            measure(&mut criterion, &mut times, &format!("jacobian {name}"), n, || {
                jacobian.evaluate(black_box(node), K, &mut blocks).expect("lengths agree");
            });
        }
    }
    criterion.final_summary();
    report(&mut times);
}

/// The flow among spheres, for the joint frames and for swept links.
fn constrained(criterion: &mut Criterion, times: &mut Times, model: &Model, node: Node<'_, f64>) {
    let n = model.dof();
    let swept: Vec<CollisionSphere> =
        Capsule::along_links(model, 0.05).iter().flat_map(|capsule| capsule.balls(0.1).expect("positive")).collect();
    for (name, balls) in [("joint frames", CollisionSphere::joint_frames(model)), ("swept", swept)] {
        println!("{name}: {} rows for {n} joints", 10 * balls.len());
        among_spheres(criterion, times, model, node, name, balls);
    }
}

/// The terms of ten spheres alone, and the flow with them and limits on the torque.
fn among_spheres(
    criterion: &mut Criterion,
    times: &mut Times,
    model: &Model,
    node: Node<'_, f64>,
    name: &str,
    balls: Vec<CollisionSphere>,
) {
    let n = model.dof();
    let sphere = |i: u32| Sphere { centre: Vector3::new(0.5, 0.1, 0.4).map(|x| (x * f64::from(i)).sin()), radius: 0.2 };
    let spheres = (1..=10).map(sphere).collect();
    let penalty = Penalty { k_cons: 1e4, c_cons: 20.0 };
    let constraints = Penalised {
        constraints: Constraints {
            state: SphereClearance { balls, spheres },
            torque: TorqueLimits::of(model),
            stage: Default::default(),
        },
        weights: PenaltyWeights { state: penalty, torque: penalty },
    };
    let (mut omega, mut blocks) = (vec![0.0; 2 * n], NodeBlocks::new(n));
    let mut terms = constraints.state_penalty(model);
    measure(criterion, times, &format!("terms omega {name}"), n, || {
        terms.omega(black_box(node), K, &mut omega).expect("lengths agree");
    });
    let row = format!("terms jacobian {name}");
    measure(criterion, times, &row, n, || {
        terms.evaluate(black_box(node), K, &mut blocks).expect("lengths agree");
    });
    let mut rhs = constraints.right_hand_side(model);
    let row = format!("constrained omega {name}");
    measure(criterion, times, &row, n, || {
        rhs.omega(black_box(node), K, &mut omega).expect("lengths agree");
    });
    let mut jacobian = JacobianKind::ControlForm.build_constrained(model, &constraints);
    let row = format!("constrained jacobian {name}");
    measure(criterion, times, &row, n, || {
        jacobian.evaluate(black_box(node), K, &mut blocks).expect("lengths agree");
    });
}
