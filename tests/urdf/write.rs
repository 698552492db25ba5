//! URDFs from other programs, and URDFs written by the library.

use crate::common::config;
use aghf::dynamics::{Data, rnea};
use aghf::model::{JointKind, JointSpec, Limits, Model, pendulum, random_tree};
use aghf::spatial::{Inertia, Placement};
use aghf::urdf::{LoadNote, Mimic, UrdfOptions, builtin_robot, builtin_robots, parse_urdf, parse_urdf_with};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// A robot as exported by a simulator, with many elements that do not concern dynamics, some of them invalid.
const FOUND: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<!-- generated from arm.urdf.xacro: <xacro:include filename="hand.xacro"/> -->
<robot name="found" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <material name="grey"><color rgba="1 1 1"/><texture/></material>
  <material name="grey"/>
  <gazebo reference="base"><sensor name="no type"/></gazebo>
  <transmission name="t"><actuator/></transmission>
  <link name="world"/>
  <link name="base">
    <inertial><mass value=" 4 "/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><mesh filename="package://nowhere/base.dae"/></geometry>
      <material name="grey"><texture/></material></visual>
    <visual><geometry><capsule/></geometry></visual>
    <contact><lateral_friction value="x"/></contact>
  </link>
  <link name="arm">
    <inertial><origin xyz="+1.5E-1  0	-2e-1 "/><mass value="+2.0E+0"/>
      <inertia ixx="1E-2" ixy="0" ixz="0" iyy=".01" iyz="0" izz="1."/></inertial>
    <visual/>
  </link>
  <link name="finger">
    <inertial><origin xyz="0 0 0.1"/><mass value="0.1"/>
      <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>
  </link>
  <joint name="fix" type="fixed"><parent link="world"/><child link="base"/><axis xyz="0 0 0"/>
    <limit/><mimic joint="swing" multiplier="none"/></joint>
  <joint name="swing" type="revolute"><parent link="base"/><child link="arm"/>
    <limit lower="-1" upper="1" velocity="2" effort="3"/><dynamics damping="much"/>
    <safety_controller/><calibration rising="never"/></joint>
  <joint name="grip" type="prismatic"><parent link="arm"/><child link="finger"/>
    <mimic joint="swing" multiplier="0.5"/></joint>
</robot>"#;

fn independent(text: &str) -> aghf::Result<(Model, Vec<LoadNote>)> {
    let options = UrdfOptions { mimic: Mimic::Independent, ..UrdfOptions::default() };
    parse_urdf_with(text, "found.urdf", options)
}

#[test]
fn only_what_the_dynamics_read_is_read() {
    let (model, report) = independent(FOUND).expect("what is broken is not read");
    let names: Vec<_> = model.joints().iter().map(|j| j.name()).collect();
    assert_eq!(names, ["swing", "grip"]);
    assert_eq!(model.joints()[0].axis(), &Vector3::x(), "the default");
    assert_eq!(model.joints()[0].limits().effort, 3.0);
    let arm = model.inertias()[0];
    assert_eq!((arm.mass, arm.first_moment.x), (2.0, 0.3));
    assert_eq!(model.frames().len(), 4);
    let told = report.iter().filter(|n| matches!(n, LoadNote::Merged { .. }));
    assert_eq!(told.count(), 1, "the base became part of the world: {report:?}");
}

#[test]
fn mimic_joints_are_refused_or_independent_as_is_asked_for() {
    let error = parse_urdf(FOUND, "found.urdf").expect_err("a joint mimics another");
    let text = error.to_string();
    let words = ["joint 'grip'", "mimics joint 'swing'", "--mimic independent", "Mimic::Independent"];
    assert!(words.iter().all(|w| text.contains(w)), "{text}");

    let (with, report) = independent(FOUND).expect("it is asked for");
    let note = LoadNote::Independent { joint: "grip".to_owned(), mimics: "swing".to_owned() };
    assert!(report.contains(&note), "{report:?}");
    assert_eq!(note.to_string(), "joint 'grip': mimics 'swing', independent here");
    let without = FOUND.replace(r#"<mimic joint="swing" multiplier="0.5"/>"#, "");
    let (without, _) = parse_urdf(&without, "found.urdf").expect("no joint mimics");
    assert_same(&with, &without, 0.0);
}

#[test]
fn macros_that_are_not_expanded_are_refused() {
    for (before, with) in [
        ("<link name=\"world\"/>", r#"<link name="world"/><xacro:hand side="left"/>"#),
        ("<visual/>", r#"<xacro:box_inertia m="1"/>"#),
    ] {
        let error = independent(&FOUND.replace(before, with)).expect_err("a part is missing");
        assert!(error.to_string().contains("run xacro"), "{error}");
    }
}

#[test]
fn limits_without_speed_or_effort_are_refused() {
    for attribute in [r#" velocity="2""#, r#" effort="3""#] {
        let error = independent(&FOUND.replace(attribute, "")).expect_err("it is required");
        assert!(error.to_string().contains("joint 'swing': its limit has no"), "{error}");
    }
}

fn torques(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let mut tau = vec![0.0; model.dof()];
    rnea(model, &mut Data::new(model), q, v, a, &mut tau).expect("lengths agree");
    tau
}

fn wave(n: usize, shift: f64) -> Vec<f64> {
    (0..n).map(|i| 2.0 * (shift + 1.3 * i as f64).sin()).collect()
}

/// Asserts that two models have the same joints in the same order, the same frames and the same dynamics.
fn assert_same(a: &Model, b: &Model, bound: f64) {
    assert_eq!(a.name(), b.name());
    for (a, b) in a.joints().iter().zip(b.joints()) {
        assert_eq!((a.name(), a.kind()), (b.name(), b.kind()));
        assert_eq!((a.limits(), a.parent()), (b.limits(), b.parent()));
        assert_close!(a.axis(), b.axis(), bound);
    }
    assert_eq!(a.frames().len(), b.frames().len());
    for (a, b) in a.frames().iter().zip(b.frames()) {
        assert_eq!((&a.name, a.body), (&b.name, b.body));
        assert_close!(&a.placement.translation, &b.placement.translation, bound);
        assert_close!(&a.placement.rotation, &b.placement.rotation, bound);
    }
    let n = a.dof();
    let (q, v, acceleration) = (wave(n, 0.3), wave(n, 1.7), wave(n, 2.9));
    let [a, b] = [a, b].map(|model| torques(model, &q, &v, &acceleration));
    assert_close!(&a, &b, bound);
}

fn written(model: &Model) -> Model {
    let text = model.to_urdf().unwrap_or_else(|e| panic!("{e}"));
    let (read, _) = parse_urdf(&text, "written.urdf").unwrap_or_else(|e| panic!("{e}\n{text}"));
    read
}

#[test]
fn robots_that_are_built_in_come_back() {
    for name in builtin_robots() {
        let model = builtin_robot(name).expect("it is there");
        let text = model.to_urdf().expect("a URDF can say it");
        assert!(!text.contains("inf\""), "{name}: other readers refuse it");
        assert_same(&written(&model), &model, 1e-12);
        assert_same(&written(&written(&model)), &written(&model), 1e-13);
    }
    let (found, _) = independent(FOUND).expect("it loads");
    assert_same(&written(&found), &found, 1e-15);
}

/// The joint on the fixed link comes first in the visit, and would not if it were on the link before.
#[test]
fn the_order_of_joints_survives_merging() {
    let body = r#"<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"#;
    let joint = |name: &str, kind: &str, parent: &str, child: &str| {
        format!(
            r#"<joint name="{name}" type="{kind}"><origin xyz="1 2 3" rpy="0.1 {FRAC_PI_2} 0.3"/>
            <parent link="{parent}"/><child link="{child}"/></joint><link name="{child}">{body}</link>"#
        )
    };
    let text = format!(
        r#"<robot name="r &lt;&amp;&quot;'&gt; ü"><link name="base"/>{}{}{}</robot>"#,
        joint("a", "fixed", "base", "plate"),
        joint("z &amp; &lt;", "continuous", "plate", "&quot;last&quot;"),
        joint("b", "continuous", "base", "first"),
    );
    let (model, _) = parse_urdf(&text, "order.urdf").expect("it is good");
    assert_eq!(model.name(), "r <&\"'> ü");
    assert_eq!(model.joints()[0].name(), "z & <");
    assert_same(&written(&model), &model, 1e-13);
}

/// A model with one joint, at `rotation`.
fn one_joint(rotation: Matrix3<f64>) -> JointSpec<f64> {
    JointSpec {
        name: "joint".to_owned(),
        kind: JointKind::Continuous,
        parent: None,
        origin: Placement::new(rotation, Vector3::new(1e-300, -2.0 / 3.0, 0.1)),
        axis: Vector3::x(),
        inertia: Inertia::from_com(1.0, Vector3::zeros(), Matrix3::identity()),
        limits: Limits::NONE,
    }
}

fn model_of(spec: JointSpec<f64>) -> Model {
    Model::from_joints("one", vec![spec]).expect("there is a joint")
}

proptest! {
    #![proptest_config(config(64))]

    /// URDFs have no order, so joints are matched by name.
    #[test]
    fn random_trees_come_back((n, seed) in (1..12_usize, 0..u64::MAX)) {
        let model = random_tree(n, seed).expect("there is a joint");
        let read = written(&model);
        assert_same(&written(&read), &read, 1e-13);
        let place = |name: &str| model.joints().iter().position(|j| j.name() == name).expect("it is kept");
        let order: Vec<usize> = read.joints().iter().map(|j| place(j.name())).collect();
        let sorted = |x: &[f64]| order.iter().map(|i| x[*i]).collect::<Vec<_>>();
        let (q, v, a) = (wave(n, 0.3), wave(n, 1.7), wave(n, 2.9));
        let ours = torques(&model, &q, &v, &a);
        assert_close!(&torques(&read, &sorted(&q), &sorted(&v), &sorted(&a)), &sorted(&ours), 1e-12);
    }

    /// At pitches of a quarter turn, and near it by less or little more than rounding, rotations are read back
    /// correctly.
    #[test]
    fn rotations_come_back_at_any_pitch(
        (roll, yaw, side, exponent) in (-3.2..3.2_f64, -3.2..3.2_f64, prop::bool::ANY, -18..1_i32)
    ) {
        let near = FRAC_PI_2 - 10_f64.powi(exponent);
        let pitch = if side { near } else { -near };
        // Forward and back, so that rounding leaves errors like those of products of rotations.
        let turn = Rotation3::from_euler_angles(0.3, 0.4, 0.5);
        let rotation = turn.inverse() * (turn * Rotation3::from_euler_angles(roll, pitch, yaw));
        let model = model_of(one_joint(rotation.into_inner()));
        let read = written(&model);
        let (ours, theirs) = (model.joints()[0].origin(), read.joints()[0].origin());
        assert_close!(&theirs.rotation, &ours.rotation, 2e-15);
        prop_assert_eq!(theirs.translation, ours.translation, "to the bit");
    }
}

/// Rotations by quarter turns, whose entries are zeros and ones.
#[test]
fn quarter_turns_come_back() {
    let turns = [Vector3::x(), Vector3::y(), Vector3::z()]
        .map(|axis| Rotation3::new(axis * FRAC_PI_2).into_inner().map(f64::round));
    for a in turns {
        for b in turns {
            for c in turns {
                let model = model_of(one_joint(a * b * c * a));
                let read = written(&model);
                let (ours, theirs) = (model.joints()[0].origin(), read.joints()[0].origin());
                assert_close!(&theirs.rotation, &ours.rotation, 2e-16);
            }
        }
    }
}

#[test]
fn what_no_urdf_can_say_is_refused() {
    let refused = |model: Model, words: &str| {
        let error = model.to_urdf().expect_err(words).to_string();
        assert!(words.split("; ").all(|word| error.contains(word)), "{error}; want {words}");
    };
    let spec = || one_joint(Matrix3::identity());
    let moon = pendulum(2).expect("two links").with_gravity(Vector3::new(0.0, 0.0, -1.62));
    refused(moon, "pendulum_2: robot: its gravity cannot be said");
    let limits = Limits { lower: -1.0, ..Limits::NONE };
    refused(model_of(JointSpec { limits, ..spec() }), "joint 'joint': a limit of it cannot be said");
    let still = Limits { lower: 0.0, upper: 0.0, velocity: 0.0, effort: 0.0 };
    let kind = JointKind::Revolute;
    let weak = Limits { upper: 1.0, velocity: 1.0, ..still };
    for limits in [still, weak] {
        refused(model_of(JointSpec { limits, kind, ..spec() }), "a limit of it cannot be said");
    }
    let mut inertia = spec().inertia;
    inertia.mass = 0.0;
    inertia.first_moment.x = 0.5;
    refused(model_of(JointSpec { inertia, ..spec() }), "the inertia that it moves cannot be said");
    let mirror = -Matrix3::identity();
    refused(model_of(one_joint(mirror)), "its origin cannot be said");
    let axis = Vector3::new(2.0, 0.0, 0.0);
    refused(model_of(JointSpec { axis, ..spec() }), "its axis cannot be said");
    let inertia = Inertia::zero();
    refused(model_of(JointSpec { inertia, ..spec() }), "joint 'joint': ; singular");
}

/// Partial limits, and a body with rotational inertia but no mass.
#[test]
fn unusual_limits_and_inertias_come_back() {
    let limits = Limits { upper: 2.0, effort: 0.1 + 0.2, ..Limits::NONE };
    let kind = JointKind::Prismatic;
    let model = model_of(JointSpec { limits, kind, ..one_joint(Matrix3::identity()) });
    assert_eq!(written(&model).joints()[0].limits(), &limits);
    let mut rotor = one_joint(Matrix3::identity());
    rotor.inertia = Inertia::from_com(0.0, Vector3::zeros(), Matrix3::identity());
    let model = model_of(rotor);
    assert_eq!(written(&model).inertias(), model.inertias());
}
