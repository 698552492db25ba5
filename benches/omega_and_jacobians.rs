//! The right-hand side of the flow and its Jacobians at one node, on robots of 2 to 128 joints.
//!
//! `cargo bench --bench omega_and_jacobians` measures; at the end it prints the medians in microseconds and the exponent `e` of
//! the growth `N^e` that fits the four largest robots of each row best.

use aghf::constraint::Constraints;
use aghf::constraint::TorqueLimits;
use aghf::constraint::{Capsule, CollisionSphere, Sphere, SphereClearance};
use aghf::flow::Penalty;
use aghf::flow::PenaltyWeights;
use aghf::flow::jacobian::{JacobianKind, NodeBlocks, NodeJacobian};
use aghf::flow::{AlgorithmB1, ControlForm, Node, Penalised, RightHandSide};
use aghf::model::{Model, random_chain};
use aghf::urdf::{builtin_robot, builtin_robots};
use criterion::Criterion;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// The penalty; it changes no time.
const K: f64 = 1e7;

/// Seconds a call, by what was called and `N`.
type Times = BTreeMap<(String, usize), Vec<f64>>;

/// Robots up to this size also get the Jacobians that are no match for large ones.
const LARGEST_FOR_ALL: usize = 22;

fn models() -> Vec<Model> {
    let built_in = builtin_robots().skip(1).filter_map(builtin_robot);
    let built_in = built_in.map(|robot| robot.expect("it loads").0);
    let chains = [32, 64, 128].map(|n| random_chain(n, 1).expect("it has joints"));
    built_in.chain(chains).collect()
}

fn measure(
    criterion: &mut Criterion,
    times: &mut Times,
    what: &str,
    n: usize,
    mut call: impl FnMut(),
) {
    let mut seen = Vec::new();
    criterion.bench_function(&format!("{what}/{n}"), |bencher| {
        bencher.iter_custom(|iterations| {
            let start = Instant::now();
            (0..iterations).for_each(|_| call());
            let elapsed = start.elapsed();
            seen.push(elapsed.as_secs_f64() / iterations as f64);
            elapsed
        });
    });
    times.insert((what.to_owned(), n), seen);
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600))
        .configure_from_args();
    let mut times = Times::new();
    for model in &models() {
        let n = model.dof();
        let wave = |f: f64| {
            (0..2 * n)
                .map(|i| (f * (i as f64 + 1.0)).sin())
                .collect::<Vec<_>>()
        };
        let (x, xdot, xddot) = (wave(0.7), wave(1.3), wave(2.1));
        let node = Node {
            x: &x,
            xdot: &xdot,
            xddot: &xddot,
        };
        let mut omega = vec![0.0; 2 * n];
        let mut control = ControlForm::<f64, f64>::new(model);
        measure(&mut criterion, &mut times, "omega control-form", n, || {
            control
                .omega(black_box(node), K, &mut omega)
                .expect("lengths agree");
        });
        let mut b1 = AlgorithmB1::<f64, f64>::new(model);
        measure(&mut criterion, &mut times, "omega algorithm-b1", n, || {
            b1.omega(black_box(node), K, &mut omega)
                .expect("lengths agree");
        });
        let mut blocks = NodeBlocks::new(n);
        if n <= LARGEST_FOR_ALL {
            constrained(&mut criterion, &mut times, model, node);
        }
        for (name, kind) in JacobianKind::by_name() {
            if n > LARGEST_FOR_ALL && kind != JacobianKind::ControlForm {
                continue;
            }
            let mut jacobian = kind.build(model);
            measure(
                &mut criterion,
                &mut times,
                &format!("jacobian {name}"),
                n,
                || {
                    jacobian
                        .evaluate(black_box(node), K, &mut blocks)
                        .expect("lengths agree");
                },
            );
        }
    }
    criterion.final_summary();
    report(&mut times);
}

/// The terms of ten spheres alone, and the flow with them and limits on the torque: for the joint frames and for swept links.
fn constrained(criterion: &mut Criterion, times: &mut Times, model: &Model, node: Node<'_, f64>) {
    let n = model.dof();
    let swept: Vec<CollisionSphere> = Capsule::along_links(model, 0.05)
        .iter()
        .flat_map(|capsule| capsule.balls(0.1).expect("positive"))
        .collect();
    let sphere = |i: u32| Sphere {
        centre: Vector3::new(0.5, 0.1, 0.4).map(|x| (x * f64::from(i)).sin()),
        radius: 0.2,
    };
    let penalty = Penalty {
        k_cons: 1e4,
        c_cons: 20.0,
    };
    for (name, balls) in [
        ("joint frames", CollisionSphere::joint_frames(model)),
        ("swept", swept),
    ] {
        println!("{name}: {} rows for {n} joints", 10 * balls.len());
        let spheres = (1..=10).map(sphere).collect();
        let constraints = Penalised {
            constraints: Constraints {
                state: SphereClearance { balls, spheres },
                torque: TorqueLimits::of(model),
            },
            weights: PenaltyWeights {
                state: penalty,
                torque: penalty,
            },
        };
        let (mut omega, mut blocks) = (vec![0.0; 2 * n], NodeBlocks::new(n));
        let mut terms = constraints.state_penalty(model);
        measure(criterion, times, &format!("terms omega {name}"), n, || {
            terms
                .omega(black_box(node), K, &mut omega)
                .expect("lengths agree");
        });
        measure(
            criterion,
            times,
            &format!("terms jacobian {name}"),
            n,
            || {
                terms
                    .evaluate(black_box(node), K, &mut blocks)
                    .expect("lengths agree");
            },
        );
        let mut rhs = constraints.right_hand_side(model);
        measure(
            criterion,
            times,
            &format!("constrained omega {name}"),
            n,
            || {
                rhs.omega(black_box(node), K, &mut omega)
                    .expect("lengths agree");
            },
        );
        let mut jacobian = JacobianKind::ControlForm.build_constrained(model, &constraints);
        measure(
            criterion,
            times,
            &format!("constrained jacobian {name}"),
            n,
            || {
                jacobian
                    .evaluate(black_box(node), K, &mut blocks)
                    .expect("lengths agree");
            },
        );
    }
}

/// Prints medians and growth.
fn report(times: &mut Times) {
    let mut columns: BTreeMap<&str, Vec<(usize, f64)>> = BTreeMap::new();
    for ((what, n), seen) in times.iter_mut() {
        seen.sort_by(f64::total_cmp);
        if let Some(median) = seen.get(seen.len() / 2) {
            columns.entry(what).or_default().push((*n, *median));
        }
    }
    println!("\nmedians in microseconds by N; growth fitted over the four largest robots");
    for (what, points) in columns {
        let row: Vec<String> = (points.iter())
            .map(|(n, t)| format!("{n}: {:.1}", 1e6 * t))
            .collect();
        let largest = &points[points.len().saturating_sub(4)..];
        println!(
            "{what:24} {}  growth N^{:.2}",
            row.join("  "),
            growth(largest)
        );
    }
}

/// The exponent of the power of `N` that fits the times best: least squares in the logarithms.
fn growth(points: &[(usize, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .map(|(n, t)| ((*n as f64).ln(), t.ln()))
        .collect();
    let count = logs.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let covariance: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    covariance / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}
