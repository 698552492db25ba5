//! Each limit of a `joint_limits.yaml` is kept, or refused by its file and element.

use crate::written::{folder, load};
use aghf_scenario::{Quantity, Scenario};
use serde_json::{Value, json};

/// A scenario of two joints, the second of which is continuous, that takes this kind of limit from this file.
fn limited(key: &str, yaml: &str) -> Result<Scenario, String> {
    let link = r#"<inertial><mass value="1"/>
        <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>"#;
    let urdf = format!(
        r#"<robot name="two"><link name="base"/><link name="a">{link}<link name="b">{link}
        <joint name="j1" type="revolute"><parent link="base"/><child link="a"/>
          <limit lower="-3" upper="6.28318" velocity="2" effort="60"/></joint>
        <joint name="j2" type="continuous"><parent link="a"/><child link="b"/><limit velocity="2" effort="60"/></joint>
        </robot>"#
    );
    for (name, text) in [("two.urdf", urdf.as_str()), ("joint_limits.yaml", yaml)] {
        std::fs::write(folder().join(name), text).expect("the folder is writable");
    }
    let limits = json!({ key: { "file": "joint_limits.yaml" } });
    let scenario = json!({ "robot": "two.urdf", "horizon_s": 90.0, "q_start": [0.0, 0.0], "v_start": [0.0, 0.0],
        "q_goal": [0.1, 0.1], "v_goal": [0.0, 0.0], "enforced_limits": limits });
    load("limited", &scenario)
}

/// The limits of `j1` and `j2`, or the error.
fn of(key: &str, yaml: &str) -> Result<[Option<f64>; 2], String> {
    let scenario = limited(key, yaml)?;
    let limit = match key {
        "max_velocity" => Quantity::Velocity,
        "acceleration" => Quantity::Acceleration,
        _ => Quantity::Jerk,
    };
    Ok([0, 1].map(|joint| scenario.bound(limit, joint).map(|[_, most]| most)))
}

#[test]
fn angles_in_degrees_are_converted() {
    let yaml = "joint_limits:\n  \
        j1: {max_velocity: !degrees 30.0, max_acceleration: !degrees 90, max_jerk: !radians 5}\n  \
        j2: {has_velocity_limits: true, max_velocity: !radians 0.25}\n";
    let velocities = of("max_velocity", yaml).expect("it is good");
    assert_eq!(velocities, [Some(30.0_f64.to_radians()), Some(0.25)]);
    let accelerations = of("acceleration", yaml).expect("it is good");
    assert_eq!(accelerations, [Some(90.0_f64.to_radians()), None]);
    assert_eq!(of("jerk", yaml).expect("it is good"), [Some(5.0), None]);
    for (bad, words) in [
        ("{j1: {max_velocity: !grad 30}}", "the tag !grad, of which !degrees and !radians alone are read, at line 1"),
        ("{j1: !degrees {max_velocity: 30}}", "the tag !degrees"),
        ("!all {j1: {max_velocity: 30}}", "the tag !all"),
        ("{j1: {max_velocity: !degrees fast}}", "the tag !degrees without a number at line 1"),
        ("{j1: {max_velocity: !!float 3}}", "the tag "),
    ] {
        let error = of("max_velocity", &format!("joint_limits: {bad}")).expect_err(bad);
        assert!(error.contains("joint_limits.yaml: ") && error.contains(words), "{error}");
    }
}

#[test]
fn decelerations_have_any_sign_and_the_smaller_limit_holds() {
    for (keys, least, note) in [
        ("max_acceleration: 3, max_deceleration: -2.0", 2.0, Some("the smaller of 3 and 2 holds")),
        ("max_acceleration: 2, max_deceleration: 5", 2.0, Some("the smaller of 2 and 5 holds")),
        ("max_acceleration: 2, max_deceleration: -2", 2.0, None),
        ("max_deceleration: -4", 4.0, None),
        ("max_acceleration: 3, has_deceleration_limits: false, max_deceleration: -1", 3.0, None),
    ] {
        let yaml = format!("joint_limits: {{j1: {{{keys}}}}}");
        let scenario = limited("acceleration", &yaml).expect("it is good");
        assert_eq!(scenario.bound(Quantity::Acceleration, 0), Some([-least, least]), "{keys}");
        let notes = scenario.load_notes.iter().map(ToString::to_string);
        let notes: Vec<_> = notes.filter(|note| note.contains("deceleration")).collect();
        match note {
            Some(words) => assert!(notes.len() == 1 && notes[0].contains(words), "{notes:?}"),
            None => assert!(notes.is_empty(), "{notes:?}"),
        }
    }
}

/// A velocity that the file does not limit is that of the robot, which the factor scales too.
#[test]
fn default_factors_scale_all_limits() {
    let yaml = "default_velocity_scaling_factor: 0.1\ndefault_acceleration_scaling_factor: 0.5\n\
        joint_limits: {j1: {max_velocity: 1, max_acceleration: 3, max_jerk: 9}}\n";
    assert_eq!(of("max_velocity", yaml), Ok([Some(0.1), Some(0.2)]));
    assert_eq!(of("acceleration", yaml), Ok([Some(1.5), None]));
    assert_eq!(of("jerk", yaml), Ok([Some(9.0), None]));
    for factor in ["0", "1.01", "-0.1"] {
        for kind in ["velocity", "acceleration"] {
            let key = format!("default_{kind}_scaling_factor");
            let error = of("jerk", &format!("{key}: {factor}\njoint_limits: {{j1: {{max_jerk: 9}}}}"));
            let error = error.expect_err(factor);
            assert!(error.contains(&format!("joint_limits.yaml: {key}: it is {factor}, a factor is")), "{error}");
        }
    }
}

#[test]
fn positions_and_efforts_within_those_of_the_urdf_are_refused() {
    for (joint, keys, words) in [
        (
            "j1",
            "has_position_limits: true, min_position: -0.2, max_position: 0.5",
            "its positions [-0.2, 0.5] are within",
        ),
        ("j1", "max_position: !degrees 90", "are within those of the URDF, [-3, 6.28318]"),
        ("j2", "min_position: -3", "are within those of the URDF"),
        ("j1", "has_position_limits: true", "but no min_position and no max_position"),
        ("j1", "max_effort: 30", "max_effort: 30 is less than the effort of the URDF, 60"),
        ("j1", "has_effort_limits: true", "max_effort: it is missing"),
        ("j1", "has_soft_limits: true, soft_lower_limit: 0", "has_soft_limits: it is not read"),
    ] {
        let yaml = format!("joint_limits: {{{joint}: {{max_velocity: 1, {keys}}}}}");
        let error = of("max_velocity", &yaml).expect_err(keys);
        assert!(error.contains(&format!("joint_limits.yaml: joint_limits.{joint}")), "{error}");
        assert!(error.contains(words), "{error}");
    }
    for keys in [
        "has_position_limits: true, min_position: -3, max_position: !degrees 360",
        "has_position_limits: false, min_position: 0, max_position: 0",
        "has_effort_limits: true, max_effort: 60.0",
        "has_effort_limits: false, max_effort: 0",
        "has_soft_limits: false",
    ] {
        let yaml = format!("joint_limits: {{j1: {{max_velocity: 1, {keys}}}}}");
        assert_eq!(of("max_velocity", &yaml), Ok([Some(1.0), Some(2.0)]), "{keys}");
    }
}

/// A number without a flag is a limit, as in MoveIt; a key that is not known is none.
#[test]
fn keys_are_those_of_moveit() {
    assert_eq!(of("jerk", "joint_limits: {j1: {max_jerk: 9}}"), Ok([Some(9.0), None]));
    let off = "joint_limits: {j1: {has_jerk_limits: false, max_jerk: 9}, j2: {max_jerk: 7}}";
    assert_eq!(of("jerk", off), Ok([None, Some(7.0)]));
    let bad: [(Value, &str); 3] = [
        (json!({ "joint_limits": { "j1": { "max_jrek": 9 } } }), "joint_limits.j1.max_jrek: it is no field of a joint"),
        (json!({ "joint_limits": {}, "scale": 1 }), "scale: it is no field of joint_limits.yaml"),
        (json!({ "joint_limits": { "j1": 3 } }), "joint_limits.j1: an object with fields of"),
    ];
    for (yaml, words) in bad {
        let error = of("jerk", &yaml.to_string()).expect_err(words);
        assert!(error.contains(&format!("joint_limits.yaml: {words}")), "{error}");
    }
}
