//! Scenarios with obstacles that stand in the way, made from a seed.
//!
//! The paper's scenarios with obstacles are clear along the straight line already. Here the line hits something, and a bent path that is
//! known when the obstacles are placed does not, so each scenario can be solved. `NAME_NN` is made from seed `NN`.

mod digit;
mod kinova;
mod paths;

use super::{EnforcedLimits, FlowParameters, RobotShape, ScenarioFile, SphereObstacle};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::motion::Feedback;
use crate::urdf::builtin_robot;
use nalgebra::Vector3;
use paths::Paths;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// How often a family tries to place obstacles before it gives a seed up.
const ATTEMPTS: usize = 5000;
/// How many scenarios of a family are listed.
const LISTED: u64 = 10;
/// The path that is known to be free stays this far from every obstacle, m.
const CLEAR: f64 = 0.03;
/// The line goes at least this deep into an obstacle, m.
const HIT: f64 = 0.02;

/// The links of Digit are taken for capsules of this radius, m.
const DIGIT_LINK_RADIUS: f64 = 0.03;

/// Scenarios of one kind.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// The start of their names.
    pub name: &'static str,
    /// A description of them.
    pub about: &'static str,
    robot: &'static str,
    link_radius: f64,
    flow: FlowParameters,
    feedback: Feedback,
    /// Boundary states, obstacles and half-spaces, if the random choices go together.
    attempt: fn(&Model, &mut ChaCha8Rng) -> Result<Option<Candidate>>,
}

/// What a family chooses.
struct Candidate {
    paths: Paths,
    spheres: Vec<(Vector3<f64>, f64)>,
    half_spaces: Vec<super::HalfSpaceObstacle>,
}

const KINOVA: Family = Family {
    name: "",
    about: "",
    robot: "kinova_gen3",
    link_radius: 0.05,
    flow: FlowParameters {
        p: 12,
        k: 1e8,
        s_max: 1e3,
        guess: crate::motion::Guess::LineConfiguration,
        k_cons: 1e12,
        c_cons: 1e3,
    },
    feedback: Feedback { kp: 10.0, kv: 10.0 },
    attempt: kinova::cross,
};

/// The families of generated scenarios, ten of each are listed.
pub const FAMILIES: [Family; 4] = [
    Family {
        name: "kinova_cross",
        about: "spheres that the links of the line sweep through",
        ..KINOVA
    },
    Family {
        name: "kinova_gap",
        about: "two spheres with a narrow passage between, across the line",
        attempt: kinova::gap,
        ..KINOVA
    },
    Family {
        name: "kinova_floor",
        about: "a floor that the line dips below",
        attempt: kinova::floor,
        ..KINOVA
    },
    Family {
        name: "digit_box",
        about: "a step over a box of spheres in the way of the swinging foot",
        robot: "digit_v3_pinned",
        link_radius: DIGIT_LINK_RADIUS,
        flow: FlowParameters {
            p: 6,
            k: 1e8,
            s_max: 1.0,
            guess: crate::motion::Guess::LineConfiguration,
            k_cons: 1e5,
            c_cons: 200.0,
        },
        feedback: Feedback {
            kp: 100.0,
            kv: 100.0,
        },
        attempt: digit::step_over_box,
    },
];

/// The names of the generated scenarios that are listed.
pub fn generated_scenarios() -> impl Iterator<Item = String> {
    let of_family =
        |family: &'static Family| (1..=LISTED).map(|seed| format!("{}_{seed:02}", family.name));
    FAMILIES.iter().flat_map(of_family)
}

/// The scenario that is generated under this name, such as `kinova_gap_03`; `None` if no family has such names. Any seed will do.
///
/// # Errors
/// No way was found to place obstacles with this seed.
pub fn generate(name: &str) -> Option<Result<ScenarioFile>> {
    let (family, seed) = name.rsplit_once('_')?;
    let family = FAMILIES.iter().find(|f| f.name == family)?;
    let seed = seed.parse().ok()?;
    Some(family.scenario(name, seed))
}

impl Family {
    fn scenario(&self, name: &str, seed: u64) -> Result<ScenarioFile> {
        let unknown = || Err(Error::input(name, "robot", "it is not built in"));
        let (model, _) = builtin_robot(self.robot).unwrap_or_else(unknown)?;
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..ATTEMPTS {
            if let Some(made) = (self.attempt)(&model, rng)? {
                return Ok(self.file(made));
            }
        }
        let condition = format!("no free place for the obstacles of seed {seed} was found");
        Err(Error::input(name, "scenario", condition))
    }

    fn file(&self, made: Candidate) -> ScenarioFile {
        let Paths {
            start, goal, rates, ..
        } = made.paths;
        let sphere = |(centre, radius): (Vector3<f64>, f64)| SphereObstacle {
            center_m: centre.into(),
            radius_m: radius,
        };
        let [v_start, v_goal] = rates;
        ScenarioFile {
            robot: self.robot.to_owned(),
            locked_joints: BTreeMap::new(),
            horizon_s: 2.0,
            q_start: start,
            v_start,
            q_goal: goal,
            v_goal,
            free_final_velocity: false,
            running_cost: None,
            free_horizon: None,
            sphere_obstacles: made.spheres.into_iter().map(sphere).collect(),
            half_spaces: made.half_spaces,
            robot_shape: RobotShape::SweptLinks {
                radius_m: self.link_radius,
                spacing_m: 0.05,
            },
            enforced_limits: EnforcedLimits::NONE,
            flow: self.flow,
            feedback: self.feedback,
            success_threshold: 0.05,
        }
    }
}
