//! Solving a walk: one search, and one report per phase.

use crate::keys::phases::of_phase;
use crate::results::report::{Solution, Solve, SolveReport, report_of};
use crate::solve::by_direct::{search_directly, solution_of};
use crate::solve::custom_terms::worst_row;
use crate::solve::search::Search;
use crate::{DirectOptions, Scenario, ScenarioFile, SolveOptions};
use aghf::constraint::{Constraint, Evaluator, Weights};
use aghf::curve::Curve;
use aghf::direct::{DirectSettings, DirectSolution};
use aghf::error::{Error, Result, check_length};
use nalgebra::DMatrix;
use serde::Serialize;
use std::path::Path;

/// The solve of a walk.
#[derive(Debug)]
pub struct Walk {
    /// The phases: ordinary scenarios, whose ends are those of the motion, each with the report of its part of the
    /// motion.
    pub phases: Vec<(Scenario, SolveReport)>,
    /// The landings between them.
    pub landings: Vec<Landing>,
}

/// The landing of a foot, on the robot of the walk.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Landing {
    /// The time, s.
    pub time_s: f64,
    /// The name of the foot.
    pub frame: String,
    /// The largest deviation from its place, m or rad.
    pub off: f64,
    /// The largest speed at which it lands, m/s or rad/s.
    pub speed: f64,
}

impl Walk {
    /// Returns true if all phases are valid and all feet land at their places, without speed.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let lands = |of: &Landing| of.off.max(of.speed) <= LANDS;
        let valid = |(_, report): &(Scenario, SolveReport)| report.summary.success;
        self.phases.iter().all(valid) && self.landings.iter().all(lands)
    }
}

/// The accepted deviation and speed of a landing, m and m/s: ten times that of the search, whose rates are in the unit
/// of the horizon.
const LANDS: f64 = 10.0 * DirectSettings::FEASIBLE;

impl Solve<'_> {
    /// Solves a walk, a scenario with [phases](crate::ScenarioFile::phases), in one search.
    ///
    /// # Errors
    /// As [`run`](Self::run); the scenario has no phases, there is a start, or the method is another than
    /// the direct one.
    pub fn run_walk(self) -> Result<Walk> {
        let (scenario, options) = (self.scenario, self.options.clone());
        let SolveOptions::Direct(own) = &options else {
            let condition = "a walk is solved by the method 'direct' alone";
            return Err(Error::input("options", "method", condition));
        };
        if self.start.is_some() {
            let condition = "a walk cannot be warm-started: a run holds one phase";
            return Err(Error::input("options", "start", condition));
        }
        scenario.check_for(options.method())?;
        options.check(scenario)?;
        scenario.check_feasible()?;
        let Self { interrupt, mut observe, .. } = self;
        let run = |search: &mut Search<'_, '_>| search.run();
        let (found, whole) = search_directly(scenario, own, (None, interrupt), &mut *observe, run)?;
        let mut phases = Vec::new();
        let landings = scenario.landings_of(&found.curve)?;
        for (phase, curve) in scenario.split(&found.curve)? {
            let part = part(&phase, own, (&found, curve), &whole)?;
            let of_phase = DirectOptions {
                degree: Some(part.curve.degree()),
                segments: Some(part.curve.segments()),
                ..own.clone()
            };
            let report = report_of(&phase, &of_phase.into(), part)?;
            phases.push((phase, report));
        }
        Ok(Walk { phases, landings })
    }
}

/// The part of a solution in a phase.
fn part(
    phase: &Scenario,
    options: &DirectOptions,
    (found, curve): (&DirectSolution, Curve),
    whole: &Solution,
) -> Result<Solution> {
    let settings = options.settings(phase)?;
    let points = phase.file.waypoints.iter();
    let times = points.filter_map(|point| point.time_s).collect();
    let own = DirectSolution {
        cost: aghf::flow::effort_of(&phase.model, &curve, 1.0)?.control_effort,
        first_guess: curve.clone(),
        curve,
        multipliers: Default::default(),
        minima: Vec::new(),
        minima_curves: Vec::new(),
        waypoint_times: times,
        ..found.clone()
    };
    let part = solution_of(phase, (&settings, None), (None, own), whole.solve_seconds)?;
    Ok(Solution { failure: whole.failure.clone(), ..part })
}

impl Scenario {
    /// The phases of a walk along a motion: ordinary scenarios, each with its robot, its ends and its part of the
    /// motion.
    ///
    /// # Errors
    /// The motion has other joints than the scenario, or no segments that belong to one phase each.
    pub fn split(&self, curve: &Curve) -> Result<Vec<(Self, Curve)>> {
        let (n, count) = (self.model.dof(), self.phases.len());
        check_length("motion", n, curve.dof())?;
        if count == 0 || !curve.segments().is_multiple_of(count) {
            let condition = format!("{} segments are not those of {count} phases", curve.segments());
            return Err(Error::input(&self.name, "phases", condition));
        }
        let segments = curve.segments() / count;
        let columns = segments * (curve.degree() + 1);
        let mut all = Vec::new();
        for (k, (phase, terms)) in self.file.phases.iter().zip(&self.phases).enumerate() {
            let at = |i: usize| i - i % n + terms.order[i % n];
            let own = |i: usize, j: usize| curve.x()[(at(i), k * columns + j)];
            let x = DMatrix::from_fn(2 * n, columns, own);
            let horizon = curve.horizon_of(k * curve.parts() / count) / count as f64;
            let part = |j: usize, first: usize| x.column(j).as_slice()[first..first + n].to_vec();
            let [[q_start, v_start], [q_goal, v_goal]] = [0, columns - 1].map(|j| [part(j, 0), part(j, n)]);
            let file = ScenarioFile {
                robot: self.robot_place.clone(),
                q_start,
                v_start,
                q_goal,
                v_goal,
                enforced_limits: self.file.enforced_limits.in_order(&terms.order),
                ..of_phase(&self.file, phase, horizon)
            };
            let mut of = Self::new(file, &self.name, Path::new(""))?;
            of.name = format!("{}_phase_{}", self.name, k + 1);
            all.push((of, Curve::piecewise(horizon, segments, x)?));
        }
        Ok(all)
    }

    /// The landings between the phases along a motion.
    fn landings_of(&self, curve: &Curve) -> Result<Vec<Landing>> {
        let (n, mut all) = (self.model.dof(), Vec::new());
        let landings = self.waypoints.iter().filter(|point| point.lands);
        let phases = self.file.phases.iter().zip(landings);
        for (k, (phase, waypoint)) in phases.enumerate() {
            let time_s = curve.breakpoints()[(k + 1) * curve.segments() / self.phases.len()];
            let (x, _) = curve.at(time_s);
            let (q, v) = x.as_slice().split_at(n);
            let (rows, still) = (&waypoint.constraints[..], [q, &vec![0.0; n]].concat());
            let off = worst_row(rows, &self.model, &still)?.map_or(0.0, |(off, _)| off);
            let scales = rows.row_scales();
            let mut evaluator = Evaluator::new(&self.model);
            let (mut placed, mut speed) = (evaluator.at(&still)?, 0.0_f64);
            for row in (0..rows.dim()).filter(|row| rows.row_set(*row).is_equality) {
                let mut alone = vec![0.0; rows.dim()];
                alone[row] = 1.0 / scales[row];
                let weights = Weights { first_order: &alone, gauss_newton: None };
                let gradient = placed.weighted_derivatives(rows, weights)?.gradient();
                let rate: f64 = v.iter().zip(gradient.iter()).map(|(v, g)| v * g).sum();
                speed = speed.max(rate.abs());
            }
            let frame = phase.land.as_ref().map(|land| land.frame.clone());
            all.push(Landing { time_s, frame: frame.unwrap_or_default(), off, speed });
        }
        Ok(all)
    }
}
