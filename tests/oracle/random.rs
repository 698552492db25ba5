//! Pendulums, random trees and chains, and two built-in robots at random states.

use crate::common::{config, robot};
use crate::compare::{Comparison, assert_same_names, compare_dynamics, compare_second_derivatives, state};
use crate::python::Oracle;
use aghf::model::{Drive, Model, pendulum, random_chain, random_tree};
use aghf::urdf::parse_urdf;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::cell::RefCell;
use std::fmt;

/// A robot and the URDF text that both sides read.
#[derive(Clone)]
pub struct Robot {
    pub model: Model,
    urdf: String,
}

/// The name determines the robot: it contains the number of joints and the seed.
impl fmt::Debug for Robot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.model.name())
    }
}

impl Robot {
    /// The robot as read back from URDF, its joints in the order of the file.
    fn new(model: &Model) -> Self {
        let urdf = model.to_urdf().expect("a URDF can say it");
        let (model, _) = parse_urdf(&urdf, model.name()).expect("it was written here");
        Self { model, urdf }
    }

    /// The robot with random drives if `seed` is odd.
    fn driven(mut self, seed: u64) -> Self {
        if seed & 1 == 1 {
            self.model = self.model.with_random_drives(seed);
        }
        self
    }

    /// The robot without dry friction, so that derivatives in velocities are polynomials.
    pub fn without_friction(mut self) -> Self {
        let mut drives = self.model.drives().to_vec();
        drives.iter_mut().for_each(|drive| drive.friction = 0.0);
        self.model = self.model.with_drives(drives).expect("as many as before");
        self
    }

    /// The robot in Pinocchio, its drives too.
    pub fn oracle(&self) -> Oracle {
        let oracle = Oracle::load(&self.urdf).expect("Pinocchio reads it");
        let drives = self.model.drives();
        if !drives.is_empty() {
            let all = |constant: fn(&Drive) -> f64| drives.iter().map(constant).collect::<Vec<_>>();
            let constants: [Vec<f64>; 4] = [
                all(|drive| drive.damping),
                all(|drive| drive.friction),
                all(|drive| drive.friction_velocity),
                all(|drive| drive.armature),
            ];
            oracle.call("set_drives", &constants.each_ref().map(Vec::as_slice));
        }
        oracle
    }
}

/// A robot of up to eight joints, or Digit; every second one with drives.
pub fn any_robot() -> impl Strategy<Value = Robot> {
    let random = |make: fn(usize, u64) -> aghf::Result<Model>| {
        (1..9_usize, 0..u64::MAX).prop_map(move |(n, seed)| make(n, seed).expect("n > 0"))
    };
    let model = prop_oneof![
        2 => (1..7_usize).prop_map(|n| pendulum(n).expect("n > 0")),
        4 => random(random_tree),
        2 => random(random_chain),
        1 => Just(()).prop_map(|()| robot("kinova_gen3")),
        1 => Just(()).prop_map(|()| robot("digit_v3_pinned")),
    ];
    (model, 0..u64::MAX).prop_map(|(model, seed)| Robot::new(&model).driven(seed))
}

#[test]
fn dynamics() {
    let all = RefCell::new(Comparison::default());
    let robot_and_state = any_robot().prop_flat_map(|r| (Just(r.clone()), state(&r.model)));
    let config = Config { source_file: Some(file!()), max_shrink_iters: 100, ..config(512) };
    let run = TestRunner::new(config).run(&robot_and_state, |(robot, state)| {
        let (model, oracle) = (&robot.model, robot.oracle());
        assert_same_names(model, &oracle);
        let mut comparison = compare_dynamics(model, &oracle, &state);
        comparison.merge(compare_second_derivatives(model, &oracle, &state));
        prop_assert!(comparison.off.is_empty(), "{:?}", comparison.off);
        all.borrow_mut().merge(comparison);
        Ok(())
    });
    println!("{}", all.borrow());
    run.unwrap_or_else(|e| panic!("{e}"));
}
