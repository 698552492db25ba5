//! An independent judge of trajectories from any source.
//!
//! [`judge`] checks a [`Trajectory`], a table of samples, against a [`Scenario`]. Of the code that finds motions it
//! shares only the model, its kinematics and inverse dynamics, the distances of [`geometry`](aghf::geometry), and the
//! scenario: no curve, no constraint row, no derivative.
//!
//! **Between samples** a table means a motion, which the judgement names, for each joint and interval:
//!
//! | columns | motion | its rates |
//! | --- | --- | --- |
//! | q, v, a | the quintic through q, v and a, as a `joint_trajectory_controller` executes it | given |
//! | q, v | the cubic through q and v | given |
//! | q | the quintic through q and the first and second derivatives of polynomials of degree four through five samples | uncertain |
//!
//! If accelerations may jump (`continuity` is `velocity`), an acceleration of the table is left out at the end of an
//! interval whose motion without it does not have it: a table has a row at each jump, with the acceleration of either
//! side.
//!
//! **Positions alone** determine rates only to the deviations from sample to sample that they may hide: a fourth
//! difference of `D` hides rates of order `m` of $D (2 / h)^m / 16$ at an interval `h`, and less than five samples hide
//! all. A check of rates passes if the motion passes with this on either side. It fails if any motion through the
//! samples does, by their divided differences, less four times the uncertainty, or for torques, feet and speeds if the
//! derived rates do with that. Otherwise it is *not checked*.
//!
//! | check | compared quantities |
//! | --- | --- |
//! | horizon | the time from the first to the last sample with the bounds of `free_horizon`, or, unless the objective weighs time, with `horizon_s` |
//! | start, goal | the first and last positions and velocities with those of the scenario; angles are compared without removing whole turns; a free final velocity is not checked |
//! | continuity | the accelerations at an end at rest with zero; between the quintics they are continuous; not checked for cubics |
//! | velocity is rate, acceleration is rate | on each interval the mean rate with the mean of those at its ends, except for what the accelerations of the neighbouring samples explain |
//! | dynamics | at the samples, with their accelerations |
//! | passive joints | the torques of the table and of inverse dynamics at the samples and halfway between them, because a polynomial keeps none at zero for longer |
//! | position, velocity, acceleration, jerk limits | the Bernstein coefficients of the motion; jumps of accelerations, as those between cubics, over the time between the middles of two intervals count as jerks |
//! | torque and power limits | the torques of the table, and inverse dynamics at all times |
//! | goal, if it is a set | the pose of the frame in the last sample with the set that it misses least |
//! | waypoints | the configurations or poses of the way in their order, each where the motion passes it first after the one before: the samples that are nearer than their neighbours, and the nearest time about them |
//! | conditions along the way | the poses of frames and the speeds of points at all times between those of the condition, both included |
//! | standing foot | the force of the ground by the laws of Newton and Euler, body by body, at all times |
//! | obstacles, self-collision | the distances of the balls or convex bodies of the robot, at all times |
//! | added constraints | not checked: constraints that a program added |
//!
//! **At all times** means proved: a quantity is enclosed on each interval, by Bernstein coefficients, or by polynomials
//! of degree two with a bound on their error ([`TaylorModel`](aghf::scalar::TaylorModel)), and intervals are halved
//! until that is within the bounds and the tolerance. If the work exceeds a limit, the check is undecided.
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
//! An excess up to the [`Tolerances`] passes. A trajectory is *valid* if all checks pass that apply, *valid in part* if
//! some are not checked, and otherwise *not valid*.

mod checks;
mod clearance;
mod ends;
mod foot;
mod hermite;
mod intervals;
mod message;
mod poses;
mod rates;
mod reach;
mod rows;
mod torques;
mod trajectory;
mod verdict;
mod waypoints;

pub use hermite::Hermite;
pub use reach::{Reach, carriers};
pub use rows::sufficient_samples;
pub use trajectory::Trajectory;
pub use verdict::{Check, Judgement, Outcome, Row, Tolerances, Verdict, Worst};

use crate::{Continuous, Quantity, Scenario};
use aghf::error::{Error, Result, check_length, plain};
use aghf::model::Joint;
use intervals::Intervals;

/// Judges a trajectory of the robot of `scenario`.
///
/// Cost per sample: O(N), and O(N) per pair of a ball and an obstacle, or of balls of links that keep clear of each
/// other; about as much again per halving near the least clearance.
///
/// # Errors
/// A tolerance is negative or not finite, or the trajectory has another number of joints.
pub fn judge(scenario: &Scenario, trajectory: &Trajectory, tolerances: Tolerances) -> Result<Judgement> {
    scenario.refuse_walk()?;
    for (what, value) in [("tolerance", tolerances.tolerance), ("overlap", tolerances.overlap_m)] {
        if !(value.is_finite() && value >= 0.0) {
            let value = plain(value);
            let condition = format!("it is {value} and must be a number that is not negative");
            return Err(Error::input("options", what, condition));
        }
    }
    check(scenario, trajectory)?;
    let intervals = Intervals::new(trajectory, jumps(scenario));
    let checks = checks_of(scenario, trajectory, &intervals, tolerances)?;
    let verdict = match checks.iter().map(|row| row.outcome).max() {
        None | Some(Outcome::NotApplicable | Outcome::Pass) => Verdict::Valid,
        Some(Outcome::NotChecked) => Verdict::ValidInPart,
        Some(Outcome::Undecided | Outcome::Fail) => Verdict::NotValid,
    };
    Ok(Judgement {
        verdict,
        valid: verdict == Verdict::Valid,
        scenario: scenario.name.clone(),
        samples: trajectory.times.len(),
        duration_s: trajectory.duration(),
        between_samples: intervals.words,
        tolerances,
        checks,
    })
}

/// True if accelerations may jump.
fn jumps(scenario: &Scenario) -> bool {
    scenario.file.continuity() == Continuous::Velocity
}

/// The checks of all promises of the scenario.
fn checks_of(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    tolerances: Tolerances,
) -> Result<Vec<Row>> {
    let Tolerances { tolerance, overlap_m } = tolerances;
    let mut checks = checks::by_joint(scenario, trajectory, intervals, tolerance)?;
    checks.extend(clearance::clearances(scenario, intervals, overlap_m)?);
    checks.extend(poses::kept(scenario, intervals, tolerance)?);
    checks.extend(waypoints::passed(scenario, intervals, tolerance)?);
    checks.extend(foot::standing(scenario, intervals, tolerance)?);
    let others = unknown(scenario, &checks, tolerance);
    checks.extend(others);
    Ok(checks)
}

/// Promises without a row, each once, as rows that are not checked.
fn unknown(scenario: &Scenario, checks: &[Row], tolerance: f64) -> Vec<Row> {
    let added = scenario.added_constraints();
    let note = format!("{added} of a program, which the judge does not know");
    let other = |check, note: &str| Row::without_value(check, tolerance, Outcome::NotChecked, note);
    let mut rows: Vec<Row> = (added > 0).then(|| other(Check::Bounds(Quantity::Other), &note)).into_iter().collect();
    for check in scenario.promises().iter().map(Check::of) {
        if !checks.iter().chain(&rows).any(|row| row.check == check) {
            rows.push(other(check, "the judge cannot evaluate it"));
        }
    }
    rows
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
        ("v", trajectory.v.as_ref()),
        ("a", trajectory.a.as_ref()),
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

/// The name of a joint for messages.
fn joint_name(joint: &Joint<f64>) -> String {
    format!("joint '{}'", joint.name())
}
