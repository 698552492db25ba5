//! The prover finds a false claim in any place, its instances hide no error, and no identity compares a side with
//! itself.

use aghf::Result;
use aghf::model::{JointKind, JointSpec, Model};
use aghf::scalar::PrimeField as F;
use aghf::spatial::Placement;
use aghf::verify::field::{Equality, Identity, RandomInstance, identities, prove_identities};
use nalgebra::{DMatrix, Matrix3, Vector3};
use num_traits::{One, Zero};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

fn instances(seed: u64) -> impl Iterator<Item = RandomInstance> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || RandomInstance::random(&mut rng).expect("there is a joint"))
}

/// Claims that are false in a single place, and the end of the message.
type Wrong = (fn(&RandomInstance) -> Result<Vec<Equality>>, &'static str);
const WRONG: [Wrong; 4] = [
    (
        |_| {
            let [zero, one] = [F::zero(), F::one()];
            Ok(vec![Equality::numbers("first", one, one), Equality::numbers("second", one, zero)])
        },
        "point 0, 5 joints: second: entry (0, 0) is 1 left and 0 right",
    ),
    (
        |_| {
            let unit = DMatrix::from_fn(2, 3, |i, j| F::new(u64::from((i, j) == (1, 2))));
            Ok(vec![Equality::new("matrix", DMatrix::zeros(2, 3), unit)])
        },
        "point 0, 5 joints: matrix: entry (1, 2) is 0 left and 1 right",
    ),
    (
        |_| Ok(vec![Equality::new("shape", DMatrix::zeros(2, 3), DMatrix::zeros(3, 2))]),
        "point 0, 5 joints: shape: sizes (2, 3) and (3, 2)",
    ),
    (
        |p| Ok(vec![Equality::numbers("joints", F::new(p.dof() as u64 / 8), F::zero())]),
        "point 2, 8 joints: joints: entry (0, 0) is 1 left and 0 right",
    ),
];

#[test]
fn a_false_claim_is_found_wherever_it_stands() {
    let sizes = |seed: &u64| instances(*seed).take(3).map(|p| p.dof()).eq([5, 6, 8]);
    let seed = (0..).find(sizes).expect("seeds do not end");
    let identity = |(claims, _): Wrong| Identity { label: "wrong", statement: "", convention: "", claims };
    let verdicts = prove_identities(&WRONG.map(identity), 3, seed).expect("nothing refuses");
    for (verdict, (_, expected)) in verdicts.iter().zip(WRONG) {
        let failure = verdict.failure.as_deref().unwrap_or("no failure");
        assert!(failure.ends_with(expected), "{failure}, not {expected}");
    }
    assert_eq!(verdicts.iter().map(|v| v.entries).collect::<Vec<_>>(), [6, 18, 18, 3]);
}

/// Numbers that vanish, equal one or coincide could make a false identity hold.
#[test]
fn the_numbers_of_an_instance_are_in_general_position() {
    for p in instances(1).take(5) {
        let mut all: Vec<F> = [&p.x, &p.xdot, &p.xddot, &p.w].into_iter().flat_map(|v| v.iter().copied()).collect();
        all.extend(p.extra.iter().chain([&p.k, &p.t]).chain(p.model.gravity()));
        for (joint, inertia) in p.model.joints().iter().zip(p.model.inertias()) {
            let (place, i) = (joint.origin(), inertia.rotational);
            all.extend(joint.axis().iter().chain(&place.rotation).chain(&place.translation));
            all.extend(inertia.first_moment.iter().chain([
                &inertia.mass,
                &i.m11,
                &i.m22,
                &i.m33,
                &i.m12,
                &i.m13,
                &i.m23,
            ]));
            assert_eq!(joint.axis().dot(joint.axis()), F::one());
            assert_eq!(place.rotation * place.rotation.transpose(), Matrix3::identity());
            assert_eq!(i, i.transpose());
        }
        let mut residues: Vec<u64> = all.iter().map(|x| x.residue()).collect();
        assert!(residues.iter().all(|x| (2..F::ORDER - 1).contains(x)));
        residues.sort_unstable();
        residues.dedup();
        assert_eq!(residues.len(), all.len());
        assert!(p.weightless.gravity().iter().all(Zero::is_zero));
        let joint = |i: usize| (p.model.joints()[i].kind(), p.model.joints()[i].parent());
        let [turns, slides] = [JointKind::Revolute, JointKind::Prismatic];
        assert_eq!([0, 1, 2, 3].map(joint), [(turns, None), (turns, Some(0)), (turns, Some(1)), (slides, Some(1))]);
    }
}

/// The instance with inconsistent bodies: axes that are not unit vectors, frames that are sheared and not rotated, and
/// inertia matrices that are not symmetric.
fn no_robot(p: RandomInstance) -> RandomInstance {
    let joints = p.model.joints().iter().zip(p.model.inertias());
    let specs = joints.map(|(joint, inertia)| {
        let shear = Matrix3::identity() + inertia.first_moment * joint.axis().transpose();
        let mut inertia = *inertia;
        inertia.rotational *= shear;
        JointSpec {
            name: joint.name().to_owned(),
            kind: joint.kind(),
            parent: joint.parent(),
            origin: Placement::new(joint.origin().rotation * shear, joint.origin().translation),
            axis: joint.axis() * F::new(2),
            inertia,
            limits: *joint.limits(),
        }
    });
    let model = Model::from_joints("no robot", specs.collect()).expect("it is a tree");
    RandomInstance {
        weightless: model.clone().with_gravity(Vector3::zeros()),
        model: model.with_gravity(*p.model.gravity()),
        ..p
    }
}

/// The identities that are algebra or calculus of arbitrary functions; those of the supplement by their numbers.
const ALGEBRA: [&str; 18] = [
    "rnea",
    "aba",
    "crba",
    "A1",
    "A2",
    "A3",
    "bounds",
    "torque limits",
    "Algorithm B1 line 2",
    "Algorithm B1 line 7",
    "Algorithm B2 line 3",
    "Algorithm B3 line 1",
    "Algorithm B3 line 3",
    "dual trajectory",
    "dual cost of the control",
    "step of the multipliers",
    "metric of the action",
    "root wrench",
];
const ALGEBRA_B: [RangeInclusive<u32>; 8] = [5..=9, 11..=35, 40..=43, 51..=51, 58..=58, 64..=64, 67..=67, 78..=80];

/// All others depend on the motion of rigid bodies and fail without it, unless they compare a side with itself.
#[test]
fn no_identity_of_motion_holds_for_what_is_no_robot() {
    let p = no_robot(instances(1).next().expect("instances do not end"));
    let holds = |identity: &Identity| {
        let claims = (identity.claims)(&p).expect("the identities can be evaluated");
        claims.iter().all(|claim| claim.difference().is_none())
    };
    let found: BTreeSet<String> = identities().iter().filter(|i| holds(i)).map(|i| i.label.to_owned()).collect();
    let numbered = ALGEBRA_B.into_iter().flatten().map(|number| format!("B{number}"));
    let algebra: BTreeSet<String> = ALGEBRA.map(str::to_owned).into_iter().chain(numbered).collect();
    assert_eq!(found, algebra);
}
