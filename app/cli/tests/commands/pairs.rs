//! `aghf pairs` lists the links that may overlap.

use crate::command::{aghf, assert_bad_input};
use crate::import::folder;
use serde_json::{Value, json};

#[test]
fn pairs_are_those_of_the_srdf_or_found() {
    let folder = folder("pairs", "", None, "");
    let printed = aghf(&folder, &["pairs", "robot.urdf"]);
    let found: Value = serde_json::from_str(&printed.stdout).expect("it is JSON");
    let pair = |reason: &str| json!([{ "links": ["arm", "hand"], "reason": reason }]);
    assert_eq!(found["ignored_pairs"], pair("neighbours"));
    let run = aghf(&folder, &["pairs", "robot.urdf", "--srdf", "robot.srdf", "-o", "pairs.json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let text = std::fs::read_to_string(folder.join("pairs.json")).expect("it was written");
    let found: Value = serde_json::from_str(&text).expect("it is JSON");
    assert_eq!(found["ignored_pairs"], pair("disabled in the SRDF: Adjacent"));
    assert_bad_input(&folder, &["pairs", "robot.urdf", "-o", "pairs.json"], "pairs.json; exists already");
    assert_bad_input(&folder, &["pairs", "pendulum_2"], "pendulum_2; none of its links has a collision element");
}
