//! A point on the way.

use super::DirectSettings;
use crate::constraint::AnyConstraint;
use crate::error::{Error, Result, check_length};
use crate::motion::Problem;

/// A point on the way, one of several in their order: at some time the motion is at a configuration, or in a set of
/// configurations.
///
/// An unknown time is found by Newton's method, which does not converge to a time at which the acceleration jumps: with
/// several segments it should be continuous.
#[derive(Clone, Debug)]
pub struct Waypoint {
    /// The configuration, rad or m, `N` entries; with [`constraints`](Self::constraints) first guesses of it, at least
    /// one: start `k` has entry `k` modulo their number.
    pub guesses: Vec<Vec<f64>>,
    /// The constraints on the configuration, with rows at zero velocity; without any it is the guess itself.
    pub constraints: Vec<AnyConstraint>,
    /// True if all velocities are zero there.
    pub stop: bool,
    /// True if a foot lands there: the rates of all equalities of the constraints are zero.
    pub lands: bool,
    /// The time as a share of the horizon, between those of its neighbours; an unknown by default. At one, the end,
    /// only a periodic motion has such a point.
    pub share: Option<f64>,
}

impl Waypoint {
    /// A configuration at an unknown time, rad or m, `N` entries.
    #[must_use]
    pub fn new(q: Vec<f64>) -> Self {
        Self { guesses: vec![q], constraints: Vec::new(), stop: false, lands: false, share: None }
    }

    /// The first guess of a start.
    pub(super) fn guess(&self, start: usize) -> &[f64] {
        &self.guesses[start % self.guesses.len()]
    }
}

/// The number of positions and velocities that waypoints fix per joint.
pub(super) fn conditions(waypoints: &[Waypoint]) -> usize {
    waypoints.iter().map(|of| 1 + usize::from(of.stop)).sum()
}

/// Checks waypoints for a problem.
///
/// # Errors
/// A waypoint has no guess, several without constraints, or one without `N` finite entries; its time is not between
/// those of its neighbours; or there are more of them than the final basis can pass through.
pub(super) fn check(settings: &DirectSettings, problem: &Problem<'_>) -> Result<()> {
    let mut before = 0.0;
    for (i, waypoint) in settings.waypoints.iter().enumerate() {
        let refuse = |condition: String| Err(Error::input("settings", format!("waypoints[{i}]"), condition));
        match (waypoint.guesses.len(), waypoint.constraints.is_empty()) {
            (0, _) => return refuse("it has no configuration".to_owned()),
            (2.., true) => {
                return refuse("it has several configurations and no constraints".to_owned());
            }
            _ => (),
        }
        for q in &waypoint.guesses {
            check_length("waypoint", problem.model().dof(), q.len())?;
            if !q.iter().all(|q| q.is_finite()) {
                return refuse("a number is not finite".to_owned());
            }
        }
        let Some(share) = waypoint.share else {
            continue;
        };
        let is_end = share == 1.0 && settings.period.is_some();
        if !(share > before && (share < 1.0 || is_end)) {
            let range = format!("more than {before} and less than 1");
            return refuse(format!("it has the share {share} of the horizon, {range} is needed"));
        }
        before = share;
    }
    let free = settings.basis(problem).free().len();
    let conditions = conditions(&settings.waypoints);
    if conditions > free {
        let condition = format!(
            "they fix {conditions} positions and velocities per joint, and {} segments of degree {} leave {free} free",
            settings.segments, settings.degree
        );
        return Err(Error::input("settings", "waypoints", condition));
    }
    Ok(())
}
