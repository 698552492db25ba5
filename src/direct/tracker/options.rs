//! The options of a tracker.

use crate::direct::DirectSettings;
use crate::error::{Error, Result, check_count, check_positive};
use crate::motion::Problem;
use std::time::Duration;

/// The options of a [`Tracker`](super::Tracker).
#[derive(Clone, Debug)]
pub struct TrackerOptions {
    /// The settings of the first search, and of the iterations after it: one segment, to a given state at rest. By
    /// default those [for constraints](DirectSettings::constrained).
    pub settings: DirectSettings,
    /// The fixed barrier parameter after the first search, relative to the objective and summed over all rows, by
    /// default 1e-2: the excess of the objective over its minimum. Multipliers that are smooth in time remain good for
    /// a goal that has moved; with 1e-4 a search takes several times as many iterations.
    pub barrier: f64,
    /// The largest number of interior-point iterations per step, by default 1: a second one would use an older state
    /// than the first one of the next step. For a polynomial of degree 12 of an arm with seven joints a step with one
    /// takes 0.6 to 1 ms (`benches/tracker.py`).
    pub iterations_per_step: usize,
    /// The least decrease of the objective with its barrier, relative to the objective, for which a plan to the same
    /// goal replaces the old one, by default 1e-3: each replacement may make the acceleration jump.
    pub least_gain: f64,
    /// The number of intervals of the check of a plan per degree of its polynomial, by default 10: for `K` in all, the
    /// times are $T (1 - \cos \pi k / K) / 2$. The state at which a plan begins is fixed, and may already be at a
    /// bound: it would take 1000 equal intervals not to miss violations of 1e-4 within the first milliseconds.
    pub look: usize,
    /// The time within which a step returns; see [`Tracker::step`](super::Tracker::step). By default there is none.
    pub deadline: Option<Duration>,
    /// The bandwidth $\omega$ of the feedback, rad/s, by default 30: at 500 Hz the delay of one and a half periods
    /// takes ten degrees of phase at $2 \omega$.
    pub bandwidth: f64,
    /// The shortest remaining time for which a plan is changed, s, by default 0.1: closer to the end the accelerations
    /// that correct a plan grow with the inverse square of that time.
    pub shortest_horizon: f64,
    /// The distance of a joint from the plan, rad or m, beyond which a new plan begins at the measured state instead,
    /// by default 0.1: more than the deviation that wrong masses cause with the default bandwidth.
    pub largest_deviation: f64,
}

impl Default for TrackerOptions {
    fn default() -> Self {
        let mut settings = DirectSettings::constrained();
        settings.search.points = settings.search.points_of_segments;
        Self {
            settings,
            barrier: 1e-2,
            iterations_per_step: 1,
            least_gain: 1e-3,
            look: 10,
            deadline: None,
            bandwidth: 30.0,
            shortest_horizon: 0.1,
            largest_deviation: 0.1,
        }
    }
}

impl TrackerOptions {
    /// Refuses values out of range.
    ///
    /// # Errors
    /// An option is out of range; the motion does not end at rest at a given configuration; or it has more than one
    /// segment: the rest of several segments is not in their basis.
    pub fn check(&self, problem: &Problem<'_>) -> Result<()> {
        let refuse = |what, condition| Err(Error::input("tracker", what, condition));
        self.settings.check(problem)?;
        check_count("iterations_per_step", self.iterations_per_step, 1..=DirectSettings::MAX_ITERATIONS)?;
        check_count("look", self.look, 1..=1000)?;
        for (what, value) in [
            ("barrier", self.barrier),
            ("least_gain", self.least_gain),
            ("bandwidth", self.bandwidth),
            ("shortest_horizon", self.shortest_horizon),
            ("largest_deviation", self.largest_deviation),
        ] {
            check_positive("tracker", what, value)?;
        }
        if self.settings.segments != 1 {
            let condition = format!("it is {}, a tracker has 1", self.settings.segments);
            return refuse("segments", condition);
        }
        let DirectSettings { goal, period, .. } = &self.settings;
        if goal.is_some() || period.is_some() || self.settings.free_final_velocity {
            return refuse("goal", "a configuration at rest is needed".to_owned());
        }
        if !self.settings.waypoints.is_empty() {
            let condition = "the rest of a motion has passed some of them".to_owned();
            return refuse("waypoints", condition);
        }
        let velocities = &problem.goal()[problem.model().dof()..];
        if let Some(joint) = velocities.iter().position(|v| *v != 0.0) {
            return refuse("goal", format!("joint {joint} is not at rest there"));
        }
        if problem.accelerations()[1].iter().flatten().any(|a| *a != 0.0) {
            return refuse("goal", "the acceleration there is not zero".to_owned());
        }
        if problem.horizon() < self.shortest_horizon {
            let condition = format!("it is {} s, less than the shortest", problem.horizon());
            return refuse("horizon", condition);
        }
        Ok(())
    }
}
