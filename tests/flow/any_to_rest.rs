//! The flow of any Lagrangian to rest.

use crate::common::{assert_refused, robot};
use crate::rest::{FREE, beside, degree, rested, swing};
use aghf::curve::Curve;
use aghf::flow::AghfLagrangian;
use aghf::flow::rest::{AnyFlowToRest, AnyRestOptions, RestMetric, RestSettings};
use aghf::flow::weak::{AnalyticLagrangian, DualLagrangian, StateGrid};
use aghf::motion::{Interrupt, Problem, Stopped};
use std::time::Duration;

/// The guess of the flow to rest.
fn guess(problem: &Problem<'_>, segments: usize) -> Curve {
    let settings = RestSettings {
        time_limit: Some(Duration::ZERO),
        segments,
        ..degree(9)
    };
    rested(problem, &settings, 1e3, &FREE).curve
}

/// The same Lagrangian by dual numbers ends at the same curve, also without its convex part.
#[test]
fn any_lagrangian_comes_to_rest() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let grid = StateGrid::new(2, 7, 25, problem.horizon());
    let start = guess(&problem, 1);
    let mut records = 0;
    let options = AnyRestOptions::default();
    let analytic = AnalyticLagrangian::new(&model, 1e3);
    let analytic = AnyFlowToRest::new(&grid, analytic, &start).observe(|_| records += 1);
    let analytic = analytic.run().expect("valid");
    assert!(
        analytic.at_rest && records == analytic.steps,
        "{analytic:?} {records}"
    );
    for metric in [RestMetric::Action, RestMetric::Flow] {
        let options = AnyRestOptions {
            metric,
            ..options.clone()
        };
        let dual = DualLagrangian::new(&model, AghfLagrangian, 1e3);
        let dual = AnyFlowToRest::new(&grid, dual, &start).options(options.clone());
        let dual = dual.run().expect("valid");
        assert!(
            dual.at_rest && dual.gradient_norm <= options.tolerance && dual.steps > 1,
            "{dual:?}"
        );
        assert_close!(dual.curve.x(), analytic.curve.x(), 1e-6);
        assert!((dual.action - analytic.action).abs() < 1e-12 * analytic.action);
    }
    // It is where the flow to rest ends as well.
    let settings = RestSettings {
        segments: 2,
        duals: false,
        start: Some(beside(&analytic.curve)),
        ..degree(7)
    };
    let again = rested(&problem, &settings, 1e3, &FREE);
    assert!(again.at_rest && again.steps > 0, "{again:?}");
    assert_close!(again.curve.x(), analytic.curve.x(), 1e-6);

    let refused = |grid: &StateGrid<f64>, options: &AnyRestOptions, words: &str| {
        let lagrangian = AnalyticLagrangian::new(&model, 1e3);
        let flow = AnyFlowToRest::new(grid, lagrangian, &start).options(options.clone());
        assert_refused(flow.run(), words);
    };
    refused(&StateGrid::new(2, 7, 25, 1.0), &options, "horizon");
    refused(&StateGrid::new(1, 3, 25, 1.5), &options, "degree");
    for tolerance in [0.0, f64::NAN] {
        refused(
            &grid,
            &AnyRestOptions {
                tolerance,
                ..options.clone()
            },
            "tolerance",
        );
    }
    let other = robot("pendulum_3");
    let lagrangian = DualLagrangian::new(&other, AghfLagrangian, 1e3);
    assert_refused(
        AnyFlowToRest::new(&grid, lagrangian, &start).run(),
        "states",
    );
    let interrupt = Interrupt::default();
    interrupt.raise();
    let options = AnyRestOptions {
        interrupt,
        ..options
    };
    let lagrangian = AnalyticLagrangian::new(&model, 1e3);
    let flow = AnyFlowToRest::new(&grid, lagrangian, &start).options(options);
    let stopped = flow.run().expect("valid");
    assert_eq!(
        (stopped.stopped, stopped.at_rest, stopped.steps),
        (Some(Stopped::Interrupt), false, 0)
    );
}
