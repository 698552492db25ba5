//! Certificates, and the checker that shares no code with what writes them.

#[path = "../judge/gantry.rs"]
mod gantry;

mod attacks;
mod checker;
mod points;
mod search;
mod shapes;
mod table;

use aghf::curve::{Chebyshev, Curve};
use aghf_scenario::certify::{Certification, Texts, certify};
use aghf_scenario::{CurveFile, Scenario};
use gantry::{FROM, TO};
use nalgebra::DMatrix;
use serde_json::{Value, json};
use std::path::Path;

/// The curve of a motion, given as positions and velocities of the joints, over `horizon`.
fn curve(joints: usize, degree: usize, horizon: f64, at: impl Fn(usize, f64) -> [f64; 2]) -> Curve {
    let chebyshev = Chebyshev::new(degree, horizon).expect("it is in range");
    let times = chebyshev.times().to_vec();
    let x = DMatrix::from_fn(2 * joints, degree + 1, |i, k| {
        let [q, v] = at(i % joints, times[k]);
        if i < joints { q } else { v }
    });
    Curve::new(chebyshev, x).expect("it has a column per node")
}

/// From rest to rest in 1 s by a polynomial of degree five.
fn smooth() -> Curve {
    curve(3, 8, 1.0, |i, t| {
        let way = TO[i] - FROM[i];
        let rise = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
        [FROM[i] + way * rise, way * 30.0 * (t * (1.0 - t)).powi(2)]
    })
}

/// The motion as it is written.
fn written(scenario: &Scenario, curve: &Curve) -> CurveFile {
    let joints = scenario.model.joints().iter();
    CurveFile::new(curve, joints.map(|joint| joint.name().to_owned()).collect())
}

/// The part of a summary that has the motion.
fn run(curve: &CurveFile) -> Value {
    json!({ "curve": curve })
}

/// The certification of a curve that passes waypoints at these times, in a tube.
fn certified(scenario: &Scenario, curve: &Curve, times: &[f64], tube: f64) -> aghf::error::Result<Certification> {
    let curve = written(scenario, curve);
    let full = serde_json::to_string(&scenario.file).expect("it is JSON");
    let texts = Texts { scenario: &[&full], run: &run(&curve).to_string() };
    certify(scenario, &curve, texts, times, tube)
}

/// A scenario of the gantry with a box, a cylinder and a capsule, a load, and these obstacles.
fn shaped(test: &str, obstacles: Value) -> Scenario {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("certify").join(test);
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    let keys = json!({ "self_collision": { "ignored_pairs": [] },
        "payload": { "link": "fore", "mass_kg": 0.1, "shape": { "cylinder": { "radius_m": 0.01, "length_m": 0.04 } },
            "shape_pose": { "position_m": [0.45, 0.0, 0.02], "orientation_xyzw": [0.0, 0.6, 0.0, 0.8] } } });
    let balls = gantry::scenario(test, keys);
    let along = r#"rpy="0 1.5707963267948966 0"/><geometry>"#;
    let cylinder = format!(
        r#"<link name="upper"><collision><origin xyz="0.25 0 0" {along}<cylinder radius="0.02" length="0.3"/></geometry>
           </collision>"#
    );
    let capsule = format!(
        r#"<link name="fore"><collision><origin xyz="0.2 0 0" {along}<capsule radius="0.015" length="0.2"/></geometry>
           </collision>"#
    );
    let urdf = (balls.source.text)
        .replacen(r#"<sphere radius="0.01"/>"#, r#"<box size="0.1 0.06 0.04"/>"#, 1)
        .replace(r#"<link name="upper">"#, &cylinder)
        .replace(r#"<link name="fore">"#, &capsule);
    std::fs::write(folder.join("gantry.urdf"), urdf).expect("the folder is writable");
    let mut file = balls.file;
    file.obstacles = serde_json::from_value(obstacles).expect("they are known");
    Scenario::new(file, "gantry", &folder).expect("it is good")
}
