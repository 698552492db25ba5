//! Built-in robots, robots built in code or at random, and the order of their joints.

use crate::common::robot;
use aghf::dynamics::{Data, crba, rnea};
use aghf::model::{Joint, JointKind, JointSpec, Limits, Model, pendulum, random_tree};
use aghf::spatial::{Inertia, Placement};
use aghf::urdf::{LoadNote, builtin_robots, load_robot, parse_urdf};
use nalgebra::{DMatrix, Vector3};
use std::path::Path;

/// The text of a robot in `robots/`.
fn urdf(name: &str) -> String {
    let file = format!("robots/{name}/{name}.urdf");
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).expect("it exists")
}

/// The links and joints of such a text, each of which begins on a separate line.
fn elements(text: &str) -> (String, Vec<String>) {
    let mut parts = vec![String::new()];
    for line in text.lines().filter(|line| *line != "</robot>") {
        if line.starts_with("  <link ") || line.starts_with("  <joint ") {
            parts.push(String::new());
        }
        let last = parts.last_mut().expect("there is one");
        *last += &format!("{line}\n");
    }
    (parts.remove(0), parts)
}

fn joint_names(model: &Model) -> Vec<&str> {
    model.joints().iter().map(Joint::name).collect()
}

fn torques_somewhere(model: &Model) -> Vec<f64> {
    let n = model.dof();
    let [q, v, a] = [0.3, 1.7, 2.9].map(|c| {
        (0..n)
            .map(|i| 2.0 * (c + 1.3 * i as f64).sin())
            .collect::<Vec<_>>()
    });
    let mut tau = vec![0.0; n];
    rnea(model, &mut Data::new(model), &q, &v, &a, &mut tau).expect("lengths agree");
    tau
}

#[test]
fn joints_are_numbered_depth_first_by_name_whatever_the_order_of_the_file() {
    for name in builtin_robots() {
        let (head, mut parts) = elements(&urdf(name));
        assert!(parts.len() >= 3, "{name}: {} elements", parts.len());
        let (expected, notes) = load_robot(name).expect("built in");
        for turn in 0..4 {
            match turn {
                0 => parts.reverse(),
                1 => parts.sort(),
                // A step that is coprime to the number of elements visits all.
                _ => {
                    let (count, step) = (parts.len(), if parts.len() % 7 == 0 { 5 } else { 7 });
                    parts = (0..count)
                        .map(|i| parts[(i * step + turn) % count].clone())
                        .collect();
                    parts.dedup();
                    assert_eq!(parts.len(), count, "{name}: {step} skips some");
                }
            }
            let text = format!("{head}{}</robot>", parts.concat());
            let (model, report) = parse_urdf(&text, name).expect("it is as good");
            assert_eq!(format!("{model:?}"), format!("{expected:?}"), "{name}");
            assert_eq!(report, notes, "{name}");
        }
    }
}

/// The children of a link are in the order of the names of their joints, not of their own names or of the file.
#[test]
fn siblings_are_in_alphabetical_order_of_joint_names() {
    let body = r#"<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"#;
    let links = ["base", "a", "b", "c", "d"].map(|l| format!(r#"<link name="{l}">{body}</link>"#));
    let joint = |name: &str, parent: &str, child: &str| {
        let ends = format!(r#"<parent link="{parent}"/><child link="{child}"/>"#);
        format!(r#"<joint name="{name}" type="continuous">{ends}</joint>"#)
    };
    let joints = [
        joint("j_9", "base", "a"),
        joint("j_10", "base", "b"),
        joint("J_11", "base", "c"),
        joint("a_0", "b", "d"),
    ];
    let text = format!(
        r#"<robot name="tree">{}{}</robot>"#,
        links.concat(),
        joints.concat()
    );
    let (model, _) = parse_urdf(&text, "tree.urdf").expect("it is good");
    assert_eq!(joint_names(&model), ["J_11", "j_10", "a_0", "j_9"]);
    let parents: Vec<_> = model.joints().iter().map(Joint::parent).collect();
    assert_eq!(parents, [None, None, Some(1), None]);
    let links: Vec<_> = model.frames().iter().map(|f| f.name.as_str()).collect();
    assert_eq!(links, ["base", "c", "b", "d", "a"]);
}

#[test]
fn kinova_has_seven_joints_in_a_row() {
    let (model, report) = load_robot("kinova_gen3").expect("built in");
    let names = [
        "joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6", "joint_7",
    ];
    assert_eq!(joint_names(&model), names);
    let parents: Vec<_> = model.joints().iter().map(Joint::parent).collect();
    assert_eq!(
        parents,
        [None, Some(0), Some(1), Some(2), Some(3), Some(4), Some(5)]
    );
    // 1.3773 + 1.1636 + 1.1636 + 0.9302 + 0.6781 + 0.6781 + 0.5; the base of 1.697 does not move.
    assert!((model.mass() - 6.4909).abs() < 1e-12, "{}", model.mass());
    let link = "end_effector_link".to_owned();
    let merged = LoadNote::Merged {
        link: link.clone(),
        joint: "end_effector".to_owned(),
        into: Some("joint_7".to_owned()),
    };
    // Each joint has damping of 7.4 to 10.5 N m s and friction of 0.1 to 0.6 N m in the file.
    let lost = |note: &&LoadNote| matches!(note, LoadNote::LeftOut { .. });
    assert_eq!(report.iter().filter(lost).count(), 14);
    let others: Vec<_> = report.iter().filter(|note| !lost(note)).collect();
    assert_eq!(others, [&LoadNote::Massless { link }, &merged]);
    let second = Limits {
        lower: -2.25,
        upper: 2.25,
        velocity: 1.3963,
        effort: 39.0,
    };
    assert_eq!(*model.joints()[1].limits(), second);
}

#[test]
fn digit_has_22_joints_in_the_order_of_its_scenarios() {
    let model = robot("digit_v3_pinned");
    // Up the left leg, down the left arm, then the right leg and the right arm; each with the joint that carries it.
    let expected = [
        ("left_toe_roll", None),
        ("left_toe_pitch", Some(0)),
        ("left_tarsus", Some(1)),
        ("left_knee", Some(2)),
        ("left_hip_pitch", Some(3)),
        ("left_hip_yaw", Some(4)),
        ("left_hip_roll", Some(5)),
        ("left_shoulder_roll", Some(6)),
        ("left_shoulder_pitch", Some(7)),
        ("left_shoulder_yaw", Some(8)),
        ("left_elbow", Some(9)),
        ("right_hip_roll", Some(6)),
        ("right_hip_yaw", Some(11)),
        ("right_hip_pitch", Some(12)),
        ("right_knee", Some(13)),
        ("right_tarsus", Some(14)),
        ("right_toe_pitch", Some(15)),
        ("right_toe_roll", Some(16)),
        ("right_shoulder_roll", Some(6)),
        ("right_shoulder_pitch", Some(18)),
        ("right_shoulder_yaw", Some(19)),
        ("right_elbow", Some(20)),
    ];
    let found: Vec<_> = model
        .joints()
        .iter()
        .map(|j| (j.name(), j.parent()))
        .collect();
    assert_eq!(found, expected);
    // The torso of 15.028392, two legs and arms of 15.590741 each (0.915088 + 0.818753 + 6.244279 + 1.227077 + 0.895793
    // + 1.322865 + 0.043881 + 0.531283 + 0.535396 + 1.440357 + 1.065387 + 0.550582), less the pinned left toe.
    assert!((model.mass() - 45.678591).abs() < 1e-12, "{}", model.mass());
}

#[test]
fn pendulums_in_code_are_those_of_the_files() {
    for n in 1..=6 {
        let (built, read) = (pendulum(n).expect("n > 0"), robot(&format!("pendulum_{n}")));
        assert_eq!(built.name(), read.name());
        assert_eq!(joint_names(&built), joint_names(&read));
        assert_eq!(built.mass(), n as f64);
        assert_close!(&torques_somewhere(&built), &torques_somewhere(&read), 1e-14);
        let continuous =
            |j: &Joint<f64>| j.kind() == JointKind::Continuous && *j.limits() == Limits::NONE;
        assert!(read.joints().iter().all(continuous), "{n}");
    }
    // A level link: 1 kg at 0.5 m, at rest and accelerating.
    let mut tau = [0.0_f64];
    let one = pendulum(1).expect("n > 0");
    rnea(&one, &mut Data::new(&one), &[0.0], &[0.0], &[2.0], &mut tau).expect("lengths agree");
    assert!(
        (tau[0] - (0.5 * 9.81 + 0.25 * 2.0)).abs() < 1e-14,
        "{}",
        tau[0]
    );
}

fn spec(name: &str, parent: Option<usize>) -> JointSpec<f64> {
    JointSpec {
        name: name.to_owned(),
        kind: JointKind::Revolute,
        parent,
        origin: Placement::identity(),
        axis: Vector3::y(),
        inertia: Inertia::from_com(1.0, Vector3::x(), nalgebra::Matrix3::identity()),
        limits: Limits::NONE,
    }
}

#[test]
fn bad_models_in_code_are_errors() {
    let refused = |specs: Vec<JointSpec<f64>>| {
        Model::from_joints("mine", specs)
            .expect_err("it is bad")
            .to_string()
    };
    assert_eq!(refused(vec![]), "mine: robot: has no moving joint");
    let twice = refused(vec![spec("a", None), spec("a", Some(0))]);
    assert_eq!(twice, "mine: joint 'a': the name occurs twice");
    for parent in [1, 2] {
        let later = refused(vec![spec("a", None), spec("b", Some(parent))]);
        assert_eq!(later, "mine: joint 'b': its parent does not come before it");
    }
    for error in [
        pendulum(0).expect_err("no link"),
        random_tree(0, 1).expect_err("no joint"),
    ] {
        assert!(error.to_string().contains("no moving joint"), "{error}");
    }
    let mut hollow = spec("b", Some(0));
    hollow.inertia = Inertia::zero();
    let model = Model::from_joints("mine", vec![spec("a", None), hollow]).expect("it is a tree");
    let error = model
        .check_regular("mine")
        .expect_err("it is singular")
        .to_string();
    assert!(
        error.starts_with("mine: joint 'b': ") && error.contains("singular"),
        "{error}"
    );
}

#[test]
fn random_trees_repeat_with_their_seed() {
    let shown = |n, seed| format!("{:?}", random_tree(n, seed).expect("n > 0"));
    assert_eq!(shown(9, 5), shown(9, 5));
    // The name contains the seed, so the dynamics are compared.
    let torques = |n, seed| torques_somewhere(&random_tree(n, seed).expect("n > 0"));
    assert_ne!(torques(9, 5), torques(9, 6));
}

#[test]
fn random_trees_are_of_all_kinds() {
    let trees: Vec<_> = (0..20)
        .map(|seed| random_tree(8, seed).expect("n > 0"))
        .collect();
    let some = |what: &dyn Fn(&Model, &Joint<f64>) -> bool| {
        trees.iter().any(|t| t.joints().iter().any(|j| what(t, j)))
    };
    for kind in [
        JointKind::Revolute,
        JointKind::Continuous,
        JointKind::Prismatic,
    ] {
        assert!(some(&|_, j| j.kind() == kind), "{kind:?}");
    }
    let axis = |what: &'static dyn Fn(f64) -> bool| some(&|_, j| j.axis().iter().all(|x| what(*x)));
    assert!(
        axis(&|x| x == 0.0 || x == -1.0),
        "along a negative coordinate axis"
    );
    assert!(axis(&|x| x.abs() > 0.1 && x.abs() < 0.9), "oblique");
    let children = |t: &Model, parent| t.joints().iter().filter(|j| j.parent() == parent).count();
    assert!(
        some(&|t, j| j.parent().is_some() && children(t, j.parent()) > 1),
        "a body with two children"
    );
    assert!(
        some(&|t, j| j.parent().is_none() && children(t, None) > 1),
        "a base with two children"
    );
    for tree in &trees {
        assert_eq!(tree.dof(), 8);
        assert!(
            tree.joints()
                .iter()
                .all(|j| (j.axis().norm() - 1.0).abs() < 1e-14)
        );
    }
}

#[test]
fn mass_matrices_of_random_trees_are_positive_definite() {
    for (n, seed) in (1..9).flat_map(|n| (0..10).map(move |seed| (n, seed))) {
        let tree = random_tree(n, seed).expect("n > 0");
        tree.check_regular("random")
            .expect("all bodies have inertia");
        let q: Vec<f64> = (0..n)
            .map(|i| 3.0 * (i as f64 + seed as f64).sin())
            .collect();
        let mut h = DMatrix::zeros(n, n);
        crba(&tree, &mut Data::new(&tree), &q, &mut h).expect("lengths agree");
        let smallest = h.symmetric_eigenvalues().min();
        assert!(smallest > 1e-6, "{n} {seed}: {smallest}");
    }
}
