//! The settings and the results of the direct method.

use super::minimise::Stage;
use super::waypoint;
use super::{FreeHorizon, GoalSet, Multipliers, Period, SearchOptions, Waypoint};
use crate::curve::{Basis, Continuity, Curve};
use crate::error::{Error, Result, check_count, check_positive};
use crate::motion::{Interrupt, Problem};
use crate::nlp;
use std::time::{Duration, Instant};

/// The settings of a direct solve.
#[derive(Clone, Debug)]
pub struct DirectSettings {
    /// The degree of the polynomial, or of each segment.
    pub degree: usize,
    /// The number of polynomials on equal parts of the horizon. At their joints `q` and `v` are continuous;
    /// acceleration and control may jump.
    pub segments: usize,
    /// The relative change of the cost between two degrees below which the degree is high enough. Starting from
    /// [`degree`](Self::degree), it grows through 9, 16, 24, 32, 48 and 64, each from the end of the one before; see
    /// [`DegreeRefinement`](super::DegreeRefinement). `None` keeps the degree fixed.
    pub degree_tolerance: Option<f64>,
    /// The relative gradient norm of convergence; see [`Iteration::gradient_norm`](super::Iteration::gradient_norm).
    pub tolerance: f64,
    /// The largest number of iterations per degree and quadrature.
    pub iterations: usize,
    /// The largest relative difference between the quadrature and a finer one.
    pub quadrature_tolerance: f64,
    /// The number of starts: the straight line, and bent ones.
    pub starts: usize,
    /// The seed of the bends of the starts.
    pub seed: u64,
    /// The time after which the search stops with the best motion so far. Where other searches follow the starts, for a
    /// free horizon or another degree, the starts have their share of it; a search that needs less is as without a
    /// limit. With one a path is planned first, unless there are no planned starts: a search that is cut off before it
    /// finds anything better ends with the motion along it, if that satisfies the constraints.
    pub time_limit: Option<Duration>,
    /// The handle by which another thread stops the search in the same way.
    pub interrupt: Interrupt,
    /// The number of threads for the starts; the result does not depend on it.
    pub threads: usize,
    /// The amplitude of the bent starts, rad or m.
    pub start_amplitude: f64,
    /// The degree of the first polynomial of a start, unless the degree is lower; by default 6, as smooth curves lead
    /// to better minima, and 9 with constraints, as no curve of a lower degree may be feasible within limits.
    pub lowest_degree: usize,
    /// The starts for which a planner finds paths around obstacles; see [`plan`](crate::plan). It has no effect if only
    /// joints have bounds. A [first](PlannedStarts::First) planned start may lengthen the horizon up to
    /// [`longest_horizon`](Self::longest_horizon). Because it satisfies all constraints before the minimisation, so
    /// does the final motion.
    pub planned_starts: PlannedStarts,
    /// The longest horizon to which a planned first start may lengthen that of the problem, s. The upper bound of a
    /// free horizon takes precedence.
    pub longest_horizon: Option<f64>,
    /// An initial curve, used directly at this degree; its shape is fitted to the boundary states and the horizon of
    /// the problem, or to its own horizon if that is free.
    pub start: Option<Curve>,
    /// The multipliers of the rows at the initial curve; with these the first barrier parameter is smaller.
    pub multipliers: Option<Multipliers>,
    /// True if the initial curve and the multipliers are those of a minimum of this problem or of one that differs
    /// little: the search then begins with the margins of that minimum and the last barrier parameter that its
    /// conditions of optimality allow.
    pub start_is_minimum: bool,
    /// True if the final velocity is free. That of the goal then serves only as the first guess.
    pub free_final_velocity: bool,
    /// True if the acceleration is continuous: between segments, and with the rest before and after, so that it is zero
    /// at an end at which all velocities are. Otherwise it may jump.
    pub continuous_acceleration: bool,
    /// The bounds and the weight of a free horizon; the search then starts from that of the problem.
    pub free_horizon: Option<FreeHorizon>,
    /// The shortest and the longest length of each of at least two parts of the motion with equal numbers of segments,
    /// s. If the horizon is free, each length is an unknown and the horizon their sum; otherwise each is as close as
    /// its bounds allow to that of equal parts. If empty, the motion has no parts with lengths of their own.
    pub parts: Vec<[f64; 2]>,
    /// A goal that is a set: the final configuration is an unknown within it, and that of the problem has no effect.
    pub goal: Option<GoalSet>,
    /// The points on the way, in their order.
    pub waypoints: Vec<Waypoint>,
    /// The relation between the ends of a periodic motion, whose states are then unknown; those of the problem serve
    /// only as the first guess.
    pub period: Option<Period>,
    /// The constants of the search.
    pub search: SearchOptions,
    /// Those of the interior-point method, with the rule of its barrier parameter. [`tolerance`](Self::tolerance) and
    /// [`iterations`](Self::iterations) replace its own.
    pub nlp: nlp::Options,
}

crate::names::named_enum! {
/// The starts for which a planner looks for a path around obstacles.
pub enum PlannedStarts("planned starts") {
    /// Every other start beyond the requested ones, while none of these leads to a motion.
    Later = "later",
    /// The first start, on a longer horizon if limits require it, and later ones; a feasible motion suffices.
    First = "first",
    /// None.
    Never = "never",
}
}

impl Default for DirectSettings {
    fn default() -> Self {
        Self {
            degree: 16,
            segments: 1,
            degree_tolerance: None,
            tolerance: 1e-8,
            iterations: 500,
            quadrature_tolerance: 1e-3,
            starts: 32,
            seed: 0,
            time_limit: None,
            interrupt: Interrupt::default(),
            threads: 1,
            start_amplitude: 2.5,
            lowest_degree: 6,
            planned_starts: PlannedStarts::default(),
            longest_horizon: None,
            start: None,
            multipliers: None,
            start_is_minimum: false,
            free_final_velocity: false,
            continuous_acceleration: false,
            free_horizon: None,
            parts: Vec::new(),
            goal: None,
            waypoints: Vec::new(),
            period: None,
            search: SearchOptions::default(),
            nlp: nlp::Options::default(),
        }
    }
}

impl DirectSettings {
    /// The largest degree: beyond it the tables of a single polynomial no longer fit into memory.
    pub const MAX_DEGREE: usize = 64;
    /// The largest degree times the number of segments: beyond it the Hessians of a large robot do not fit into memory.
    pub const MAX_SIZE: usize = 256;
    /// The largest number of starts: the record of each, a cost and about fifty iterations, is up to 4 kB, all 400 MB.
    pub const MAX_STARTS: usize = 100_000;
    /// The largest number of iterations at one degree, each of which is recorded.
    pub const MAX_ITERATIONS: usize = 100_000;
    /// The largest number of threads: more than the cores of any machine, and within the limits of operating systems.
    pub const MAX_THREADS: usize = 1024;
    /// The accepted violation of a constraint, in rad, rad/s, m, N m or N.
    pub const FEASIBLE: f64 = 1e-6;

    /// Returns true if a search that started then has time left and is not interrupted.
    #[must_use]
    pub fn has_time(&self, started: Instant) -> bool {
        let is_late = self.time_limit.is_some_and(|limit| started.elapsed() >= limit);
        !is_late && !self.interrupt.is_raised()
    }

    /// The defaults for problems with constraints: a gradient norm of 1e-6, because large multipliers limit the
    /// accuracy.
    #[must_use]
    pub fn constrained() -> Self {
        Self { tolerance: 1e-6, starts: 1, start_amplitude: 1.0, lowest_degree: 9, ..Self::default() }
    }

    /// The last stage, at the degree and the segments of the settings.
    pub(super) fn highest(&self) -> Stage {
        Stage {
            tolerance: self.tolerance,
            iterations: self.iterations,
            quadrature_tolerance: self.quadrature_tolerance,
            last_barrier: self.nlp.last_barrier.max(self.tolerance * self.tolerance),
            feasible: self.nlp.feasible,
            last: true,
        }
    }

    /// The sequence of bases: single polynomials of those degrees among 6, 9, 16, 24, 32, 48, ... that are below the
    /// final degree; then the final degree on fewer segments, each basis with all breakpoints of the previous one; then
    /// the final basis. With passive joints there are at least half of the final segments: a few polynomials leave such
    /// a joint almost no freedom. There is at least one polynomial per phase, or per part with a length of its own.
    pub(crate) fn levels(&self, continuity: Continuity, passive: bool, parts: usize) -> Vec<Level> {
        let lower = self.search.lower();
        let fewer_segments = Stage { iterations: self.search.segment_iterations, ..lower };
        let new = |segments, p| Basis::new(segments, p, continuity);
        let mut levels: Vec<_> = Basis::degrees_below(self.degree, self.lowest_degree)
            .map(|p| Level { basis: new(parts, p), stage: lower })
            .collect();
        levels.extend(
            Basis::fewer_segments(self.segments).map(|n| Level { basis: new(n, self.degree), stage: fewer_segments }),
        );
        levels.retain(|level| level.basis.segments().is_multiple_of(parts));
        // A low degree on one segment is already the first level.
        levels.dedup_by(|b, a| a.basis == b.basis);
        if passive {
            levels.retain(|level| 2 * level.basis.segments() >= self.segments);
        }
        let conditions = waypoint::conditions(&self.waypoints);
        levels.retain(|level| level.basis.free().len() > conditions);
        let last = new(self.segments, self.degree);
        levels.retain(|level| level.basis != last);
        levels.push(Level { basis: last, stage: self.highest() });
        levels
    }

    /// The continuity of motions of a problem.
    pub(super) fn continuity(&self, problem: &Problem<'_>) -> Continuity {
        let n = problem.model().dof();
        let rests = |state: &[f64]| state[n..].iter().all(|v| *v == 0.0);
        let is_periodic = self.period.is_some();
        let free_final_velocity = self.free_final_velocity || is_periodic;
        let [given_start, given_goal] = problem.accelerations().each_ref().map(Option::is_some);
        let at_goal = given_goal || !free_final_velocity && rests(problem.goal());
        Continuity {
            acceleration: self.continuous_acceleration,
            fixed_accelerations: [given_start || rests(problem.start()), at_goal],
            free_final_velocity,
            free_final_position: self.goal.is_some() || is_periodic,
            corners: false,
            free_start: is_periodic,
        }
    }

    /// The basis of motions of a problem.
    pub(super) fn basis(&self, problem: &Problem<'_>) -> Basis {
        Basis::new(self.segments, self.degree, self.continuity(problem))
    }

    /// The degrees above that of a basis in a refinement.
    pub(super) fn higher_degrees(basis: &Basis) -> impl Iterator<Item = usize> + use<> {
        let (degree, segments) = (basis.degree(), basis.segments());
        let largest = Self::MAX_DEGREE.min(Self::MAX_SIZE / segments);
        let above = Basis::degrees().skip_while(move |higher| *higher <= degree);
        above.take_while(move |degree| *degree <= largest)
    }

    /// Checks a degree and a number of segments.
    ///
    /// # Errors
    /// One of the two is out of range.
    pub fn check_size(degree: usize, segments: usize, continuity: Continuity) -> Result<()> {
        let refuse = |what: &str, condition: String| Err(Error::input("settings", what, condition));
        let (smallest, largest) = (continuity.smallest_degree(), Self::MAX_DEGREE);
        if !(smallest..=largest).contains(&degree) {
            let range = format!("at least {smallest} and at most {largest}");
            return refuse("degree", format!("it is {degree} and must be {range}"));
        }
        let most = Self::MAX_SIZE / degree;
        if !(1..=most).contains(&segments) {
            let range = format!("at least 1 and for degree {degree} at most {most}");
            return refuse("segments", format!("it is {segments} and must be {range}"));
        }
        Ok(())
    }

    /// Refuses values out of range.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn check(&self, problem: &Problem<'_>) -> Result<()> {
        Self::check_size(self.degree, self.segments, self.continuity(problem))?;
        self.search.check(self.continuity(problem))?;
        self.nlp.check()?;
        for (what, value) in [
            ("tolerance", self.tolerance),
            ("quadrature_tolerance", self.quadrature_tolerance),
            ("degree_tolerance", self.degree_tolerance.unwrap_or(1.0)),
        ] {
            check_positive("settings", what, value)?;
        }
        if !self.start_amplitude.is_finite() {
            let condition = format!("it is {} and must be a finite number", self.start_amplitude);
            return Err(Error::input("settings", "start_amplitude", condition));
        }
        let degrees = self.continuity(problem).smallest_degree()..=Self::MAX_DEGREE;
        check_count("lowest_degree", self.lowest_degree, degrees)?;
        check_count("starts", self.starts, 1..=Self::MAX_STARTS)?;
        check_count("iterations", self.iterations, 1..=Self::MAX_ITERATIONS)?;
        check_count("threads", self.threads, 1..=Self::MAX_THREADS)?;
        if let Some(free) = &self.free_horizon {
            free.check(problem.horizon())?;
        }
        super::parts::check(self)?;
        let are_given = problem.accelerations().iter().any(Option::is_some);
        if are_given && (!self.continuous_acceleration || self.period.is_some() || !self.parts.is_empty()) {
            let condition = "they are given, and need continuous accelerations, without a period or parts";
            return Err(Error::input("settings", "accelerations", condition));
        }
        if let Some(goal) = &self.goal {
            goal.check(problem)?;
        }
        if let Some(period) = &self.period {
            period.check(self, problem)?;
        }
        waypoint::check(self, problem)?;
        if let Some(longest) = self.longest_horizon {
            let least = problem.horizon();
            if !(longest.is_finite() && longest >= least) {
                let condition = format!("it is {longest} and must be at least the horizon {least}");
                return Err(Error::input("settings", "longest_horizon", condition));
            }
        }
        match (&self.start, &self.multipliers) {
            (Some(curve), _) => problem.model().check("start", curve.dof()),
            (None, Some(_)) => {
                let condition = "they are given without a start";
                Err(Error::input("settings", "multipliers", condition))
            }
            (None, None) => Ok(()),
        }
    }
}

/// One basis of the sequence.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    pub basis: Basis,
    pub stage: Stage,
}
