//! The robots with several arms, which `robots/several_arms.py` writes: each arm equals the single one, and they do not
//! interact.

use crate::common::robot;
use aghf::dynamics::{Data, forward_kinematics, rnea};
use aghf::model::Model;
use aghf::spatial::Placement;
use nalgebra::Vector3;

fn torques(model: &Model, [q, v, a]: [&[f64]; 3]) -> Vec<f64> {
    let mut tau = vec![0.0; model.dof()];
    rnea(model, &mut Data::new(model), q, v, a, &mut tau).expect("lengths agree");
    tau
}

fn placements(model: &Model, q: &[f64]) -> Vec<Placement<f64>> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements).expect("lengths agree");
    placements
}

#[test]
fn every_arm_is_the_single_one_in_its_place() {
    let single = robot("kinova_gen3");
    for count in [2, 3] {
        let several = robot(&format!("kinova_gen3_{count}arms"));
        assert_eq!(several.dof(), 7 * count);
        let [q, v, a] = [0.3, 1.7, 2.9].map(|c| -> Vec<f64> {
            let entry = |i: usize| 2.0 * (c + 1.3 * i as f64).sin();
            (0..several.dof()).map(entry).collect()
        });
        let (tau, bodies) = (torques(&several, [&q, &v, &a]), placements(&several, &q));
        for arm in 0..count {
            let own = 7 * arm..7 * arm + 7;
            let [q, v, a] = [&q, &v, &a].map(|x| &x[own.clone()]);
            let apart = Vector3::y() * (arm as f64 - 0.5 * (count as f64 - 1.0));
            let alone = torques(&single, [q, v, a]).into_iter().zip(placements(&single, q));
            for (i, (expected, body)) in own.zip(alone) {
                assert!((tau[i] - expected).abs() < 1e-12, "{count} {i}");
                let moved = body.translation + apart - bodies[i].translation;
                assert!(moved.norm() < 1e-12, "{count} {i}");
                let [joint, of_one] = [&several.joints()[i], &single.joints()[i % 7]];
                assert_eq!(joint.name(), format!("arm_{}_{}", arm + 1, of_one.name()));
                assert_eq!(joint.limits(), of_one.limits());
            }
        }
    }
}
