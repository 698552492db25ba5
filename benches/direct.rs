//! The direct method of whole scenarios with the defaults, multi-start included.
//!
//! `cargo bench --bench direct` measures and prints the medians in microseconds at the end.

mod common;

use aghf_scenario::{Scenario, Solve, SolveOptions};
use common::{Times, criterion, measure, report};

const SCENARIOS: [&str; 4] = ["pendulum_5_swingup", "kinova_free_01", "kinova_obstacles_01", "digit_free_stretch"];

fn main() {
    let mut criterion = criterion().sample_size(10);
    let mut times = Times::new();
    for name in SCENARIOS {
        let scenario = Scenario::load(name).expect("built in");
        let (n, options) = (scenario.model.dof(), SolveOptions::default());
        measure(&mut criterion, &mut times, name, n, || {
            Solve::new(&scenario).options(options.clone()).run().expect("good input");
        });
    }
    criterion.final_summary();
    report(&mut times);
}
