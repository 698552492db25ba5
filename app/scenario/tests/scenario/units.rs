//! Objectives in units of the problem, and the horizons that they make free.

use crate::written::{folder, load, with};
use aghf_scenario::{Details, DirectDetails, DirectOptions, HorizonBounds, Scenario, Solve};
use serde_json::{Value, json};

/// The way of the cart, m, and its largest velocity, m/s.
const WAY: f64 = 1.5;
const FASTEST: f64 = 3.0;

/// A cart on a level rail with this mass, kg, and force, N.
pub fn cart(mass: f64, force: f64, keys: Value) -> Value {
    let urdf = format!(
        r#"<robot name="slide"><link name="base"/>
  <link name="cart"><inertial><mass value="{mass}"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="2" velocity="{FASTEST}" effort="{force}"/></joint></robot>"#
    );
    let name = format!("cart_{mass}.urdf");
    std::fs::write(folder().join(&name), urdf).expect("writable");
    let scenario = json!({
        "robot": name, "horizon_s": 1.0,
        "q_start": [0.0], "v_start": [0.0], "q_goal": [WAY], "v_goal": [0.0],
    });
    with(scenario, keys)
}

/// Duration, cost and details of the motion of least cost.
pub fn solved(name: &str, file: &Value) -> DirectDetails {
    let scenario = load(name, file).expect("it is good");
    found(&scenario)
}

/// The same of a scenario that is read.
pub fn found(scenario: &Scenario) -> DirectDetails {
    let options = DirectOptions { degree: Some(12), starts: Some(1), threads: Some(1), ..DirectOptions::default() };
    let report = Solve::new(scenario).options(options).run();
    let summary = report.expect("it is good").summary;
    assert!(summary.success, "{summary:?}");
    let Details::Direct(details) = summary.details else {
        panic!("it is a direct solve");
    };
    *details
}

#[test]
fn scaled_weights_mean_the_same_for_a_light_and_a_heavy_robot() {
    let scaled = json!({ "objective": { "time": 2.0, "effort": 1.0 } });
    let si = json!({ "objective": { "units": "si", "time": 2.0, "effort": 1.0 } });
    let horizons = |keys: &Value| {
        [2.0, 2000.0].map(|mass| {
            let details = solved("cart", &cart(mass, 40.0 * mass, keys.clone()));
            (details.horizon_s, details.cost)
        })
    };
    let [(light, cost), (heavy, of_heavy)] = horizons(&scaled);
    assert!((light - heavy).abs() < 1e-6 * light, "{light} {heavy}");
    assert!((cost - of_heavy).abs() < 1e-6 * cost, "{cost} {of_heavy}");
    let [(light, _), (heavy, _)] = horizons(&si);
    assert!(heavy > 2.0 * light, "{light} {heavy}");
}

/// The straight motion is the quintic, which has the least jerk: a cost of one in its own units on its own horizon.
#[test]
fn the_units_are_the_costs_of_the_straight_motion() {
    let horizon = 2.0 * WAY / FASTEST;
    let of = |weights: Value| {
        let keys = json!({ "horizon_s": horizon, "objective": weights });
        solved("unit", &cart(2.0, 400.0, keys)).cost
    };
    let jerk = of(json!({ "effort": 0.0, "jerk": 1.0 }));
    assert!((jerk - 1.0).abs() < 1e-5, "{jerk}");
    let [effort, acceleration] = [json!({ "effort": 1.0 }), json!({ "effort": 0.0, "acceleration": 1.0 })].map(of);
    assert!((effort - acceleration).abs() < 1e-5, "{effort} {acceleration}");
    assert!((0.7..1.0).contains(&effort), "{effort}");
    let si = of(json!({ "units": "si", "effort": 0.0, "jerk": 1.0 }));
    let expected = 720.0 * WAY * WAY / horizon.powi(5);
    assert!((si - expected).abs() < 1e-5 * expected, "{si} {expected}");
}

/// $w T + 720 d^2 / T^5$ is least at $T^6 = 3600 d^2 / w$.
#[test]
fn jerk_and_time_have_the_horizon_between_them() {
    let keys = json!({
        "objective": { "units": "si", "time": 200.0, "effort": 0.0, "jerk": 1.0 },
        "free_horizon": { "shortest_s": 0.3, "longest_s": 10.0 },
    });
    let details = solved("between", &cart(2.0, 4e5, keys));
    let expected = (3600.0 * WAY * WAY / 200.0_f64).powf(1.0 / 6.0);
    let off = (details.horizon_s - expected).abs();
    assert!(off < 1e-4 * expected, "{} {expected}", details.horizon_s);
}

#[test]
fn time_makes_the_horizon_free() {
    let bounds = |keys: Value| load("free", &cart(2.0, 40.0, keys)).expect("good").horizon_bounds();
    let least = WAY / FASTEST;
    let between = |shortest_s: f64, longest_s: f64| Some(HorizonBounds { shortest_s, longest_s });
    assert_eq!(bounds(json!({})), None);
    assert_eq!(bounds(json!({ "objective": { "effort": 2.0 } })), None);
    for objective in [json!("least-time"), json!("balanced"), json!({ "time": 1.0 })] {
        let keys = json!({ "objective": objective });
        assert_eq!(bounds(keys), between(least, 10.0));
    }
    let keys = json!({ "objective": "least-time", "horizon_s": 0.1 });
    assert_eq!(bounds(keys), between(0.1, 10.0 * least));
    let given = json!({ "shortest_s": 0.9, "longest_s": 1.1 });
    let keys = json!({ "objective": "least-time", "free_horizon": given });
    assert_eq!(bounds(keys), between(0.9, 1.1));
    let limits = json!({ "position": false, "velocity": false, "torque": false });
    let keys = json!({ "objective": { "time": 1.0 }, "enforced_limits": limits });
    assert_eq!(bounds(keys), between(0.1, 10.0));
}
