//! The flow to rest: its end is that of the direct method, satisfies the constraints, and is reported correctly.

mod descent;
mod settings;

use crate::common::direct::solved;
use crate::common::robot;
use crate::common::scenario::Scenario;
use aghf::constraint::{
    CollisionSphere, Constraint, Constraints, Sphere, SphereClearance, StageConstraints, TorqueLimits,
};
use aghf::curve::{Curve, gauss_legendre};
use aghf::direct::DirectSettings;
use aghf::dynamics::{Data, forward_kinematics, rnea};
use aghf::flow::rest::{FlowToRest, RestMetric, RestSettings, RestSolution};
use aghf::model::Model;
use aghf::motion::Problem;
use aghf::spatial::Placement;
use nalgebra::Vector3;

pub(super) const FREE: Constraints<()> =
    Constraints { state: (), torque: TorqueLimits(Vec::new()), stage: StageConstraints::NONE };

pub(super) fn swing(model: &Model) -> Problem<'_> {
    let n = model.dof();
    let mut goal = vec![0.0; 2 * n];
    goal[..n].fill(1.0);
    Problem::new(model, vec![0.0; 2 * n], goal, 1.5).expect("valid")
}

pub(super) fn degree(degree: usize) -> RestSettings {
    RestSettings { degree, ..RestSettings::default() }
}

pub(super) fn rested<K: Constraint>(
    problem: &Problem<'_>,
    settings: &RestSettings,
    k: f64,
    constraints: &Constraints<K>,
) -> RestSolution {
    FlowToRest::new(problem, k)
        .settings(settings.clone())
        .constraints(constraints)
        .run()
        .unwrap_or_else(|e| panic!("{e}"))
}

/// The torques at `points` Gauss points of each segment, with the weights of these.
fn torques(model: &Model, curve: &Curve, points: usize) -> Vec<(f64, Vec<f64>)> {
    let (n, half) = (model.dof(), 0.5 * curve.horizon() / curve.segments() as f64);
    let (nodes, weights) = gauss_legendre(points);
    let mut found = Vec::new();
    for e in 0..curve.segments() {
        for (s, w) in nodes.iter().zip(&weights) {
            let (x, xdot) = curve.at_in(e, half * ((2 * e + 1) as f64 + s));
            let mut u = vec![0.0; n];
            let (q, v) = x.as_slice().split_at(n);
            let a = &xdot.as_slice()[n..];
            rnea(model, &mut Data::new(model), q, v, a, &mut u).expect("sizes agree");
            found.push((w * half, u));
        }
    }
    found
}

/// $\int |u|^2 dt$.
fn effort(model: &Model, curve: &Curve) -> f64 {
    let square = |u: &[f64]| u.iter().map(|u| u * u).sum::<f64>();
    torques(model, curve, 100).iter().map(|(w, u)| w * square(u)).sum()
}

/// Curves of the flow at rest have no slip, so they are feasible for the direct method, which started there finds the
/// same least effort.
#[test]
fn it_rests_where_the_effort_is_least() {
    for (name, degree, segments) in
        [("pendulum_2_swingup", 12, 1), ("pendulum_2_swingup", 6, 3), ("kinova_free_01", 9, 1)]
    {
        let scenario = Scenario::load(name);
        let problem = scenario.problem();
        let settings = RestSettings { degree, segments, ..RestSettings::default() };
        let solution = rested(&problem, &settings, 1e4, &FREE);
        assert!(solution.at_rest && solution.gradient_norm <= 1e-8, "{name}: {solution:?}");
        assert!(solution.slip <= 1e-6, "{name}: slip {:e}", solution.slip);
        assert_eq!(solution.curve.segments(), segments);
        assert_close!(&solution.curve.at(0.0).0, problem.start(), 1e-12);
        assert_close!(&solution.curve.at(problem.horizon()).0, problem.goal(), 1e-12);
        let direct = solved(
            &problem,
            &DirectSettings {
                degree,
                segments,
                quadrature_tolerance: 1e-9,
                start: Some(solution.curve.clone()),
                ..DirectSettings::default()
            },
        );
        // The two quadratures have other points, so both motions are measured by a third one.
        let [found, least] = [&solution.curve, &direct.curve].map(|curve| effort(problem.model(), curve));
        assert!(direct.converged && (found / least - 1.0).abs() <= 5e-4, "{name}, {segments}: {found} {least}");
        // Steps in s are large in the end.
        let last: Vec<_> = solution.history.iter().rev().take(3).collect();
        assert!(last.windows(2).all(|pair| pair[0].s > pair[1].s), "{last:?}");
    }
}

/// Without duals the slip is of order 1 / k; with them it vanishes for any `k`.
#[test]
fn duals_take_the_place_of_a_large_penalty() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let without = RestSettings { duals: false, ..degree(9) };
    let [coarse, fine] = [1e4, 1e5].map(|k| rested(&problem, &without, k, &FREE));
    assert!(coarse.at_rest && fine.at_rest);
    let ratio = coarse.slip / fine.slip;
    assert!(coarse.slip > 1e-4 && (ratio - 10.0).abs() < 0.5, "{} {ratio}", coarse.slip);
    let small = rested(&problem, &degree(9), 1e2, &FREE);
    assert!(small.at_rest && small.slip <= 1e-6 && small.rounds > 1, "{small:?}");
    let from_there = RestSettings { start: Some(small.curve.clone()), ..degree(9) };
    let large = rested(&problem, &from_there, 1e5, &FREE);
    assert!(large.at_rest && large.slip <= 1e-6, "{large:?}");
    assert_close!(large.curve.x(), small.curve.x(), 1e-5);
    let [a, b] = [small.action, large.action];
    assert!((a - b).abs() < 1e-8 * b, "{a} {b}");
}

/// $\int |u|^2 + k |\dot x_{P1} - x_{P2}|^2 dt$.
fn action(model: &Model, curve: &Curve, k: f64) -> f64 {
    let (n, half) = (model.dof(), 0.5 * curve.horizon() / curve.segments() as f64);
    let (nodes, weights) = gauss_legendre(100);
    let mut sum = effort(model, curve);
    for e in 0..curve.segments() {
        for (s, w) in nodes.iter().zip(&weights) {
            let (x, xdot) = curve.at_in(e, half * ((2 * e + 1) as f64 + s));
            let slip = xdot.rows(0, n) - x.rows(n, n);
            sum += w * half * k * slip.norm_squared();
        }
    }
    sum
}

/// The metric changes only the path: with either the gradient of the action vanishes at its end, and from beside one
/// end leads back to it.
#[test]
fn it_comes_to_rest_in_either_metric() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let (mut actions, mut start) = (Vec::new(), None);
    for metric in [RestMetric::Velocity, RestMetric::Flow] {
        let settings =
            RestSettings { metric, duals: false, segments: 2, tolerance: 1e-9, start: start.take(), ..degree(6) };
        let solution = rested(&problem, &settings, 1e3, &FREE);
        assert!(solution.at_rest, "{metric:?}: {solution:?}");
        // Neighbours on either side cost the same, up to the third order.
        let [before, here, after] = [-1e-3, 0.0, 1e-3].map(|by| action(&model, &moved(&solution.curve, by), 1e3));
        let (slope, bend) = (after - before, after + before - 2.0 * here);
        assert!(bend > 0.0 && slope.abs() < 0.02 * bend, "{metric:?}: {slope:e} {bend:e}");
        actions.push(solution.action);
        start = Some(moved(&solution.curve, 1e-2));
    }
    assert!((actions[0] - actions[1]).abs() < 1e-9 * actions[1], "{actions:?}");
}

#[test]
fn a_torque_limit_is_kept() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let free = rested(&problem, &degree(12), 1e4, &FREE);
    let largest = |curve: &Curve| {
        let all = torques(&model, curve, 300);
        all.iter().map(|(_, u)| u[0].abs()).fold(0.0, f64::max)
    };
    let limit = 0.9 * largest(&free.curve);
    let limited = Constraints { state: (), torque: TorqueLimits(vec![Some(limit), None]), stage: Default::default() };
    for two_phases in [false, true] {
        let settings = RestSettings { two_phases, start: Some(free.curve.clone()), ..degree(12) };
        let solution = rested(&problem, &settings, 1e4, &limited);
        assert!(solution.at_rest && solution.violation <= 1e-5, "{two_phases}: {solution:?}");
        let reached = largest(&solution.curve);
        assert!(reached <= limit + 2e-5 && reached > 0.99 * limit, "{reached} {limit}");
        let [kept, least] = [&solution, &free].map(|s| effort(&model, &s.curve));
        assert!(kept > 1.0001 * least, "{kept} {least}");
    }
}

#[test]
fn a_sphere_is_kept_out_of() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let free = rested(&problem, &degree(12), 1e4, &FREE);
    let tip = Vector3::new(0.0, 0.0, -0.5);
    let place = |curve: &Curve, t: f64| {
        let mut placements = vec![Placement::identity(); 2];
        forward_kinematics(&model, &curve.at(t).0.as_slice()[..2], &mut placements).expect("sizes agree");
        placements[1].rotation * tip + placements[1].translation
    };
    // Larger than the distance at which another motion of least effort passes it.
    let (t, radius) = (0.5 * problem.horizon(), 0.12);
    let (middle, near) = (place(&free.curve, t), place(&free.curve, t + 0.01));
    // Off the path, so that only one way round is short.
    let along = (near - middle).normalize();
    let axis = model.joints()[0].axis();
    let centre = middle + 0.05 * along.cross(axis);
    let clearance = SphereClearance {
        balls: vec![CollisionSphere { body: Some(1), centre: tip, radius: 0.0 }],
        spheres: vec![Sphere { centre, radius }],
    };
    let constraints = Constraints { state: clearance, torque: TorqueLimits(Vec::new()), stage: Default::default() };
    let solution = rested(&problem, &degree(16), 1e4, &constraints);
    assert!(solution.at_rest && solution.violation <= 1e-5, "{solution:?}");
    let times = (0..=500).map(|i| problem.horizon() * f64::from(i) / 500.0);
    let nearest = times.map(|t| (place(&solution.curve, t) - centre).norm()).fold(f64::MAX, f64::min);
    assert!((nearest - radius).abs() < 1e-3 && nearest > radius - 2e-5, "{nearest}");
    assert!((place(&free.curve, t) - centre).norm() < 0.06);
}

/// The torque of a passive joint vanishes at the collocation points, one for each coefficient of a segment.
#[test]
fn a_passive_joint_has_no_torque_at_the_gauss_points() {
    let scenario = Scenario::load("cart_pole_swingup");
    let problem = scenario.problem();
    let passive = scenario.passive();
    let limits = (0..scenario.model.dof()).map(|i| passive.contains(&i).then_some(0.0));
    let constraints = Constraints { state: (), torque: TorqueLimits(limits.collect()), stage: Default::default() };
    let solution = rested(&problem, &degree(16), 1e4, &constraints);
    assert!(solution.at_rest && solution.slip <= 1e-6, "{solution:?}");
    let torque = |points: usize| {
        let all = torques(&scenario.model, &solution.curve, points);
        let passive = all.iter().map(|(_, u)| u[passive[0]].abs()).fold(0.0, f64::max);
        let all = all.iter().flat_map(|(_, u)| u).map(|u| u.abs()).fold(0.0, f64::max);
        (passive, all)
    };
    let ((held, _), (between, all)) = (torque(15), torque(100));
    assert!(held <= 1e-5, "{held:e}");
    assert!(between > 10.0 * held && between < 0.1 * all, "{held:e} {between:e} {all}");
}

/// A curve with another position at one of its nodes.
pub(super) fn moved(curve: &Curve, by: f64) -> Curve {
    let mut x = curve.x().clone();
    x[(0, 3)] += by;
    Curve::piecewise(curve.horizon(), curve.segments(), x).expect("they meet")
}
