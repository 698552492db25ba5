//! An independent judge of trajectories from any source.
//!
//! [`judge`] checks a [`Trajectory`], a table of samples, against a [`Scenario`]. Of the code that finds motions it
//! shares only the model, its kinematics and inverse dynamics, the distances of [`geometry`](aghf::geometry), and the
//! scenario: no curve, no constraint row, no derivative.
//!
//! **Between samples** the motion of each joint is the cubic polynomial with the positions and velocities of both
//! samples (Hermite). Velocities and accelerations that a table lacks are derived at the samples from polynomials of
//! degree four through five neighbours. At a jump of the acceleration their error is about as large as the jump, so
//! that tables with jumps should contain both.
//!
//! | check | compared quantities |
//! | --- | --- |
//! | horizon | the time from the first to the last sample with `horizon_s`, or with the bounds of `free_horizon` |
//! | start, goal | the first and last positions and velocities with those of the scenario; angles are compared without removing whole turns; a free final velocity is not checked |
//! | v is the rate of q | on each interval the mean velocity with the mean of the velocities at its ends, except for the difference that accelerations like those of this interval and its neighbours explain: an eighth of the interval times their spread |
//! | a is the rate of v | in the same way, except for half of the spread of the accelerations at the two samples and their neighbours and of those extrapolated from the two samples before and the two after, so that accelerations may jump |
//! | u is inverse dynamics | at the samples, with their accelerations |
//! | passive joints, torque limits | the torques of the table and of inverse dynamics at the samples, and inverse dynamics of the cubic halfway between them |
//! | position and velocity limits | the extrema of the cubics, in closed form |
//! | goal, if it is a set | the pose of the frame in the last sample with the set that it misses least |
//! | waypoints | the configurations or poses of the way in their order, each where the motion passes it first after the one before: the samples that are nearer than their neighbours, and the nearest time about them |
//! | kept along the way | the poses of frames at all times, and speeds of points at the samples and halfway between them |
//! | standing foot | the force of the ground by the laws of Newton and Euler, body by body, at the samples and halfway between them |
//! | obstacles, self-collision | the distances of the balls of the robot, at all times |
//!
//! **Clearances** are proved. A ball is within a [bound](Reach) of its position in the middle of an interval, so that
//! its distance from an obstacle, or the gap to a ball of another link, is at least the one in the middle minus that
//! bound. Intervals are halved until this excludes a new least gap, to within a tenth of the accepted overlap or a
//! twentieth of the least clearance, whichever is larger. Therefore no collision is missed, however thin the obstacle.
//! Only balls on moving bodies are checked, and the pairs of
//! [`Scene::pairs`](aghf::geometry::Scene::pairs). If the work exceeds a limit, the check is
//! undecided, and reports the proved bound.
//!
//! Poses that are kept are proved in the same way, to the accepted excess.
//!
//! An excess up to the [`Tolerances`] passes.

mod checks;
mod clearance;
mod cubic;
mod foot;
mod message;
mod poses;
mod reach;
mod rows;
mod trajectory;
mod verdict;
mod waypoints;

pub use cubic::Cubic;
pub use reach::{Reach, carriers};
pub use rows::sufficient_samples;
pub use trajectory::Trajectory;
pub use verdict::{Check, Judgement, Outcome, Row, Tolerances, Worst};

use crate::{Scenario, Verdict};
use aghf::error::{Error, Result, check_length, plain};
use aghf::model::{Joint, JointKind};

/// Judges a trajectory of the robot of `scenario`.
///
/// Cost per sample: O(N), and O(N) per pair of a ball and an obstacle, or of balls of links that keep clear of each
/// other; about as much again per halving near the least clearance.
///
/// # Errors
/// A tolerance is negative or not finite, or the trajectory has another number of joints.
pub fn judge(
    scenario: &Scenario,
    trajectory: &Trajectory,
    tolerances: Tolerances,
) -> Result<Judgement> {
    scenario.refuse_walk()?;
    for (what, value) in [
        ("tolerance", tolerances.tolerance),
        ("overlap", tolerances.overlap_m),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            let value = plain(value);
            let condition = format!("it is {value}, a number that is not negative is needed");
            return Err(Error::input("options", what, condition));
        }
    }
    check(scenario, trajectory)?;
    let checks = checks_of(scenario, trajectory, tolerances)?;
    let valid = checks.iter().all(|row| row.outcome.is_good());
    Ok(Judgement {
        verdict: if valid {
            Verdict::Valid
        } else {
            Verdict::NotValid
        },
        valid,
        scenario: scenario.name.clone(),
        samples: trajectory.times.len(),
        duration_s: trajectory.duration(),
        between_samples: "the cubic Hermite curve of q and v",
        derived: derived(trajectory),
        tolerances,
        checks,
    })
}

/// The checks of all promises of the scenario.
fn checks_of(
    scenario: &Scenario,
    trajectory: &Trajectory,
    tolerances: Tolerances,
) -> Result<Vec<Row>> {
    let intervals = Intervals::new(trajectory);
    let Tolerances {
        tolerance,
        overlap_m,
    } = tolerances;
    let mut checks = checks::by_joint(scenario, trajectory, &intervals, tolerance)?;
    checks.extend(clearance::clearances(scenario, &intervals, overlap_m)?);
    checks.extend(poses::kept(scenario, trajectory, &intervals, tolerance)?);
    checks.extend(waypoints::passed(scenario, &intervals, tolerance)?);
    checks.extend(foot::standing(scenario, trajectory, &intervals, tolerance)?);
    Ok(checks)
}

/// The quantities that a trajectory does not give, with their derivation.
fn derived(trajectory: &Trajectory) -> Vec<&'static str> {
    let given = [
        (
            trajectory.has_velocities,
            "v from five neighbouring samples of q",
        ),
        (
            trajectory.has_accelerations,
            "a from five neighbouring samples of v",
        ),
        (
            trajectory.u.is_some(),
            "u by inverse dynamics from q, v and a",
        ),
    ];
    let missing = given.into_iter().filter(|(given, _)| !given);
    missing.map(|(_, derivation)| derivation).collect()
}

/// Refuses a trajectory whose numbers of joints or samples are inconsistent.
fn check(scenario: &Scenario, trajectory: &Trajectory) -> Result<()> {
    let (times, n) = (&trajectory.times, scenario.model.dof());
    if times.len() < 2 || !times.windows(2).all(|pair| pair[0] < pair[1]) {
        let condition = "at least two are needed, ascending";
        return Err(Error::input("trajectory", "times", condition));
    }
    let tables = [
        ("q", Some(&trajectory.q)),
        ("v", Some(&trajectory.v)),
        ("a", Some(&trajectory.a)),
        ("u", trajectory.u.as_ref()),
    ];
    for (what, table) in tables {
        let Some(table) = table else { continue };
        check_length(what, times.len(), table.len())?;
        for sample in table {
            check_length(what, n, sample.len())?;
        }
    }
    Ok(())
}

/// The motion between the samples.
struct Intervals {
    /// The time after the start at which each interval begins, and its duration, s.
    times: Vec<[f64; 2]>,
    /// The cubics of the joints in each interval.
    cubics: Vec<Vec<Cubic>>,
}

impl Intervals {
    fn new(trajectory: &Trajectory) -> Self {
        let Trajectory { times, q, v, .. } = trajectory;
        let interval = |k: usize| times[k + 1] - times[k];
        let cubics = |k: usize| {
            let cubic = |i| Cubic::new([q[k][i], q[k + 1][i]], [v[k][i], v[k + 1][i]], interval(k));
            (0..q[k].len()).map(cubic).collect()
        };
        let all = 0..times.len() - 1;
        Self {
            times: (all.clone())
                .map(|k| [times[k] - times[0], interval(k)])
                .collect(),
            cubics: all.map(cubics).collect(),
        }
    }

    /// The time after the start, s, at the fraction `s` of interval `k`.
    fn time(&self, k: usize, s: f64) -> f64 {
        let [begin, interval] = self.times[k];
        begin + s * interval
    }
}

/// The name of a joint for messages.
fn joint_name(joint: &Joint<f64>) -> String {
    format!("joint '{}'", joint.name())
}

/// The unit of a joint: the first for a revolute joint, the second for a prismatic one.
fn unit_of(joint: &Joint<f64>, [turns, slides]: [&'static str; 2]) -> &'static str {
    match joint.kind() {
        JointKind::Revolute | JointKind::Continuous => turns,
        JointKind::Prismatic => slides,
    }
}
