//! Phases of a walk with durations of their own.

use crate::phases::walk;
use crate::written::load;
use aghf::motion::sample;
use aghf_scenario::judge::{Tolerances, Trajectory, judge};
use aghf_scenario::{DirectOptions, Solve, Verdict};

/// Where phases have durations of their own each is an unknown: the effort is less than with equal ones, and more with
/// durations beside the best one. The parts are ordinary motions of these durations.
#[test]
fn phases_last_as_long_as_is_best() {
    let lasting = |durations: [[f64; 2]; 2], horizon: f64| {
        let mut file = walk();
        file["horizon_s"] = horizon.into();
        for (k, [shortest, longest]) in durations.into_iter().enumerate() {
            file["phases"][k]["shortest_s"] = shortest.into();
            file["phases"][k]["longest_s"] = longest.into();
        }
        let scenario = load("durations", &file).expect("it is good");
        let options = DirectOptions { starts: Some(1), ..DirectOptions::default() };
        let found = Solve::new(&scenario).options(options).run_walk().expect("it is good");
        assert!(found.is_valid());
        for (phase, report) in &found.phases {
            assert_eq!(report.summary.verdict, Verdict::Optimal);
            let motion = Trajectory::of_samples(sample(&phase.model, &report.curve, 2000).expect("its joints"));
            let judged = judge(phase, &motion, Tolerances::default()).expect("its joints");
            assert!(judged.checks.iter().all(|row| row.outcome.is_good()));
        }
        let lasted = [0, 1].map(|k| found.phases[k].1.curve.horizon());
        assert!((found.landings[0].time_s - lasted[0]).abs() < 1e-12);
        let efforts = found.phases.iter().map(|(_, of)| of.summary.control_effort);
        (efforts.sum::<f64>(), lasted)
    };
    let (equal, lasted) = lasting([[1.0; 2]; 2], 2.0);
    assert_eq!(lasted, [1.0; 2]);
    let (both, lasted) = lasting([[0.5, 1.2]; 2], 2.0);
    // To stand costs effort, so both are as short as they may be.
    assert!(lasted.iter().all(|of| (of - 0.5).abs() < 1e-5), "{lasted:?}");
    let (best, [first, second]) = lasting([[0.25, 2.5], [0.5; 2]], 0.775);
    assert!(best < both && both < equal, "{best}, {both} and {equal}");
    assert!(first > 0.3 && (second - 0.5).abs() < 1e-12, "{first}");
    for change in [1.25, 0.8] {
        let (effort, found) = lasting([[change * first; 2], [0.5; 2]], change * first + 0.5);
        assert!((found[0] - change * first).abs() < 1e-12);
        assert!(effort > best, "{change}: {effort} and {best}");
    }
}
