//! Generated scenarios: the line between their ends hits something, the ends are free, and a seed always makes the
//! same.

use aghf::constraint::{AnyConstraint, CollisionSphere, SphereClearance};
use aghf::geometry::Capsule;
use aghf_scenario::{FAMILIES, RobotShape, Scenario, ScenarioFile, generate, generated_scenarios};
use rayon::prelude::*;
use std::sync::LazyLock;

/// All that are listed, generated once for several tests.
pub static LISTED: LazyLock<Vec<(String, Scenario)>> = LazyLock::new(|| {
    let names: Vec<String> = generated_scenarios().collect();
    let generated = names.into_par_iter().map(|name| {
        let scenario = Scenario::load(&name).expect("it can be generated");
        (name, scenario)
    });
    generated.collect()
});

/// The smallest clearance of configurations, m.
fn clearance(scenario: &Scenario, configurations: &[Vec<f64>]) -> f64 {
    let configurations = configurations.iter().map(Vec::as_slice);
    let smallest = scenario.smallest_clearance(configurations);
    smallest.expect("it is the robot's").expect("there are obstacles")
}

#[test]
fn every_line_hits_something_between_free_ends() {
    let mut names = 0;
    let without = |name: &String| {
        let number = name.strip_prefix("limits_");
        number.is_some_and(|n| n.parse::<u64>().is_ok())
    };
    for (name, scenario) in LISTED.iter().filter(|(name, _)| !without(name)) {
        let ScenarioFile { q_start, q_goal, .. } = &scenario.file;
        let at = |t: f64| -> Vec<f64> {
            let both = q_start.iter().zip(q_goal);
            both.map(|(start, goal)| start + (goal - start) * t).collect()
        };
        let line: Vec<_> = (0..=100).map(|i| at(f64::from(i) / 100.0)).collect();
        // The generator asks for 2 cm on a coarser grid.
        assert!(clearance(scenario, &line) < -0.02, "{name}: the line hits nothing");
        let ends = [q_start.clone(), q_goal.clone()];
        assert!(clearance(scenario, &ends) > 0.029, "{name}: an end is not free");
        assert_eq!(scenario.outside_limits(), Vec::<String>::new(), "{name}");
        names += 1;
    }
    // One family has no obstacles.
    assert_eq!(names, 10 * (FAMILIES.len() - 1));
}

/// Capsules that share a ball leave the larger one.
#[test]
fn the_balls_of_a_scenario_cover_its_links() {
    for name in ["kinova_cross_01", "digit_box_01"] {
        let scenario = Scenario::load(name).expect("it can be generated");
        let constraints = scenario.state_constraints();
        let [AnyConstraint::Spheres(SphereClearance { balls, .. }), ..] = &constraints[..] else {
            panic!("{name}: {constraints:?}");
        };
        let Some(RobotShape::SweptLinks { radius_m, spacing_m }) = scenario.file.robot_shape else {
            panic!("{name}: the whole robot is meant");
        };
        let mut shared = 0;
        for capsule in Capsule::along_links(&scenario.model, radius_m) {
            for ball in capsule.balls(spacing_m).expect("positive") {
                let there = |b: &CollisionSphere| (b.body, b.centre) == (ball.body, ball.centre);
                let known: Vec<_> = balls.iter().filter(|b| there(b)).collect();
                assert_eq!(known.len(), 1, "{name}");
                assert!(known[0].radius >= ball.radius, "{name}");
                shared += usize::from(known[0].radius > ball.radius);
            }
        }
        println!("{name}: {shared} shared");
        assert!(shared > 0 || name.starts_with("kinova"), "{name}");
    }
}

#[test]
fn the_name_decides() {
    let file = |name: &str| generate(name).map(|made| made.expect("it can be generated"));
    assert_eq!(file("kinova_gap_07"), file("kinova_gap_7"));
    assert_ne!(file("kinova_gap_07"), file("kinova_gap_08"));
    assert!(file("kinova_gap_123456").is_some());
    for unknown in ["kinova_gap", "kinova_gap_x", "kinova_gap_-1", "kinova_free_01", "_1", ""] {
        assert_eq!(file(unknown), None, "{unknown}");
    }
}

#[test]
fn a_generated_scenario_survives_its_file() {
    for family in &FAMILIES {
        let name = format!("{}_01", family.name);
        let made = Scenario::load(&name).expect("it can be generated");
        let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.json"));
        let text = serde_json::to_string(&made.file).expect("it is JSON");
        std::fs::write(&path, text).expect("the folder is writable");
        let read = Scenario::load(path.to_str().expect("it is text")).expect("it is good");
        assert_eq!(read.file, made.file);
    }
}
