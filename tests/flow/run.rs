//! The flow and its end.

use crate::common::scenario::Scenario;
use crate::common::{assert_refused, robot};
use aghf::curve::{Chebyshev, Curve};
use aghf::flow::jacobian::JacobianKind;
use aghf::flow::{Flow, FlowRecord, FlowSettings, FlowSolution, effort_of};
use aghf::model::{Model, pendulum};
use aghf::motion::{Feedback, Guess, Problem, Stopped, simulate};
use nalgebra::DMatrix;

fn run(problem: &Problem<'_>, settings: &FlowSettings) -> FlowSolution {
    let solution = Flow::new(problem, settings.clone()).run().expect("valid");
    assert_eq!(solution.failure, None);
    solution
}

fn swing_up(model: &Model) -> Problem<'_> {
    let n = model.dof();
    let mut start = vec![0.0; 2 * n];
    let mut goal = start.clone();
    start[0] = -std::f64::consts::FRAC_PI_2;
    goal[0] = std::f64::consts::FRAC_PI_2;
    Problem::new(model, start, goal, 2.0).expect("valid")
}

/// A curve whose velocity is the derivative of its configuration: `q(t) = c t^2 (T - t)` in every joint.
pub fn consistent(model: &Model, c: f64) -> Curve {
    let (n, horizon) = (model.dof(), 2.0);
    let chebyshev = Chebyshev::new(6, horizon).expect("valid");
    let x = DMatrix::from_fn(2 * n, 7, |row, node| {
        let t = chebyshev.times()[node];
        if row < n { c * t * t * (horizon - t) } else { c * t * (2.0 * horizon - 3.0 * t) }
    });
    Curve::new(chebyshev, x).expect("valid")
}

#[test]
fn the_flow_lowers_the_action_and_keeps_the_ends() {
    let model = robot("pendulum_2");
    let problem = swing_up(&model);
    let mut seen = Vec::new();
    let flow = Flow::new(&problem, FlowSettings::new(9, 1e5, 10.0));
    let flow = flow.observe(|record| seen.push(*record));
    let solution = flow.run().expect("valid");
    assert_eq!(solution.failure, None);
    assert_eq!(seen, solution.history);
    assert_eq!((seen[0].s, seen[1].s), (0.0, 1e-6));
    assert_eq!(seen.last().map(|r| r.s), Some(10.0));
    assert_eq!(seen.len(), 51);
    assert!(seen.windows(2).all(|w| w[0].s < w[1].s));
    // Decreasing from record to record, to the tolerance of the integrator.
    let falls = |w: &[FlowRecord]| w[1].action_at_nodes <= w[0].action_at_nodes * (1.0 + 1e-3);
    assert!(seen.windows(2).all(falls), "{seen:?}");
    assert!(seen[50].action_at_nodes < 0.1 * seen[0].action_at_nodes, "{seen:?}");
    let effort = effort_of(&model, &solution.curve, 1e5).expect("same robot");
    assert_close!(&[seen[50].action_at_nodes], &[effort.action_at_nodes], 1e-10);
    let x = solution.curve.x();
    assert_eq!(x.column(0).as_slice(), problem.start());
    assert_eq!(x.column(9).as_slice(), problem.goal());
}

/// At rest of the flow, Omega vanishes at the interior nodes.
#[test]
fn a_long_flow_comes_to_rest() {
    use aghf::flow::Collocation;
    use aghf::flow::{ControlForm, RightHandSide};
    let model = robot("pendulum_1");
    let problem = swing_up(&model);
    let tight = FlowSettings { tolerance: 1e-9, ..FlowSettings::new(8, 100.0, 1e3) };
    let curve = run(&problem, &tight).curve;
    let size = |x: &DMatrix<f64>| {
        let mut collocation =
            Collocation::<f64, f64>::new(curve.chebyshev(0), problem.start(), problem.goal()).expect("valid");
        let inner: Vec<f64> = x.columns_range(1..8).iter().copied().collect();
        collocation.set(&inner).expect("valid");
        let mut rates = vec![0.0; inner.len()];
        let mut rhs = ControlForm::new(&model);
        collocation.rates(&mut rhs, 100.0, &mut rates).expect("valid");
        let mut omega = vec![0.0; 2];
        rhs.omega(collocation.node(1), 100.0, &mut omega).expect("valid");
        assert_eq!(omega, rates[..2]);
        rates.iter().fold(0.0_f64, |m, r| m.max(r.abs()))
    };
    let (rest, guess) = (size(curve.x()), size(&problem.guess(Guess::LineConfiguration, curve.chebyshev(0))));
    assert!(rest < 1e-6 * guess, "{rest:e} {guess:e}");
}

#[test]
fn a_tighter_tolerance_changes_little() {
    let scenario = Scenario::load("kinova_free_01");
    let problem = scenario.problem();
    let at = |tolerance| run(&problem, &FlowSettings { tolerance, ..FlowSettings::new(9, 1e9, 0.1) });
    let (loose, tight, tighter) = (at(1e-4), at(1e-7), at(1e-8));
    assert!(loose.statistics.steps < tight.statistics.steps);
    let difference = |a: &FlowSolution, b: &FlowSolution| (a.curve.x() - b.curve.x()).amax();
    let (coarse, fine) = (difference(&loose, &tighter), difference(&tight, &tighter));
    assert!(coarse < 1e-4 && fine < 0.1 * coarse, "{coarse:e} {fine:e}");
}

#[test]
fn guesses_are_what_they_say() {
    let model = robot("pendulum_1");
    let problem = Problem::new(&model, vec![1.0, 4.0], vec![3.0, 8.0], 2.0).expect("valid");
    let chebyshev = Chebyshev::new(2, 2.0).expect("valid");
    let line = problem.guess(Guess::LineState, &chebyshev);
    assert_close!(&line, &DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 3.0, 4.0, 6.0, 8.0]), 1e-14);
    let slope = problem.guess(Guess::LineConfiguration, &chebyshev);
    assert_close!(&slope, &DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 3.0, 4.0, 1.0, 8.0]), 1e-14);
}

#[test]
fn measures_of_a_known_curve() {
    // A pendulum held level: u = 4.905, and v = 1 although it does not move.
    let model = robot("pendulum_1");
    let chebyshev = Chebyshev::new(4, 2.0).expect("valid");
    let x = DMatrix::from_fn(2, 5, |row, _| row as f64);
    let curve = Curve::new(chebyshev, x).expect("valid");
    let effort = effort_of(&model, &curve, 100.0).expect("same robot");
    assert!((effort.control_effort - 2.0 * 4.905_f64.powi(2)).abs() < 1e-10);
    assert!((effort.action - effort.control_effort - 200.0).abs() < 1e-10);
    assert!((effort.action_at_nodes - effort.action).abs() < 1e-10);
    assert!((effort.dynamics_defect - 1.0).abs() < 1e-12);
    assert!(effort_of(&model, &consistent(&model, 0.3), 1.0).expect("same robot").dynamics_defect < 1e-12);
}

/// A start so fast that its forces overflow: the error says where, and the curve is kept.
#[test]
fn a_flow_that_is_not_finite_says_where() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.5, 1.0, 1e200, 0.0], vec![0.0; 4], 2.0).expect("finite");
    let flow = Flow::new(&problem, FlowSettings::new(5, 1e3, 1.0));
    let solution = flow.run().expect("valid");
    let failure = solution.failure.expect("overflows");
    assert!(failure.contains("at s = 0e0: "), "{failure}");
    assert!(failure.contains("at node 1 "), "{failure}");
    assert_eq!(solution.stopped, None);
    assert_eq!(solution.curve.x().column(0).as_slice(), problem.start());
}

/// A penalty far too small for the duration of the flow: it stops early and keeps its last curve.
#[test]
fn a_flow_that_stops_on_the_way_keeps_its_last_curve() {
    let model = robot("pendulum_5");
    let problem = swing_up(&model);
    let flow = Flow::new(&problem, FlowSettings::new(15, 1e5, 100.0));
    let solution = flow.run().expect("valid");
    assert!(solution.failure.is_some() && solution.stopped.is_none());
    let s = solution.history.last().map_or(0.0, |r| r.s);
    assert!(s > 1.0 && s < 100.0, "{s}");
    assert!(solution.curve.x().iter().all(|x| x.is_finite()));
    assert!(solution.statistics.steps > 0);
}

#[test]
fn bad_problems_and_settings_are_errors() {
    let model = robot("pendulum_1");
    let (state, short) = (vec![0.0; 2], vec![0.0; 1]);
    let refused = |start: &[f64], goal: &[f64], horizon, words: &str| {
        let error = Problem::new(&model, start.to_vec(), goal.to_vec(), horizon).expect_err("bad");
        assert!(error.to_string().contains(words), "{error}");
    };
    refused(&short, &state, 1.0, "start: expected 2 entries, found 1");
    refused(&state, &[0.0, f64::NAN], 1.0, "goal: entry 1 is not a finite number");
    refused(&state, &state, -1.0, "horizon: it is -1");
    let problem = Problem::new(&model, state.clone(), state, 1.0).expect("valid");
    let bad = [
        (FlowSettings::new(1, 1.0, 1.0), "degree: it is 1"),
        (FlowSettings::new(5, 0.0, 1.0), "k: it is 0"),
        (FlowSettings::new(5, 1.0, f64::NAN), "s_max: it is NaN"),
        (FlowSettings { tolerance: -1.0, ..FlowSettings::new(5, 1.0, 1.0) }, "tolerance: it is -1"),
    ];
    for (settings, words) in bad {
        assert_refused(Flow::new(&problem, settings).run(), words);
    }
    let long = pendulum(26).expect("it has links");
    let (problem, settings) = (swing_up(&long), FlowSettings::new(200, 1.0, 1.0));
    let words = "degree: it is 200, with 26 joints 10348 unknowns; at most 10000";
    assert_refused(Flow::new(&problem, settings).run(), words);
    let other = robot("pendulum_2");
    let (curve, words) = (consistent(&model, 0.1), "expected 2 entries, found 1");
    assert_refused(simulate(&other, &curve, Feedback::NONE, &[]), words);
    assert_refused(effort_of(&other, &curve, 1.0), "x: expected 4 entries, found 2");
}

/// Acceptance: the flow ends at the same curve with each Jacobian, to the tolerance.
#[test]
fn every_jacobian_gives_the_same_curve() {
    for name in ["kinova_free_01", "digit_free_stretch"] {
        let scenario = Scenario::load(name);
        let problem = scenario.problem();
        let of = |key: &str| scenario.number(&format!("/flow/{key}"));
        let settings = FlowSettings::new(of("degree") as usize, of("k"), of("s_max"));
        let reference = run(&problem, &settings).curve;
        for (kind_name, kind) in JacobianKind::by_name() {
            let settings = FlowSettings { jacobian: kind, ..settings.clone() };
            let curve = run(&problem, &settings).curve;
            // The integrator's error test is relative to entries of up to about ten.
            let difference = (curve.x() - reference.x()).amax();
            println!("{name}, {kind_name}: {difference:e}");
            assert!(difference < 10.0 * FlowSettings::TOLERANCE, "{name}, {kind_name}: {difference:e}");
        }
    }
}

/// A time limit that has passed before the first step, and one that is never reached.
#[test]
fn a_flow_stops_at_its_time_limit_and_says_so() {
    use std::time::Duration;
    let model = robot("pendulum_2");
    let problem = swing_up(&model);
    let limited = |limit| FlowSettings { time_limit: Some(limit), ..FlowSettings::new(7, 1e5, 10.0) };
    let flow = Flow::new(&problem, limited(Duration::ZERO));
    let stopped = flow.run().expect("good input");
    assert_eq!(stopped.stopped, Some(Stopped::TimeLimit(Duration::ZERO)));
    assert_eq!(stopped.statistics.steps, 0);
    let words = "the flow stopped at s = 0e0: time limit of 0 s reached";
    assert_eq!(stopped.failure.as_deref(), Some(words));
    let guess = problem.guess(Default::default(), stopped.curve.chebyshev(0));
    assert_eq!(stopped.curve.x(), &guess, "nothing moved");

    let long = run(&problem, &limited(Duration::from_secs(3600)));
    let unlimited = run(&problem, &FlowSettings::new(7, 1e5, 10.0));
    assert_eq!(long.curve.x(), unlimited.curve.x(), "a clock changes nothing");
}

#[test]
fn a_flow_that_is_interrupted_keeps_its_curve() {
    let model = robot("pendulum_2");
    let problem = swing_up(&model);
    let settings = FlowSettings::new(7, 1e5, 10.0);
    let interrupt = settings.interrupt.clone();
    let flow = Flow::new(&problem, settings).observe(|record| {
        if record.s > 1e-3 {
            interrupt.raise();
        }
    });
    let stopped = flow.run().expect("good input");
    assert_eq!(stopped.stopped, Some(Stopped::Interrupt));
    let s = stopped.history.last().map_or(0.0, |r| r.s);
    assert!(s > 1e-3 && s < 10.0, "{s}");
    let words = format!("the flow stopped at s = {s:e}: interrupted");
    assert_eq!(stopped.failure, Some(words));
    let guess = problem.guess(Default::default(), stopped.curve.chebyshev(0));
    assert_ne!(stopped.curve.x(), &guess);
}
