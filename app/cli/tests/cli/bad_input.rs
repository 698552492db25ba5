//! The answers of `aghf solve` to bad input: exit code 2, a message that names file and key, no files.

use crate::command::{aghf, assert_bad_input, empty_folder, files, parsed};
use serde_json::json;

#[test]
fn bad_scenarios_exit_with_2() {
    let folder = empty_folder("bad_scenarios");
    assert_bad_input(
        &folder,
        &["solve", "kinova_free_99"],
        "kinova_free_99; neither a file nor a built-in scenario",
    );
    std::fs::write(folder.join("bad.json"), "{ \"robot\": \n }").expect("writable");
    assert_bad_input(&folder, &["solve", "bad.json"], "aghf: bad.json: ; line 2");
    std::fs::write(
        folder.join("short.json"),
        r#"{"robot": "pendulum_1", "horizon_s": 1}"#,
    )
    .expect("writable");
    assert_bad_input(
        &folder,
        &["solve", "short.json"],
        "aghf: short.json: ; missing field `q_start`",
    );
    let mut long = json!({ "robot": "pendulum_1", "horizon_s": 1.0 });
    for key in ["q_start", "v_start", "v_goal"] {
        long[key] = json!([0.0]);
    }
    long["q_goal"] = json!([1.0, 2.0]);
    std::fs::write(folder.join("long.json"), long.to_string()).expect("writable");
    assert_bad_input(
        &folder,
        &["solve", "long.json"],
        "aghf: long.json: q_goal: ; 1 joints; 2 values",
    );
    assert_bad_input(&folder, &["dance"], "dance");
    assert_eq!(files(&folder).len(), 3, "nothing is written");
}

#[test]
fn a_robot_is_chosen_for_generated_scenarios_alone() {
    let folder = empty_folder("chosen_robot");
    let run = aghf(
        &folder,
        &["scenarios", "limits_02", "--robot", "pendulum_3"],
    );
    assert_eq!(parsed(&run)["robot"], "pendulum_3");
    std::fs::write(folder.join("some.json"), run.stdout).expect("writable");
    for command in ["solve", "scenarios"] {
        for (scenario, words) in [
            ("some.json", "some.json: robot: ; names its robot"),
            ("kinova_free_01", "kinova_free_01: robot: ; names its robot"),
            ("kinova_gap_01", "kinova_gap_01: robot: ; kinova_gen3 alone"),
        ] {
            let arguments = [command, scenario, "--robot", "pendulum_2"];
            assert_bad_input(&folder, &arguments, words);
        }
        let arguments = [command, "limits_01", "--mimic", "maybe"];
        assert_bad_input(&folder, &arguments, "--mimic; 'maybe'; independent");
    }
    assert_bad_input(&folder, &["scenarios", "--robot", "pendulum_2"], "SCENARIO");
    assert_eq!(files(&folder).len(), 1, "nothing is written");
}

#[test]
fn bad_options_exit_with_2() {
    let folder = empty_folder("bad_options");
    for (option, value, words) in [
        ("--degree", "0", "degree: it is 0; at least 2"),
        ("--degree", "1", "degree: it is 1; at least 2"),
        ("--degree", "x", "--degree; invalid value 'x'"),
        ("--k", "0", "k: it is 0; positive"),
        ("--k", "1e999", "--k; it is inf; finite"),
        ("--s-max", "nan", "--s-max; it is NaN; finite"),
        ("--s-max", "inf", "--s-max; it is inf; finite"),
        ("--tolerance", "0", "tolerance: it is 0; positive"),
        ("--jacobian", "magic", "--jacobian; 'magic'; dual"),
        ("--guess", "circle", "--guess; 'circle'; line_state"),
        (
            "--integrator",
            "magic",
            "--integrator; 'magic'; bdf; esdirk34",
        ),
    ] {
        assert_bad_input(
            &folder,
            &[
                "solve",
                "pendulum_1_swingup",
                "--method",
                "flow",
                option,
                value,
            ],
            words,
        );
    }
    for (option, value, words) in [
        ("--method", "magic", "--method; 'magic'; relax; flow"),
        ("--degree", "3", "degree: it is 3; at least 4"),
        ("--starts", "0", "starts: it is 0; at least 1"),
        ("--segments", "0", "segments: it is 0; at least 1"),
        ("--segments", "17", "segments: it is 17; at most 16"),
        (
            "--degree-tolerance",
            "0",
            "degree_tolerance: it is 0; positive",
        ),
        (
            "--degree-tolerance",
            "-1",
            "degree_tolerance: it is -1; positive",
        ),
        ("--tolerance", "0", "tolerance: it is 0; positive"),
        ("--k", "1e5", "options: k: unknown field `k`; `degree`"),
        (
            "--integrator",
            "esdirk34",
            "options: integrator: unknown field; `degree`",
        ),
    ] {
        assert_bad_input(
            &folder,
            &["solve", "pendulum_1_swingup", option, value],
            words,
        );
    }
    for (option, value) in [("--segments", "2"), ("--degree-tolerance", "0.1")] {
        let arguments = [
            "solve",
            "pendulum_1_swingup",
            "--method=flow",
            option,
            value,
        ];
        assert_bad_input(
            &folder,
            &arguments,
            "options: ; unknown field; `integrator`",
        );
    }
    assert!(files(&folder).is_empty(), "nothing is written");
}

#[test]
fn negative_options_are_told_from_other_options() {
    let folder = empty_folder("negative_options");
    for (option, words) in [
        ("--k", "k: it is -1; positive"),
        ("--s-max", "s_max: it is -1; positive"),
        ("--tolerance", "tolerance: it is -1; positive"),
    ] {
        assert_bad_input(
            &folder,
            &[
                "solve",
                "pendulum_1_swingup",
                "--method=flow",
                &format!("{option}=-1"),
            ],
            words,
        );
        assert_bad_input(
            &folder,
            &["solve", "pendulum_1_swingup", "--method=flow", option, "-1"],
            words,
        );
    }
}

/// A degree for which there is no memory is bad input, no crash.
#[test]
fn absurd_degrees_exit_with_2() {
    let folder = empty_folder("absurd");
    for p in ["18446744073709551615", "9000000000000000000", "4294967296"] {
        assert_bad_input(
            &folder,
            &["solve", "pendulum_1_swingup", "--degree", p],
            &format!("degree: it is {p}"),
        );
    }
}

#[test]
fn places_that_cannot_be_written_exit_with_2_and_leave_nothing_half_done() {
    let folder = empty_folder("unwritable");
    std::fs::write(folder.join("file"), "mine").expect("writable");
    for out in ["file", "file/below"] {
        assert_bad_input(
            &folder,
            &["solve", "pendulum_1_swingup", "--out", out],
            &format!("aghf: {out}"),
        );
    }
    assert_eq!(files(&folder), ["file".to_owned()].into());
    assert_eq!(
        std::fs::read_to_string(folder.join("file")).expect("it is there"),
        "mine"
    );
    for taken in ["trajectory.csv", "summary.json", "report.html"] {
        let out = format!("taken_{taken}");
        std::fs::create_dir_all(folder.join(&out).join(taken)).expect("writable");
        assert_bad_input(
            &folder,
            &["solve", "pendulum_1_swingup", "--out", &out],
            &format!("aghf: {out}/{taken}: "),
        );
    }
    let left = files(&folder);
    assert!(!left.iter().any(|f| f.contains("partial")), "{left:?}");
}
