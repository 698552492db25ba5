//! Certificates: proofs that a motion keeps the promises of a scenario at all times.
//!
//! [`certify`] proves them, with rounding accounted for, for the piecewise polynomial $q(t)$ with exactly the Chebyshev
//! coefficients of a solve; velocities, accelerations, jerks and the torques of inverse dynamics are defined by it. Its
//! mathematics is in [`aghf::certify`], its assumptions are in `proofs/certificate.md` of the repository.
//!
//! A [`Certificate`] lists intervals that cover the horizon. On each, for each promise, it claims the least reserve of
//! all rows: for a limit the distance from its bound relative to the larger one of its bounds, for a
//! condition along the way that distance in m, rad or m/s, for a foot that distance in its unit, for a clearance the
//! distance beyond the one that is kept, in m. The checkers (the program `aghf-check` and
//! `python -m aghf.check_certificate`) share no code with this library, read robot, scenario and motion independently
//! and prove each claim once more.

mod clearance;
mod document;
mod points;
mod rows;
mod scope;
mod search;
mod shapes;
mod table;

pub use document::{Certificate, Certification, Direction, Failure, Interval, LEFT_OUT, Passage, Piece};

pub use table::{NAME, TableDifference, named_run, table_differences};

use crate::{CurveFile, Scenario};
use aghf::error::{Error, Result, check_length};

/// The accepted shortfall of a reserve: a motion may begin on a limit, where only rounding decides.
pub const TOLERANCE: f64 = 1e-9;

/// The texts that a certificate names by their hashes.
#[derive(Clone, Copy, Debug)]
pub struct Texts<'a> {
    /// Those of the scenario, as it was given and in full.
    pub scenario: &'a [&'a str],
    /// That of the summary with the motion.
    pub run: &'a str,
}

/// Proves that a motion keeps the promises of a scenario. The parts of the scenario that cannot be certified are listed
/// in the certificate with their reasons. The times at which it passes the waypoints, s, are those of the solve.
///
/// Cost per interval: O(N p^2), the dynamics with polynomials of degree eight for numbers, and a distance per ball of
/// the robot and obstacle or other ball.
///
/// Positions are those of the motion to within `tracking_error`, rad or m for each joint by itself; velocities,
/// accelerations and jerks are its own.
///
/// # Errors
/// The joints of the motion are not those of the robot, there is another number of times than of waypoints, or the
/// tracking error is negative or not finite.
pub fn certify(
    scenario: &Scenario,
    curve: &CurveFile,
    texts: Texts,
    waypoint_times: &[f64],
    tracking_error: f64,
) -> Result<Certification> {
    scenario.refuse_walk()?;
    curve.check_joints(&scenario.model, "certify")?;
    check_length("waypoint_times_s", scenario.waypoints.len(), waypoint_times.len())?;
    if !(tracking_error >= 0.0 && tracking_error.is_finite()) {
        let condition = format!("it is {tracking_error} and must be a finite number that is not negative");
        return Err(Error::input("certify", "tracking_error", condition));
    }
    search::certification(scenario, curve, texts, waypoint_times, tracking_error)
}
