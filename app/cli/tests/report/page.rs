//! Kinematics, clearances, plots and what the search found.

use crate::{floats, page_of, shorts, solved};
use aghf::dynamics::forward_kinematics;
use aghf::spatial::Placement;
use aghf_scenario::{Details, EnforcedLimits, PointOnTheWay, Scenario, SolveReport};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::{Value, json};

/// The largest page of a robot with 22 joints, bytes.
const MAX_PAGE: usize = 2_000_000;

#[test]
fn every_body_is_where_the_kinematics_put_it() {
    let scenario = Scenario::load("digit_free_step").expect("it is built in");
    let outcome = solved(&scenario, 1);
    let (text, data) = page_of(&scenario, &outcome);
    assert!(text.len() < MAX_PAGE, "{} bytes", text.len());
    let n = scenario.model.dof();
    let track = &data["tracks"][0];
    let (times, unit) = (floats(&track["times"]), track["unit"].as_f64().expect("a number"));
    let (positions, turns) = (shorts(&track["positions"]), shorts(&track["turns"]));
    assert_eq!(positions.len(), 3 * n * times.len());
    assert_eq!(turns.len(), 4 * n * times.len());
    let values = floats(&data["values"]);
    assert_eq!(values.len(), 4 * n * times.len());
    let mut placements = vec![Placement::identity(); n];
    for row in [0, times.len() / 3, times.len() - 1] {
        let (x, _) = outcome.curve.at(times[row]);
        let q = &x.as_slice()[..n];
        for (joint, q) in q.iter().enumerate() {
            // Times are of single precision, and velocities some 30 rad/s.
            assert!((values[4 * n * row + joint] - q).abs() < 1e-4, "joint {joint}");
        }
        forward_kinematics(&scenario.model, q, &mut placements).expect("of this robot");
        for (body, placement) in placements.iter().enumerate() {
            let at = n * row + body;
            for axis in 0..3 {
                let off = positions[3 * at + axis] * unit - placement.translation[axis];
                assert!(off.abs() < 2e-4, "body {body}: {off}");
            }
            let q = &turns[4 * at..4 * at + 4];
            let turn = UnitQuaternion::new_normalize(Quaternion::new(q[3], q[0], q[1], q[2]));
            let off = turn.to_rotation_matrix().into_inner() - placement.rotation;
            assert!(off.abs().max() < 5e-4, "body {body}: {off}");
        }
    }
}

#[test]
fn clearances_are_those_of_the_surroundings_and_have_names() {
    for name in [
        "kinova_obstacles_01",
        "kinova_gap_01",
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda/scenarios/box_0001.json"),
    ] {
        let scenario = Scenario::load(name).expect("it is there");
        let mut outcome = solved(&scenario, 1);
        // Whatever was found is good enough to look at.
        outcome.summary.feasibility.smallest_clearance_m = None;
        let (_, data) = page_of(&scenario, &outcome);
        let times = floats(&data["tracks"][0]["times"]);
        let (clearance, n) = (&data["clearance"], scenario.model.dof());
        let (values, points) = (floats(&clearance["values"]), floats(&clearance["points"]));
        let mut placements = vec![Placement::identity(); n];
        for row in (0..times.len()).step_by(17) {
            let (x, _) = outcome.curve.at(times[row]);
            forward_kinematics(&scenario.model, &x.as_slice()[..n], &mut placements).expect("of this robot");
            let known = scenario.scene.clearance(&placements).expect("of this robot");
            assert!((values[row] - known).abs() < 1e-4, "{name}: {} is {known}", values[row]);
            let point = |k: usize| &points[6 * row + 3 * k..6 * row + 3 * k + 3];
            let apart = point(0).iter().zip(point(1)).map(|(a, b)| (a - b) * (a - b));
            let apart = apart.sum::<f64>().sqrt();
            assert!((apart - known.abs()).abs() < 1e-4, "{name}: the points are {apart} apart, not {known}");
            let pair = clearance["pair"][row].as_u64().expect("a number") as usize;
            let names = &clearance["pairs"][pair];
            assert!(names.as_array().is_some_and(|names| names.len() == 2 && names[0] != names[1]), "{names}");
        }
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let told = data["least_clearance"].as_f64().expect("a number");
        assert!((least - told).abs() < 1e-6, "{least} is told as {told}");
    }
}

#[test]
fn the_efforts_of_the_joints_make_up_that_of_the_motion() {
    for name in ["kinova_free_01", "pendulum_3_swingup"] {
        let scenario = Scenario::load(name).expect("it is built in");
        let outcome = solved(&scenario, 2);
        let (_, data) = page_of(&scenario, &outcome);
        let joints = data["joints"].as_array().expect("a list");
        let sum: f64 = joints.iter().filter_map(|joint| joint["effort"].as_f64()).sum();
        let known = outcome.summary.control_effort;
        assert!((sum - known).abs() < 2e-3 * known, "{name}: {sum} is {known}");
    }
}

fn curves(plot: &Value, color: &str) -> usize {
    let svg = plot["svg"].as_str().expect("it is text");
    svg.matches(&format!("<polyline stroke=\"{color}\"")).count()
}

/// The page of a motion among obstacles with all limits of the robot.
fn page_with_limits() -> (String, Value) {
    let mut scenario = Scenario::load("kinova_obstacles_01").expect("it is built in");
    let outcome = solved(&scenario, 1);
    scenario.file.enforced_limits = EnforcedLimits::default();
    page_of(&scenario, &outcome)
}

#[test]
fn a_curve_for_each_joint_and_limits_in_its_colour() {
    let (_, data) = page_with_limits();
    let plots = data["plots"].as_array().expect("a list");
    let titles: Vec<_> = plots.iter().filter_map(|plot| plot["title"].as_str()).collect();
    let expected = ["Position", "Velocity", "Acceleration", "Torque", "Clearance", "Cost, by iteration", "Convergence"];
    assert_eq!(titles, expected);
    for plot in &plots[..4] {
        for joint in data["joints"].as_array().expect("a list") {
            let color = joint["color"].as_str().expect("it is text");
            assert_eq!(curves(plot, color), 1, "{} {joint}", plot["title"]);
        }
    }
    // The limits of joint 2, 2.24 rad, are in the plot.
    let svg = plots[0]["svg"].as_str().expect("it is text");
    let shaded = |joint: usize| {
        let color = data["joints"][joint]["color"].as_str().expect("it is text");
        svg.matches(&format!("fill=\"{color}\"")).count()
    };
    assert_eq!(shaded(1), 2);
}

/// Strips are beyond the limits that the scenario enforces, and the waypoints have the times of the motion.
#[test]
fn limits_are_the_enforced_ones_and_waypoints_have_their_times() {
    let mut scenario = Scenario::load("pendulum_2_swingup").expect("it is built in");
    let strips = |scenario: &Scenario, outcome: &SolveReport| {
        let (_, data) = page_of(scenario, outcome);
        let plots = data["plots"].as_array().expect("a list")[..4].iter();
        let svgs = plots.map(|plot| plot["svg"].as_str().expect("it is text").matches("<rect").count());
        (svgs.collect::<Vec<_>>(), data["waypoints"].clone())
    };
    let enforced = |limits: Value| serde_json::from_value(limits).expect("they are limits");
    let none = json!({ "position": false, "velocity": false, "torque": false });
    scenario.file.enforced_limits = enforced(none.clone());
    let outcome = solved(&scenario, 1);
    let (without, times) = strips(&scenario, &outcome);
    assert_eq!((without, times), (vec![0; 4], json!([])));
    let largest = outcome.curve.at(0.5 * outcome.curve.horizon()).1[2].abs();
    let mut limits = none;
    limits["acceleration"] = json!(largest);
    scenario.file.enforced_limits = enforced(limits);
    let (with, _) = strips(&scenario, &outcome);
    assert!(with[2] > 0 && [with[0], with[1], with[3]] == [0; 3], "{with:?}");

    let mut passing = outcome;
    let Details::Direct(details) = &mut passing.summary.details else { panic!("it was solved directly") };
    details.waypoint_times_s = vec![0.25, 0.75];
    let rest = PointOnTheWay { q: Some(vec![0.0; 2]), ..PointOnTheWay::default() };
    scenario.file.waypoints = vec![rest];
    let (_, found) = strips(&scenario, &passing);
    assert_eq!([&found[0]["time"], &found[1]["time"]], [&json!(0.25), &json!(0.75)]);
    let (x, _) = passing.curve.at(0.25);
    let mut placements = vec![Placement::identity(); 2];
    forward_kinematics(&scenario.model, &x.as_slice()[..2], &mut placements).expect("of this robot");
    // The pendulum moves in a plane, and its tip is further out than its second joint.
    let place: [f64; 3] = serde_json::from_value(found[0]["place"].clone()).expect("a place");
    let joint = placements[1].translation;
    assert!((joint - Vector3::from(place)).norm() > 0.1 && (joint.y - place[1]).abs() < 1e-9, "{place:?} {joint}");
    assert_eq!(found[1]["place"], Value::Null);
}

/// A torque of one joint is not in the colour of another one whose limits are smaller, and where strips of several
/// joints overlap, a grey one shows in their place until a joint is chosen.
#[test]
fn strips_beyond_limits_are_narrow_and_apart_and_labels_fit() {
    let (_, data) = page_with_limits();
    let numbers = |text: &str, key: &str| -> Vec<f64> {
        let begin = format!(" {key}=\"");
        let parts = text.split(begin.as_str()).skip(1);
        let values = parts.filter_map(|part| part.split('"').next()?.parse().ok());
        values.collect()
    };
    let (mut strips, mut grey) = (0, 0);
    for plot in data["plots"].as_array().expect("a list") {
        let svg = plot["svg"].as_str().expect("it is text");
        let height = numbers(svg, "height")[0];
        let mut shown = Vec::new();
        for strip in svg.split("<rect ").skip(1) {
            let strip = strip.split("/>").next().expect("its end");
            let [y, own] = ["y", "height"].map(|key| numbers(&format!(" {strip}"), key)[0]);
            let is_grey = strip.contains("#010101");
            assert!(is_grey || own < 0.04 * height, "{strip}");
            strips += 1;
            grey += usize::from(is_grey);
            if !strip.contains("opacity=\"0.25\"") {
                shown.push([y, y + own]);
            }
        }
        shown.sort_by(|[a, _], [b, _]| a.total_cmp(b));
        // Both ends are rounded to pixels, of which there are four to one of the page.
        let apart = |pair: &[[f64; 2]]| pair[0][1] <= pair[1][0] + 1.0;
        assert!(shown.windows(2).all(apart), "{}: {shown:?}", plot["title"]);
        for label in svg.split("<text ").skip(1) {
            let label = label.split('>').nth(1).and_then(|text| text.split('<').next());
            let label = label.expect("a text").trim();
            assert!(label.len() <= 8, "{label}");
        }
    }
    assert!(strips > 4 && grey > 1, "{strips} strips, {grey} grey");
}

#[test]
fn violations_on_the_way_are_told() {
    // The line hits something.
    let scenario = Scenario::load("kinova_cross_01").expect("it can be generated");
    let (_, data) = page_of(&scenario, &solved(&scenario, 1));
    let plots = data["plots"].as_array().expect("a list");
    let legend = plots[6]["legend"].as_array().expect("a list");
    let names: Vec<_> = legend.iter().filter_map(|entry| entry[0].as_str()).collect();
    assert_eq!(names, ["gradient norm", "largest violation"]);
}

#[test]
fn the_first_guess_and_other_minima_are_ghosts() {
    let scenario = Scenario::load("kinova_free_01").expect("it is built in");
    let outcome = solved(&scenario, 12);
    let (_, data) = page_of(&scenario, &outcome);
    let tracks = data["tracks"].as_array().expect("a list");
    let kinds: Vec<_> = tracks.iter().filter_map(|track| track["kind"].as_str()).collect();
    assert_eq!(kinds[..3], ["motion", "guess", "minimum"]);
    assert!(kinds.len() <= 4, "{kinds:?}");
    let minima = data["minima"].as_array().expect("a list");
    let starts: u64 = minima.iter().filter_map(|minimum| minimum["starts"].as_u64()).sum();
    assert!(minima.len() > 1 && starts <= 12, "{minima:?}");
    assert_eq!(minima[0]["track"], 0);
    assert_eq!(minima[1]["track"], 2);
    // All begin where the motion does, and the other minimum is another way.
    let positions = |track: usize| {
        let unit = tracks[track]["unit"].as_f64().unwrap_or(f64::NAN);
        shorts(&tracks[track]["positions"]).into_iter().map(move |x| x * unit).collect::<Vec<_>>()
    };
    let n = 3 * scenario.model.dof();
    let (motion, other) = (positions(0), positions(2));
    for (a, b) in motion[..n].iter().zip(&other[..n]) {
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
    let middle = |all: &[f64]| all[all.len() / n / 2 * n..][..n].to_vec();
    let apart = middle(&motion).iter().zip(middle(&other)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart > 0.05, "the minima are {apart} apart");
}
