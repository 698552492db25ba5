//! Periodic walks.

use crate::phases::walk;
use crate::written::{folder, load, with};
use aghf::dynamics::{Data, rnea};
use aghf::model::Joint;
use aghf::motion::{Sample, sample};
use aghf_scenario::{Scenario, Solve, Verdict};
use serde_json::{Value, json};

/// The joints of a leg with the axes of the left one, from the hip to the foot, each with the length of the link above
/// it, m.
const LEG: [(&str, [f64; 3], f64); 6] = [
    ("hip_yaw", [0.0, 0.0, 1.0], 0.1),
    ("hip_roll", [1.0, 0.0, 0.0], 0.05),
    ("hip_pitch", [0.0, 1.0, 0.0], 0.05),
    ("knee", [0.0, 1.0, 0.0], 0.4),
    ("ankle_pitch", [0.0, 1.0, 0.0], 0.4),
    ("ankle_roll", [1.0, 0.0, 0.0], 0.05),
];

/// A pelvis of 20 kg on two legs of 8 kg, mirror images of each other in mass and shape, with axes of roll and yaw that
/// point the same way on both sides; `side` is the mass that the pelvis has on its left, kg.
fn biped(side: f64) -> String {
    let link = |name: &str, mass: f64, at: [f64; 3]| {
        let [x, y, z] = at;
        format!(
            "<link name='{name}'><inertial><origin xyz='{x} {y} {z}'/><mass value='{mass}'/>\
             <inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.05'/></inertial></link>"
        )
    };
    let share = 0.2 * side / (20.0 + side);
    let mut text = link("pelvis", 20.0 + side, [0.0, share, 0.15]);
    for (leg, y) in [("left", 0.1), ("right", -0.1)] {
        let mut parent = "pelvis".to_owned();
        for (k, (joint, axis, length)) in LEG.iter().enumerate() {
            let name = format!("{leg}_{joint}");
            let [x, a, z] = axis;
            let beside = if k == 0 { y } else { 0.0 };
            let heavy = if joint.starts_with("hip_p") || joint.starts_with("knee") { 3.0 } else { 0.5 };
            text += &link(&format!("{name}_link"), heavy, [0.0, 0.0, -0.02]);
            text += &format!(
                "<joint name='{name}' type='revolute'><origin xyz='0 {beside} -{length}'/><parent link='{parent}'/>\
                 <child link='{name}_link'/><axis xyz='{x} {a} {z}'/><limit lower='-2' upper='2' effort='200' \
                 velocity='20'/></joint>"
            );
            parent = format!("{name}_link");
        }
        text += &format!(
            "<link name='{leg}_sole'/><joint name='{leg}_sole' type='fixed'><origin xyz='0 0 -0.05'/>\
             <parent link='{parent}'/><child link='{leg}_sole'/></joint>"
        );
    }
    format!("<robot name='biped'>{text}</robot>")
}

/// A step of the biped of 0.2 m from bent knees, and the next one the same on the other foot.
fn step(side: f64) -> Value {
    let file = folder().join(format!("biped_{side}.urdf"));
    std::fs::write(&file, biped(side)).expect("the folder is writable");
    let foot = json!({ "frame": "left_sole", "half_length_m": 0.1, "half_width_m": 0.05, "friction": 0.7 });
    let bent = [0.0, -0.25, 0.5, -0.25, 0.0, 0.0];
    let above = json!({ "size_m": [null, null, 1.0], "pose": { "position_m": [0.0, 0.0, 0.5] } });
    let bent: Vec<f64> = bent.into_iter().chain([0.0, 0.0, -0.25, 0.5, -0.25, 0.0]).collect();
    json!({
        "robot": file, "robot_shape": "joint_frames", "horizon_s": 0.6, "periodic": true,
        "q_start": bent, "v_start": vec![0.0; 12],
        "phases": [{
            "stand": foot, "lift_m": 0.05, "keep": [{ "frame": "right_sole", "box": above }],
            "land": { "frame": "right_sole", "position_m": [0.2, -0.2, 0.0], "orientation_xyzw": [0.0, 0.0, 0.0, 1.0] },
        }],
    })
}

/// The joint of the other leg.
fn twin(name: &str) -> String {
    match name.strip_prefix("left") {
        Some(rest) => format!("right{rest}"),
        None => name.replace("right", "left"),
    }
}

/// A joint of pitch keeps its sign on the other side, those of roll and yaw change it.
fn sign(name: &str) -> f64 {
    if name.ends_with("pitch") || name.ends_with("knee") { 1.0 } else { -1.0 }
}

fn names(scenario: &Scenario) -> Vec<String> {
    let joints = scenario.model.joints().iter();
    joints.map(|joint| Joint::name(joint).to_owned()).collect()
}

/// The step ends in the mirror image of its start, on the other foot, which lands there without speed. The next step is
/// the same: with the mirrored motion the robot on its other foot needs the mirrored torques.
#[test]
fn a_step_ends_in_the_mirror_image_of_its_start() {
    let scenario = load("step", &step(0.0)).expect("it is good");
    let found = Solve::new(&scenario).run_walk().expect("it is good");
    assert!(found.is_valid());
    let (phase, report) = &found.phases[0];
    assert_eq!(report.summary.verdict, Verdict::Optimal);
    assert_eq!(found.landings.len(), 1);
    assert!(found.landings[0].off < 1e-6 && found.landings[0].speed < 1e-6);
    let (names, samples) = (names(phase), sample(&phase.model, &report.curve, 100).expect("its joints"));
    let at = |name: &str| names.iter().position(|of| of == name).expect("a joint");
    let (first, last) = (&samples[0], &samples[100]);
    for (k, name) in names.iter().enumerate() {
        let other = at(&twin(name));
        for (start, end) in [(&first.q, &last.q), (&first.v, &last.v)] {
            assert!((end[other] - sign(name) * start[k]).abs() < 1e-9, "{name}");
        }
    }
    assert!(first.v.iter().any(|v| v.abs() > 0.1), "it walks on");
    let mut other = step(0.0);
    other["periodic"] = json!(false);
    other["phases"][0]["stand"]["frame"] = json!("right_sole");
    other["phases"][0]["keep"] = json!([]);
    other["phases"][0]["land"]["frame"] = json!("left_sole");
    let other = load("other", &other).expect("it is good");
    let order = self::names(&other);
    let Sample { q, v, a, u, .. } = &samples[30];
    let mirrored = |x: &[f64]| {
        let of = order.iter().map(|name| sign(name) * x[at(&twin(name))]);
        of.collect::<Vec<f64>>()
    };
    let mut torques = vec![0.0; 12];
    let mut data = Data::new(&other.model);
    rnea(&other.model, &mut data, &mirrored(q), &mirrored(v), &mirrored(a), &mut torques).expect("its joints");
    for (expected, torque) in mirrored(u).iter().zip(&torques) {
        assert!((expected - torque).abs() < 1e-9 * 200.0, "{expected} and {torque}");
    }
}

/// Two steps end as they start, whatever the sides of the robot, and the walk goes on from there.
#[test]
fn two_steps_end_as_they_start() {
    let mut two = with(walk(), json!({ "periodic": true }));
    two["phases"][1]["land"]["position_m"] = json!([0.2, 0.25, 0.0]);
    let scenario = load("two", &two).expect("it is good");
    let found = Solve::new(&scenario).run_walk().expect("it is good");
    assert!(found.is_valid());
    assert_eq!(found.landings.len(), 2);
    let state = |k: usize, at: f64| {
        let (phase, report) = &found.phases[k];
        let (x, _) = report.curve.at(at * report.curve.horizon());
        let n = phase.model.dof();
        let mut all: Vec<_> = names(phase).into_iter().zip(x.iter().take(n).copied()).collect();
        let speeds = names(phase).into_iter().map(|name| format!("{name} v"));
        all.extend(speeds.zip(x.iter().skip(n).copied()));
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all
    };
    for ((name, start), (_, end)) in state(0, 0.0).into_iter().zip(state(1, 1.0)) {
        assert!((start - end).abs() < 1e-9, "{name}: {start} and {end}");
    }
}

#[test]
fn periodic_walks_that_cannot_be_meant_are_refused() {
    let one = |side: f64| step(side);
    let mut goal = one(0.0);
    goal["q_goal"] = json!(vec![0.1; 12]);
    let mut still = one(0.0);
    still["phases"][0] = with(still["phases"][0].clone(), json!({ "land": null, "lift_m": null }));
    let no_phases = {
        let mut none = one(0.0);
        none["phases"] = json!([]);
        with(none, json!({ "q_goal": vec![0.0; 12], "v_goal": vec![0.0; 12] }))
    };
    let mut alone = with(walk(), json!({ "periodic": true }));
    alone["phases"] = json!([alone["phases"][0]]);
    for (name, walk, words) in [
        ("goal", goal, "q_goal: that of a periodic walk follows from its start"),
        ("still", still, "periodic: the last phase has no landing"),
        ("no_phases", no_phases, "periodic: phases: there are none"),
        ("heavy", one(10.0), "periodic: the torques that hold q_start and its mirror image differ by"),
        // The published standing leg has inertias in the frames of the hanging one.
        ("digit", alone, "periodic: the torques that hold q_start and its mirror image differ by"),
    ] {
        let refused = load(name, &walk).expect_err(name);
        assert!(refused.contains(words), "{name}: '{refused}' does not say '{words}'");
    }
}
