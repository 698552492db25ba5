//! Sweep files that are refused.

use crate::files::{FULL, GRID, load};
use aghf_cli::sweep::Sweep;

/// Asserts that a good text is refused with each of these faults, which are a text in it, its replacement and the words
/// of the refusal (between semicolons); an accepted text "is good".
fn assert_refused(test: &str, good: &str, faults: &[(&str, &str, &str)]) {
    let mut problems = Vec::new();
    for (from, to, words) in faults {
        assert!(good.contains(from), "{from}");
        let error = match load(test, &good.replace(from, to)) {
            Ok(_) => "grid.toml: it is good".to_owned(),
            Err(error) => error.to_string(),
        };
        let all = words.split("; ").all(|word| error.contains(word));
        if !(all && error.contains("grid.toml: ")) {
            problems.push(format!("{error}; want {words}"));
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

/// Faults of a sweep by the flow.
const OF_THE_FLOW: &[(&str, &str, &str)] = &[
    ("time_limit_s", "timeout", "grid.toml: timeout: it is no key of a sweep (; time_limit_s"),
    ("time_limit_s = 600", "", "grid.toml: sweep: ; missing field `time_limit_s`"),
    ("degree = [5, 7]", "degree = [5, 7", "grid.toml: line 6: "),
    ("degree = [5, 7]", "degree = [5, 7.5]", "grid.toml: degree[1]: ; 7.5"),
    ("degree = [5, 7]", "degree = [5, 1]", "grid.toml: degree[1]: it is 1 and must be at least 2"),
    ("degree = [5, 7]", "degree = []", "grid.toml: degree: it is an empty list"),
    ("degree = [5, 7]", "degree = [5, 7, 5]", "grid.toml: degree[2]: the value is there already"),
    ("1, 10", "1, 1.0", "grid.toml: s_max[1]: the value is there already"),
    ("1e3", "-1e3", "grid.toml: k[0]: it is -1000 and must be a positive"),
    ("1e3", "nan", "grid.toml: k[0]: it is NaN and must be a finite"),
    ("1e3", "\"much\"", "grid.toml: k[0]: ; \"much\""),
    ("600", "0", "grid.toml: time_limit_s: it is 0 and must be a positive"),
    ("600", "1e300", "grid.toml: time_limit_s: it is 1"),
    ("600", "600\nname = \"../up\"", "grid.toml: name: '../up'"),
    ("600", "600\nname = 3", "grid.toml: name: ; expected a string"),
    (
        "degree = [5, 7]",
        "degree = [5, 7]\np = [5]",
        "grid.toml: p: it is no key of a sweep (; no option of the method 'flow' (degree, k,",
    ),
    ("600", "600\nguess = [\"line_state\", \"circle\"]", "grid.toml: guess[1]: ; circle"),
    ("600", "600\nk_cons = [1e5]", "grid.toml: k_cons[0]: 'pendulum_2_swingup' has no constraints"),
    ("600", "600\nc_cons = [0]", "grid.toml: c_cons[0]: it is 0"),
    ("\"flow\"", "\"magic\"", "grid.toml: method: ; magic"),
    ("600", "600\nrobot = \"kinova_gen3\"", "grid.toml: scenarios[0]: ; robot: the scenario names its robot"),
    ("\"pendulum_2_swingup\"", "\"pendulum_x*\"", "grid.toml: scenarios[0]: no built-in scenario matches"),
    ("\"pendulum_2_swingup\"", "\"no.json\"", "grid.toml: scenarios[0]: ; no.json; neither"),
    ("\"pendulum_2_swingup\"", "\"pendulum_3*\"", "grid.toml: scenarios[1]: 'pendulum_3_swingup' is there"),
];

#[test]
fn bad_sweep_files_are_refused_by_name_and_key() {
    assert_refused("bad", GRID, OF_THE_FLOW);
    let error = Sweep::load("table_99").expect_err("there is none").to_string();
    assert!(error.starts_with("table_99: sweep: there is neither"), "{error}");
}

/// Faults of a sweep by the direct method.
const OF_THE_DIRECT_METHOD: &[(&str, &str, &str)] = &[
    ("600", "600\nk = [1]", "k: it is no key of a sweep (; no option of the method 'direct' (degree, segments,"),
    ("600", "600\np = [9]", "p: it is no key of a sweep"),
    ("600", "600\nwaves = [9]", "waves: it is no key of a sweep"),
    ("[9, 16]", "[9, 65]", "degree[1]: it is 65 and must be at least 4 and at most 64"),
    ("[9, 16]", "[9, 16, 9]", "degree[2]: the value is there already"),
    ("[9, 16]", "[9, -1]", "degree[1]: ; -1"),
    ("[9, 16]", "[]", "degree: it is an empty list"),
    ("segments = [1, 2]", "segments = [1, 17]", "segments[1]: it is 17 and must be ; degree 16"),
    ("segments = [1, 2]", "segments = [0]", "segments[0]: it is 0"),
    ("starts = [1, 3]", "starts = [1, 0]", "starts[1]: it is 0 and must be at least 1"),
    ("[1e-6]", "[0]", "tolerance[0]: it is 0 and must be a positive number"),
    ("seed = [7, 8]", "seed = [7, 7]", "seed[1]: the value is there already"),
    ("seed = [7, 8]", "seed = [-7]", "seed[0]: ; -7"),
    ("[0.5]", "[-0.5]", "objective.velocity[0]: it is -0.5, a weight"),
    ("[0.5]", "[inf]", "objective.velocity[0]: it is inf and must be a finite"),
    ("velocity = [0.5]", "speed = [0.5]", "objective.speed[0]: unknown field `speed`"),
    ("position = [true]", "position = [0.0]", "enforced_limits.position[0]: it is 0, a share"),
    ("position = [true]", "position = [2]", "enforced_limits.position[0]: it is 2, a share"),
    ("position = [true]", "position = [true, true]", "enforced_limits.position[1]: the value"),
    ("position = [true]", "position = [\"all\"]", "enforced_limits.position[0]: true, false"),
    ("position = [true]", "position = [{ joints = [\"joint_1\"] }]", "it is good"),
    (
        "effort = [0, 1], velocity = [0.5], acceleration = [0.1, 2] }",
        "effort = [0, 1], velocity = [1, 0], acceleration = [0] }",
        "objective: ; all are zero",
    ),
    ("\"kinova_obstacles_01\"", "\"kinova_cross_01\"", "it is good"),
    (
        "\"kinova_obstacles_01\"]",
        "\"kinova_cross_01\"]\nrobot = \"kinova_gen3\"",
        "scenarios[0]: ; robot: scenarios 'kinova_cross' are for kinova_gen3 alone",
    ),
    ("\"kinova_obstacles_01\"]", "\"limits_01\"]\nrobot = \"no.urdf\"", "scenarios[0]: ; robot: ; no.urdf"),
];

#[test]
fn bad_sweeps_of_the_direct_method_are_refused_by_name_and_key() {
    assert_refused("bad_direct", FULL, OF_THE_DIRECT_METHOD);
    // So many numbers of starts that the grid is too large.
    let many: Vec<_> = (1..=10_000).map(|n: usize| n.to_string()).collect();
    let many = format!("starts = [{}]", many.join(", "));
    let words = "sweep: the grid has more than 1000000 sets";
    assert_refused("bad_direct", FULL, &[("starts = [1, 3]", &many, words)]);
}
