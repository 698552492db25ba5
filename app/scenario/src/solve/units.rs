//! The weights of an objective in SI units, the cost that they make, and the bounds of the horizon.

use crate::keys::durations::sum_of;
use crate::solve::custom_terms::ScenarioCost;
use crate::{HorizonBounds, Objective, ObjectiveWeights, Scenario, Units};
use aghf::constraint::{Quantity, RowLabel};
use aghf::cost::{ControlEffort, CostWithControl, InPhases, Point, WeightedSquares};
use aghf::direct::FreeHorizon;
use aghf::error::Result;
use std::array::from_fn;

/// The duration of the straight motion by which terms are scaled, as a multiple of the least horizon. Its largest
/// velocity is then 15/16 of that of the least horizon.
const STRAIGHT_DURATION: f64 = 2.0;

/// The number of intervals in which the cost of that motion is integrated.
const INTERVALS: usize = 64;

/// The bounds of a horizon that the objective makes free, as multiples of the least one and of `horizon_s`.
const MAX_MULTIPLE: f64 = 10.0;
const MIN_MULTIPLE: f64 = 0.1;

/// The shortest horizon that the objective chooses, s: the period of usual controllers.
const MIN_S: f64 = 1e-3;

/// The weights of the duration and of the integrals of squares, in SI units.
struct SiWeights {
    time: f64,
    /// Those of torques, velocities, accelerations and jerks, `N` entries each.
    squares: [Vec<f64>; 4],
}

impl Scenario {
    /// The unit of time of a scaled objective for a motion to `goal`, s: the [least horizon](Self::least_horizon), or
    /// else `horizon_s`.
    pub(crate) fn unit_of_time(&self, goal: Option<&[f64]>) -> f64 {
        self.least_horizon_to(goal).map_or(self.file.horizon_s, |(.., time)| time)
    }

    /// The duration from which a search to an end of a goal that is a set begins, s.
    pub(crate) fn first_horizon(&self, end: &[f64]) -> f64 {
        STRAIGHT_DURATION * self.unit_of_time(Some(end))
    }

    /// The integral of a running cost along the straight motion from rest to rest to `goal`, `N` entries,
    /// $q = q_0 + (10 x^3 - 15 x^4 + 6 x^5) (q_1 - q_0)$ with $x = t / T$, in twice the unit of time.
    pub(crate) fn cost_of_straight(&self, cost: &mut impl CostWithControl, goal: &[f64]) -> Result<f64> {
        let (file, horizon) = (&self.file, STRAIGHT_DURATION * self.unit_of_time(Some(goal)));
        let ends = || file.q_start.iter().zip(goal);
        let along = |share: f64| ends().map(|(from, to)| share * (to - from)).collect();
        let mut sum = 0.0;
        for index in 0..=INTERVALS {
            let x = index as f64 / INTERVALS as f64;
            let share = x.powi(3) * (10.0 + x * (6.0 * x - 15.0));
            let q: Vec<f64> = ends().map(|(from, to)| from + share * (to - from)).collect();
            let v: Vec<f64> = along(30.0 * (x * (1.0 - x)).powi(2) / horizon);
            let a: Vec<f64> = along(60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / horizon.powi(2));
            // Simpson's rule.
            let weight = match index {
                0 | INTERVALS => 1.0,
                _ => [2.0, 4.0][index % 2],
            };
            sum += weight * cost.value(Point { index, phase: 0, time: x * horizon, q: &q, v: &v, a: &a })?;
        }
        Ok(sum * horizon / (3.0 * INTERVALS as f64))
    }

    /// The units of the terms of a scaled objective: the unit of time, and the integrals of $|u|^2$, $|v|^2$, $|a|^2$
    /// and $|\dot a|^2$ along the straight motion; one where that is zero, as without gravity between equal ends.
    fn units_of_squares(&self) -> Result<[f64; 4]> {
        let aim = self.aim();
        let goal = aim.as_ref().unwrap_or(&self.file.q_goal);
        let horizon = STRAIGHT_DURATION * self.unit_of_time(Some(goal));
        let ends = self.file.q_start.iter().zip(goal);
        let way: f64 = ends.map(|(from, to)| (to - from).powi(2)).sum();
        let effort = self.cost_of_straight(&mut ControlEffort::new(&self.model), goal)?;
        // The integrals of the squared derivatives of the quintic over [0, 1] are 10/7, 120/7 and 720.
        let [velocity, acceleration, jerk] =
            [10.0 / 7.0 * way / horizon, 120.0 / 7.0 * way / horizon.powi(3), 720.0 * way / horizon.powi(5)];
        let all = [effort, velocity, acceleration, jerk];
        Ok(all.map(|unit| if unit > 0.0 { unit } else { 1.0 }))
    }

    /// The weights of the objective; those of a preset are those of the effort.
    fn weights(&self) -> Result<SiWeights> {
        let default = ObjectiveWeights { units: Units::Si, ..ObjectiveWeights::default() };
        let weights = match &self.file.objective {
            Objective::Weights(weights) if self.file.objective.preset().is_none() => weights,
            _ => &default,
        };
        let (time, squares) = match weights.units {
            Units::Si => (1.0, [1.0; 4]),
            Units::Scaled => (self.unit_of_time(self.aim().as_deref()), self.units_of_squares()?),
        };
        let (integrals, dof) = (weights.integrals(), self.model.dof());
        let scaled = |i: usize| {
            let all = integrals[i].1.all(dof).into_iter();
            all.map(|weight| weight / squares[i]).collect()
        };
        Ok(SiWeights { time: weights.time / time, squares: from_fn(scaled) })
    }

    /// The running cost that is minimised, without the weight of time; with a preset the control effort.
    ///
    /// # Errors
    /// The scenario has weights for another number of joints.
    pub fn running_cost(&self) -> Result<impl CostWithControl> {
        self.scenario_cost()
    }

    /// The same by its type.
    pub(crate) fn scenario_cost(&self) -> Result<ScenarioCost<'_>> {
        if let Some(own) = self.own_cost() {
            return Ok(own);
        }
        if !self.phases.is_empty() {
            let costs = self.phases.iter();
            let costs = costs.map(|of| (ControlEffort::new(&of.model), of.order.clone()));
            let costs = costs.collect();
            return Ok(ScenarioCost::Phases(Box::new(InPhases::new(costs)?)));
        }
        let SiWeights { squares, .. } = self.weights()?;
        let [torque, velocity, acceleration, jerk] = squares;
        let squares = WeightedSquares::new(self.model.dof(), torque, velocity, acceleration)?;
        let cost = ControlEffort::weighted(&self.model, &squares)?.with_higher(&[&jerk])?;
        Ok(ScenarioCost::Squares(Box::new(cost)))
    }

    /// The bounds of the horizon if it is an unknown: those of `free_horizon`, or the sums of those of the phases of a
    /// walk. Without these, if the objective weighs time, it is from the least horizon, or `horizon_s` if that is
    /// shorter, to ten times the longer one of the two. If the goal is a set, it is from a tenth of the least horizon
    /// to the end that takes least, as others in the set may take less.
    #[must_use]
    pub fn horizon_bounds(&self) -> Option<HorizonBounds> {
        let file = &self.file;
        let back = file.start_tolerance.map_or(0.0, |start| start.back_s);
        let durations = file.durations();
        if file.free_horizon.is_none() && !durations.is_empty() {
            let [shortest_s, longest_s] = sum_of(&durations);
            let bounds =
                HorizonBounds { shortest_s: shortest_s.min(file.horizon_s), longest_s: longest_s.max(file.horizon_s) };
            return durations.iter().any(|of| of[0] < of[1]).then_some(bounds);
        }
        if file.free_horizon.is_some() || !file.objective.weighs_time() {
            return file.free_horizon.map(|free| HorizonBounds { shortest_s: free.shortest_s.max(back), ..free });
        }
        let given = file.horizon_s;
        let aim = self.aim();
        let least = self.least_horizon_to(aim.as_deref());
        let least = least.map(|(.., least)| least);
        let shortest = match least {
            Some(least) if self.goal.is_some() => MIN_MULTIPLE * least,
            Some(least) => least,
            None if self.is_at(aim.as_deref()) => MIN_S,
            None => MIN_MULTIPLE * given,
        };
        Some(HorizonBounds {
            shortest_s: shortest.max(MIN_S).min(given).max(back),
            longest_s: MAX_MULTIPLE * least.unwrap_or(given).max(given),
        })
    }

    /// The excess of a free horizon, s, over the bound that it exceeds most, or its distance from both if negative.
    pub(crate) fn off_horizon(&self, horizon: f64) -> Option<(f64, RowLabel)> {
        let bounds = self.horizon_bounds()?;
        let below = (bounds.shortest_s - horizon, "lower");
        let above = (horizon - bounds.longest_s, "upper");
        let (by, side) = if below.0 > above.0 { below } else { above };
        Some((by, RowLabel::new(format!("{side} bound of the horizon"), "s", Quantity::Duration)))
    }

    /// The bounds of the horizon and the cost of a second, if it is an unknown.
    pub(crate) fn free_horizon(&self) -> Result<Option<FreeHorizon>> {
        let bounds = self.horizon_bounds();
        let weight = self.weights()?.time;
        Ok(bounds.map(|bounds| bounds.weighted(weight)))
    }
}
