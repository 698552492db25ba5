//! The force on a standing foot in the picture, against the weight, the centre of mass and Newton's second law.

use crate::{floats, folder, page_of, solved};
use aghf::curve::{Chebyshev, Curve};
use aghf::dynamics::forward_kinematics;
use aghf::spatial::Placement;
use aghf_scenario::{Scenario, SolveReport};
use nalgebra::{DMatrix, Vector3};
use serde_json::{Value, json};

/// An arm on a plate that stands, with its sole turned by 90 degrees about the vertical, or that is screwed down.
fn arm(test: &str, stand: bool) -> Scenario {
    let mut scenario = json!({
        "robot": "kinova_gen3", "horizon_s": 1.0, "continuity": "velocity",
        "q_start": [0.0, 0.1, 0.0, 0.2, 0.0, 0.1, 0.0], "v_start": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "q_goal": [0.5, -0.2, 0.0, -0.3, 0.0, -0.1, 0.0], "v_goal": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "robot_shape": "joint_frames",
        "enforced_limits": { "position": false, "velocity": false, "torque": false },
    });
    if stand {
        let turned = [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()];
        scenario["stand"] = json!({
            "frame": "base_link", "half_length_m": 0.15, "half_width_m": 0.1, "friction": 0.4, "torsion": 0.05,
            "sole": { "position_m": [0.02, -0.01, -0.03], "orientation_xyzw": turned },
        });
    }
    let path = folder(test).join("arm.json");
    std::fs::write(&path, scenario.to_string()).expect("writable");
    Scenario::load(&path.display().to_string()).expect("it is right")
}

/// The mass of the robot and its centre, that of the base included.
fn centre_of_mass(scenario: &Scenario, q: &[f64]) -> (f64, Vector3<f64>) {
    let model = &scenario.model;
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements).expect("of this robot");
    let base = model.base_inertia();
    let (mut mass, mut moment) = (base.mass, base.first_moment);
    for (inertia, at) in model.inertias().iter().zip(&placements) {
        mass += inertia.mass;
        moment += at.rotation * inertia.first_moment + at.translation * inertia.mass;
    }
    (mass, moment / mass)
}

/// The points and the forces of the page.
fn arrows(foot: &Value) -> [Vec<Vector3<f64>>; 2] {
    ["points", "forces"].map(|key| {
        let numbers = floats(&foot[key]);
        numbers.chunks_exact(3).map(Vector3::from_column_slice).collect()
    })
}

#[test]
fn at_rest_the_force_is_the_weight_and_acts_under_the_centre_of_mass() {
    let scenario = arm("at_rest", true);
    let outcome = solved(&scenario, 1);
    for (second, inside) in [(0.1, true), (1.5, false)] {
        let q = [0.0, second, 0.0, 0.2, 0.0, 0.1, 0.0];
        let still = DMatrix::from_fn(14, 5, |i, _| q.get(i).copied().unwrap_or(0.0));
        let nodes = Chebyshev::new(4, 1.0).expect("a degree");
        let outcome = SolveReport { curve: Curve::new(nodes, still).expect("a curve"), ..outcome.clone() };
        let (_, data) = page_of(&scenario, &outcome);
        let foot = &data["foot"];
        assert_eq!(foot["size"], json!([0.15, 0.1]));
        assert_eq!(foot["pose"].as_array().expect("a list")[..3], [0.02, -0.01, -0.03]);
        let (mass, centre) = centre_of_mass(&scenario, &q);
        let weight = -scenario.model.gravity() * mass;
        let named = foot["weight"].as_f64().expect("a number");
        assert!((named - weight.norm()).abs() < 1e-9, "{named} {weight}");
        let [points, forces] = arrows(foot);
        let times = floats(&data["tracks"][0]["times"]).len();
        assert_eq!([points.len(), forces.len()], [times; 2]);
        for (point, force) in points.iter().zip(&forces) {
            // Numbers of the page are of single precision.
            assert!((force - weight).norm() < 1e-5 * named, "{force} {weight}");
            let under = Vector3::new(centre.x, centre.y, -0.03);
            assert!((point - under).norm() < 1e-6, "{point} {under}");
        }
        // The length of the sole is along y.
        let off = centre - Vector3::new(0.02, -0.01, 0.0);
        assert_eq!(off.x.abs() < 0.1 && off.y.abs() < 0.15, inside, "{off}");
        assert_eq!(foot["holds"], json!(vec![inside; times]));
    }
}

#[test]
fn in_motion_the_force_accelerates_the_centre_of_mass() {
    let scenario = arm("in_motion", true);
    let outcome = solved(&scenario, 1);
    let (_, data) = page_of(&scenario, &outcome);
    let [_, forces] = arrows(&data["foot"]);
    let times = floats(&data["tracks"][0]["times"]);
    let at = |t: f64| {
        let (x, _) = outcome.curve.at(t);
        centre_of_mass(&scenario, &x.as_slice()[..7])
    };
    let (step, mut most) = (1e-4, 0.0_f64);
    for (&t, force) in times.iter().zip(&forces).skip(1).step_by(9) {
        if t + step > outcome.curve.horizon() {
            continue;
        }
        let [(_, before), (mass, now), (_, after)] = [t - step, t, t + step].map(at);
        let acceleration = (before - now * 2.0 + after) / (step * step);
        let expected = (acceleration - scenario.model.gravity()) * mass;
        // Differences of second order.
        assert!((force - expected).norm() < 1e-3, "{t}: {force} {expected}");
        most = most.max(acceleration.norm());
    }
    assert!(most > 0.1, "it hardly moves");
}

#[test]
fn a_robot_that_is_screwed_to_the_ground_has_no_arrow() {
    let scenario = arm("screwed", false);
    let (_, data) = page_of(&scenario, &solved(&scenario, 1));
    assert!(data["foot"].is_null(), "{}", data["foot"]);
    let plots = data["plots"].as_array().expect("a list");
    let pressure = plots.iter().filter(|plot| plot["title"] == "Centre of pressure");
    assert_eq!(pressure.count(), 0);
}
