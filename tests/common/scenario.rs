//! The boundary value problems of the scenarios in `robots/`, read without the application.

use super::robot;
use aghf::constraint::{AnyConstraint, CollisionSphere, Sphere, SphereClearance};
use aghf::model::Model;
use aghf::motion::Problem;
use nalgebra::Vector3;
use serde_json::Value;
use std::path::Path;

/// A scenario file with its robot.
pub struct Scenario {
    pub model: Model,
    keys: Value,
}

impl Scenario {
    /// Reads `robots/ROBOT/NAME.json`.
    pub fn load(name: &str) -> Self {
        let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
        let folders = std::fs::read_dir(robots).expect("it is there");
        let mut paths = folders.map(|folder| folder.expect("readable").path().join(format!("{name}.json")));
        let path = paths.find(|path| path.exists()).expect("a scenario of this name");
        let text = std::fs::read_to_string(path).expect("readable");
        let keys: Value = serde_json::from_str(&text).expect("JSON");
        let model = robot(keys["robot"].as_str().expect("a name"));
        Self { model, keys }
    }

    fn numbers(value: &Value) -> impl Iterator<Item = f64> {
        let numbers = value.as_array().expect("a list").iter();
        numbers.map(|x| x.as_f64().expect("a number"))
    }

    /// The number under this JSON pointer.
    pub fn number(&self, pointer: &str) -> f64 {
        self.keys.pointer(pointer).and_then(Value::as_f64).expect("a number")
    }

    /// The boundary value problem.
    pub fn problem(&self) -> Problem<'_> {
        let state = |keys: [&str; 2]| keys.iter().flat_map(|key| Self::numbers(&self.keys[key])).collect();
        let (start, goal) = (state(["q_start", "v_start"]), state(["q_goal", "v_goal"]));
        Problem::new(&self.model, start, goal, self.number("/horizon_s")).expect("a good problem")
    }

    /// The joints without a motor.
    pub fn passive(&self) -> Vec<usize> {
        let names = self.keys["passive"].as_array().cloned().unwrap_or_default();
        let joints = self.model.joints();
        let index = |name: &Value| joints.iter().position(|joint| Some(joint.name()) == name.as_str());
        names.iter().map(|name| index(name).expect("a joint of the robot")).collect()
    }

    /// The rows that keep the origins of the joint frames clear of the spheres.
    pub fn clearance(&self) -> Vec<AnyConstraint> {
        let obstacles = self.keys["obstacles"].as_array().expect("a list");
        let sphere = |keys: &Value| {
            let radius = &keys["shape"]["sphere"]["radius_m"];
            Sphere {
                centre: Vector3::from_iterator(Self::numbers(&keys["pose"]["position_m"])),
                radius: radius.as_f64().expect("a sphere"),
            }
        };
        vec![AnyConstraint::Spheres(SphereClearance {
            balls: CollisionSphere::joint_frames(&self.model),
            spheres: obstacles.iter().map(sphere).collect(),
        })]
    }
}
