//! Promises of other kinds than limits: conditions along the way, feet, shapes.

use super::*;

/// A scenario with conditions of every kind at the end, on the way and at two points.
fn conditions() -> Value {
    let (sin, cos) = (0.3_f64.sin(), 0.3_f64.cos());
    let turned = |angle: f64| json!([0.0, 0.0, (0.5 * angle).sin(), (0.5 * angle).cos()]);
    let x = |angle: f64| json!({ "of_frame": [2, 0, 0], "direction": [angle.cos(), angle.sin(), 0] });
    let at = |position: [f64; 3]| json!({ "position_m": position, "orientation_xyzw": turned(0.3) });
    json!({
        "goal": [{ "frame": "fore", "position_m": [0.0, 0.0, 0.0] },
            { "frame": "fore", "position_m": [0.5 + 0.5 * cos, -0.5 * sin, 0.0], "orientation_xyzw": turned(1.1) }],
        "keep": [
            { "poses": { "frame": "fore", "relative_to": "carriage", "position_m": [0.0, 0.0, 0.0],
                "tolerance_m": 0.500_001, "orientation_xyzw": turned(0.8), "tolerance_rad": 0.35 } },
            { "poses": { "frame": "upper", "axis": x(0.0), "tolerance_rad": 0.301 } },
            { "poses": { "frame": "carriage", "axis": x(0.0),
                "box": { "size_m": [null, 0.3, 0.0], "pose": at([0.0, 0.0, 0.0]) } } },
            { "speed": { "frame": "carriage", "most_m_s": 0.768 }, "from_s": 0.8 },
            { "speed": { "frame": "carriage", "most_m_s": 0.768 }, "to_s": 0.2 },
        ],
        "waypoints": [{ "q": [0.0, -0.05, 0.9] },
            { "poses": { "frame": "carriage", "position_m": [0.0, 0.0, 0.0], "orientation_xyzw": [0, 0, 0, 1] },
                "time_s": 0.5 }],
    })
}

#[test]
fn conditions_are_proved_once_more() {
    let good = || Case::new("conditions", conditions());
    assert!(good().check().is_ok_and(|report| report.contains("goal, waypoints, position")), "{:?}", good().check());
    for (pointer, value) in [
        ("/goal/1/position_m/2", json!(1.1e-6)),
        ("/goal/1/orientation_xyzw", json!([0.0, 0.0, 0.0, 1.0])),
        ("/keep/0/poses/tolerance_m", json!(0.499_999)),
        ("/keep/0/poses/tolerance_rad", json!(0.3)),
        ("/keep/1/poses/tolerance_rad", json!(0.299)),
        ("/keep/2/poses/box/size_m/1", json!(0.29)),
        ("/keep/2/poses/box/pose/position_m/2", json!(2e-6)),
        ("/keep/2/poses/axis/direction/1", json!(1e-5)),
        ("/keep/3/from_s", json!(0.799_999)),
        ("/keep/4/to_s", json!(0.200_001)),
        ("/keep/3/speed/most_m_s", json!(0.767_999)),
        ("/waypoints/0/q/0", json!(1.1e-6)),
        ("/waypoints/1/poses/position_m/0", json!(1.1e-6)),
        ("/waypoints/1/time_s", json!(0.500_000_1)),
    ] {
        let mut case = good();
        *case.scenario.pointer_mut(pointer).expect("it is there") = value;
        assert!(case.check().is_err(), "{pointer}");
    }
    for (pointer, value) in [
        ("/goal", json!(1.1e-6)),
        ("/goal", json!(-1e-8)),
        ("/goal", json!(null)),
        ("/waypoints/0/2", json!(1.1e-6)),
        ("/waypoints/0/1", json!(1e-5)),
        ("/waypoints/0/0", json!(1)),
        ("/waypoints/1", json!([0, 0.0])),
        ("/waypoints", json!([])),
    ] {
        let mut case = good();
        *case.certificate.pointer_mut(pointer).expect("it is there") = value;
        assert!(case.check().is_err(), "{pointer}");
    }
    // The second point before the first one.
    let mut case = good();
    case.scenario["waypoints"] = json!([{ "q": [0.0, -0.05, 0.9] }, { "poses": { "frame": "carriage",
        "box": { "size_m": [null, 0, 0], "pose": { "position_m": [0.0, 0.0, 0.0] } } } }]);
    assert!(case.check().is_ok(), "{:?}", case.check());
    case.certificate["waypoints"][1][1] = json!(-0.5);
    assert!(case.check().is_err_and(|fault| fault.contains("before another one")));
}

/// The foot of a scenario with claims of another one.
#[test]
fn other_feet_are_refused() {
    let good = Case::new("feet", json!({}));
    for (key, value) in [
        ("friction", json!(0.01)),
        ("torsion", json!(0.01)),
        ("half_length_m", json!(0.1)),
        ("half_width_m", json!(0.1)),
        ("sole", json!({ "position_m": [1.5, 0.1, 0.0] })),
    ] {
        let mut case = Case {
            scenario: good.scenario.clone(),
            robot: good.robot.clone(),
            run: good.run.clone(),
            certificate: good.certificate.clone(),
        };
        case.scenario["stand"][key] = value;
        assert!(case.check().is_err(), "{key}");
    }
}

/// Boxes, cylinders and capsules are separated from others by directions.
#[test]
fn shapes_are_separated_once_more() {
    let good = || {
        let obstacles = json!([
            { "shape": { "sphere": { "radius_m": 0.02 } }, "pose": { "position_m": [0.0, 0.06, 0.045] } },
            { "shape": { "box": { "size_m": [1.0, 0.2, 0.1] } }, "clearance_m": 0.001,
                "pose": { "position_m": [0.3, 0.1, 0.0782], "orientation_xyzw": [0.0, 0.0, 0.1, (0.99_f64).sqrt()] } },
            { "shape": { "capsule": { "radius_m": 0.1, "length_m": 0.4 } },
                "pose": { "position_m": [0.0, -0.7, 0.1] } },
            { "shape": { "cylinder": { "radius_m": 0.1, "length_m": 0.3 } },
                "pose": { "position_m": [0.0, -0.9, 0.3] } },
            { "shape": { "half_space": {} }, "pose": { "position_m": [0.0, 0.0, -0.03] } }
        ]);
        Case::of(&shaped("separated", obstacles))
    };
    let report = good().check();
    assert!(report.as_ref().is_ok_and(|report| report.starts_with("certified at all times")), "{report:?}");
    for (pointer, value) in [
        ("/obstacles/0/pose/position_m/2", json!(0.039)),
        ("/obstacles/1/pose/position_m/2", json!(0.0705)),
        ("/obstacles/1/clearance_m", json!(0.0083)),
        ("/obstacles/4/pose/position_m/2", json!(-0.019)),
        ("/obstacles/3", json!({ "shape": { "mesh": {} }, "pose": { "position_m": [0, 0, 0] } })),
    ] {
        let mut case = good();
        *case.scenario.pointer_mut(pointer).expect("it is there") = value;
        assert!(case.check().is_err(), "{pointer}");
    }
    // Without its directions, or with others.
    for wrong in [json!([]), json!([0.0, 0.0, 0.0]), json!([0.0, 0.0, -1.0]), json!([0.1, 0.9]), json!("x")] {
        let mut case = good();
        let intervals = case.certificate["intervals"].as_array_mut().expect("a list");
        let listed = intervals.iter_mut().flat_map(|interval| interval[4].as_array_mut().expect("a list"));
        for direction in listed {
            direction[2] = wrong.clone();
        }
        assert!(case.check().is_err(), "{wrong}");
    }
}
