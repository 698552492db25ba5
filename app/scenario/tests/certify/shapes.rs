//! Clearances of robots with meshes.

use crate::{FROM, TO, certified, gantry, run, smooth, written};
use aghf::dynamics::forward_kinematics;
use aghf::geometry::Triangle;
use aghf::spatial::Placement;
use aghf::urdf::load_mesh;
use aghf_scenario::Scenario;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// An angle of two boxes, each with a length of 0.4 m, in mm.
const ANGLE: [[[f64; 3]; 2]; 2] = [[[0.0; 3], [400.0, 40.0, 40.0]], [[0.0; 3], [40.0, 40.0, 200.0]]];

/// The corners of a box, and its faces as triangles of them.
fn corner([lower, upper]: &[[f64; 3]; 2], i: usize) -> [f64; 3] {
    std::array::from_fn(|k| if i >> k & 1 == 0 { lower[k] } else { upper[k] })
}

const FACES: [[usize; 4]; 6] = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];

/// The text of an STL of a rod, and of an OBJ of an angle with faces of four corners, in mm.
fn meshes() -> [(&'static str, String); 2] {
    let rod = [[0.0, -15.0, -15.0], [450.0, 15.0, 15.0]];
    let mut stl = String::from("solid a rod\n");
    for [a, b, c, d] in FACES {
        for triangle in [[a, b, c], [a, c, d]] {
            stl += " facet normal 0 0 0\n  outer loop\n";
            for i in triangle {
                let [x, y, z] = corner(&rod, i);
                stl += &format!("   vertex {x} {y} {z}\n");
            }
            stl += "  endloop\n endfacet\n";
        }
    }
    stl += "endsolid a rod\n";
    let mut obj = String::from("# an angle\no angle\n");
    for (first, of) in [1, 9].into_iter().zip(&ANGLE) {
        for i in 0..8 {
            let [x, y, z] = corner(of, i);
            obj += &format!("v {x} {y} {z}\n");
        }
        for face in FACES {
            let [a, b, c, d] = face.map(|i| i + first);
            obj += &format!("f {a}//1 {b} {c} {d}\n");
        }
    }
    [("rod.stl", stl), ("angle.obj", obj)]
}

fn folder(test: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("certify").join(test)
}

/// The gantry with meshes on both links, among these obstacles.
fn meshed(test: &str, obstacles: Value) -> Scenario {
    let folder = folder(test);
    fs::create_dir_all(&folder).expect("the folder is writable");
    for (name, text) in meshes() {
        fs::write(folder.join(name), text).expect("the folder is writable");
    }
    let balls = gantry::scenario(test, json!({ "self_collision": { "ignored_pairs": [["upper", "fore"]] } }));
    let of = |link: &str, file: &str| {
        let mesh = format!(r#"<mesh filename="{file}" scale="0.001 0.001 -0.001"/>"#);
        (format!(r#"<link name="{link}">"#), format!("<collision><geometry>{mesh}</geometry></collision>"))
    };
    let mut urdf = balls.source.text.to_string();
    for (link, collision) in [of("upper", "rod.stl"), of("fore", "angle.obj")] {
        urdf = urdf.replace(&link, &format!("{link}{collision}"));
    }
    fs::write(folder.join("gantry.urdf"), urdf).expect("the folder is writable");
    let mut file = balls.file;
    file.obstacles = serde_json::from_value(obstacles).expect("they are known");
    Scenario::new(file, "gantry", &folder).expect("it is good")
}

fn ball(position: [f64; 3], radius: f64) -> Value {
    json!([{ "shape": { "sphere": { "radius_m": radius } }, "pose": { "position_m": position } }])
}

/// The certificate of the motion of the gantry, if there is one.
fn certificate(scenario: &Scenario) -> Option<Value> {
    let found = certified(scenario, &smooth(), &[], 0.0).expect("it is of this robot");
    found.certificate.map(|certificate| serde_json::to_value(certificate).expect("it is JSON"))
}

/// The text of the report of the checker and whether it is complete.
fn checked(
    scenario: &Scenario,
    certificate: &Value,
    meshes: &dyn Fn(&str) -> Option<Vec<u8>>,
) -> Result<(String, bool), String> {
    let (file, run) = (serde_json::to_string(&scenario.file), run(&written(scenario, &smooth())).to_string());
    let texts = [&*scenario.source.text, &file.expect("it is JSON"), &run, &certificate.to_string()];
    aghf_check::check(texts, meshes).map(|report| (report.text, report.is_complete))
}

#[test]
fn pieces_contain_their_meshes_or_are_refused() {
    let test = "meshes";
    let scenario = meshed(test, ball([0.3, -0.4, 0.0], 0.05));
    let good = certificate(&scenario).expect("the ball is out of the way");
    assert_eq!(good["complete"], true);
    let [angle, rod] = [0, 1].map(|i| good["pieces"][i].as_array().expect("pieces").len());
    assert_eq!((angle, rod), (2, 1), "the links are sorted by their names");
    let urdf = folder(test).join("gantry.urdf");
    let files = |name: &str| aghf_check::find_mesh(name, &urdf, &[]);
    let (report, is_complete) = checked(&scenario, &good, &files).expect("it is good");
    assert!(is_complete && report.contains("self_collision"), "{report}");

    let (report, is_complete) = checked(&scenario, &good, &|_| None).expect("it is good");
    assert!(!is_complete && report.contains("the pieces of 'rod.stl' contain"), "{report}");
    let other = |name: &str| files(name).map(|bytes| [&bytes[..], b"\n"].concat());
    assert!(checked(&scenario, &good, &other).is_err_and(|why| why.contains("another file")));

    let refused = |what: &str, spoil: &dyn Fn(&mut Value), why: &str| {
        let mut bad = good.clone();
        spoil(&mut bad);
        let found = checked(&scenario, &bad, &files);
        assert!(found.as_ref().is_err_and(|found| found.contains(why)), "{what}: {found:?}");
    };
    let not_within = "do not contain it";
    let all = |value: &mut Value| value.as_array().expect("a list").len();
    for mesh in 0..2 {
        for piece in 0..all(&mut good["pieces"][mesh].clone()) {
            for k in 0..all(&mut good["pieces"][mesh][piece][0].clone()) {
                let inward = |bad: &mut Value| {
                    let corners = bad["pieces"][mesh][piece][0].as_array_mut().expect("corners");
                    for i in 0..3 {
                        let all = corners.iter().map(|corner| corner[i].as_f64().expect("a number"));
                        let (middle, x) = (all.sum::<f64>() / corners.len() as f64, corners[k][i].as_f64());
                        let x = x.expect("a number");
                        corners[k][i] = json!(x + 2e-5 * (middle - x).signum());
                    }
                };
                refused("a corner inward", &inward, not_within);
            }
            let none = |bad: &mut Value| drop(bad["pieces"][mesh].as_array_mut().expect("pieces").remove(piece));
            refused("a piece is missing", &none, if mesh == 0 { "" } else { "no pieces" });
        }
    }
    refused("a mesh is missing", &|bad| drop(bad["pieces"].as_array_mut().expect("a list").pop()), "no pieces");
    let more = |bad: &mut Value| bad["pieces"].as_array_mut().expect("a list").push(json!([[[[0, 0, 0]], []]]));
    refused("more meshes", &more, "pieces of more meshes");
    let index = |bad: &mut Value| bad["pieces"][1][0][1][0][0] = json!(8);
    refused("a corner that is not there", &index, "a face without one");
}

/// The least distance of the triangles of meshes from a point over some times of the motion, m.
fn least_distance(scenario: &Scenario, meshes: &[(usize, Vec<Triangle>)], point: &Vector3<f64>) -> f64 {
    let mut placements = vec![Placement::identity(); 3];
    let mut least = f64::INFINITY;
    for k in 0..=200 {
        let t = f64::from(k) / 200.0;
        let rise = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
        let q: Vec<f64> = (0..3).map(|i| FROM[i] + (TO[i] - FROM[i]) * rise).collect();
        forward_kinematics(&scenario.model, &q, &mut placements).expect("three joints");
        for (body, triangles) in meshes {
            for [a, b, c] in triangles.iter().map(|t| t.map(|p| placements[*body].point(&p))) {
                // Points of the triangle, spaced by a thirtieth of its edges.
                for (i, j) in (0..=30).flat_map(|i| (0..=30 - i).map(move |j| (i, j))) {
                    let p = a + (b - a) * (f64::from(i) / 30.0) + (c - a) * (f64::from(j) / 30.0);
                    least = least.min((p - point).norm());
                }
            }
        }
    }
    least
}

/// What is certified to keep clear does, by points of the meshes themselves; what keeps clear by more than the pieces
/// stick out is certified.
#[test]
fn certified_motions_keep_their_meshes_clear() {
    let mut rng = ChaCha8Rng::seed_from_u64(74);
    let mut found = [0, 0];
    for _ in 0..24 {
        let position: [f64; 3] =
            [rng.random_range(-0.2..1.2), rng.random_range(-0.5..0.6), rng.random_range(-0.25..0.15)];
        let radius = rng.random_range(0.02..0.15);
        let scenario = meshed("clear", ball(position, radius));
        let scale = Vector3::new(0.001, 0.001, -0.001);
        let load = |file| load_mesh(file, &folder("clear"), &scale).expect("it is there");
        let meshes = [(1, load("rod.stl")), (2, load("angle.obj"))];
        let least = least_distance(&scenario, &meshes, &position.into()) - radius;
        let is_certified = certificate(&scenario).is_some();
        assert!(!is_certified || least > 0.0, "{position:?} with {radius}: {least}");
        // The balls of the URDF are in the way as well.
        let of_balls = [(0, vec![[Vector3::zeros(); 3]]), (2, vec![[Vector3::x() * 0.5; 3]])];
        let balls = least_distance(&scenario, &of_balls, &position.into()) - radius;
        assert!(is_certified || least < 0.02 || balls < 0.02, "{position:?} with {radius}: {least}");
        found[usize::from(is_certified)] += 1;
    }
    assert!(found.iter().all(|count| *count >= 3), "{found:?}");
}

/// The largest clearance that is certified is one that the checker proves: both have the radius of the pieces.
#[test]
fn the_checker_proves_the_largest_clearance_that_is_certified() {
    let (position, radius, test) = ([0.3, -0.4, 0.0], 0.05, "largest");
    let mut obstacles = ball(position, radius);
    let urdf = folder(test).join("gantry.urdf");
    let scale = Vector3::new(0.001, 0.001, -0.001);
    let meshed_with = |obstacles: &Value| meshed(test, obstacles.clone());
    let scenario = meshed_with(&obstacles);
    let meshes = [(1, "rod.stl"), (2, "angle.obj")];
    let meshes = meshes.map(|(body, file)| (body, load_mesh(file, &folder(test), &scale).expect("it is there")));
    let least = least_distance(&scenario, &meshes, &position.into()) - radius;
    let mut range = [least - 2e-3, least];
    for _ in 0..14 {
        let clearance = 0.5 * (range[0] + range[1]);
        obstacles[0]["clearance_m"] = json!(clearance);
        let scenario = meshed_with(&obstacles);
        let found = certificate(&scenario);
        range[usize::from(found.is_none())] = clearance;
        if let Some(found) = found {
            let checked = checked(&scenario, &found, &|name| aghf_check::find_mesh(name, &urdf, &[]));
            assert!(checked.is_ok(), "{clearance}: {checked:?}");
        }
    }
    assert!(range[1] - range[0] < 1e-6 && range[0] > least - 2e-3, "{range:?}");
}
