//! Refusals of a flow to rest, and its end on request.

use crate::common::{assert_refused, robot};
use crate::rest::{FREE, degree, rested, swing};
use aghf::constraint::{Constraints, TorqueLimits};
use aghf::flow::rest::{FlowToRest, RestSettings};
use aghf::flow::weak::AnalyticLagrangian;
use aghf::motion::{Interrupt, Stopped};
use std::time::Duration;

#[test]
fn settings_that_make_no_sense_are_refused() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let refused = |settings: &RestSettings, words: &str| {
        let lagrangian = AnalyticLagrangian::new(&model, 1e3);
        let flow = FlowToRest::new(&problem, &lagrangian).settings(settings.clone());
        assert_refused(flow.run(), words);
    };
    refused(&degree(3), "degree");
    refused(&degree(65), "degree");
    for segments in [0, 33] {
        refused(
            &RestSettings {
                segments,
                ..degree(16)
            },
            "segments",
        );
    }
    refused(
        &RestSettings {
            starts: 0,
            ..degree(9)
        },
        "starts",
    );
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(
            &RestSettings {
                tolerance: wrong,
                ..degree(9)
            },
            "tolerance",
        );
        refused(
            &RestSettings {
                feasible: wrong,
                ..degree(9)
            },
            "feasible",
        );
    }
    let other = robot("pendulum_1");
    let start = rested(&swing(&other), &degree(6), 1e3, &FREE).curve;
    let start = RestSettings {
        start: Some(start),
        ..degree(9)
    };
    refused(&start, "start");
    let longer = problem
        .with_horizon(3.0 * problem.horizon())
        .expect("valid");
    let start = RestSettings {
        start: Some(rested(&longer, &degree(6), 1e3, &FREE).curve),
        ..degree(9)
    };
    refused(&start, "settings: start: it does not go");
    for (steps, rounds, words) in [(0, 1, "steps"), (1, 0, "rounds")] {
        let settings = RestSettings {
            steps,
            rounds,
            ..degree(9)
        };
        refused(&settings, words);
    }
    let lagrangian = AnalyticLagrangian::new(&other, 1e3);
    let flow = FlowToRest::new(&problem, &lagrangian).settings(degree(9));
    assert_refused(flow.run(), "entries");
    let limits = Constraints {
        state: (),
        torque: TorqueLimits(vec![Some(1.0)]),
        stage: Default::default(),
    };
    let lagrangian = AnalyticLagrangian::new(&model, 1e3);
    let flow = FlowToRest::new(&problem, &lagrangian).settings(degree(9));
    assert_refused(flow.constraints(&limits).run(), "entries");
}

/// A stopped flow returns its current curve and the reason.
#[test]
fn it_stops_when_asked_to() {
    let model = robot("pendulum_2");
    let problem = swing(&model);
    let limit = Duration::ZERO;
    let late = RestSettings {
        time_limit: Some(limit),
        ..degree(9)
    };
    let solution = rested(&problem, &late, 1e3, &FREE);
    assert_eq!(
        (solution.stopped, solution.at_rest),
        (Some(Stopped::TimeLimit(limit)), false)
    );
    assert_close!(&solution.curve.at(0.0).0, problem.start(), 1e-12);

    let interrupt = Interrupt::default();
    let settings = RestSettings {
        interrupt: interrupt.clone(),
        ..degree(9)
    };
    let lagrangian = AnalyticLagrangian::new(&model, 1e3);
    let mut seen = 0;
    let flow = FlowToRest::new(&problem, &lagrangian).settings(settings);
    let flow = flow.observe(|_| {
        seen += 1;
        if seen == 3 {
            interrupt.raise();
        }
    });
    let solution = flow.run().expect("valid");
    assert_eq!(
        (solution.stopped, solution.at_rest, seen),
        (Some(Stopped::Interrupt), false, 3)
    );
}
