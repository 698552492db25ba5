//! Limits of acceleration, jerk and power, and continuous accelerations.

use crate::common::direct::{solved, solved_within};
use crate::common::{assert_refused, robot, slider};
use aghf::constraint::{Constraints, RateLimit, StageConstraints, StageRows, StandingFoot, TorqueLimits};
use aghf::curve::Curve;
use aghf::direct::{DirectSettings, DirectSolution, FreeHorizon};
use aghf::flow::rest::FlowToRest;
use aghf::motion::{Problem, violations};
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The settings within constraints, with continuous accelerations.
fn smooth(segments: usize, degree: usize) -> DirectSettings {
    DirectSettings { segments, degree, continuous_acceleration: true, ..DirectSettings::constrained() }
}

fn within(stage: StageConstraints) -> Constraints<()> {
    Constraints { state: (), torque: TorqueLimits(Vec::new()), stage }
}

/// Accelerations on both sides of all breakpoints and at the ends.
fn accelerations(curve: &Curve) -> Vec<[Vec<f64>; 2]> {
    let (n, last) = (curve.dof(), curve.segments() - 1);
    let at = |segment: usize, time: f64| curve.at_in(segment, time).1.rows(n, n).as_slice().to_vec();
    let sides = curve.breakpoints().iter().enumerate();
    sides.map(|(i, t)| [at(i.saturating_sub(1), *t), at(i.min(last), *t)]).collect()
}

#[test]
fn continuous_accelerations_are_zero_at_rest() {
    let model = robot("pendulum_2");
    let rest = Problem::new(&model, vec![0.0; 4], vec![1.0, -0.7, 0.0, 0.0], 1.5).expect("valid");
    let jumping = solved(&rest, &DirectSettings { continuous_acceleration: false, ..smooth(6, 8) });
    let found = solved(&rest, &smooth(3, 8));
    assert!(found.converged && jumping.converged);
    assert!(found.cost > jumping.cost, "{} {}", found.cost, jumping.cost);
    let ends = accelerations(&found.curve);
    for [before, after] in &ends {
        assert!(before.iter().zip(after).all(|(a, b)| (a - b).abs() < 1e-8), "{before:?} {after:?}");
    }
    for end in [&ends[0], &ends[3]] {
        assert!(end.iter().flatten().all(|a| a.abs() < 1e-9), "{end:?}");
    }
    assert!(accelerations(&jumping.curve)[0][0].iter().any(|a| a.abs() > 0.1));
    // A start that moves may accelerate, and more segments come closer to the least effort.
    let moving = Problem::new(&model, vec![0.0, 0.0, 0.5, 0.0], vec![1.0, -0.7, 0.0, 0.0], 1.5);
    let moving = solved(&moving.expect("valid"), &smooth(3, 8));
    assert!(accelerations(&moving.curve)[0][0].iter().any(|a| a.abs() > 0.1));
    let finer = solved(&rest, &smooth(6, 8));
    let costs = [jumping.cost, finer.cost, found.cost];
    assert!(finer.converged && costs.is_sorted(), "{} {costs:?}", finer.converged);
}

/// From rest to rest over `d` in `T` with $|a| \le \bar a$: the acceleration is at its limit up to
/// $T / 2 - w$ and linear between, with $w^2 = 3 (T^2 / 4 - d / \bar a)$.
#[test]
fn an_acceleration_limit_gives_the_known_optimum() {
    let (mass, d, horizon, limit) = (2.0, 1.0, 1.0_f64, 4.5);
    let model = slider(mass);
    let problem = Problem::new(&model, vec![0.0, 0.0], vec![d, 0.0], horizon).expect("valid");
    let limits =
        within(StageConstraints { rates: RateLimit::both(2, 0, limit).to_vec(), ..StageConstraints::default() });
    let settings = DirectSettings { continuous_acceleration: false, ..smooth(16, 6) };
    let found = solved_within(&problem, &settings, &limits);
    let w = (3.0 * (horizon * horizon / 4.0 - d / limit)).sqrt();
    let exact = 2.0 * mass * mass * limit * limit * (horizon / 2.0 - w + w / 3.0);
    assert!(found.converged, "{found:?}");
    assert!((found.cost - exact).abs() < 1e-3 * exact, "{} {exact}", found.cost);
    let worst = violations(&model, &found.curve, &limits, 200).expect("the same robot");
    assert!(worst.iter().all(|row| row.by <= 1e-6), "{worst:?}");
    assert!(worst.iter().any(|row| row.by > -1e-3), "{worst:?}");
}

/// The least time from rest to rest over `d` with a jerk of at most $\bar\jmath$ is $(32 d / \bar\jmath)^{1/3}$.
#[test]
fn a_jerk_limit_bounds_the_time() {
    let (d, limit) = (1.0, 20.0);
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0, 0.0], vec![d, 0.0], 2.0).expect("valid");
    let limits =
        within(StageConstraints { rates: RateLimit::both(3, 0, limit).to_vec(), ..StageConstraints::default() });
    let least = (32.0 * d / limit).cbrt();
    // A single polynomial cannot follow the jumps of the jerk as closely.
    for (segments, degree, share) in [(8, 6, 0.03), (1, 16, 0.2)] {
        let settings = DirectSettings {
            free_horizon: Some(FreeHorizon { shortest: 0.1, longest: 5.0, weight: 1e4 }),
            ..smooth(segments, degree)
        };
        let found: DirectSolution = solved_within(&problem, &settings, &limits);
        let horizon = found.curve.horizon();
        assert!(found.converged, "{found:?}");
        assert!(horizon > least * (1.0 - 1e-6), "{horizon} {least}");
        assert!(horizon < (1.0 + share) * least, "{horizon} {least}");
        let worst = violations(&model, &found.curve, &limits, 200).expect("the same robot");
        assert!(worst.iter().all(|row| row.by <= 1e-6), "{worst:?}");
    }
}

/// A limit of the power that varies with time, of a robot with gravity, with a free horizon.
#[test]
fn a_closure_limits_the_power() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, -0.7, 0.0, 0.0], 1.0).expect("valid");
    let settings = DirectSettings {
        free_horizon: Some(FreeHorizon { shortest: 0.3, longest: 4.0, weight: 200.0 }),
        ..smooth(1, 16)
    };
    let power = |most: f64| {
        let rows = StageRows::new("power", vec![most], move |at, g| {
            g[0] = at.u[0] * at.v[0] - most - at.t;
        });
        within(StageConstraints { custom: vec![Arc::new(rows)], ..StageConstraints::default() })
    };
    let free = solved(&problem, &settings);
    let beyond = |found: &DirectSolution, most: f64| {
        let all = violations(&model, &found.curve, &power(most), 400).expect("the same robot");
        all[0].by
    };
    let most = 0.6 * beyond(&free, 1e-9);
    assert!(most > 0.0);
    let found = solved_within(&problem, &settings, &power(most));
    assert!(found.converged, "{found:?}");
    let by = beyond(&found, most);
    assert!((-1e-3 * most..1e-6).contains(&by), "{by} of {most}");
    let time = |found: &DirectSolution| found.cost + 200.0 * found.curve.horizon();
    assert!(time(&found) > time(&free));
}

#[test]
fn flows_refuse_limits_of_acceleration() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, -0.7, 0.0, 0.0], 1.0).expect("valid");
    let limits = within(StageConstraints { rates: RateLimit::both(2, 1, 5.0).to_vec(), ..StageConstraints::default() });
    let refused = FlowToRest::new(&problem, 1e3).constraints(&limits).run();
    assert_refused(refused, "acceleration");
}

/// A mass that slides at the height `h` above a sole presses on it at $x - a h / g$: at rest at one end the motion can
/// only accelerate as fast as the pressure stays within the edges.
#[test]
fn a_foot_bounds_the_acceleration_by_its_edges() {
    let (model, half) = (slider(2.0), 0.25);
    let problem = Problem::new(&model, vec![-0.1, 0.0], vec![0.1, 0.0], 0.8).expect("valid");
    let settings = DirectSettings { continuous_acceleration: false, ..smooth(4, 8) };
    let stand = within(StageConstraints {
        foot: Some(StandingFoot {
            name: "foot".to_owned(),
            sole: Placement::new(Matrix3::identity(), Vector3::new(0.0, 0.0, -1.0)),
            half_length: half,
            half_width: 0.1,
            friction: 0.9,
            torsion: None,
            weight: 2.0 * 9.81,
        }),
        ..StageConstraints::default()
    });
    let free = solved(&problem, &settings);
    let found = solved_within(&problem, &settings, &stand);
    assert!(found.converged && found.cost > 1.01 * free.cost, "{found:?}");
    let worst = violations(&model, &found.curve, &stand, 400).expect("the same robot");
    assert!(worst.iter().all(|row| row.by <= 1e-6), "{worst:?}");
    let samples = aghf::motion::sample(&model, &found.curve, 400).expect("the same robot");
    let pressure = samples.iter().map(|s| s.q[0] - s.a[0] / 9.81);
    let farthest = pressure.fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!((farthest - half).abs() < 1e-3, "{farthest}");
    let refused = FlowToRest::new(&problem, 1e4).constraints(&stand).run();
    assert_refused(refused, "a foot that stands");
}
