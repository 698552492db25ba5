//! The forces of the drives.

use crate::common::{assert_refused, tree};
use aghf::dynamics::{Data, rnea};
use aghf::model::{Drive, pendulum};
use num_dual::HyperDual64;

const DRIVE: Drive = Drive { damping: 0.3, friction: 2.0, friction_velocity: 0.05, armature: 0.7 };

/// Friction is odd, grows with the velocity, and is within 1 % of its bound where the documentation says so.
#[test]
fn friction_is_odd_and_saturates() {
    let friction = Drive { damping: 0.0, ..DRIVE };
    let force = |v: f64| friction.losses(v)[0];
    let width = friction.friction_velocity;
    let forces: Vec<_> = (-300..=300).map(|i| force(0.1 * f64::from(i) * width)).collect();
    assert!(forces.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(forces.iter().zip(forces.iter().rev()).all(|(a, b)| *a == -b));
    assert_eq!(force(0.0), 0.0);
    assert!(force(7.1 * width) > 0.99 * friction.friction && force(1e9) <= friction.friction);
    let damped = DRIVE.losses(2.0)[0] - force(2.0);
    assert!((damped - 2.0 * DRIVE.damping).abs() < 1e-15, "{damped}");
}

#[test]
fn the_derivatives_of_the_losses_are_those_of_duals() {
    for v in [-3.0, -0.2, -0.01, 0.0, 0.003, 0.05, 0.4, 2.0] {
        let dual = HyperDual64::from_re(v).derivative1().derivative2();
        let [expected, ..] = DRIVE.losses(dual);
        let [force, slope, curvature] = DRIVE.losses(v);
        let steepness = DRIVE.friction / DRIVE.friction_velocity;
        let bounds = [1e-15, 1e-15 * steepness, 1e-15 * steepness / DRIVE.friction_velocity];
        let errors = [force - expected.re, slope - expected.eps1, curvature - expected.eps1eps2];
        for (error, bound) in errors.iter().zip(bounds) {
            assert!(error.abs() <= 4.0 * bound, "{v}: {errors:?}");
        }
    }
}

/// A model without drives, and one whose drives are zero, have the forces of the rigid bodies alone.
#[test]
fn without_drives_there_are_rigid_bodies_alone() {
    let driven = tree(6, 1);
    let [q, v, a] = [0.3, -0.8, 1.1].map(|x| (1..=6).map(|i| x * f64::from(i)).collect::<Vec<_>>());
    let torques = |drives: Vec<Drive>| {
        let (model, mut tau) = (driven.clone().with_drives(drives).expect("six or none"), [0.0; 6]);
        rnea(&model, &mut Data::new(&model), &q, &v, &a, &mut tau).expect("lengths agree");
        tau
    };
    let idle = Drive { damping: 0.0, friction: 0.0, armature: 0.0, ..DRIVE };
    let rigid = torques(Vec::new());
    assert_eq!(torques(vec![idle; 6]), rigid);
    let with = torques(vec![DRIVE; 6]);
    for i in 0..6 {
        let added = DRIVE.losses(v[i])[0] + DRIVE.armature * a[i];
        assert!((with[i] - rigid[i] - added).abs() <= 1e-14 * with[i].abs().max(added.abs()));
    }
}

#[test]
fn as_many_drives_as_joints() {
    let arm = pendulum(2).expect("two links");
    assert_refused(arm.clone().with_drives(vec![DRIVE; 3]), "drives");
    assert_eq!(arm.with_drives(vec![DRIVE; 2]).expect("two").drives(), [DRIVE; 2]);
}
