//! A model with locked joints moves like the full one while these joints are at rest.

use crate::common::{config, tree};
use aghf::dynamics::{Data, crba, forward_kinematics, frame_placement, rnea, root_wrench};
use aghf::model::{JointKind, JointSpec, Limits, Model, pendulum};
use aghf::spatial::{Inertia, Placement};
use aghf::urdf::{builtin_robot, parse_urdf};
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

fn torques(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let mut tau = vec![0.0; model.dof()];
    rnea(model, &mut Data::new(model), q, v, a, &mut tau).expect("lengths agree");
    tau
}

fn mass_matrix(model: &Model, q: &[f64]) -> DMatrix<f64> {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h).expect("lengths agree");
    h
}

/// The frames of all links in the base frame.
fn frames(model: &Model, q: &[f64]) -> Vec<(String, Placement<f64>)> {
    let mut bodies = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut bodies).expect("lengths agree");
    let placed = |f: &aghf::model::Frame<f64>| {
        let placement = frame_placement(f, &bodies).expect("lengths agree");
        (f.name.clone(), placement)
    };
    model.frames().iter().map(placed).collect()
}

/// A tree, a state of it, and its locked joints: not all of them.
fn tree_and_locks() -> impl Strategy<Value = (Model, [Vec<f64>; 3], Vec<bool>)> {
    (2..12_usize, 0..u64::MAX).prop_flat_map(|(n, seed)| {
        let numbers = || prop::collection::vec(-2.0..2.0_f64, n);
        let locks = prop::collection::vec(prop::bool::ANY, n);
        let some = locks.prop_filter("one joint is left", |locks| locks.contains(&false));
        let model = tree(n, seed);
        (Just(model), [numbers(), numbers(), numbers()], some)
    })
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn the_joints_that_are_left_move_as_before((model, [q, mut v, mut a], locks) in tree_and_locks()) {
        let gravity = Vector3::new(1.0, -2.0, 3.0);
        let model = model.with_gravity(gravity);
        let locked: Vec<_> = (0..model.dof()).filter(|i| locks[*i]).map(|i| (i, q[i])).collect();
        for (i, _) in &locked {
            (v[*i], a[*i]) = (0.0, 0.0);
        }
        let left = |x: &[f64]| -> Vec<f64> {
            x.iter().zip(&locks).filter(|(_, locked)| !**locked).map(|(x, _)| *x).collect()
        };
        let reduced = model.with_locked_joints(&locked).expect("a joint is left");
        let kept = model.joints().iter().zip(&locks).filter(|(_, locked)| !**locked);
        let names: Vec<_> = kept.map(|(joint, _)| joint.name()).collect();
        prop_assert_eq!(reduced.joints().iter().map(|j| j.name()).collect::<Vec<_>>(), names);
        prop_assert_eq!(reduced.gravity(), &gravity);

        let (q_left, v_left, a_left) = (left(&q), left(&v), left(&a));
        let expected = left(&torques(&model, &q, &v, &a));
        assert_close!(&torques(&reduced, &q_left, &v_left, &a_left), &expected, 1e-11);
        let h = mass_matrix(&model, &q);
        let indices: Vec<usize> = (0..model.dof()).filter(|i| !locks[*i]).collect();
        let expected = h.select_rows(&indices).select_columns(&indices);
        assert_close!(&mass_matrix(&reduced, &q_left), &expected, 1e-11);

        let (full, now) = (frames(&model, &q), frames(&reduced, &q_left));
        prop_assert_eq!(full.len(), now.len());
        for ((name, full), (same, now)) in full.iter().zip(&now) {
            prop_assert_eq!(name, same);
            assert_close!(&now.rotation, &full.rotation, 1e-12);
            assert_close!(&now.translation, &full.translation, 1e-11);
        }
        // Written to a file and read back, it is the same model with fixed joints.
        let upright = reduced.with_gravity(Vector3::new(0.0, 0.0, -9.81));
        let upright = upright.with_drives(Vec::new()).expect("none");
        let text = upright.to_urdf().expect("a URDF can say it");
        let (read, _) = parse_urdf(&text, "reduced").expect("it is good");
        prop_assert_eq!(read.dof(), upright.dof());
        prop_assert_eq!(read.frames().len(), upright.frames().len() + 1);
    }
}

proptest! {
    #![proptest_config(config(96))]

    /// Mounted at another place a robot has the torques of gravity as it points there, all frames at their places from
    /// there, and the force on its base turned likewise.
    #[test]
    fn a_mounted_robot_moves_as_under_turned_gravity(
        (model, [q, v, a], _) in tree_and_locks(),
        turn in prop::array::uniform3(-3.0..3.0_f64),
        place in prop::array::uniform3(-2.0..2.0_f64),
    ) {
        let inertia = Inertia::from_com(2.0, Vector3::new(0.1, 0.2, -0.3), Matrix3::identity());
        let model = model.with_base_inertia(inertia);
        let rotation = Rotation3::new(Vector3::from(turn)).into_inner();
        let mount = Placement::new(rotation, place.into());
        let gravity = Vector3::new(1.0, -2.0, 3.0);
        let turned = model.clone().with_gravity(rotation.transpose() * gravity);
        let mounted = model.mounted(&mount).expect("the same joints").with_gravity(gravity);
        assert_close!(&torques(&mounted, &q, &v, &a), &torques(&turned, &q, &v, &a), 1e-9);
        assert_close!(&mass_matrix(&mounted, &q), &mass_matrix(&turned, &q), 1e-9);
        for ((name, at), (same, there)) in frames(&turned, &q).iter().zip(&frames(&mounted, &q)) {
            prop_assert_eq!(name, same);
            let expected = mount.compose(at);
            assert_close!(&there.rotation, &expected.rotation, 1e-11);
            assert_close!(&there.translation, &expected.translation, 1e-10);
        }
        let [own, there] = [&turned, &mounted].map(|model| {
            root_wrench(model, &mut Data::new(model), &q, &v, &a).expect("lengths agree")
        });
        assert_close!(&there.linear, &(rotation * own.linear), 1e-8);
        let moment = rotation * own.angular + mount.translation.cross(&there.linear);
        assert_close!(&there.angular, &moment, 1e-8);
    }
}

/// Immovable mass is ignored, and limits stay with their joints.
#[test]
fn a_joint_locked_to_the_base_and_limits() {
    let spec = |name: &str, parent, upper| JointSpec {
        name: name.to_owned(),
        kind: JointKind::Revolute,
        parent,
        origin: Placement::new(Matrix3::identity(), Vector3::new(0.5, 0.0, 0.0)),
        axis: Vector3::z(),
        inertia: Inertia::from_com(1.0 + upper, Vector3::x(), Matrix3::identity()),
        limits: Limits { upper, ..Limits::NONE },
    };
    let specs = vec![spec("a", None, 1.0), spec("b", Some(0), 2.0), spec("c", Some(1), 3.0)];
    let model = Model::from_joints("three", specs).expect("a chain");
    let one = model.with_locked_joints(&[(0, 1.0)]).expect("two are left");
    assert_eq!((one.mass(), one.joints()[0].parent()), (7.0, None));
    let uppers: Vec<_> = one.joints().iter().map(|j| j.limits().upper).collect();
    assert_eq!(uppers, [2.0, 3.0]);
    let bodies: Vec<_> = one.frames().iter().map(|f| f.body).collect();
    assert_eq!(bodies, [None, Some(0), Some(1)]);
    let (sin, cos) = 1_f64.sin_cos();
    let shoulder = one.joints()[0].origin().translation;
    assert_close!(&shoulder, &[0.5 + 0.5 * cos, 0.5 * sin, 0.0], 1e-15);
    let tip = model.with_locked_joints(&[(2, -4.0)]).expect("two are left");
    assert_eq!(tip.inertias()[1].mass, 7.0);
}

#[test]
fn joints_that_cannot_be_locked_are_refused_by_name() {
    let arm = builtin_robot("kinova_gen3").expect("built in");
    let all: Vec<_> = (0..7).map(|i| (i, 0.0)).collect();
    for (locked, words) in [
        (&[(7, 0.0)][..], "joint 7: there is no such joint, there are 7"),
        (&[(1, 2.3)], "joint 'joint_2': locked at 2.3, outside [-2.25, 2.25]"),
        (&[(1, f64::NAN)], "joint 'joint_2': locked at NaN, outside"),
        (&[(1, 0.0), (1, 0.0)], "joint 'joint_2': it is locked twice"),
        (&all, "robot: all joints are locked"),
    ] {
        let error = arm.with_locked_joints(locked).expect_err(words).to_string();
        assert!(error.starts_with(&format!("kinova_gen3: {words}")), "{error}");
    }
    let free = pendulum(2).expect("two links");
    let error = free.with_locked_joints(&[(0, f64::INFINITY)]);
    assert!(error.expect_err("nowhere").to_string().contains("locked at inf"));
}
