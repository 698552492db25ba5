//! The moving joints of a URDF with their keys in the scenario.

use crate::Checked;
use crate::arithmetic::{Matrix, Tm, Vector, about, add, apply, product, times};
use crate::json::{number, number_or, option, require};
use crate::robot::{Pose, child, scalar};
use roxmltree::Node;
use serde_json::Value;

/// A joint and its body, in the frame of the joint.
pub(crate) struct Joint {
    pub(crate) name: String,
    pub(crate) parent: Option<usize>,
    pub(crate) origin: Pose,
    pub(crate) axis: Vector,
    pub(crate) slides: bool,
    pub(crate) mass: Tm,
    pub(crate) first: Vector,
    pub(crate) inertia: Matrix,
    /// Damping, friction, the inverse of its width, armature.
    pub(crate) drive: [Tm; 4],
    /// Lower and upper position, velocity, effort.
    pub(crate) limits: [f64; 4],
}

impl Joint {
    pub(crate) fn new(name: String, parent: Option<usize>, origin: Pose, axis: Vector, slides: bool) -> Self {
        let zero = Tm::new(0.0);
        let (first, inertia) = ([zero; 3], [[zero; 3]; 3]);
        let (drive, limits) = ([zero; 4], [f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY, f64::INFINITY]);
        Self { name, parent, origin, axis, slides, mass: zero, first, inertia, drive, limits }
    }

    pub(crate) fn read(&mut self, node: Node, kind: &str, scenario: &Value) -> Checked<()> {
        let is_free = child(node, "mimic").is_none() || scenario["mimic"] == "independent";
        require(is_free, format!("joint '{}' mimics another one", self.name))?;
        let limit = |name| scalar(child(node, "limit"), name);
        let [lower, upper, velocity, effort] = [limit("lower")?, limit("upper")?, limit("velocity")?, limit("effort")?];
        if [lower, upper, velocity, effort].iter().any(|x| *x != 0.0) {
            let known = |x: f64| if x > 0.0 { x } else { f64::INFINITY };
            self.limits = [lower, upper, known(velocity), known(effort)];
            require(lower <= upper, format!("the limits of joint '{}' exclude all positions", self.name))?;
            if kind == "continuous" {
                self.limits[0] = f64::NEG_INFINITY;
                self.limits[1] = f64::INFINITY;
            }
        }
        let losses = option(scenario, "losses").unwrap_or(&Value::Bool(false));
        if *losses == Value::Bool(false) {
            return Ok(());
        }
        let of_urdf = |name| scalar(child(node, "dynamics"), name);
        let given = |key: &str, default: f64| match option(losses, key) {
            Some(by_name @ Value::Object(_)) => number_or(by_name, &self.name, default),
            same => same.map_or(default, number),
        };
        let width = given("friction_velocity", 0.02);
        self.drive = [
            Tm::new(given("damping", of_urdf("damping")?)),
            Tm::new(given("friction", of_urdf("friction")?)),
            Tm::new(1.0).over(width),
            Tm::new(given("armature", 0.0)),
        ];
        Ok(())
    }

    pub(crate) fn placement(&self, q: Tm) -> Pose {
        if self.slides {
            (self.origin.0, add(self.origin.1, apply(self.origin.0, times(self.axis, q))))
        } else {
            (product(self.origin.0, about(self.axis, q.sin_cos())), self.origin.1)
        }
    }
}
