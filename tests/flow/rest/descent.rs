//! The flow of any Lagrangian to rest.

use super::{FREE, degree, moved, rested, swing};
use crate::common::{assert_refused, robot};
use aghf::curve::Curve;
use aghf::flow::AghfLagrangian;
use aghf::flow::rest::{LagrangianDescent, LagrangianDescentOptions, RestMetric, RestSettings};
use aghf::motion::{Interrupt, Problem, Stopped};
use std::time::Duration;

/// The guess of the flow to rest.
fn guess(problem: &Problem<'_>, segments: usize) -> Curve {
    let settings = RestSettings { time_limit: Some(Duration::ZERO), segments, ..degree(9) };
    rested(problem, &settings, 1e3, &FREE).curve
}

/// In either metric the paper's Lagrangian ends at the same curve, which is where the flow of the effort ends.
#[test]
fn any_lagrangian_comes_to_rest() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let start = guess(&problem, 1);
    let options = LagrangianDescentOptions { segments: 2, degree: 7, ..LagrangianDescentOptions::default() };
    let mut found = Vec::new();
    for metric in [RestMetric::Velocity, RestMetric::Flow] {
        let options = LagrangianDescentOptions { metric, ..options.clone() };
        let tolerance = options.tolerance;
        let mut records = 0;
        let flow =
            LagrangianDescent::new(&model, AghfLagrangian, 1e3, &start).options(options).observe(|_| records += 1);
        let dual = flow.run().expect("valid");
        assert!(dual.at_rest && dual.gradient_norm <= tolerance && dual.steps > 1, "{dual:?}");
        assert_eq!(records, dual.steps);
        found.push(dual);
    }
    let [first, second] = &found[..] else {
        panic!("{found:?}");
    };
    assert_close!(first.curve.x(), second.curve.x(), 1e-6);
    assert!((first.action - second.action).abs() < 1e-12 * first.action);
    let settings = RestSettings { segments: 2, duals: false, start: Some(moved(&first.curve, 1e-3)), ..degree(7) };
    let again = rested(&problem, &settings, 1e3, &FREE);
    assert!(again.at_rest && again.steps > 0, "{again:?}");
    assert_close!(again.curve.x(), first.curve.x(), 1e-5);
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let start = guess(&problem, 1);
    let options = LagrangianDescentOptions::default();
    let refused = |options: LagrangianDescentOptions, words: &str| {
        let flow = LagrangianDescent::new(&model, AghfLagrangian, 1e3, &start).options(options);
        assert_refused(flow.run(), words);
    };
    for (segments, degree, points, words) in
        [(1, 3, None, "degree"), (33, 16, None, "segments"), (1, 16, Some(0), "points")]
    {
        refused(LagrangianDescentOptions { segments, degree, points, ..options.clone() }, words);
    }
    for tolerance in [0.0, f64::NAN] {
        refused(LagrangianDescentOptions { tolerance, ..options.clone() }, "tolerance");
    }
    let flow = LagrangianDescent::new(&model, AghfLagrangian, f64::NAN, &start);
    assert_refused(flow.run(), "k");
    let other = robot("pendulum_3");
    let flow = LagrangianDescent::new(&other, AghfLagrangian, 1e3, &start);
    assert_refused(flow.run(), "curve");
    let interrupt = Interrupt::default();
    interrupt.raise();
    let options = LagrangianDescentOptions { interrupt, ..options };
    let flow = LagrangianDescent::new(&model, AghfLagrangian, 1e3, &start).options(options);
    let stopped = flow.run().expect("valid");
    assert_eq!((stopped.stopped, stopped.at_rest, stopped.steps), (Some(Stopped::Interrupt), false, 0));
}
