//! Models built in code.

use crate::common::{robot, torques_somewhere};
use aghf::dynamics::{Data, rnea};
use aghf::model::{Joint, JointKind, JointSpec, Limits, Model, pendulum, random_tree};
use aghf::spatial::{Inertia, Placement};
use nalgebra::Vector3;

fn joint_names(model: &Model) -> Vec<&str> {
    model.joints().iter().map(Joint::name).collect()
}

#[test]
fn pendulums_in_code_are_those_of_the_files() {
    for n in 1..=6 {
        let (built, read) = (pendulum(n).expect("n > 0"), robot(&format!("pendulum_{n}")));
        assert_eq!(built.name(), read.name());
        assert_eq!(joint_names(&built), joint_names(&read));
        assert_eq!(built.mass(), n as f64);
        assert_close!(&torques_somewhere(&built), &torques_somewhere(&read), 1e-14);
        let continuous = |j: &Joint<f64>| j.kind() == JointKind::Continuous && *j.limits() == Limits::NONE;
        assert!(read.joints().iter().all(continuous), "{n}");
    }
    // A level link: 1 kg at 0.5 m, at rest and accelerating.
    let mut tau = [0.0_f64];
    let one = pendulum(1).expect("n > 0");
    rnea(&one, &mut Data::new(&one), &[0.0], &[0.0], &[2.0], &mut tau).expect("lengths agree");
    assert!((tau[0] - (0.5 * 9.81 + 0.25 * 2.0)).abs() < 1e-14, "{}", tau[0]);
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
    let refused = |specs: Vec<JointSpec<f64>>| Model::from_joints("mine", specs).expect_err("it is bad").to_string();
    assert_eq!(refused(vec![]), "mine: robot: has no moving joint");
    let twice = refused(vec![spec("a", None), spec("a", Some(0))]);
    assert_eq!(twice, "mine: joint 'a': the name occurs twice");
    for parent in [1, 2] {
        let later = refused(vec![spec("a", None), spec("b", Some(parent))]);
        assert_eq!(later, "mine: joint 'b': its parent does not come before it");
    }
    for error in [pendulum(0).expect_err("no link"), random_tree(0, 1).expect_err("no joint")] {
        assert!(error.to_string().contains("no moving joint"), "{error}");
    }
    let mut hollow = spec("b", Some(0));
    hollow.inertia = Inertia::zero();
    let model = Model::from_joints("mine", vec![spec("a", None), hollow]).expect("it is a tree");
    let error = model.check_regular("mine").expect_err("it is singular").to_string();
    assert!(error.starts_with("mine: joint 'b': ") && error.contains("singular"), "{error}");
}
