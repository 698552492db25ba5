//! Scenarios generated from a seed: obstacles across the straight line, and motions that are difficult for the limits
//! of a robot.
//!
//! The straight line is already free in the paper's scenarios with obstacles. Here the line hits an obstacle, and a
//! bent path, known when the obstacles are placed, does not. If limits are enforced, that path is a motion within them
//! ([`witness`]), so each scenario has a solution. `NAME_NN` is generated from seed `NN`.

mod digit;
mod kinova;
mod limits;
mod paths;
mod witness;

use super::{
    Continuous, EnforcedLimits, FlowParameters, Objective, ObjectiveWeights, Obstacle, ObstacleShape, PerJoint, Pose,
    RobotShape, ScenarioFile, Units,
};
use aghf::error::{Error, Result};
use aghf::model::Model;
use aghf::motion::Feedback;
use aghf::urdf::{Mimic, UrdfOptions, load_robot_with};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use witness::Witness;

/// The number of draws of a motion and obstacles before a family gives up on a seed.
const ATTEMPTS: usize = 5000;
/// The number of listed scenarios per family.
const LISTED: u64 = 10;
/// The smallest distance of the known free path from every obstacle, m.
const CLEAR: f64 = 0.03;
/// The smallest depth of the line in an obstacle, m.
const HIT: f64 = 0.02;
/// The number of parts of a metre, radian or second to which numbers in a file are rounded.
const ROUND: f64 = 1000.0;

/// The weight of squared accelerations relative to squared torques. Motions of least effort alone oscillate along a
/// path many times longer than the straight one, because accelerating a light link costs almost nothing; this small
/// weight makes the motions direct.
const SMALL_ACCELERATION: f64 = 0.1;

/// A family of generated scenarios of one kind.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// The start of their names.
    pub name: &'static str,
    /// A description of them.
    pub about: &'static str,
    /// The default robot.
    robot: &'static str,
    /// True if the family accepts any robot.
    any_robot: bool,
    /// True if the limits of the robot are enforced; the known solution then satisfies them.
    within_limits: bool,
    flow: FlowParameters,
    feedback: Feedback,
    /// Draws boundary states, obstacles and half-spaces; `None` if the random choices are unsuitable.
    attempt: fn(&Model, &mut ChaCha8Rng) -> Result<Option<Candidate>>,
}

/// The random choices of a family.
struct Candidate {
    ends: [Vec<f64>; 2],
    /// The velocities at start and goal.
    rates: [Vec<f64>; 2],
    horizon: f64,
    shape: RobotShape,
    obstacles: Vec<Obstacle>,
}

impl Candidate {
    /// A candidate that `witness` solves, with links of this radius and no obstacle yet.
    fn new(witness: Witness, link_radius: f64) -> Self {
        let rest = vec![0.0; witness.model.dof()];
        Self {
            ends: witness.ends,
            rates: [rest.clone(), rest],
            horizon: witness.horizon,
            shape: RobotShape::SweptLinks { radius_m: link_radius, spacing_m: 0.05 },
            obstacles: Vec::new(),
        }
    }

    fn with_obstacles(self, obstacles: Vec<Obstacle>) -> Self {
        Self { obstacles, ..self }
    }
}

/// An obstacle of this shape, not rotated.
fn obstacle(shape: ObstacleShape, position: Vector3<f64>) -> Obstacle {
    Obstacle {
        name: None,
        shape,
        pose: Pose { position_m: position.into(), orientation_xyzw: None },
        clearance_m: None,
    }
}

fn sphere((centre, radius_m): (Vector3<f64>, f64)) -> Obstacle {
    obstacle(ObstacleShape::Sphere { radius_m }, centre)
}

fn rounded(x: f64) -> f64 {
    (x * ROUND).round() / ROUND
}

fn round_up(x: f64) -> f64 {
    (x * ROUND).ceil() / ROUND
}

fn round_down(x: f64) -> f64 {
    (x * ROUND).floor() / ROUND
}

fn round_vector(v: Vector3<f64>) -> Vector3<f64> {
    v.map(rounded)
}

/// A random direction.
fn direction(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        if v.norm() > 0.1 {
            return v.normalize();
        }
    }
}

const KINOVA: Family = Family {
    name: "",
    about: "",
    robot: "kinova_gen3",
    any_robot: false,
    within_limits: true,
    flow: FlowParameters {
        degree: 12,
        k: 1e8,
        s_max: 1e3,
        guess: aghf::motion::Guess::LineConfiguration,
        k_cons: 1e12,
        c_cons: 1e3,
    },
    feedback: Feedback { kp: 10.0, kv: 10.0 },
    attempt: kinova::cross,
};

/// The families of generated scenarios; ten scenarios of each are listed.
pub const FAMILIES: [Family; 6] = [
    Family { name: "kinova_cross", about: "spheres that the links of the line sweep through", ..KINOVA },
    Family {
        name: "kinova_gap",
        about: "two spheres with a narrow passage between, across the line",
        attempt: kinova::gap,
        ..KINOVA
    },
    Family { name: "kinova_floor", about: "a floor that the line dips below", attempt: kinova::floor, ..KINOVA },
    Family {
        name: "digit_box",
        about: "a step over a box of spheres in the way of the swinging foot",
        robot: "digit_v3_pinned",
        // The efforts in the file are those of the motors before their gears, with which the robot cannot hold itself
        // anywhere. The known path is not a motion in time either, because the step starts and ends in motion.
        within_limits: false,
        flow: FlowParameters {
            degree: 6,
            k: 1e8,
            s_max: 1.0,
            guess: aghf::motion::Guess::LineConfiguration,
            k_cons: 1e5,
            c_cons: 200.0,
        },
        feedback: Feedback { kp: 100.0, kv: 100.0 },
        attempt: digit::step_over_box,
        ..KINOVA
    },
    Family {
        name: "limits",
        about: "random pairs close to the velocity limits, of any robot (--robot)",
        any_robot: true,
        attempt: limits::without_obstacle,
        ..KINOVA
    },
    Family {
        name: "limits_obstacle",
        about: "the same with a sphere that the line hits",
        any_robot: true,
        attempt: limits::with_obstacle,
        ..KINOVA
    },
];

/// The names of the listed generated scenarios.
pub fn generated_scenarios() -> impl Iterator<Item = String> {
    let of_family = |family: &'static Family| (1..=LISTED).map(|seed| format!("{}_{seed:02}", family.name));
    FAMILIES.iter().flat_map(of_family)
}

/// Returns true if a scenario is generated under this name, listed or not.
#[must_use]
pub fn is_generated(name: &str) -> bool {
    family_and_seed(name).is_some()
}

/// The family and the seed of a name.
fn family_and_seed(name: &str) -> Option<(&'static Family, u64)> {
    let (family, seed) = name.rsplit_once('_')?;
    let family = FAMILIES.iter().find(|f| f.name == family)?;
    Some((family, seed.parse().ok()?))
}

/// Generates the scenario of this name, such as `kinova_gap_03`; `None` if no family has such names. Any seed is
/// accepted.
///
/// # Errors
/// No motion with such obstacles was found for this seed.
pub fn generate(name: &str) -> Option<Result<ScenarioFile>> {
    generate_for(name, None, Mimic::default())
}

/// Generates as [`generate`] does, for another robot if the family accepts any: a built-in name or the path of a URDF
/// file, with a treatment of its mimic joints.
///
/// # Errors
/// The robot cannot be loaded, the family has a fixed robot, or no such motion was found for this seed.
pub fn generate_for(name: &str, robot: Option<&str>, mimic: Mimic) -> Option<Result<ScenarioFile>> {
    let (family, seed) = family_and_seed(name)?;
    Some(family.scenario(name, seed, robot, mimic))
}

impl Family {
    fn scenario(&self, name: &str, seed: u64, robot: Option<&str>, mimic: Mimic) -> Result<ScenarioFile> {
        if robot.is_some() && !self.any_robot {
            let condition = format!("scenarios '{}' are for {} alone", self.name, self.robot);
            return Err(Error::input(name, "robot", condition));
        }
        let robot = robot.unwrap_or(self.robot);
        let (model, _) = load_robot_with(robot, Path::new(""), UrdfOptions { mimic, ..UrdfOptions::default() })
            .map_err(|e| Error::input(name, "robot", e.to_string()))?;
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..ATTEMPTS {
            if let Some(made) = (self.attempt)(&model, rng)? {
                return Ok(self.file(robot, mimic, made));
            }
        }
        let condition = format!(
            "none with a solution was found in {ATTEMPTS} draws for seed {seed} and {robot}; its torques may not \
            hold it at rest, or no link reach an obstacle"
        );
        Err(Error::input(name, "scenario", condition))
    }

    fn file(&self, robot: &str, mimic: Mimic, made: Candidate) -> ScenarioFile {
        let [q_start, q_goal] = made.ends;
        let [v_start, v_goal] = made.rates;
        let (start, goal) = ([q_start, v_start], [q_goal, v_goal]);
        ScenarioFile {
            mimic,
            continuity: Some(Continuous::Velocity),
            objective: Objective::Weights(ObjectiveWeights {
                units: Units::Si,
                acceleration: PerJoint::Same(SMALL_ACCELERATION),
                ..ObjectiveWeights::default()
            }),
            obstacles: made.obstacles,
            robot_shape: Some(made.shape),
            enforced_limits: if self.within_limits { EnforcedLimits::default() } else { EnforcedLimits::NONE },
            flow: self.flow,
            feedback: self.feedback,
            ..ScenarioFile::new(robot.to_owned(), made.horizon, start, goal)
        }
    }
}
