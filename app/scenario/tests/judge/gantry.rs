//! A small robot, and scenarios of it.

use aghf_scenario::Scenario;
use serde_json::{Value, json};
use std::path::Path;

/// A slider along `x` that carries an arm of two links in the plane of `x` and `y`, each 0.5 m long, with a ball of
/// 10 mm on the slider and at the end of the second link.
const URDF: &str = r#"<robot name="gantry">
  <link name="rail"/>
  <link name="carriage">
    <inertial><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <collision><geometry><sphere radius="0.01"/></geometry></collision>
  </link>
  <link name="upper">
    <inertial><origin xyz="0.25 0 0"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
  </link>
  <link name="fore">
    <inertial><origin xyz="0.25 0 0"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
    <collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.01"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" velocity="5" effort="300"/></joint>
  <joint name="shoulder" type="revolute"><parent link="carriage"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="8" effort="200"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/>
  <axis xyz="0 0 1"/>
    <limit lower="-4" upper="4" velocity="8" effort="100"/></joint>
</robot>"#;

/// The motion of [`good`] in 1 s.
pub const FROM: [f64; 3] = [-0.5, 0.2, 0.4];
pub const TO: [f64; 3] = [0.5, -0.3, 1.4];

/// The scenario of [`good`], with these keys beside.
pub fn scenario(test: &str, keys: Value) -> Scenario {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("judge").join(test);
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    std::fs::write(folder.join("gantry.urdf"), URDF).expect("the folder is writable");
    let mut file = json!({
        "robot": "gantry.urdf", "horizon_s": 1.0,
        "q_start": FROM, "v_start": [0.0, 0.0, 0.0], "q_goal": TO, "v_goal": [0.0, 0.0, 0.0],
        "robot_shape": { "collision": {} }, "self_collision": "off"
    });
    for (key, value) in keys.as_object().expect("an object") {
        file[key] = value.clone();
    }
    let file = serde_json::from_value(file).expect("the keys are known");
    Scenario::new(file, "gantry", &folder).expect("it is good")
}
