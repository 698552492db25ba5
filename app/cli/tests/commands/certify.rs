//! `aghf certify` and `aghf check-certificate`.

use crate::command::{aghf, assert_bad_input, empty_folder};
use aghf::urdf::builtin_robot_text;
use serde_json::{Value, json};

#[test]
fn a_solve_is_certified_and_checked() {
    let folder = empty_folder("certify");
    let solved = aghf(
        &folder,
        &[
            "solve",
            "kinova_obstacles_02",
            "--out",
            "out",
            "--starts",
            "1",
        ],
    );
    assert_eq!(solved.code, Some(0), "{}", solved.stderr);
    let arguments = ["certify", "kinova_obstacles_02", "out"];
    let run = aghf(&folder, &arguments);
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout
            .contains("clearance from obstacles: proved for the origins of joint frames and a load, not for links"),
        "{}",
        run.stdout
    );
    assert_bad_input(&folder, &arguments, "certificate.json; --force");
    let text = std::fs::read_to_string(folder.join("certificate.json")).expect("it is written");
    assert!(text.len() < 200_000);
    let urdf = builtin_robot_text("kinova_gen3").expect("it is built in");
    std::fs::write(folder.join("kinova.urdf"), urdf).expect("writable");
    let check = [
        "check-certificate",
        "kinova.urdf",
        "out/summary.json",
        "out/summary.json",
        "certificate.json",
    ];
    let checked = aghf(&folder, &check);
    assert_eq!(checked.code, Some(0), "{}", checked.stdout);
    assert!(
        checked.stdout.starts_with("certified at all times"),
        "{}",
        checked.stdout
    );
    // A claim that is not true.
    let mut wrong: Value = serde_json::from_str(&text).expect("it is JSON");
    wrong["intervals"][3][3][0] = 10.0.into();
    std::fs::write(folder.join("certificate.json"), wrong.to_string()).expect("writable");
    let checked = aghf(&folder, &check);
    assert_eq!(checked.code, Some(1), "{}", checked.stdout);
    assert!(
        checked.stdout.contains("refused: segment 0 from"),
        "{}",
        checked.stdout
    );
    // The motion of another scenario.
    let other = aghf(
        &folder,
        &["certify", "kinova_obstacles_01", "out", "-o", "other.json"],
    );
    assert_eq!(other.code, Some(1), "{}", other.stdout);
    assert!(
        other.stdout.contains("start position: broken"),
        "{}",
        other.stdout
    );
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
    let solved = aghf(
        &folder,
        &["solve", "load.json", "--out", "out", "--starts", "1"],
    );
    assert_eq!(solved.code, Some(0), "{}{}", solved.stdout, solved.stderr);
    let run = aghf(&folder, &["certify", "load.json", "out"]);
    assert_eq!(run.code, Some(4), "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout.contains("\ncertified in part: "),
        "{}",
        run.stdout
    );
    assert!(folder.join("certificate.json").exists());
}
