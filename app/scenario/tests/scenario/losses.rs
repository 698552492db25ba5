//! Scenarios whose robots have losses and rotor inertia.

use crate::written::{folder, load, solved_once, with};
use aghf::dynamics::{Data, rnea};
use aghf::model::Model;
use aghf_scenario::{FlowOptions, RestOptions, Scenario, Solve, SolveOptions};
use serde_json::{Value, json};

/// A motion of Kinova, each joint by a third of a radian in 2 s.
fn arm() -> Value {
    json!({
        "robot": "kinova_gen3", "robot_shape": "joint_frames", "horizon_s": 2.0,
        "q_start": [0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], "v_start": vec![0.0; 7],
        "q_goal": [0.3, 0.8, 0.3, 1.3, 0.3, 0.8, 0.3], "v_goal": vec![0.0; 7],
        "losses": true, "enforced_limits": { "velocity": false, "torque": false },
    })
}

fn torques(model: &Model, v: f64, a: f64) -> Vec<f64> {
    let mut tau = vec![0.0; 7];
    let [q, v, a] = [0.4, v, a].map(|x| [x; 7]);
    rnea(model, &mut Data::new(model), &q, &v, &a, &mut tau).expect("lengths agree");
    tau
}

/// True if a note on loading tells of losses that are not counted.
fn told(scenario: &Scenario) -> bool {
    let mut notes = scenario.load_notes.iter();
    notes.any(|note| note.to_string().contains("damping is not counted"))
}

#[test]
fn losses_count_where_they_are_asked_for() {
    let without = load("rigid", &with(arm(), json!({ "losses": false }))).expect("it is good");
    let counted = load("counted", &arm()).expect("it is good");
    assert!(without.model.drives().is_empty() && told(&without) && !told(&counted));
    let given = json!({ "damping": { "joint_1": 2.0 }, "friction": 0.0, "armature": 0.5 });
    let given = load("given", &with(arm(), json!({ "losses": given }))).expect("it is good");
    let rigid = torques(&without.model, 1.0, -1.0);
    let added = |scenario: &Scenario| -> Vec<f64> {
        let with = torques(&scenario.model, 1.0, -1.0);
        with.iter().zip(&rigid).map(|(with, rigid)| with - rigid).collect()
    };
    // The damping of the file, and nearly all of its friction.
    assert!((added(&counted)[0] - 10.5 - 0.5217).abs() < 1e-3, "{:?}", added(&counted));
    assert_close!(&added(&given)[..2], &[1.5, 7.406484581723072 - 0.5], 1e-12);
}

/// A motion of least effort is found by the direct method, its effort is that of the motor, and its summary says it
/// again.
#[test]
fn motions_count_losses() {
    let effort = |keys: Value| {
        let scenario = load("moved", &with(arm(), keys)).expect("it is good");
        let report = solved_once(&scenario);
        let kept = &report.summary.provenance.scenario.losses;
        assert_eq!(*kept, scenario.file.losses);
        let (model, data, n) = (&scenario.model, &mut Data::new(&scenario.model), 7);
        let (steps, mut sum, mut tau) = (2000, 0.0, vec![0.0; n]);
        for i in 0..=steps {
            let (x, xdot) = report.curve.at(2.0 * f64::from(i) / f64::from(steps));
            let (x, xdot) = (x.as_slice(), xdot.as_slice());
            rnea(model, data, &x[..n], &x[n..], &xdot[n..], &mut tau).expect("lengths agree");
            let end = if i % steps == 0 { 0.5 } else { 1.0 };
            sum += end * tau.iter().map(|tau| tau * tau).sum::<f64>() * 2.0 / f64::from(steps);
        }
        let told = report.summary.control_effort;
        assert!((told - sum).abs() < 1e-3 * sum, "{told} {sum}");
        told
    };
    let [rigid, lossy, heavy] =
        [json!({ "losses": false }), json!({ "losses": true }), json!({ "losses": { "armature": 1.0 } })].map(effort);
    assert!(lossy > 2.0 * rigid && heavy > 2.0 * rigid, "{rigid} {lossy} {heavy}");
}

/// The published flow and the flow to rest run with losses too.
#[test]
fn the_flow_counts_losses() {
    let keys = json!({ "losses": { "friction_velocity": 0.2, "armature": 0.1 } });
    let scenario = load("flowing", &with(arm(), keys)).expect("it is good");
    let flows = [SolveOptions::Flow(FlowOptions::default()), SolveOptions::Duals(RestOptions::default())];
    for options in flows {
        let method = options.method();
        let report = Solve::new(&scenario).options(options).run().expect("it is good");
        assert!(report.summary.success, "{method}: {:?}", report.summary);
    }
}

/// A joint that moves nothing with inertia counts as the lightest other one of its kind, and losses stay uncounted.
#[test]
fn a_joint_without_inertia_has_the_rotor_of_the_lightest_other_one() {
    let folder = folder();
    let urdf = r#"<robot name="arm">
        <link name="base"/><link name="upper"><inertial><origin xyz="0 0 1"/><mass value="2"/>
          <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <link name="tip"/>
        <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
          <limit lower="-2" upper="2" velocity="2" effort="40"/><dynamics damping="3"/></joint>
        <joint name="wrist" type="revolute"><parent link="upper"/><child link="tip"/><axis xyz="0 0 1"/>
          <limit lower="-2" upper="2" velocity="2" effort="5"/></joint></robot>"#;
    std::fs::write(folder.join("arm.urdf"), urdf).expect("it is writable");
    let scenario = json!({
        "robot": folder.join("arm.urdf"), "robot_shape": "joint_frames", "horizon_s": 2.0, "q_start": [0.0, 0.0],
        "v_start": [0.0, 0.0], "q_goal": [0.4, 1.0], "v_goal": [0.0, 0.0],
    });
    let read = load("massless", &scenario).expect("the wrist has a substitute");
    let drives: Vec<_> = read.model.drives().iter().map(|d| [d.damping, d.armature]).collect();
    assert_close!(&drives.concat(), &[0.0, 0.0, 0.0, 2.1], 1e-12);
    let notes: Vec<_> = read.load_notes.iter().map(ToString::to_string).collect();
    let told = |note: &String| note.contains("joint 'wrist': nothing") && note.contains("2.1 kg m^2");
    assert!(notes.iter().any(told), "{notes:?}");
    solved_once(&read);

    // The file that was read says so itself, and then no note is needed.
    let mut again = serde_json::to_value(&read.file).expect("numbers");
    assert_eq!(again["losses"]["damping"], 0.0);
    let same = load("again", &again).expect("it is good");
    assert_eq!(same.model.drives(), read.model.drives());
    let told = |note: &aghf::urdf::LoadNote| note.to_string().contains("rotor");
    assert!(!same.load_notes.iter().any(told));

    again["losses"] = json!({ "armature": { "wrist": 0.3 } });
    let given = load("given", &again).expect("it is good");
    assert_close!(&[given.model.drives()[1].armature], &[0.3], 0.0);
}
