//! Refusals of a flow to rest, and its end on request.

use super::{FREE, degree, rested, swing};
use crate::common::{assert_refused, robot};
use aghf::constraint::{Constraints, TorqueLimits};
use aghf::cost::ControlEffort;
use aghf::flow::rest::{FlowToRest, RestSettings};
use aghf::motion::{Interrupt, Stopped};
use std::time::Duration;

#[test]
fn settings_that_make_no_sense_are_refused() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let refused = |settings: &RestSettings, words: &str| {
        let flow = FlowToRest::new(&problem, 1e3).settings(settings.clone());
        assert_refused(flow.run(), words);
    };
    refused(&degree(3), "degree");
    refused(&degree(65), "degree");
    let changed = |change: &dyn Fn(&mut RestSettings), words: &str| {
        let mut settings = degree(9);
        change(&mut settings);
        refused(&settings, words);
    };
    for segments in [0, 33] {
        let many = RestSettings { segments, ..degree(16) };
        refused(&many, "segments");
    }
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        changed(&|s| s.tolerance = wrong, "tolerance");
        changed(&|s| s.feasible = wrong, "feasible");
    }
    changed(&|s| s.starts = 0, "starts");
    changed(&|s| s.iterations = 0, "iterations");
    let other = robot("pendulum_1");
    let start = rested(&swing(&other), &degree(6), 1e3, &FREE).curve;
    changed(&|s| s.start = Some(start.clone()), "start");
    let longer = problem.with_horizon(3.0 * problem.horizon()).expect("valid");
    let start = rested(&longer, &degree(6), 1e3, &FREE).curve;
    let words = "settings: start: it does not go";
    changed(&|s| s.start = Some(start.clone()), words);
    let flow = FlowToRest::new(&problem, 1e3).cost(ControlEffort::new(&other));
    assert_refused(flow.settings(degree(9)).run(), "entries");
    for k in [0.0, f64::INFINITY] {
        assert_refused(FlowToRest::new(&problem, k).run(), "k");
    }
    let limits = Constraints { state: (), torque: TorqueLimits(vec![Some(1.0)]), stage: Default::default() };
    let flow = FlowToRest::new(&problem, 1e3).settings(degree(9));
    assert_refused(flow.constraints(&limits).run(), "entries");
}

/// A stopped flow returns its current curve and the reason.
#[test]
fn it_stops_when_asked_to() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let limit = Duration::ZERO;
    let late = RestSettings { time_limit: Some(limit), ..degree(9) };
    let solution = rested(&problem, &late, 1e3, &FREE);
    assert_eq!((solution.stopped, solution.at_rest), (Some(Stopped::TimeLimit(limit)), false));
    assert_close!(&solution.curve.at(0.0).0, problem.start(), 1e-12);

    let interrupt = Interrupt::default();
    let settings = RestSettings { interrupt: interrupt.clone(), ..degree(9) };
    let mut seen = 0;
    let flow = FlowToRest::new(&problem, 1e3).settings(settings);
    let flow = flow.observe(|_| {
        seen += 1;
        if seen == 3 {
            interrupt.raise();
        }
    });
    let solution = flow.run().expect("valid");
    assert_eq!((solution.stopped, solution.at_rest, seen), (Some(Stopped::Interrupt), false, 3));
}
