//! The numerical options of the search.

use super::DirectSettings;
use super::minimise::Stage;
use crate::curve::Continuity;
use crate::error::{Error, Result, check_count, check_positive};

/// The constants of the search around the [interior-point method](crate::nlp), each with its reason. A minimum does not
/// depend on them beyond its tolerances, but they may influence which minimum is found, and in what time.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchOptions {
    /// The initial number of quadrature points per degree, on one segment.
    pub points: f64,
    /// The same on several segments, which are shorter: it leads to the same costs in two thirds of the time on planned
    /// starts and underactuated swing-ups.
    pub points_of_segments: f64,
    /// The largest number of points per degree: beyond it the curve has corners that no quadrature of this kind
    /// resolves.
    pub most_points: usize,
    /// The accepted relative difference of quadratures before the end of a minimisation.
    pub quadrature_on_the_way: f64,
    /// The number of intervals per quadrature point at which rows are scanned.
    pub scan: usize,
    /// The smallest number of intervals of the last scan, on all segments together.
    pub last_scan: usize,
    /// The distance from its bound, relative to its scale, beyond which a scan ignores a row.
    pub scan_depth: f64,
    /// The number of times that margins are set anew at the last barrier parameter before they only grow, so that the
    /// search ends: where a maximum moves from one side of a point to the other, new margins oscillate.
    pub exact_margins: usize,
    /// The distance that rows keep from their bounds, relative to their scale, against rounding at the end.
    pub reserve: f64,
    /// The distance from its bound up to which a clearance is in the working set, relative to the reach of the problem:
    /// more than a few steps near the end of a search.
    pub near: f64,
    /// The same relative to the distance beyond which a row is constant, where a step should not end.
    pub share_of_cutoff: f64,
    /// The distance by which balls may move before clearances that are far are evaluated again, relative to the reach
    /// of the problem; no motion depends on it. With a larger one more of them are evaluated each time (balanced
    /// motions of a Panda among obstacles: 15 % more instructions with 0.06, 20 to 45 % more with 0.02).
    pub moved: f64,
    /// The last barrier parameter, relative to the cost, if only the horizon has bounds, which are easy to approach.
    pub last_barrier_of_bounds: f64,
    /// The accepted torque of a passive joint between the collocated points, relative to the largest torque.
    pub passive_share: f64,
    /// The accepted deviation of an equality of the state between its collocated points, in its unit.
    pub deviation: f64,
    /// The largest product of degree and number of segments when these are increased for passive joints or equalities.
    pub largest_passive_size: usize,
    /// The number of starts that are processed in parallel.
    pub batch: usize,
    /// The fraction of a time limit for the starts if a search for a horizon or a degree follows them.
    pub share_of_starts: f64,
    /// The relative excess over the cost of the best earlier start beyond which a start is dropped, on the last basis
    /// but one and on lower ones: low degrees are a poor indicator.
    pub drop_ratio: [f64; 2],
    /// The number of starts of a batch that go on to the next basis if the goal is a set.
    pub kept_ends: usize,
    /// The relative gradient norm at the end in the bases below the last one: a curve there is only the start of the
    /// next.
    pub lower_tolerance: f64,
    /// The largest number of iterations there on one segment.
    pub lower_iterations: usize,
    /// The same on fewer segments than the last basis has, where the next breakpoints will reduce the cost further.
    pub segment_iterations: usize,
    /// The accepted relative difference of quadratures in lower bases.
    pub lower_quadrature_tolerance: f64,
    /// The last barrier parameter in lower bases, relative to the cost.
    pub lower_last_barrier: f64,
    /// The accepted violation of a row in lower bases, in its unit.
    pub lower_feasible: f64,
    /// The number of further starts that are tried at once, after a single one, while none of the requested ones ends
    /// within the constraints.
    pub more_starts: usize,
    /// The largest number of starts while none of them ends within the constraints.
    pub most_starts: usize,
    /// The smallest number of segments of a planned start.
    pub planned_segments: usize,
    /// Their degree, unless that many segments are requested.
    pub planned_degree: usize,
    /// The first penalty of a violation from a planned start or a given one, relative to the cost: a start that keeps
    /// all rows stays inside.
    pub planned_penalty: f64,
    /// The factor of that penalty from one planned start to the next: the larger it is, the closer a motion stays to
    /// its planned path, in narrow places too.
    pub planned_penalty_factor: f64,
    /// The largest such penalty, after which the first one follows again. With 10 000, steps are so short that searches
    /// do not end, and with 1000 from every later start some do not end either.
    pub largest_planned_penalty: f64,
    /// The number of checked configurations after which a path no longer keeps a margin.
    pub margin_checks: usize,
    /// The factor between successive horizons of a planned start.
    pub horizon_growth: f64,
    /// The relative difference below which the costs of two minima count as equal.
    pub same_minimum: f64,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            points: 3.5,
            points_of_segments: 2.5,
            most_points: 64,
            quadrature_on_the_way: 0.05,
            scan: 6,
            last_scan: 2000,
            scan_depth: 0.05,
            exact_margins: 4,
            reserve: 2e-7,
            near: 0.05,
            share_of_cutoff: 0.5,
            moved: 0.035,
            last_barrier_of_bounds: 1e-12,
            passive_share: 5e-4,
            deviation: 1e-6,
            largest_passive_size: 512,
            batch: 8,
            share_of_starts: 0.5,
            drop_ratio: [0.1, 1.0],
            kept_ends: 1,
            lower_tolerance: 0.1,
            lower_iterations: 30,
            segment_iterations: 60,
            lower_quadrature_tolerance: 0.05,
            lower_last_barrier: 1e-2,
            lower_feasible: 1e-2,
            more_starts: 2,
            most_starts: 64,
            planned_segments: 8,
            planned_degree: 6,
            planned_penalty: 10.0,
            planned_penalty_factor: 10.0,
            largest_planned_penalty: 1e3,
            margin_checks: 125_000,
            horizon_growth: 1.15,
            same_minimum: 1e-3,
        }
    }
}

impl SearchOptions {
    /// The largest number of quadrature points per degree that may be asked for.
    const MAX_POINTS: usize = 1024;

    /// The termination criteria below the last basis.
    pub(super) fn lower(&self) -> Stage {
        Stage {
            tolerance: self.lower_tolerance,
            iterations: self.lower_iterations,
            quadrature_tolerance: self.lower_quadrature_tolerance,
            last_barrier: self.lower_last_barrier,
            feasible: self.lower_feasible,
            last: false,
        }
    }

    /// Refuses values out of range.
    pub(super) fn check(&self, continuity: Continuity) -> Result<()> {
        self.check_numbers()?;
        self.check_counts(continuity)
    }

    fn check_numbers(&self) -> Result<()> {
        for (what, value) in [
            ("points", self.points),
            ("points_of_segments", self.points_of_segments),
            ("quadrature_on_the_way", self.quadrature_on_the_way),
            ("scan_depth", self.scan_depth),
            ("reserve", self.reserve),
            ("near", self.near),
            ("moved", self.moved),
            ("share_of_cutoff", self.share_of_cutoff),
            ("last_barrier_of_bounds", self.last_barrier_of_bounds),
            ("passive_share", self.passive_share),
            ("deviation", self.deviation),
            ("share_of_starts", self.share_of_starts),
            ("drop_ratio", self.drop_ratio[0]),
            ("drop_ratio", self.drop_ratio[1]),
            ("lower_tolerance", self.lower_tolerance),
            ("lower_quadrature_tolerance", self.lower_quadrature_tolerance),
            ("lower_last_barrier", self.lower_last_barrier),
            ("lower_feasible", self.lower_feasible),
            ("planned_penalty", self.planned_penalty),
            ("planned_penalty_factor", self.planned_penalty_factor),
            ("largest_planned_penalty", self.largest_planned_penalty),
            ("same_minimum", self.same_minimum),
        ] {
            check_positive("search", what, value)?;
        }
        let most = Self::MAX_POINTS;
        let points = self.points.max(self.points_of_segments);
        if points > most as f64 {
            let condition = format!("it is {points} and must be at most {most}");
            return Err(Error::input("search", "points", condition));
        }
        // Otherwise the horizons would not grow.
        if !(self.horizon_growth.is_finite() && self.horizon_growth > 1.0) {
            let condition = format!("it is {} and must be more than 1", self.horizon_growth);
            return Err(Error::input("search", "horizon_growth", condition));
        }
        Ok(())
    }

    fn check_counts(&self, continuity: Continuity) -> Result<()> {
        let most = Self::MAX_POINTS;
        let degrees = continuity.smallest_degree()..=DirectSettings::MAX_DEGREE;
        let (iterations, starts) = (1..=DirectSettings::MAX_ITERATIONS, 1..=DirectSettings::MAX_STARTS);
        for (what, count, allowed) in [
            ("most_points", self.most_points, 1..=most),
            ("scan", self.scan, 1..=most),
            ("last_scan", self.last_scan, 1..=1_000_000),
            ("largest_passive_size", self.largest_passive_size, 1..=4096),
            ("batch", self.batch, starts.clone()),
            ("lower_iterations", self.lower_iterations, iterations.clone()),
            ("segment_iterations", self.segment_iterations, iterations),
            ("more_starts", self.more_starts, starts.clone()),
            ("most_starts", self.most_starts, starts.clone()),
            ("kept_ends", self.kept_ends, starts),
            ("planned_segments", self.planned_segments, 1..=DirectSettings::MAX_SIZE),
            ("planned_degree", self.planned_degree, degrees),
            ("margin_checks", self.margin_checks, 1..=1_000_000_000),
        ] {
            check_count(what, count, allowed)?;
        }
        Ok(())
    }
}

/// The options of a [sequence of solves](super::DirectSequence).
#[derive(Clone, Debug)]
pub struct SequenceOptions {
    /// The weights of time in a search for the least time, as multiples of the cost per second of the motion before.
    /// With a first one of 30 balanced motions of four robots among obstacles take an eighth more iterations.
    pub time_share: f64,
    /// The multiple below which a search that leads to no faster motion gives up.
    pub min_time_share: f64,
    /// The same at the end, of the last motion: its cost is at most a hundredth of the objective; without it the motion
    /// of joints that do not determine the duration would be arbitrary.
    pub last_time_share: f64,
    /// The largest number of weights. If only inertia costs effort, each of them divides the duration by four.
    pub max_weights: usize,
    /// The factor up to which a horizon with a larger weight of time shows that there is no faster motion nearby:
    /// margins of rows between the points of the quadrature differ from search to search by parts in ten thousand.
    pub same_horizon: f64,
    /// The longest duration of a balanced motion, as a multiple of the least one.
    pub balanced: f64,
    /// The least duration from which its search starts, as such a multiple.
    pub slowed: f64,
    /// The factor of the first penalty with which a solve that leads to no better minimum is done again: with a larger
    /// penalty a search from a motion that keeps its rows violates them less.
    pub penalty_factor: f64,
    /// The largest number of times that a solve is done again.
    pub max_repeats: i32,
    /// The part of a time limit for the starts of a search that continues from the best one.
    pub part_of_starts: f64,
    /// True if the first solve on a free horizon follows one on the given horizon.
    pub fixed_first: bool,
}

impl Default for SequenceOptions {
    fn default() -> Self {
        Self {
            time_share: 1000.0,
            min_time_share: 2.0,
            last_time_share: 100.0,
            max_weights: 8,
            same_horizon: 1.001,
            balanced: 1.25,
            slowed: 1.2,
            penalty_factor: 10.0,
            max_repeats: 2,
            part_of_starts: 0.5,
            fixed_first: false,
        }
    }
}
