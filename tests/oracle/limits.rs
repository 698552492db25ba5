//! Generated scenarios close to the limits of other projects' robots: the known motion satisfies them.

use crate::python::share;
use aghf::dynamics::{Data, rnea};
use aghf::urdf::Mimic;
use aghf_scenario::{LoadOptions, Scenario, ScenarioFile};

/// Arms, legs, a hand and humanoids.
const ROBOTS: [&str; 12] = [
    "ur_description/urdf/ur5_robot.urdf",
    "panda_description/urdf/panda.urdf",
    "xarm_description/urdf/xarm7.urdf",
    "talos_data/robots/talos_left_arm.urdf",
    "z1_description/urdf/z1.urdf",
    "so_arm_description/urdf/so101.urdf",
    "allegro_hand_description/urdf/allegro_right_hand.urdf",
    "anymal_b_simple_description/robots/anymal.urdf",
    "g1_description/urdf/g1_29dof_rev_1_0.urdf",
    "talos_data/robots/talos_reduced.urdf",
    "icub_description/robots/icub.urdf",
    "alex_description/urdf/alex_nub_hands.urdf",
];

/// The position on the line at the fraction `t` of the duration, with the velocity 10 t (1 - t) (1 - 2 t + 2 t^2), and
/// its derivatives.
fn line(file: &ScenarioFile, t: f64) -> [Vec<f64>; 3] {
    let scaled = [
        5.0 * t.powi(2) - 10.0 * t.powi(3) + 10.0 * t.powi(4) - 4.0 * t.powi(5),
        (10.0 * t - 30.0 * t.powi(2) + 40.0 * t.powi(3) - 20.0 * t.powi(4)) / file.horizon_s,
        (10.0 - 60.0 * t + 120.0 * t.powi(2) - 80.0 * t.powi(3)) / file.horizon_s.powi(2),
    ];
    let ends = || file.q_start.iter().zip(&file.q_goal);
    let [mut q, v, a] = scaled.map(|s| ends().map(|(from, to)| (to - from) * s).collect::<Vec<_>>());
    q.iter_mut().zip(&file.q_start).for_each(|(q, from)| *q += from);
    [q, v, a]
}

#[test]
fn the_line_of_a_generated_scenario_keeps_the_limits_of_any_robot() {
    for robot in ROBOTS {
        let path = share("example-robot-data/robots").join(robot);
        let path = path.to_str().expect("it is text");
        let given =
            LoadOptions { robot: Some(path.to_owned()), mimic: Some(Mimic::Independent), ..LoadOptions::default() };
        for seed in 1..=3 {
            let name = format!("limits_{seed:02}");
            let Scenario { file, model, .. } =
                Scenario::load_for(&name, &given).unwrap_or_else(|e| panic!("{robot}: {e}"));
            let mut data = Data::new(&model);
            let mut tau = vec![0.0; model.dof()];
            let mut fastest = 0.0_f64;
            for k in 0..=100 {
                let [q, v, a] = line(&file, f64::from(k) / 100.0);
                rnea(&model, &mut data, &q, &v, &a, &mut tau).expect("lengths agree");
                for (i, joint) in model.joints().iter().enumerate() {
                    let limits = joint.limits();
                    let at = format!("{robot} {seed}: joint '{}' at {k}", joint.name());
                    assert!((limits.lower..=limits.upper).contains(&q[i]), "{at}: position");
                    assert!(v[i].abs() < 0.98 * limits.velocity, "{at}: velocity");
                    assert!(tau[i].abs() < 0.91 * limits.effort, "{at}: torque");
                    fastest = fastest.max(v[i].abs() / limits.velocity);
                }
            }
            assert!(fastest > 0.95 || file.horizon_s == 0.5, "{robot} {seed}: {fastest}");

            let name = format!("limits_obstacle_{seed:02}");
            let scenario = Scenario::load_for(&name, &given).unwrap_or_else(|e| panic!("{robot}: {e}"));
            let clearance = |configurations: &[Vec<f64>]| {
                let all = configurations.iter().map(Vec::as_slice);
                let smallest = scenario.smallest_clearance(all);
                smallest.expect("it is the robot's").expect("there is an obstacle")
            };
            let along = (0..=400).map(|k| line(&scenario.file, f64::from(k) / 400.0)[0].clone());
            let along: Vec<Vec<f64>> = along.collect();
            assert!(clearance(&along) < 0.0, "{robot} {seed}: the line hits nothing");
            let ends = [along[0].clone(), along[400].clone()];
            assert!(clearance(&ends) > 0.0, "{robot} {seed}: an end is not free");
        }
    }
}
