//! Reading robots from URDFs: the models, and the notes on unusual elements.

use crate::common::torques_somewhere;
use aghf::dynamics::{Data, crba, forward_kinematics, frame_placement, rnea};
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf::urdf::LoadNote::{ImpossibleInertia, Massless, Merged, Unlimited};
use aghf::urdf::{LoadNote, parse_urdf};
use nalgebra::{DMatrix, Isometry3, Matrix3, Rotation3, Unit, Vector3};

/// A body with a centre of mass and principal axes.
const BODY: &str = r#"<inertial><origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/><mass value="2"/>
  <inertia ixx="0.31" ixy="0.01" ixz="-0.02" iyy="0.42" iyz="0.03" izz="0.53"/></inertial>"#;
/// Another such body.
const TOOL: &str = r#"<inertial><origin xyz="-0.3 0.15 0.25" rpy="-0.7 0.8 1.9"/><mass value="1.5"/>
  <inertia ixx="0.21" ixy="-0.04" ixz="0.03" iyy="0.22" iyz="0.02" izz="0.33"/></inertial>"#;

fn link(name: &str, inertial: &str) -> String {
    format!("<link name=\"{name}\">{inertial}</link>\n")
}

/// A joint with the name of its child, with `more` for origin, axis and limit.
fn joint(kind: &str, parent: &str, child: &str, more: &str) -> String {
    let ends = format!(r#"<parent link="{parent}"/><child link="{child}"/>"#);
    format!("<joint name=\"{child}_joint\" type=\"{kind}\">{ends}{more}</joint>\n")
}

fn load(elements: &[String]) -> (Model, Vec<LoadNote>) {
    let text = format!("<robot name=\"test\">{}</robot>", elements.concat());
    parse_urdf(&text, "test.urdf").unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A robot with one joint, which moves [`BODY`].
pub fn one_joint(kind: &str, more: &str) -> (Model, Vec<LoadNote>) {
    let links = [link("base", ""), link("body", BODY)];
    load(&[links.concat(), joint(kind, "base", "body", more)])
}

fn torques(model: &Model, state: [&[f64]; 3]) -> Vec<f64> {
    let mut tau = vec![0.0; model.dof()];
    let [q, v, a] = state;
    rnea(model, &mut Data::new(model), q, v, a, &mut tau).expect("lengths agree");
    tau
}

fn mass_matrix(model: &Model, q: &[f64]) -> DMatrix<f64> {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h).expect("lengths agree");
    h
}

/// Turning about the fixed axes x, y, z in this order, written out.
fn rpy([r, p, y]: [f64; 3]) -> Matrix3<f64> {
    let (sr, cr) = r.sin_cos();
    let (sp, cp) = p.sin_cos();
    let (sy, cy) = y.sin_cos();
    let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
    let about_y = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    let about_z = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
    about_z * about_y * about_x
}

fn pose(xyz: [f64; 3], angles: [f64; 3]) -> Isometry3<f64> {
    let rotation = Rotation3::from_matrix_unchecked(rpy(angles));
    Isometry3::from_parts(Vector3::from(xyz).into(), rotation.into())
}

fn turn(axis: [f64; 3], q: f64) -> Isometry3<f64> {
    let axis = Unit::new_normalize(Vector3::from(axis));
    Isometry3::from_parts(Vector3::zeros().into(), Rotation3::from_axis_angle(&axis, q).into())
}

fn inertia_tensor([ixx, ixy, ixz, iyy, iyz, izz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz)
}

/// The contribution of a point mass at `d` to the tensor.
fn steiner(mass: f64, d: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * mass
}

pub fn unlimited(joint: &str) -> LoadNote {
    Unlimited { joint: joint.to_owned() }
}

pub fn massless(link: &str) -> LoadNote {
    Massless { link: link.to_owned() }
}

fn merged(link: &str, into: Option<&str>) -> LoadNote {
    Merged { link: link.to_owned(), joint: format!("{link}_joint"), into: into.map(str::to_owned) }
}

#[test]
fn impossible_inertia_is_told_and_kept() {
    let body = |mass: &str, ixx: &str, iyy: &str| {
        let moments = format!(r#"ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="0.1""#);
        format!(r#"<inertial><mass value="{mass}"/><inertia {moments}/></inertial>"#)
    };
    for (inertial, words) in [
        (body("1", "1", "0.1"), "exceeds the sum of the others"),
        (body("1", "0.1", "-0.05"), "-5e-2 is negative"),
        (body("0", "0.1", "0.1"), "rotational inertia but no mass"),
    ] {
        let links = link("base", "") + &link("body", &inertial);
        let (model, report) = load(&[links, joint("continuous", "base", "body", "")]);
        let [_, ImpossibleInertia { link, condition }] = &report[..] else {
            panic!("{words}: {report:?}");
        };
        assert_eq!(link, "body");
        assert!(condition.contains(words), "{condition}");
        assert!(report[1].to_string().starts_with("link 'body': "));
        let ixx = if words.starts_with("exceeds") { 1.0 } else { 0.1 };
        assert_eq!(mass_matrix(&model, &[0.3])[(0, 0)], ixx, "about x: {words}");
    }
}

/// A point mass on a universal joint: a spherical pendulum, with known dynamics.
#[test]
fn a_massless_link_between_two_joints_is_a_universal_joint() {
    let bob = r#"<inertial><origin xyz="0 0 -0.7"/><mass value="3"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>"#;
    let (model, report) = load(&[
        link("base", "") + &link("cross", "") + &link("bob", bob),
        joint("continuous", "base", "cross", r#"<axis xyz="1 0 0"/>"#),
        joint("continuous", "cross", "bob", r#"<axis xyz="0 1 0"/>"#),
    ]);
    assert_eq!(report, [massless("base"), massless("cross")]);
    let (q, inertia, weight) = ([0.4_f64, -1.1_f64], 3.0 * 0.7 * 0.7, 3.0 * 9.81 * 0.7);
    let expected = [inertia * q[1].cos().powi(2), 0.0, 0.0, inertia];
    assert_close!(mass_matrix(&model, &q).as_slice(), &expected, 1e-14);
    let gravity = [q[0].sin() * q[1].cos(), q[0].cos() * q[1].sin()].map(|g| weight * g);
    assert_close!(&torques(&model, [&q, &[0.0; 2], &[0.0; 2]]), &gravity, 1e-13);
}

#[test]
fn the_inertial_frame_turns_and_moves_the_inertia() {
    let (model, _) = one_joint("continuous", "");
    let inertia = model.inertias()[0];
    let turned = rpy([0.4, -0.5, 0.6]);
    let tensor = turned * inertia_tensor([0.31, 0.01, -0.02, 0.42, 0.03, 0.53]) * turned.transpose();
    assert_eq!(inertia.mass, 2.0);
    assert_eq!(inertia.first_moment, Vector3::new(0.2, -0.4, 0.6));
    let about_origin = tensor + steiner(2.0, Vector3::new(0.1, -0.2, 0.3));
    assert_close!(&inertia.rotational, &about_origin, 1e-15);
}

#[test]
fn axes_are_normalised_and_keep_their_direction() {
    let third = 1.0 / 3.0;
    for (written, expected) in [
        ("0 0 -5", [0.0, 0.0, -1.0]),
        ("0 -1 0", [0.0, -1.0, 0.0]),
        ("1 -2 2", [third, -2.0 * third, 2.0 * third]),
        ("-3e200 0 4e200", [-0.6, 0.0, 0.8]),
        ("3e-200 0 -4e-200", [0.6, 0.0, -0.8]),
        ("0.6 0 0.8", [0.6, 0.0, 0.8]),
    ] {
        let (model, _) = one_joint("revolute", &format!(r#"<axis xyz="{written}"/>"#));
        assert_close!(model.joints()[0].axis(), &expected, 2e-16);
    }
    let (model, _) = one_joint("revolute", "");
    assert_eq!(*model.joints()[0].axis(), Vector3::x(), "the default of URDF");
}

const SHOULDER: &str = r#"<origin xyz="0.2 0.3 0.5" rpy="0.3 0.2 -0.9"/><axis xyz="1 2 -1"/>"#;
const FLANGE: &str = r#"<origin xyz="0.4 -0.6 0.7" rpy="1.1 -0.4 2.3"/>"#;
const WRIST: &str = r#"<origin xyz="-0.1 0.2 0.35" rpy="-0.6 0.9 0.2"/><axis xyz="-2 1 1"/>"#;

/// A tool fixed between two moving joints has the same effect as its inertia added to its parent link.
#[test]
fn a_fixed_link_between_moving_joints_is_merged() {
    let (arm, report) = load(&[
        link("base", "") + &link("body", BODY) + &link("tool", TOOL) + &link("hand", BODY),
        joint("continuous", "base", "body", SHOULDER),
        joint("fixed", "body", "tool", FLANGE),
        joint("continuous", "tool", "hand", WRIST),
    ]);
    assert_eq!(report, [massless("base"), merged("tool", Some("body_joint"))]);

    // By hand: the placements of the tool and the wrist in the body, and the two masses by Steiner's theorem.
    let flange = pose([0.4, -0.6, 0.7], [1.1, -0.4, 2.3]);
    let turned_by = |rotation: Matrix3<f64>, i: Matrix3<f64>| rotation * i * rotation.transpose();
    let body = turned_by(rpy([0.4, -0.5, 0.6]), inertia_tensor([0.31, 0.01, -0.02, 0.42, 0.03, 0.53]));
    let tool = turned_by(
        flange.rotation.to_rotation_matrix().into_inner() * rpy([-0.7, 0.8, 1.9]),
        inertia_tensor([0.21, -0.04, 0.03, 0.22, 0.02, 0.33]),
    );
    let body_com = Vector3::new(0.1, -0.2, 0.3);
    let tool_com = (flange * nalgebra::Point3::new(-0.3, 0.15, 0.25)).coords;
    let com = (body_com * 2.0 + tool_com * 1.5) / 3.5;
    let i = body + tool + steiner(2.0, body_com - com) + steiner(1.5, tool_com - com);
    let wrist = flange * pose([-0.1, 0.2, 0.35], [-0.6, 0.9, 0.2]);
    let numbers = |x: &[f64]| x.iter().map(|x| format!("{x:?} ")).collect::<String>();
    let (roll, pitch, yaw) = wrist.rotation.euler_angles();
    let moments = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]
        .iter()
        .zip([i.m11, i.m12, i.m13, i.m22, i.m23, i.m33])
        .map(|(key, moment)| format!(r#"{key}="{moment:?}" "#))
        .collect::<String>();
    let com = numbers(com.as_slice());
    let both = format!(r#"<inertial><origin xyz="{com}"/><mass value="3.5"/><inertia {moments}/></inertial>"#);
    let (xyz, angles) = (numbers(wrist.translation.vector.as_slice()), numbers(&[roll, pitch, yaw]));
    let wrist = format!(r#"<origin xyz="{xyz}" rpy="{angles}"/><axis xyz="-2 1 1"/>"#);
    let (by_hand, _) = load(&[
        link("base", "") + &link("body", &both) + &link("hand", BODY),
        joint("continuous", "base", "body", SHOULDER),
        joint("continuous", "body", "hand", &wrist),
    ]);
    assert_close!(&torques_somewhere(&arm), &torques_somewhere(&by_hand), 1e-14);
}

/// Fixed joints in a row, on the base and on a moving body.
#[test]
fn chains_of_fixed_joints_are_merged_and_their_frames_are_where_geometry_says() {
    let (model, report) = load(&[
        ["base", "plate", "post", "body", "tool", "tip"].map(|l| link(l, BODY)).concat(),
        joint("fixed", "base", "plate", FLANGE),
        joint("fixed", "plate", "post", WRIST),
        joint("revolute", "post", "body", SHOULDER),
        joint("fixed", "body", "tool", FLANGE),
        joint("fixed", "tool", "tip", WRIST),
    ]);
    let expected = [
        merged("plate", None),
        merged("post", None),
        unlimited("body_joint"),
        merged("tool", Some("body_joint")),
        merged("tip", Some("body_joint")),
    ];
    assert_eq!(report, expected);
    assert!(report[0].to_string().contains("link 'plate'") && report[0].to_string().contains("into the base"));
    assert!(report[3].to_string().contains("'tool_joint' into the body of joint 'body_joint'"));
    assert_eq!(model.mass(), 6.0, "what is fixed to the base does not count");

    let q = 0.8;
    let mut bodies = [Placement::identity()];
    forward_kinematics(&model, &[q], &mut bodies).expect("lengths agree");
    let flange = pose([0.4, -0.6, 0.7], [1.1, -0.4, 2.3]);
    let wrist = pose([-0.1, 0.2, 0.35], [-0.6, 0.9, 0.2]);
    let shoulder = pose([0.2, 0.3, 0.5], [0.3, 0.2, -0.9]) * turn([1.0, 2.0, -1.0], q);
    let steps = [Isometry3::identity(), flange, wrist, shoulder, flange, wrist];
    let mut expected = Isometry3::identity();
    assert_eq!(model.frames().len(), 6);
    for (frame, step) in model.frames().iter().zip(steps) {
        expected *= step;
        let found = frame_placement(frame, &bodies).expect("lengths agree");
        assert_close!(&found.translation, &expected.translation.vector, 1e-14);
        assert_close!(&found.rotation, expected.rotation.to_rotation_matrix().matrix(), 1e-14);
    }
}
