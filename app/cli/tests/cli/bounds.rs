//! Numbers that are too large or too small for `aghf`: refused by name, with their bounds, before anything is done.

use crate::command::{assert_bad_input, empty_folder, files};
use serde_json::{Value, json};

/// The largest number that an option can hold.
const LARGEST: &str = "18446744073709551615";

#[test]
fn counts_and_times_have_bounds() {
    let folder = empty_folder("bounds");
    let pendulum = "pendulum_1_swingup";
    for (command, option, name, most) in [
        (&["solve", pendulum][..], "--starts", "starts", "100000"),
        (&["solve", pendulum], "--threads", "threads", "1024"),
        (&["check", "pendulum_1"], "--samples", "samples", "100000"),
        (&["prove"], "--points", "points", "1000"),
        (&["sweep", "table_10_quick"], "--jobs", "jobs", "1024"),
    ] {
        let above = (most.parse::<u64>().expect("a number") + 1).to_string();
        for value in ["0", &above, LARGEST] {
            let words = format!("{name}: it is {value}, at least 1 and at most {most} is needed");
            let arguments = [command, &[option, value]].concat();
            assert_bad_input(&folder, &arguments, &words);
        }
    }
    for method in ["relax", "flow"] {
        let arguments = [
            "solve",
            pendulum,
            "--method",
            method,
            "--time-limit-s",
            "1e9",
        ];
        assert_bad_input(
            &folder,
            &arguments,
            "time_limit_s: it is 1e9, at least 0 and at most 31536000 s",
        );
    }
    let left = files(&folder);
    let of_solves =
        |file: &&String| !file.starts_with("out/sweeps") && !file.starts_with("out/rep");
    assert_eq!(left.iter().find(of_solves), None);
}

/// A scenario in which some keys are others.
fn scenario(keys: Value) -> String {
    let mut scenario = json!({
        "robot": "pendulum_2", "horizon_s": 2.0, "q_start": [0, 0], "v_start": [0, 0], "q_goal": [1, 0], "v_goal": [0, 0]
    });
    for (key, value) in keys.as_object().expect("it is one") {
        scenario[key] = value.clone();
    }
    scenario.to_string()
}

#[test]
fn sizes_in_a_scenario_have_bounds() {
    let folder = empty_folder("scenario_bounds");
    let horizon = "a positive time of at least 1e-6 s and at most 31536000 s";
    let sphere = json!({"center_m": [5, 5, 5], "radius_m": 0.1});
    let swept = |spacing: f64| json!({"swept_links": {"radius_m": 0.05, "spacing_m": spacing}});
    for (keys, words) in [
        (
            json!({"horizon_s": 1e300}),
            format!("horizon_s: it is 1e300, ; {horizon}"),
        ),
        (
            json!({"horizon_s": 1e-300}),
            format!("horizon_s: it is 1e-300, ; {horizon}"),
        ),
        (
            json!({"horizon_s": 9e-7}),
            format!("horizon_s: it is 9e-7, ; {horizon}"),
        ),
        (
            json!({"horizon_s": 3.2e7}),
            format!("horizon_s: it is 32000000, ; {horizon}"),
        ),
        (
            json!({"free_horizon": {"shortest_s": 1e-9, "longest_s": 3, "weight": 1}}),
            format!("free_horizon.shortest_s: it is 1e-9, ; {horizon}"),
        ),
        (
            json!({"free_horizon": {"shortest_s": 1, "longest_s": 1e300, "weight": 1}}),
            format!("free_horizon.longest_s: it is 1e300, ; {horizon}"),
        ),
        (
            json!({"sphere_obstacles": [sphere], "robot_shape": swept(1e-6)}),
            "robot_shape.swept_links.spacing_m: it is 1e-6, ; 1000002 balls; at most 10000"
                .to_owned(),
        ),
        (
            json!({"sphere_obstacles": [sphere], "robot_shape": swept(1e-300)}),
            "robot_shape.swept_links.spacing_m: it is 1e-300, ; at most 10000".to_owned(),
        ),
        (
            json!({"sphere_obstacles": vec![sphere; 100], "robot_shape": swept(1e-3)}),
            "sphere_obstacles: 100 obstacles and 1002 balls; 50000".to_owned(),
        ),
        (
            json!({"sphere_obstacles": [{"center_m": [1e300, 0, 0], "radius_m": 1e300}]}),
            "sphere_obstacles[0]: ; no number above 1000000 m".to_owned(),
        ),
        (
            json!({"half_spaces": [{"normal": [0, 0, 1], "offset_m": 1e7}]}),
            "half_spaces[0]: ; at most 1000000 m".to_owned(),
        ),
    ] {
        std::fs::write(folder.join("s.json"), scenario(keys)).expect("writable");
        assert_bad_input(&folder, &["solve", "s.json"], &format!("s.json: {words}"));
    }
}

#[test]
fn lists_of_a_sweep_have_bounds() {
    let folder = empty_folder("sweep_bounds");
    let list = |count: usize| {
        let values: Vec<_> = (1..=count).map(|i| format!("{i}.0")).collect();
        values.join(", ")
    };
    let (long, longer) = (list(2000), list(10_001));
    let costs =
        format!("[running_cost]\ntorque = [{long}]\nvelocity = [{long}]\nacceleration = [{long}]");
    for (keys, words) in [
        (
            "starts = [100001]".to_owned(),
            "starts[0]: it is 100001, at least 1 and at most 100000",
        ),
        (
            format!("tolerance = [{longer}]"),
            "tolerance: it has 10001 values, at most 10000",
        ),
        (costs, "sweep: the grid has more than 1000000 sets"),
        (
            "running_cost = [[1.0], [0.1], [0.2]]".to_owned(),
            "running_cost[0]: it is a list, not an object",
        ),
    ] {
        let text =
            format!("method = 'relax'\nscenarios = ['pendulum_*']\ntime_limit_s = 1\n{keys}\n");
        std::fs::write(folder.join("s.toml"), text).expect("writable");
        assert_bad_input(&folder, &["sweep", "s.toml"], &format!("s.toml: {words}"));
    }
    let text = "method = 'flow'\nscenarios = ['pendulum_*']\ntime_limit_s = 1e300\ndegree = [4]\nk = [1e5]\ns_max = [1]\n";
    std::fs::write(folder.join("s.toml"), text).expect("writable");
    let words = "s.toml: time_limit_s: it is 1e300, ; at most 31536000 s";
    assert_bad_input(&folder, &["sweep", "s.toml"], words);
}

/// A file that has no end is not read to its end.
#[test]
#[cfg(unix)]
fn texts_without_end_are_refused() {
    let folder = empty_folder("endless");
    for arguments in [
        &["solve", "/dev/zero"][..],
        &["robots", "/dev/zero"],
        &["sweep", "/dev/zero"],
        &["eval", "pendulum_1", "/dev/zero"],
    ] {
        assert_bad_input(&folder, arguments, "aghf: /dev/zero: ; more than 64 MiB");
    }
}
