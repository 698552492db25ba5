//! A motion that is followed and replanned: closed loops, obstacles that move, pushes.

use crate::common::{assert_refused, robot};
use aghf::constraint::{
    AnyConstraint, Bounds, CollisionSphere, Constraints, SelfClearance, SolidClearance, Sphere, SphereClearance,
    TorqueLimits,
};
use aghf::cost::ControlEffort;
use aghf::direct::{Direct, DirectSettings, FreeHorizon, Outcome, Safety, Tracker, TrackerOptions};
use aghf::dynamics::{Data, ForwardDynamicsDerivatives, aba, aba_derivatives, forward_kinematics};
use aghf::geometry::{Shape, Solid};
use aghf::model::Model;
use aghf::motion::{Problem, violations};
use aghf::spatial::Placement;
use aghf::urdf::{builtin_robot_text, parse_urdf};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::time::Duration;

mod search;

type Kept = Constraints<Vec<AnyConstraint>>;
type Own<'a> = Tracker<'a, Vec<AnyConstraint>, ControlEffort<'a, f64, f64>>;

/// The limits of a robot, and a ball that the joints and the tool do not touch.
fn kept(model: &Model, ball: [f64; 3]) -> Kept {
    let clearance = SphereClearance {
        balls: CollisionSphere::joint_frames(model),
        spheres: vec![Sphere { centre: Vector3::from(ball), radius: 0.1 }],
    };
    Constraints {
        state: vec![
            AnyConstraint::Bounds(Bounds::positions(model)),
            AnyConstraint::Bounds(Bounds::velocities(model)),
            AnyConstraint::Spheres(clearance),
        ],
        torque: TorqueLimits::of(model),
        stage: Default::default(),
    }
}

const FAR: [f64; 3] = [9.0, 9.0, 9.0];

fn options(degree: usize) -> TrackerOptions {
    TrackerOptions { settings: DirectSettings { degree, ..DirectSettings::constrained() }, ..TrackerOptions::default() }
}

fn tracker<'a>(problem: &Problem<'a>, kept: Kept, options: TrackerOptions) -> Own<'a> {
    let cost = ControlEffort::new(problem.model());
    Tracker::new(problem, kept, cost, options).unwrap_or_else(|e| panic!("{e}"))
}

fn at_rest(q: &[f64]) -> Vec<f64> {
    [q, &vec![0.0; q.len()]].concat()
}

/// A reach of the arm of seven joints.
fn reach(model: &Model) -> Problem<'_> {
    let start = at_rest(&[0.0, 0.6, 0.0, 1.6, 0.0, 0.8, 0.0]);
    let goal = at_rest(&[1.2, 0.9, 0.0, 1.2, 0.0, 0.8, 0.0]);
    Problem::new(model, start, goal, 1.5).expect("valid")
}

/// The robot after `time` under a constant torque, by the classical Runge-Kutta method.
fn moved(model: &Model, x: &[f64], u: &[f64], time: f64) -> Vec<f64> {
    let n = model.dof();
    let mut data = Data::new(model);
    let mut rate = |x: &[f64]| {
        let mut a = vec![0.0; n];
        aba(model, &mut data, &x[..n], &x[n..], u, &mut a).expect("lengths agree");
        [&x[n..], &a].concat()
    };
    let along = |x: &[f64], k: &[f64], h: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + h * k).collect() };
    let (mut x, h) = (x.to_vec(), time / 2.0);
    for _ in 0..2 {
        let k1 = rate(&x);
        let k2 = rate(&along(&x, &k1, h / 2.0));
        let k3 = rate(&along(&x, &k2, h / 2.0));
        let k4 = rate(&along(&x, &k3, h));
        for (i, x) in x.iter_mut().enumerate() {
            *x += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }
    x
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let all = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    all.fold(0.0, f64::max)
}

fn largest(model: &Model, kept: &Kept, tracker: &Own<'_>) -> f64 {
    let rest = tracker.rest().expect("a plan");
    let rows = violations(model, &rest, kept, 4000).expect("of this robot");
    rows.iter().fold(0.0, |most, row| row.by.max(most))
}

/// Follows a tracker with a robot at 500 Hz until it has finished; returns the last state and the largest deviation.
fn closed_loop(
    real: &Model,
    tracker: &mut Own<'_>,
    mut x: Vec<f64>,
    mut each: impl FnMut(usize, &mut Own<'_>),
) -> (Vec<f64>, f64) {
    let (period, mut largest) = (0.002, 0.0_f64);
    let mut rest = 0;
    for k in 0..3000 {
        each(k, tracker);
        let step = tracker.step(&x, k as f64 * period).expect("a valid state");
        largest = largest.max(step.deviation);
        // The feedback settles after the end of the plan.
        rest += usize::from(step.outcome == Outcome::Finished);
        if rest > 200 {
            return (x, largest);
        }
        x = moved(real, &x, &step.command.u, period);
    }
    panic!("it never finished");
}

/// With the exact model the robot stays on the plan, which keeps all rows at every step, and ends at the goal.
#[test]
fn a_robot_of_the_model_arrives_exactly() {
    let model = robot("kinova_gen3");
    let problem = reach(&model);
    let kept = || kept(&model, [0.4, 0.2, 0.9]);
    let mut tracker = tracker(&problem, kept(), options(12));
    let (mut worst, mut replaced) = (0.0_f64, 0);
    let check = |k: usize, tracker: &mut Own<'_>| {
        if k > 0 && k.is_multiple_of(25) {
            worst = worst.max(largest(&model, &kept(), tracker));
            replaced += 1;
        }
    };
    let (x, deviation) = closed_loop(&model, &mut tracker, problem.start().to_vec(), check);
    assert!(replaced > 10 && worst <= 2e-6, "{worst:e}");
    assert!(deviation < 0.02, "{deviation}");
    assert!(distance(&x, problem.goal()) < 1e-3, "{x:?}");
}

/// The text of a robot with all masses times a factor.
fn heavier(name: &str, factor: f64) -> Model {
    let text = builtin_robot_text(name).expect("built in");
    let mut parts = text.split("<mass value=\"");
    let mut scaled = parts.next().expect("a beginning").to_owned();
    for part in parts {
        let (mass, rest) = part.split_once('"').expect("a number");
        let mass: f64 = mass.trim().parse().expect("a number");
        scaled += &format!("<mass value=\"{}\"{rest}", factor * mass);
    }
    let (model, _) = parse_urdf(&scaled, name).expect("as before");
    let ratio = model.mass() / robot(name).mass();
    assert!((ratio - factor).abs() < 1e-9, "{ratio}");
    model
}

/// The feedback brings a robot to the goal whose masses are wrong by a fifth, up to the sag under its weight.
#[test]
fn a_robot_with_wrong_masses_arrives() {
    let model = robot("kinova_gen3");
    let problem = reach(&model);
    for factor in [0.8, 1.2] {
        let real = heavier("kinova_gen3", factor);
        let mut tracker = tracker(&problem, kept(&model, FAR), options(12));
        let (x, deviation) = closed_loop(&real, &mut tracker, problem.start().to_vec(), |_, _| {});
        assert!(deviation > 1e-4 && deviation < 0.1, "{deviation}");
        assert!(distance(&x, problem.goal()) < 0.03, "{factor}: {x:?}");
    }
}

/// The linear closed loop has the same two poles at $-\omega$ for each joint.
#[test]
fn the_gain_places_the_poles_of_the_model() {
    let model = robot("kinova_gen3");
    let (problem, n) = (reach(&model), model.dof());
    let mut tracker = tracker(&problem, kept(&model, FAR), options(9));
    tracker.step(problem.start(), 0.0).expect("valid");
    let command = tracker.step(problem.start(), 0.02).expect("valid").command;
    let mut of = ForwardDynamicsDerivatives::new(n);
    let (q, v, tau) = (&command.q, &command.v, &command.tau);
    aba_derivatives(&model, &mut Data::new(&model), q, v, tau, &mut of).expect("valid");
    let omega = TrackerOptions::default().bandwidth;
    let gain = |first| command.gain.columns(first, n).into_owned();
    let one = DMatrix::identity(n, n);
    let of_q = &of.dq - &of.h_inverse * gain(0) + &one * (omega * omega);
    let of_v = &of.dv - &of.h_inverse * gain(n) + &one * (2.0 * omega);
    assert!(of_q.amax() < 1e-7 && of_v.amax() < 1e-7, "{of_q} {of_v}");
    assert!(distance(of.a.as_slice(), &command.a) < 1e-9);
}

/// A ball that is put onto the plan is reported at once, with its row and time, until there is a plan around it.
#[test]
fn an_obstacle_on_the_plan_is_reported() {
    let model = robot("kinova_gen3");
    let problem = reach(&model);
    let mut tracker = tracker(&problem, kept(&model, FAR), options(12));
    let plan = tracker.rest().expect("a plan");
    tracker.step(problem.start(), 0.0).expect("valid");
    let (q, _) = plan.at(0.75);
    let mut placements = vec![Placement::identity(); 7];
    forward_kinematics(&model, &q.as_slice()[..7], &mut placements).expect("lengths agree");
    let tool = placements[6].translation;
    let on = kept(&model, [tool.x, tool.y, tool.z + 0.09]);
    tracker.set_constraints(on.clone()).expect("valid");
    let mut x = problem.start().to_vec();
    let mut reported = 0;
    for k in 1..100 {
        let step = tracker.step(&x, 0.002 * f64::from(k)).expect("valid");
        x = [&step.command.q[..], &step.command.v].concat();
        match step.safety {
            Safety::Violated { row, by, after } => {
                assert!(on.label(row, &model).quantity.is_clearance());
                assert!(by > 1e-3 && after > 0.0 && after < 1.5, "{by} {after}");
                assert!(!step.replaced);
                reported += 1;
            }
            Safety::Kept => {
                assert!(step.replaced && largest(&model, &on, &tracker) < 2e-6);
                assert!(reported > 0, "it was on the plan");
                return;
            }
            Safety::Left => panic!("it is on its plan"),
        }
    }
    panic!("no plan around the ball was found");
}

/// A robot that is pushed away is reported, and gets a plan from where it is.
#[test]
fn a_robot_that_is_pushed_gets_another_plan() {
    let model = robot("kinova_gen3");
    let problem = reach(&model);
    let mut tracker = tracker(&problem, kept(&model, FAR), options(12));
    let command = tracker.step(problem.start(), 0.0).expect("valid").command;
    let mut pushed = [&command.q[..], &command.v].concat();
    pushed[1] += 0.2;
    for _ in 0..50 {
        let step = tracker.step(&pushed, 0.0).expect("valid");
        if step.replaced {
            assert!(step.deviation < 1e-12 && step.safety == Safety::Kept);
            return;
        }
        assert_eq!(step.safety, Safety::Left);
        assert!(step.deviation > 0.19, "{}", step.deviation);
    }
    panic!("no plan was found");
}

/// After the end of a plan a new goal gets a new one; with a free horizon its duration is found.
#[test]
fn a_goal_after_the_end_is_reached() {
    let model = robot("kinova_gen3");
    let problem = reach(&model);
    for free in [false, true] {
        let mut options = options(10);
        options.settings.free_horizon = free.then_some(FreeHorizon { shortest: 0.3, longest: 5.0, weight: 300.0 });
        let mut tracker = tracker(&problem, kept(&model, FAR), options);
        let goal = [1.1, 0.7, 0.1, 1.3, 0.1, 0.7, 0.2];
        let mut set = false;
        let mut state = problem.start().to_vec();
        let mut finished = 0;
        for k in 0..2000 {
            let step = tracker.step(&state, 0.004 * f64::from(k)).expect("valid");
            state = [&step.command.q[..], &step.command.v].concat();
            assert_eq!(step.safety, Safety::Kept);
            if step.outcome == Outcome::Finished {
                finished += 1;
                if set {
                    break;
                }
                tracker.set_goal(&goal, 0.8).expect("valid");
                set = true;
            }
        }
        assert_eq!(finished, 2);
        assert!(distance(&state, &at_rest(&goal)) < 1e-9, "{state:?}");
    }
}

#[test]
fn what_cannot_be_tracked_is_refused() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.5, 0.0, 0.0], 2.0).expect("valid");
    let new = |problem: &Problem<'_>, kept: Kept, change: &dyn Fn(&mut TrackerOptions)| {
        let mut options = options(9);
        change(&mut options);
        Tracker::new(problem, kept, ControlEffort::new(&model), options).map(|_| ())
    };
    let free = || kept(&model, FAR);
    let moving = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.5, 0.0, 1.0], 2.0).expect("valid");
    assert_refused(new(&moving, free(), &|_| {}), "joint 1 is not at rest");
    assert_refused(new(&problem, free(), &|o| o.settings.segments = 2), "segments");
    assert_refused(new(&problem, free(), &|o| o.bandwidth = -1.0), "bandwidth");
    assert_refused(new(&problem, free(), &|o| o.iterations_per_step = 0), "iterations_per_step");
    assert_refused(new(&problem, free(), &|o| o.shortest_horizon = 3.0), "horizon");
    let mut passive = free();
    passive.torque = TorqueLimits(vec![None, Some(0.0)]);
    assert_refused(new(&problem, passive.clone(), &|_| {}), "passive");
    let mut tracker = tracker(&problem, free(), options(9));
    assert_refused(tracker.set_constraints(passive), "passive");
    assert_refused(tracker.set_goal(&[0.0], 1.0), "");
    assert_refused(tracker.set_goal(&[0.0, f64::NAN], 1.0), "finite");
    assert_refused(tracker.set_goal(&[0.0, 0.0], 0.01), "shortest");
    assert_refused(tracker.step(&[0.0; 3], 0.0).map(|_| ()), "state");
    assert_refused(tracker.step(&[f64::NAN; 4], 0.0).map(|_| ()), "finite");
    tracker.step(&[0.0; 4], 1.0).expect("valid");
    assert_refused(tracker.step(&[0.0; 4], 0.9).map(|_| ()), "before the last step");
}
