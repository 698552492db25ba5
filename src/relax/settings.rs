//! What can be asked of the relaxation, and what it says.

use super::interior_point::Stage;
use super::tuning::{FRESH, LAST_BARRIER, LOWER, LOWEST_DEGREE, SEGMENT_STEPS};
use super::{DegreeRefinement, FreeHorizon, LocalMinimum};
use crate::curve::{Basis, Curve};
use crate::error::{Error, Result, check_count, check_positive};
use crate::motion::{Interrupt, Problem, Stopped};
use std::time::Duration;

/// The settings of a relaxation.
#[derive(Clone, Debug)]
pub struct RelaxSettings {
    /// The degree of the polynomial, or of each segment.
    pub degree: usize,
    /// The number of polynomials on equal parts of the horizon of which the motion is made. Where two meet `q` and `v` are continuous;
    /// acceleration and control may jump.
    pub segments: usize,
    /// The relative change of the cost from one degree to the next below which the degree is enough. It goes on from this degree to 9, 16,
    /// 24, 32, 48, 64, each from where the one before ended; see [`DegreeRefinement`]. The degree is that of the settings without it.
    pub degree_tolerance: Option<f64>,
    /// The relative gradient norm at which it is done; see [`Iteration::gradient_norm`].
    pub tolerance: f64,
    /// The most iterations at one degree and one quadrature.
    pub iterations: usize,
    /// The largest relative difference of the quadrature and a finer one.
    pub quadrature_tolerance: f64,
    /// The number of starts: the line, and bent ones.
    pub num_starts: usize,
    /// The number from which the bends of the starts are drawn.
    pub seed: u64,
    /// The time after which the search stops with the best motion so far. Until then it tries further starts.
    pub time_limit: Option<Duration>,
    /// The request that stops it likewise when it is raised.
    pub interrupt: Interrupt,
    /// The number of threads that work on starts; the result does not depend on it.
    pub threads: usize,
    /// The amplitude of the bent ones, rad or m.
    pub start_amplitude: f64,
    /// The starts for which a planner finds ways around what is in the way; see [`plan`](crate::plan). It does nothing where there are bounds of joints
    /// alone. A [first](PlannedStarts::First) one takes a horizon up to [`longest_horizon`](Self::longest_horizon). Since it keeps what is asked of
    /// the motion before anything is minimised, so does the motion in the end.
    pub planned_starts: PlannedStarts,
    /// The longest horizon to which that of the problem is lengthened where a planned first start asks for that, s; that of a free horizon where
    /// there is one.
    pub longest_horizon: Option<f64>,
    /// A curve to start from instead, at once at this degree; its shape, between the states of the problem and on its horizon.
    pub start: Option<Curve>,
    /// True if the velocity at the end is whatever costs least. That of the goal is then no more than the first guess.
    pub free_final_velocity: bool,
    /// Whether the horizon is found as well; that of the problem is then where the search begins.
    pub free_horizon: Option<FreeHorizon>,
}

crate::names::named_enum! {
/// The starts for which a planner looks for a way around what is in the way.
pub enum PlannedStarts("planned starts") {
    /// Every other start beyond those that were asked for, while none of these leads to a motion.
    Later = "later",
    /// The first start, on a longer horizon where limits ask for that, and later ones; a motion that keeps all constraints will do.
    First = "first",
    /// None.
    Never = "never",
}
}

impl Default for RelaxSettings {
    fn default() -> Self {
        Self {
            degree: 16,
            segments: 1,
            degree_tolerance: None,
            tolerance: 1e-8,
            iterations: 500,
            quadrature_tolerance: 1e-3,
            num_starts: 16,
            seed: 0,
            time_limit: None,
            interrupt: Interrupt::default(),
            threads: 1,
            start_amplitude: 2.5,
            planned_starts: PlannedStarts::default(),
            longest_horizon: None,
            start: None,
            free_final_velocity: false,
            free_horizon: None,
        }
    }
}

impl RelaxSettings {
    /// The largest degree: beyond it the tables of a single polynomial no longer fit into memory.
    pub const LARGEST_DEGREE: usize = 64;
    /// The largest degree times the number of segments: beyond it the Hessians of a large robot do not.
    pub const LARGEST_SIZE: usize = 256;
    /// The most starts: what is kept of each, a cost and some fifty iterations, is up to 4 kB, 400 MB in all.
    pub const LARGEST_NUM_STARTS: usize = 100_000;
    /// The most iterations at one degree, of which each is kept.
    pub const MOST_ITERATIONS: usize = 100_000;
    /// The most threads: more than any machine has cores, and no more than a system lets a program have.
    pub const MOST_THREADS: usize = 1024;
    /// What a motion may exceed its constraints by, in rad, rad/s, m, N m or N.
    pub const FEASIBLE: f64 = 1e-6;

    /// The defaults within constraints: the gradient norm is 1e-6, since large multipliers leave no more digits.
    #[must_use]
    pub fn constrained() -> Self {
        Self {
            tolerance: 1e-6,
            num_starts: 1,
            start_amplitude: 1.0,
            ..Self::default()
        }
    }

    /// The stage at the degree and the segments of the settings.
    pub(super) fn highest(&self, constrained: bool) -> Stage {
        Stage {
            tolerance: self.tolerance,
            iterations: self.iterations,
            fresh: FRESH[usize::from(constrained)],
            quadrature_tolerance: self.quadrature_tolerance,
            last_barrier: LAST_BARRIER.max(self.tolerance * self.tolerance),
            // Whoever looks at the motion by other means finds it within the tolerance as well.
            feasible: 0.5 * Self::FEASIBLE,
            slope: self.free_horizon.is_some(),
            last: true,
        }
    }

    /// The rungs of the ladder: single polynomials of those of the degrees 6, 9, 16, 24, 32, 48, ... that are below the degree, then the
    /// degree on fewer segments, of which each rung has all breakpoints of the one before, then the whole motion.
    /// With passive joints there are at least half as many segments as in the end: a few polynomials leave such a joint next to no choice.
    pub(super) fn rungs(&self, constrained: bool, passive: bool) -> Vec<Rung> {
        let lower = LOWER[usize::from(constrained)];
        let fewer_segments = Stage {
            iterations: SEGMENT_STEPS,
            ..lower
        };
        let first = LOWEST_DEGREE[usize::from(constrained)];
        let new = |segments, p| Basis::new(segments, p, self.free_final_velocity);
        let mut rungs: Vec<_> = Basis::degrees_below(self.degree, first)
            .map(|p| Rung {
                basis: new(1, p),
                stage: lower,
            })
            .collect();
        rungs.extend(Basis::fewer_segments(self.segments).map(|n| Rung {
            basis: new(n, self.degree),
            stage: fewer_segments,
        }));
        // A low degree on one segment is the first rung already.
        rungs.dedup_by(|b, a| a.basis == b.basis);
        if passive {
            rungs.retain(|rung| 2 * rung.basis.segments() >= self.segments);
        }
        // Without rows the last digits are for those alone that are among the best without them.
        let rough = Rung {
            basis: self.basis(),
            stage: lower,
        };
        if constrained {
            rungs.retain(|rung| rung.basis != rough.basis);
        } else if rungs.last().is_none_or(|last| last.basis != rough.basis) {
            rungs.push(rough);
        }
        rungs.push(Rung {
            basis: self.basis(),
            stage: self.highest(constrained),
        });
        rungs
    }

    /// The basis of the motion.
    pub(super) fn basis(&self) -> Basis {
        Basis::new(self.segments, self.degree, self.free_final_velocity)
    }

    /// The degrees after that of a basis that an adaptive one may have.
    pub(super) fn higher_degrees(basis: &Basis) -> impl Iterator<Item = usize> + use<> {
        let (degree, segments) = (basis.degree(), basis.segments());
        let largest = Self::LARGEST_DEGREE.min(Self::LARGEST_SIZE / segments);
        let above = Basis::degrees().skip_while(move |higher| *higher <= degree);
        above.take_while(move |degree| *degree <= largest)
    }

    /// Whether so many segments of this degree can be had.
    ///
    /// # Errors
    /// One of the two is out of range.
    pub fn check_size(degree: usize, segments: usize) -> Result<()> {
        let refuse = |what: &str, condition: String| Err(Error::input("settings", what, condition));
        let (smallest, largest) = (Basis::SMALLEST_DEGREE, Self::LARGEST_DEGREE);
        if !(smallest..=largest).contains(&degree) {
            let range = format!("at least {smallest} and at most {largest} is needed");
            return refuse("degree", format!("it is {degree}, {range}"));
        }
        let most = Self::LARGEST_SIZE / degree;
        if !(1..=most).contains(&segments) {
            let range = format!("at least 1 and for degree {degree} at most {most} is needed");
            return refuse("segments", format!("it is {segments}, {range}"));
        }
        Ok(())
    }

    /// # Errors
    /// A setting is out of range.
    pub(super) fn check(&self, problem: &Problem<'_>) -> Result<()> {
        Self::check_size(self.degree, self.segments)?;
        for (what, value) in [
            ("tolerance", self.tolerance),
            ("quadrature_tolerance", self.quadrature_tolerance),
            ("degree_tolerance", self.degree_tolerance.unwrap_or(1.0)),
        ] {
            check_positive("settings", what, value)?;
        }
        if !self.start_amplitude.is_finite() {
            let condition = format!("it is {}, a finite number is needed", self.start_amplitude);
            return Err(Error::input("settings", "start_amplitude", condition));
        }
        check_count("num_starts", self.num_starts, 1..=Self::LARGEST_NUM_STARTS)?;
        check_count("iterations", self.iterations, 1..=Self::MOST_ITERATIONS)?;
        check_count("threads", self.threads, 1..=Self::MOST_THREADS)?;
        if let Some(free) = &self.free_horizon {
            free.check(problem.horizon())?;
        }
        if let Some(longest) = self.longest_horizon {
            let least = problem.horizon();
            if !(longest.is_finite() && longest >= least) {
                let condition = format!("it is {longest}, at least the horizon {least} is needed");
                return Err(Error::input("settings", "longest_horizon", condition));
            }
        }
        match &self.start {
            Some(curve) => problem.model().check("start", curve.dof()),
            None => Ok(()),
        }
    }
}

/// One step up the ladder of bases.
#[derive(Clone, Debug)]
pub(super) struct Rung {
    pub basis: Basis,
    pub stage: Stage,
}

/// One iteration of the minimiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// The number of the start, from 0; `None` when the best of them is carried on to another degree or horizon.
    pub start: Option<usize>,
    /// The horizon, s.
    pub horizon: f64,
    /// The number of segments.
    pub segments: usize,
    /// The degree of the segments.
    pub degree: usize,
    /// The number of points of quadrature on each segment.
    pub points: usize,
    /// The cost $J$ before the step.
    pub cost: f64,
    /// $\sqrt{g^T G^{-1} g / J}$ with the gradient $g$ and the metric $G$ of Gauss and Newton. The cost of a problem that is
    /// linear in the curve would be above its minimum by half the square of this, relatively.
    pub gradient_norm: f64,
    /// The multiple $\lambda$ of the norm of the trust region that was added to the Hessian.
    pub damping: f64,
    /// The length of the step in that norm, roughly radians; zero where there was none.
    pub step: f64,
    /// The number of factorisations of matrices.
    pub factorisations: usize,
    /// The largest violation of a constraint at the points of the quadrature, in its own unit; zero where all are kept.
    pub violation: f64,
}

/// The result of a relaxation.
#[derive(Clone, Debug)]
pub struct RelaxSolution {
    /// The motion, with $v = \dot q$, on the horizon that was found if that was free.
    pub curve: Curve,
    /// The integral of the running cost, $\int |u|^2 dt$ unless it is another, by a quadrature finer than the one that was minimised. What
    /// a free horizon costs is not in it.
    pub cost: f64,
    /// The relative gradient norm at the end; see [`Iteration::gradient_norm`].
    pub gradient_norm: f64,
    /// The smallest eigenvalue of the Hessian relative to the metric of Gauss and Newton: positive at a minimum, one for a
    /// linear problem.
    pub smallest_curvature: f64,
    /// The violation of the worst constraint at the worst time, in rad, rad/s, m, N m or N; zero without constraints.
    pub largest_violation: f64,
    /// The largest torque of a passive joint, relative to the largest torque: what is left of it between the points at which it vanishes. A
    /// motion that keeps more than 5e-4 gets more segments, as far as there are any.
    pub passive_share: f64,
    /// The number of points of the quadrature of a segment.
    pub points: usize,
    /// The relative difference of the cost by this quadrature and that by the finer one.
    pub quadrature_error: f64,
    /// True if the gradient norm came below the tolerance, the quadrature agrees, and a horizon was found if it was free.
    pub converged: bool,
    /// True if the search did not come to a minimum, but the motion keeps the constraints. If a start keeps them, such as a
    /// [planned first one](PlannedStarts::First), the motion does: where the search ends outside it is one on the way.
    pub kept: bool,
    /// The reason why it was stopped, if it did not come to its end; the motion is then the best so far.
    pub stopped: Option<Stopped>,
    /// The degrees on the way, where the degree is adaptive.
    pub adapted: Option<DegreeRefinement>,
    /// The number of unknowns.
    pub unknowns: usize,
    /// The costs where each start begins, at the lowest degree but for some planned ones, from all starts, ascending.
    pub start_costs: Vec<f64>,
    /// The weight of the barriers at the end relative to the cost: so much, relative, the cost is above that with exact complementarity.
    pub complementarity: f64,
    /// The minima that the starts led to, by cost; empty without starts.
    pub minima: Vec<LocalMinimum>,
    /// The curves of the first [few](Self::MINIMA_CURVES) of them as the starts left them, before any further degree or horizon.
    pub minima_curves: Vec<Curve>,
    /// The number of the start that led to the motion; `None` without starts.
    pub best_start: Option<usize>,
    /// Where it began.
    pub first_guess: Curve,
    /// All iterations, of all starts and degrees.
    pub iterations: Vec<Iteration>,
}

impl RelaxSolution {
    /// The number of minima whose curves are kept.
    pub const MINIMA_CURVES: usize = 4;
}
