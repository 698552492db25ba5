//! The checker accepts certificates, and refuses wrong ones.

use crate::gantry::scenario;
use crate::{certified, run, shaped, smooth, written};
use aghf_scenario::{Scenario, sha256};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

mod kinds;

/// Texts of a robot, a scenario, a run and its certificate.
struct Case {
    robot: String,
    scenario: Value,
    run: Value,
    certificate: Value,
}

impl Case {
    fn new(test: &str, keys: Value) -> Self {
        let mut all = json!({
            "self_collision": { "ignored_pairs": [] },
            "losses": { "damping": 0.5, "friction": 0.8, "friction_velocity": 0.5, "armature": { "elbow": 0.2 } },
            "payload": { "link": "fore", "mass_kg": 0.7, "center_m": [0.4, 0.0, 0.1],
                "inertia_kg_m2": [0.01, 0.001, 0.0, 0.012, 0.0, 0.011] },
            "keep": [{ "speed": { "frame": "fore", "point_m": [0.5, 0.0, 0.0], "most_m_s": 3.5 } }],
            "stand": { "frame": "rail", "sole": { "position_m": [0.1, 0.1, 0.0],
                "orientation_xyzw": [0.0, 0.0, 0.1, (0.99_f64).sqrt()] },
                "half_length_m": 1.6, "half_width_m": 0.45, "friction": 0.8, "torsion": 1.0 },
            "enforced_limits": { "position": 0.9, "torque": { "share": 0.15 }, "acceleration": 12.0, "jerk": 130.0 },
            "obstacles": [
                { "shape": { "sphere": { "radius_m": 0.02 } }, "pose": { "position_m": [0.0, 0.0, 0.05] } },
                { "shape": { "box": { "size_m": [1.0, 0.2, 0.1] } }, "clearance_m": 0.001,
                    "pose": { "position_m": [0.3, 0.1, 0.0622], "orientation_xyzw": [0.0, 0.0, 0.1, 0.995] } }
            ]
        });
        for (key, value) in keys.as_object().expect("an object") {
            all[key] = value.clone();
        }
        Self::of(&scenario(test, all))
    }

    fn of(scenario: &Scenario) -> Self {
        Self::in_tube(scenario, 0.0)
    }

    fn in_tube(scenario: &Scenario, tube: f64) -> Self {
        let curve = smooth();
        let times = vec![0.5; scenario.waypoints.len()];
        let certification = certified(scenario, &curve, &times, tube).expect("it is of this robot");
        let certificate = certification.certificate.unwrap_or_else(|| panic!("{:?}", certification.failures));
        Self {
            robot: scenario.source.text.to_string(),
            scenario: serde_json::to_value(&scenario.file).expect("it is JSON"),
            run: run(&written(scenario, &curve)),
            certificate: serde_json::to_value(certificate).expect("it is JSON"),
        }
    }

    fn check_text(&self, certificate: &str) -> Result<String, String> {
        let [scenario, run] = [&self.scenario, &self.run].map(Value::to_string);
        aghf_check::check([&self.robot, &scenario, &run, certificate], &|_| None).map(|report| report.text)
    }

    /// The result for a certificate that names the texts as they are.
    fn check(&self) -> Result<String, String> {
        let mut certificate = self.certificate.clone();
        certificate["robot_sha256"] = json!(sha256(self.robot.as_bytes()));
        certificate["scenario_sha256"] = json!([sha256(self.scenario.to_string().as_bytes())]);
        certificate["run_sha256"] = json!(sha256(self.run.to_string().as_bytes()));
        self.check_text(&certificate.to_string())
    }
}

#[test]
fn certificates_are_accepted() {
    let case = Case::new("accepted", json!({}));
    assert_eq!(
        case.check().map(|report| report.split(": ").last().unwrap_or_default().to_owned()),
        Ok("horizon, ends, position, velocity, acceleration, jerk, torque, keep, stand, obstacles, self_collision"
            .to_owned())
    );
    for shape in [json!("joint_frames"), json!({ "swept_links": { "radius_m": 0.004, "spacing_m": 0.05 } })] {
        let keys = json!({ "robot_shape": shape, "self_collision": "off", "passive": ["shoulder"],
            "enforced_limits": {},
            "obstacles": [{ "shape": { "capsule": { "radius_m": 0.1, "length_m": 0.3 } },
                "pose": { "position_m": [0.0, 0.3, 0.3], "orientation_xyzw": [0.5, 0.5, 0.5, 0.5] } },
                { "shape": { "cylinder": { "radius_m": 0.1, "length_m": 0.3 } },
                "pose": { "position_m": [0.0, -0.3, 0.3] } }] });
        let case = Case::new("accepted by points", keys);
        assert!(case.check().is_ok_and(|report| report.contains("not certified: passive")), "{:?}", case.check());
    }
}

/// An objective that weighs time makes the horizon free, with and without bounds.
#[test]
fn a_horizon_that_the_objective_frees_is_any() {
    for objective in [json!("balanced"), json!({ "time": 1.0 })] {
        let keys = json!({ "objective": objective, "horizon_s": 2.0, "self_collision": "off" });
        let mut case = Case::in_tube(&scenario("free", keys), 0.0);
        assert!(case.check().is_ok(), "{:?}", case.check());
        for fixed in [json!("least-effort"), json!({ "time": 0.0 })] {
            case.scenario["objective"] = fixed;
            case.certificate["keys"]["horizon_s"] = json!("proved");
            assert!(case.check().is_err_and(|why| why.contains("horizon")));
        }
    }
}

#[test]
fn tubes_are_checked() {
    let keys = json!({ "losses": { "damping": 0.5 }, "enforced_limits": { "torque": 0.3 },
        "self_collision": { "ignored_pairs": [] }, "obstacles": [{ "shape": { "capsule": { "radius_m": 0.1,
        "length_m": 0.3 } }, "pose": { "position_m": [0.0, 0.3, 0.3] } }] });
    let case = Case::in_tube(&scenario("tubes", keys), 1e-3);
    let report = case.check();
    assert!(report.as_ref().is_ok_and(|report| report.contains("within 0.001")), "{report:?}");
    for wrong in [json!(null), json!("x"), json!(-1e-3), json!(10)] {
        let mut certificate = case.certificate.clone();
        certificate["tracking_error"] = wrong.clone();
        assert!(case.check_text(&certificate.to_string()).is_err(), "{wrong}");
    }
}

/// The claims are about the robot, the scenario and the run that are given.
#[test]
fn other_robots_scenarios_and_runs_are_refused() {
    let good = || Case::new("others", json!({}));
    let refused = |case: Case, why: &str| {
        let found = case.check().expect_err(why);
        assert!(found.contains(why), "{found}");
    };
    let text = good().certificate.to_string();
    for (i, why) in ["another robot", "another scenario", "another motion"].iter().enumerate() {
        let mut case = good();
        match i {
            0 => case.robot.push('\n'),
            1 => case.scenario["success_threshold"] = json!(1.0),
            _ => case.run["horizon_s"] = json!(1.0),
        }
        let found = case.check_text(&text).expect_err(why);
        assert!(found.contains(why), "{found}");
    }
    // With its own hash the torques are not what is claimed.
    let keys = json!({ "payload": { "link": "fore", "mass_kg": 0.05, "center_m": [0.4, 0.0, 0.1] } });
    let (mut case, lighter) = (good(), Case::new("lighter", keys));
    case.certificate = lighter.certificate;
    refused(case, "torque of joint");
    for (key, value) in
        [("q_goal", json!([0.5, -0.3, 1.400_001])), ("horizon_s", json!(1.1)), ("goal", json!([{ "frame": "fore" }]))]
    {
        let mut case = good();
        case.scenario[key] = value;
        assert!(case.check().is_err(), "{key}");
    }
    for (pointer, value) in [
        ("/enforced_limits/torque", json!(0.02)),
        ("/enforced_limits/jerk", json!(59.0)),
        ("/obstacles/1/pose/position_m/2", json!(0.0621)),
        ("/obstacles/1/clearance_m", json!(0.0011)),
    ] {
        let mut case = good();
        *case.scenario.pointer_mut(pointer).expect("it is there") = value;
        assert!(case.check().is_err(), "{pointer}");
    }
}

fn entries(value: &mut Value) -> &mut Vec<Value> {
    value.as_array_mut().expect("a list")
}

/// Changes a number; anything else counts as zero.
fn change(value: &mut Value, by: impl FnOnce(f64) -> f64) {
    *value = json!(by(value.as_f64().unwrap_or_default()));
}

/// Keys with one right value each.
const KEYS: [&str; 7] = ["robot_sha256", "complete", "format", "scenario_sha256", "run_sha256", "keys", "meshes"];

/// Changes one thing of a certificate to something wrong.
fn spoil(certificate: &mut Value, rng: &mut impl Rng) -> String {
    let count = certificate["intervals"].as_array().map_or(0, Vec::len);
    let i = rng.random_range(0..count);
    let kind = rng.random_range(0..12);
    match kind {
        0 => {
            // Beyond what is true: claims of rows are within a fiftieth unless they are cut off, those of small
            // clearances closer.
            let k = rng.random_range(0..9);
            let beyond = |claim: f64| match (k < 7, claim) {
                (true, ..0.9) => claim + 0.06,
                (false, ..0.04) => claim + 0.001,
                _ => claim + 10.0,
            };
            change(&mut certificate["intervals"][i][3][k], beyond);
        }
        1 => drop(entries(&mut certificate["intervals"]).remove(i)),
        2 => {
            let copy = certificate["intervals"][i].clone();
            entries(&mut certificate["intervals"]).insert(i, copy);
        }
        3 => {
            let end = rng.random_range(1..3);
            let by = [1e-12, -1e-12][rng.random_range(0..2)];
            change(&mut certificate["intervals"][i][end], |x| x + by);
        }
        4 => certificate["intervals"][i][0] = json!(1),
        5 => {
            let (j, k) = (rng.random_range(0..3), rng.random_range(3..6));
            entries(&mut certificate["promises"]).swap(j, k);
        }
        6 => {
            let outcome = ["no promise", "assumed", "left out: ", ""][rng.random_range(0..4)];
            certificate["keys"]["keep"] = json!(outcome);
        }
        7 => certificate["keys"]["kept"] = json!("proved"),
        8 => {
            let k = rng.random_range(0..9);
            entries(&mut certificate["intervals"][i][3]).remove(k);
        }
        9 => {
            let k = rng.random_range(0..9);
            entries(&mut certificate["promises"]).remove(k);
            for interval in entries(&mut certificate["intervals"]) {
                entries(&mut interval[3]).remove(k);
            }
        }
        10 => {
            let key = KEYS[rng.random_range(0..KEYS.len())];
            certificate[key] = [json!(null), json!(1e-8), json!("x"), json!(["x"])][rng.random_range(0..4)].clone();
        }
        _ => certificate["intervals"][i][3][rng.random_range(0..9)] = json!(null),
    }
    format!("kind {kind}, interval {i}")
}

#[test]
fn wrong_certificates_are_refused() {
    let case = Case::new("wrong", json!({}));
    assert!(case.check().is_ok(), "{:?}", case.check());
    let rng = &mut ChaCha8Rng::seed_from_u64(38);
    for _ in 0..400 {
        let mut certificate = case.certificate.clone();
        let what = spoil(&mut certificate, rng);
        assert!(case.check_text(&certificate.to_string()).is_err(), "{what}");
    }
    // Cut anywhere, with something that is no number, and more of the kind.
    let text = case.certificate.to_string();
    for _ in 0..50 {
        let end = rng.random_range(0..text.len());
        assert!(case.check_text(&text[..end]).is_err(), "cut at {end}");
    }
    for wrong in [text.replacen("1.0", "NaN", 1), text.replacen("-1.0", "-1e999", 1), text.replacen("[0,", "[true,", 1)]
    {
        assert!(wrong != text && case.check_text(&wrong).is_err());
    }
}

/// A reserve that overflows beside a bound proves nothing. The last two reserves are those of clearances.
#[test]
fn huge_reserves_are_refused() {
    for (huge, why) in [(f64::MAX, "reserve"), (1.1, "reserve"), (1.0, "position of joint")] {
        let mut case = Case::new("huge", json!({}));
        assert!(case.check().is_ok());
        for interval in entries(&mut case.certificate["intervals"]) {
            for claim in &mut entries(&mut interval[3])[..7] {
                *claim = json!(huge);
            }
        }
        let found = case.check().expect_err("nothing has such a reserve");
        assert!(found.contains(why), "{found}");
    }
}
