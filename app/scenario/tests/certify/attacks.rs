//! Motions that break a promise, seen by a dense evaluation, are not certified whatever a certificate claims.
//!
//! Each attack changes the robot, the scenario or the motion of a certified case, or several of these, and makes claims
//! that fit: reserves of the tolerance or of the largest number, other intervals, other hashes. `AGHF_ATTACKS` is their
//! number, `AGHF_FIRST_ATTACK` the seed of the first one. `AGHF_ATTACKS_FILE` names a file for those that break a
//! promise, one JSON list of the four texts per line, for the other checker.

mod violation;

use crate::gantry::{FROM, TO, scenario};
use crate::{certified, curve, run, shaped, written};
use aghf::curve::Curve;
use aghf_scenario::{Quantity, Scenario, sha256};
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{File, create_dir_all, write};
use std::io::Write;
use std::path::{Path, PathBuf};
use violation::violation;

/// The number of attacks of a developer's run: a few seconds.
const ATTACKS: u64 = 600;

/// The texts of a certified motion; the robot is that of the file that the scenario names.
#[derive(Clone)]
struct Case {
    robot: String,
    scenario: Value,
    run: Value,
    certificate: Value,
    /// The folder of the robot.
    folder: PathBuf,
}

/// The conditions of the cases, beside those that all have.
fn conditions() -> Vec<Value> {
    let turned = json!([0.0, 0.0, 0.0, 1.0]);
    vec![
        json!({ "enforced_limits": { "acceleration": 12.0, "jerk": 130.0, "torque": { "share": 0.15 },
            "power": 90.0 } }),
        json!({ "keep": [{ "speed": { "frame": "fore", "point_m": [0.5, 0.0, 0.0], "most_m_s": 3.5 } },
            { "speed": { "frame": "carriage", "most_m_s": 1.9 }, "from_s": 0.2, "to_s": 0.8 }],
            "waypoints": [{ "q": [0.0, -0.05, 0.9] }] }),
        json!({ "keep": [{ "poses": { "frame": "carriage", "position_m": [0.0, 0.0, 0.0], "tolerance_m": 0.51,
            "orientation_xyzw": turned, "tolerance_rad": 0.1 } }],
            "goal": { "frame": "carriage", "position_m": [0.5, 0.0, 0.0], "tolerance_m": 0.01 } }),
        json!({ "stand": { "frame": "rail", "half_length_m": 1.6, "half_width_m": 0.5, "friction": 0.8,
            "torsion": 1.2 }, "free_horizon": { "shortest_s": 0.9, "longest_s": 1.1 } }),
        json!({ "payload": { "link": "fore", "mass_kg": 0.7, "center_m": [0.4, 0.0, 0.1] },
            "losses": { "damping": 0.5, "friction": 0.8, "armature": { "elbow": 0.2 } },
            "clearance_m": { "obstacles": 0.01, "itself": 0.02 } }),
        json!({ "mount": { "position_m": [0.02, -0.01, 0.03], "orientation_xyzw": [0.02, 0.03, 0.01, 0.9993] },
            "gravity": [0.4, -0.3, -9.5], "stand": { "frame": "rail", "half_length_m": 1.7, "half_width_m": 0.6,
            "friction": 0.9 }, "enforced_limits": { "torque": { "share": 0.2 } } }),
    ]
}

/// From rest to rest in 1 s by a polynomial of degree seven with a random bump, on this many segments.
fn motion(degree: usize, segments: usize, rng: &mut impl Rng) -> Curve {
    let bumps: [f64; 3] = std::array::from_fn(|_| rng.random_range(-0.3..0.3));
    let at = move |i: usize, t: f64| {
        let way = TO[i] - FROM[i];
        let rise = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
        let (bump, rate) = ((t * (1.0 - t)).powi(3), 3.0 * (t * (1.0 - t)).powi(2) * (1.0 - 2.0 * t));
        let v = way * 30.0 * (t * (1.0 - t)).powi(2) + bumps[i] * rate;
        [FROM[i] + way * rise + bumps[i] * bump, v]
    };
    if segments == 1 {
        return curve(3, degree, 1.0, at);
    }
    let parts = (0..segments).map(|e| {
        let own = move |i: usize, t: f64| at(i, (t + e as f64) / segments as f64);
        let part = curve(3, degree, 1.0, own);
        (part.x().clone(), e)
    });
    let mut x = nalgebra::DMatrix::zeros(6, segments * (degree + 1));
    for (own, e) in parts {
        x.columns_mut(e * (degree + 1), degree + 1).copy_from(&own);
        if e > 0 {
            let end = x.column(e * (degree + 1) - 1).into_owned();
            x.set_column(e * (degree + 1), &end);
        }
    }
    Curve::piecewise(1.0, segments, x).expect("it is continuous")
}

/// The certified cases.
fn cases() -> Vec<Case> {
    let rng = &mut ChaCha8Rng::seed_from_u64(71);
    let mut all = Vec::new();
    let ball = json!({ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0.0, 0.8, 0.3] } });
    let wall = json!({ "shape": { "box": { "size_m": [4, 4, 0.1] } }, "pose": { "position_m": [0, 0, 0.2],
        "orientation_xyzw": [0.0, 0.0, 0.6, 0.8] } });
    let rod = json!({ "shape": { "capsule": { "radius_m": 0.1, "length_m": 0.4 } }, "clearance_m": 0.02,
        "pose": { "position_m": [0, -1.2, 0], "orientation_xyzw": [0.5, 0.5, 0.5, 0.5] } });
    let bodies = json!([ball, wall, rod, { "shape": { "half_space": {} }, "pose": { "position_m": [0, 0, -0.1] } }]);
    for (i, keys) in conditions().into_iter().enumerate() {
        for (degree, segments) in [(8, 1), (16, 1), (9, 2)] {
            let mut own = json!({ "self_collision": { "ignored_pairs": [] }, "obstacles": bodies });
            for (key, value) in keys.as_object().expect("an object") {
                own[key] = value.clone();
            }
            if i % 2 == 0 {
                own["robot_shape"] = json!({ "swept_links": { "radius_m": 0.02 } });
                own["self_collision"] = json!("off");
            }
            let test = format!("attacked {i} {degree}");
            let scenario = scenario(&test, own);
            all.extend(case(&scenario, &motion(degree, segments, rng)));
        }
    }
    all.extend(case(&shaped("attacked", bodies), &motion(8, 1, rng)));
    assert!(all.len() >= 12, "{} cases are certified", all.len());
    all
}

fn case(scenario: &Scenario, curve: &Curve) -> Option<Case> {
    let times = vec![0.5; scenario.waypoints.len()];
    let found = certified(scenario, curve, &times, 0.0).expect("it is of this robot");
    Some(Case {
        robot: scenario.source.text.to_string(),
        scenario: serde_json::to_value(&scenario.file).expect("it is JSON"),
        run: run(&written(scenario, curve)),
        certificate: serde_json::to_value(found.certificate?).expect("it is JSON"),
        folder: Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("attacks_{}", std::process::id())),
    })
}

impl Case {
    /// The texts of robot, scenario, run and a certificate that names them.
    fn texts(&self) -> [String; 4] {
        let [scenario, run] = [&self.scenario, &self.run].map(Value::to_string);
        let mut certificate = self.certificate.clone();
        certificate["robot_sha256"] = json!(sha256(self.robot.as_bytes()));
        certificate["scenario_sha256"] = json!([sha256(scenario.as_bytes())]);
        certificate["run_sha256"] = json!(sha256(run.as_bytes()));
        [self.robot.clone(), scenario, run, certificate.to_string()]
    }

    /// The scenario with the robot of this case; `None` if the library refuses them.
    fn read(&self) -> Option<Scenario> {
        create_dir_all(&self.folder).expect("the folder is writable");
        write(self.folder.join("attacked.urdf"), &self.robot).expect("the folder is writable");
        let mut scenario = self.scenario.clone();
        scenario["robot"] = json!("attacked.urdf");
        Scenario::parse(&scenario.to_string(), "attacked", &self.folder).ok()
    }
}

/// A number by a random factor, now and then by a large one.
fn scaled(value: &mut Value, rng: &mut impl Rng) {
    let factor = [0.5, 0.9, 0.99, 1.01, 1.1, 2.0, 10.0, -1.0][rng.random_range(0..8)];
    let off = [0.0, 0.0, 1e-5, 1e-3, 0.1][rng.random_range(0..5)];
    if let Some(x) = value.as_f64() {
        *value = json!(x * factor + off);
    }
}

/// All numbers in a value.
fn numbers<'a>(value: &'a mut Value, into: &mut Vec<&'a mut Value>) {
    match value {
        Value::Number(_) => into.push(value),
        Value::Array(all) => all.iter_mut().for_each(|inner| numbers(inner, into)),
        Value::Object(all) => all.values_mut().for_each(|inner| numbers(inner, into)),
        _ => {}
    }
}

/// Changes a number of the scenario, or a key.
fn attack_scenario(scenario: &mut Value, rng: &mut impl Rng) {
    let keys = scenario.as_object().expect("an object").keys();
    let keys: Vec<String> =
        keys.filter(|key| !["flow", "feedback", "robot"].contains(&key.as_str())).cloned().collect();
    let key = keys.choose(rng).expect("there are some").clone();
    match rng.random_range(0..8) {
        0 if key != "horizon_s" => drop(scenario.as_object_mut().map(|all| all.remove(&key))),
        1 => {
            scenario["keep"] = json!([{ "speed": { "frame": "fore", "most_m_s": rng.random_range(0.5..3.0) },
            "from_s": rng.random_range(0.0..0.9) }])
        }
        2 => scenario["enforced_limits"]["jerk"] = json!(rng.random_range(20.0..90.0)),
        3 => scenario["payload"] = json!({ "link": "fore", "mass_kg": rng.random_range(1.0..90.0) }),
        _ => {
            let mut all = Vec::new();
            numbers(&mut scenario[&key], &mut all);
            if let Some(i) = (!all.is_empty()).then(|| rng.random_range(0..all.len())) {
                scaled(all[i], rng);
            }
        }
    }
}

/// Changes a number of the robot.
fn attack_robot(robot: &mut String, rng: &mut impl Rng) {
    let (from, to) = [
        ("mass value=\"1\"", "mass value=\"30\""),
        ("effort=\"100\"", "effort=\"0.1\""),
        ("upper=\"3\"", "upper=\"0.1\""),
        ("velocity=\"8\"", "velocity=\"0.3\""),
        ("radius=\"0.01\"", "radius=\"0.3\""),
        ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 1 0\"/>"),
        ("<origin xyz=\"0.5 0 0\"/>", "<origin xyz=\"0.5 0 0.2\"/>"),
        ("<child link=\"fore\"/>", "<child link=\"fore\"/><mimic joint=\"shoulder\"/>"),
        ("type=\"prismatic\"", "type=\"revolute\""),
        ("izz=\"0.02\"", "izz=\"20\""),
    ][rng.random_range(0..10)];
    *robot = robot.replacen(from, to, 1 + rng.random_range(0..2));
}

/// Adds $a (1 - x^2)^k$, a constant or a slope to the positions of a joint on a segment, and its rate to the velocities
/// unless these slip.
fn attack_motion(run: &mut Value, rng: &mut impl Rng) {
    let segments = run["curve"]["coefficients"].as_array().map_or(0, Vec::len);
    let (e, i) = (rng.random_range(0..segments), rng.random_range(0..3));
    // The Chebyshev coefficients of (1 - x^2)^2, of (1 - x^2)^3, of 1 and of x.
    let bumps = [
        &[0.375, 0.0, -0.5, 0.0, 0.125][..],
        &[0.3125, 0.0, -0.46875, 0.0, 0.1875, 0.0, -0.03125],
        &[1.0],
        &[0.0, 1.0],
    ];
    let bump = bumps[rng.random_range(0..4)];
    let size = [1e-7, 1e-5, 1e-3, 0.1, 1.0, 30.0, -0.5][rng.random_range(0..7)];
    let slips = rng.random_range(0..6) == 0;
    let horizon = run["curve"]["horizon_s"].as_f64().unwrap_or(1.0);
    let rows = &mut run["curve"]["coefficients"][e];
    let mut rates = vec![0.0; bump.len() + 1];
    for k in (1..bump.len()).rev() {
        rates[k - 1] = rates.get(k + 1).copied().unwrap_or(0.0) + 2.0 * k as f64 * bump[k];
    }
    rates[0] *= 0.5;
    for (k, c) in bump.iter().enumerate() {
        rows[i][k] = json!(rows[i][k].as_f64().unwrap_or_default() + size * c);
        let rate = if slips { 0.0 } else { size * rates[k] * 2.0 * segments as f64 / horizon };
        rows[3 + i][k] = json!(rows[3 + i][k].as_f64().unwrap_or_default() + rate);
    }
}

/// The promises of a scenario in the order of the format.
fn promises(scenario: &Scenario) -> Vec<&'static str> {
    let limits = scenario.limits();
    let is_limited = |quantity| limits.iter().any(|limit| limit.quantity == quantity);
    let file = &scenario.file;
    let pairs = scenario.scene.robot().tree_pairs(&[]).len();
    let of_joints = Quantity::JOINT.map(|quantity| (quantity.name(), is_limited(quantity)));
    let others = [
        ("keep", !file.keep.is_empty()),
        ("stand", file.stand.is_some()),
        ("obstacles", !file.obstacles.is_empty()),
        ("self_collision", scenario.keeps_links_clear() && pairs > 0),
    ];
    of_joints.into_iter().chain(others).filter(|(_, is_promised)| *is_promised).map(|(name, _)| name).collect()
}

/// Claims that fit anything, of the promises and the keys of a scenario.
fn attack_certificate(case: &mut Case, scenario: &Scenario, rng: &mut impl Rng) {
    let claim = [-1e-9, -1e-9, -1e-9, -1e-9, -1e-9, 0.0, 1.0, f64::MAX][rng.random_range(0..8)];
    let (certificate, keys) = (&mut case.certificate, &case.scenario);
    let promises = promises(scenario);
    let claims = vec![claim; promises.len()];
    certificate["promises"] = json!(promises);
    if rng.random_range(0..2) == 0 {
        let segments = case.run["curve"]["coefficients"].as_array().map_or(0, Vec::len);
        let halves = 1 << rng.random_range(2..5);
        let interval = |e: usize, k: usize| {
            let [from, to] = [k, k + 1].map(|k| -1.0 + 2.0 * k as f64 / f64::from(halves));
            json!([e, from, to, claims, []])
        };
        let all = (0..segments).flat_map(|e| (0..halves as usize).map(move |k| (e, k)));
        certificate["intervals"] = all.map(|(e, k)| interval(e, k)).collect();
    } else {
        for interval in certificate["intervals"].as_array_mut().expect("a list") {
            interval[3] = json!(claims);
        }
    }
    for place in certificate["waypoints"].as_array_mut().expect("a list") {
        place[2] = json!(claim.min(1.0));
    }
    if keys.get("goal").is_none() {
        certificate.as_object_mut().map(|all| all.remove("goal"));
    } else {
        certificate["goal"] = json!(claim.min(1.0));
    }
    let listed = certificate["keys"].as_object_mut().expect("an object");
    let by_default = ["continuity", "enforced_limits", "self_collision"];
    listed.retain(|key, _| keys.get(key).is_some() || by_default.contains(&key.as_str()));
    for key in ["keep", "payload"].into_iter().filter(|key| keys.get(*key).is_some()) {
        listed.insert(key.to_owned(), json!(if key == "keep" { "proved" } else { "assumed" }));
    }
    let [shortest, longest] = scenario.file.horizon_bounds();
    listed.insert("horizon_s".to_owned(), json!(if shortest < longest { "no promise" } else { "proved" }));
    let asked = |is_asked: bool| json!(if is_asked { "proved" } else { "no promise" });
    listed.insert("self_collision".to_owned(), asked(scenario.keeps_links_clear()));
    if rng.random_range(0..10) == 0 {
        let key = ["self_collision", "enforced_limits", "obstacles", "q_goal"][rng.random_range(0..4)];
        listed.insert(key.to_owned(), json!(["no promise", "proved", "assumed"][rng.random_range(0..3)]));
    }
}

#[test]
fn motions_that_break_a_promise_are_not_certified() {
    let number = |key: &str| std::env::var(key).ok().and_then(|text| text.parse().ok());
    let count: u64 = number("AGHF_ATTACKS").unwrap_or(ATTACKS);
    let first: u64 = number("AGHF_FIRST_ATTACK").unwrap_or(0);
    let file = std::env::var("AGHF_ATTACKS_FILE").ok();
    let mut file = file.map(|path| File::create(path).expect("it is writable"));
    let cases = cases();
    let (mut broken, mut reasons) = (0, BTreeMap::<String, usize>::new());
    for seed in first..first + count {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let mut case = cases.choose(rng).expect("there are some").clone();
        for _ in 0..=rng.random_range(0..2) {
            match rng.random_range(0..5) {
                0 => attack_robot(&mut case.robot, rng),
                1 | 2 => attack_motion(&mut case.run, rng),
                _ => attack_scenario(&mut case.scenario, rng),
            }
        }
        let Some(scenario) = case.read() else {
            continue;
        };
        attack_certificate(&mut case, &scenario, rng);
        let Some(what) = violation(&scenario, &case.run["curve"]) else {
            continue;
        };
        broken += 1;
        let texts = case.texts();
        if let Some(file) = &mut file {
            writeln!(file, "{}", json!(texts)).expect("it is writable");
        }
        let [robot, scenario, run, certificate] = &texts;
        let found = aghf_check::check([robot, scenario, run, certificate], &|_| None);
        let Err(reason) = found else {
            panic!("attack {seed} is certified although {what}: {found:?}");
        };
        let is_proof = reason.contains("is not proved");
        let kind = if is_proof { "not proved" } else { &reason };
        *reasons.entry(kind.to_owned()).or_default() += 1;
    }
    let proofs = reasons.get("not proved").copied().unwrap_or_default();
    // Most attacks break a promise, and most of these are refused because a bound is not proved, not for their form.
    assert!(3 * broken > count, "{broken} of {count} attacks break a promise");
    assert!(2 * proofs > broken as usize, "{proofs} of {broken}: {reasons:?}");
}
