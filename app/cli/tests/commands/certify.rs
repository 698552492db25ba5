//! `aghf certify` and `aghf check-certificate`.

use crate::command::{aghf, assert_bad_input, empty_folder};
use aghf::urdf::builtin_robot_text;
use serde_json::Value;

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
        run.stdout.contains("clearance from obstacles: proved"),
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
