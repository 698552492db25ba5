//! `aghf certify` and `aghf check-certificate`.

use crate::command::{aghf, assert_bad_input, empty_folder};
use aghf::urdf::builtin_robot_text;
use serde_json::{Value, json};
use std::path::Path;

/// Asserts that a command ends with this exit code, and returns its standard output.
fn printed(folder: &Path, arguments: &[&str], code: i32) -> String {
    let run = aghf(folder, arguments);
    assert_eq!(run.code, Some(code), "{}{}", run.stdout, run.stderr);
    run.stdout
}

#[test]
fn a_solve_is_certified_and_checked() {
    let folder = empty_folder("certify");
    let solve = "solve kinova_obstacles_02 --out out --starts 1";
    printed(&folder, &solve.split(' ').collect::<Vec<_>>(), 0);
    let arguments = ["certify", "kinova_obstacles_02", "out"];
    let text = printed(&folder, &arguments, 0);
    assert!(text.contains("obstacles: proved for the origins of joint frames and a load, not for links"), "{text}");
    assert_bad_input(&folder, &arguments, "certificate.json; --force");
    let certificate = std::fs::read_to_string(folder.join("certificate.json"));
    let certificate = certificate.expect("it is written");
    assert!(certificate.len() < 200_000);
    let urdf = builtin_robot_text("kinova_gen3").expect("it is built in");
    std::fs::write(folder.join("kinova.urdf"), urdf).expect("writable");
    let check = ["check-certificate", "kinova.urdf", "out/summary.json", "out/summary.json", "certificate.json"];
    let text = printed(&folder, &check, 0);
    assert!(text.starts_with("certified at all times"), "{text}");
    // A table of the motion, one that is moved, and one of another motion.
    let with_table = [&check[..], &["--table", "table.csv"]].concat();
    for (rate, code) in [("1000", 0), ("20", 4)] {
        let sample = ["sample", "out", "--rate", rate, "--out", "table.csv", "--force"];
        printed(&folder, &sample, 0);
        let text = printed(&folder, &with_table, code);
        assert!(text.contains("with quintics between its"), "{text}");
    }
    let text = printed(&folder, &with_table, 4);
    let bound = |text: &str| -> f64 {
        let (_, rest) = text.rsplit_once("within ").expect("it is there");
        rest.split(' ').next().and_then(|x| x.parse().ok()).expect("a number")
    };
    assert!(bound(&text) < 1e-3, "{text}");
    let table = std::fs::read_to_string(folder.join("table.csv")).expect("it is written");
    let other = table.replacen("run_sha256:", "run_sha256:0", 1);
    std::fs::write(folder.join("table.csv"), other).expect("writable");
    assert_bad_input(&folder, &with_table, "table.csv; names another motion");
    let zero = table.lines().skip(1).map(|row| match row.split_once(',') {
        Some((t, rest)) if t != "t" => format!("{t},5.0{}\n", &rest[rest.find(',').unwrap_or(0)..]),
        _ => format!("{row}\n"),
    });
    std::fs::write(folder.join("table.csv"), zero.collect::<String>()).expect("writable");
    let text = printed(&folder, &with_table, 4);
    assert!(bound(&text) > 1.0, "{text}");
    // A claim that is not true.
    let mut wrong: Value = serde_json::from_str(&certificate).expect("it is JSON");
    wrong["intervals"][3][3][0] = 1.0.into();
    std::fs::write(folder.join("certificate.json"), wrong.to_string()).expect("writable");
    let text = printed(&folder, &check, 1);
    assert!(text.contains("refused: segment 0 from"), "{text}");
    // The motion of another scenario.
    let other = ["certify", "kinova_obstacles_01", "out", "-o", "other.json"];
    let text = printed(&folder, &other, 1);
    assert!(text.contains("start position: broken"), "{text}");
    assert!(!folder.join("other.json").exists());
    // The motion of another robot.
    assert_bad_input(
        &folder,
        &["certify", "pendulum_1_swingup", "out", "-o", "other.json"],
        "out/summary.json: curve.joints: the motion and robot 'pendulum_1' have 7 and 1 joints",
    );
}

/// No certificate covers a load that is no ball.
#[test]
fn a_certificate_of_a_part_has_an_exit_code_of_its_own() {
    let folder = empty_folder("certify_in_part");
    let scenario = json!({
        "robot": "pendulum_1", "horizon_s": 1.0, "q_start": [0.0], "v_start": [0.0], "q_goal": [0.5], "v_goal": [0.0],
        "robot_shape": "joint_frames",
        "payload": { "link": "link_1", "mass_kg": 0.1, "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } } },
        "obstacles": [{ "shape": { "sphere": { "radius_m": 0.5 } }, "pose": { "position_m": [5.0, 0.0, 0.0] } }]
    });
    std::fs::write(folder.join("load.json"), scenario.to_string()).expect("writable");
    let solve = ["solve", "load.json", "--out", "out", "--starts", "1"];
    printed(&folder, &solve, 0);
    let text = printed(&folder, &["certify", "load.json", "out"], 4);
    assert!(text.contains("\ncertified in part: "), "{text}");
    assert!(folder.join("certificate.json").exists());
}
