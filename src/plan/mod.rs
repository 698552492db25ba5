//! Paths around obstacles: a sampling planner in configuration space, for starts of the direct method.
//!
//! The result is a path, not a motion: configurations that are joined by straight lines, each free at rest. A
//! configuration is free if every row of the constraints on the state is within its bound at `(q, v = 0)`, which covers
//! joint limits, obstacles, self-collision and user-defined constraints. Sets of poses with equalities, such as a
//! relative pose of two hands, are kept by projection: every configuration of the path is in them, and the lines
//! between two of them, which are not, are short (Berenson, Srinivasa, Ferguson and Kuffner, *Manipulation planning on
//! constraint manifolds*, ICRA 2009).
//!
//! 1. `tree.rs`: RRT-Connect (Kuffner and LaValle, ICRA 2000): a tree from the start and one from the goal, each grown
//!    towards random configurations and then towards the other.
//! 2. `shorten.rs`: unnecessary waypoints are removed, random shortcuts are taken, then corners are rounded. Shortcuts
//!    rarely lead to the other side of an obstacle, so a long path is planned again with other random numbers, among
//!    configurations that are on shorter paths (`sampler.rs`; Gammell, Srinivasa and Barfoot, *Informed RRT\**, IROS
//!    2014), and the shortest one is kept.
//! 3. `fit.rs`: the path as a curve of cubics, as smooth as the obstacles permit.
//!
//! [`InverseKinematics`] finds configurations that keep rows, such as the pose of a frame.
//!
//! All random numbers come from the seed, and the budget is a number of configurations: the same problem has the same
//! path on any machine.

mod checker;
mod distances;
mod fit;
mod inverse_kinematics;
mod sampler;
mod shorten;
mod tree;

pub use checker::Checker;
pub(crate) use fit::along;
pub use fit::curve_along;
pub use inverse_kinematics::{InverseKinematics, Posture, nearest_turn};
#[doc(hidden)]
pub use sampler::Sampler;

use crate::constraint::{AnyConstraint, Constraint};
use crate::error::{Error, Result, check_count, check_positive};
use crate::model::{JointKind, Model};
use crate::motion::Problem;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use shorten::Along;
use std::f64::consts::PI;

/// The length of a path relative to the straight line between its ends up to which no other one is planned: most paths
/// that are longer lead around an obstacle on some side, which may be the wrong one.
const SHORT: f64 = 1.25;

/// The accepted violation of a row at the ends of the problem, in its unit.
const END_TOLERANCE: f64 = 1e-6;

/// The settings of a planner.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanSettings {
    /// The seed of all random numbers.
    pub seed: u64,
    /// The number of the path: each number gives a different one.
    pub number: u64,
    /// The largest number of paths, of which the shortest is the result. Planning stops at a path at most a quarter
    /// longer than the straight line from start to goal.
    pub paths: usize,
    /// The distance that rows keep from their bounds if start and goal have it too, in the unit of the row, m for a
    /// clearance.
    pub margin: f64,
    /// The motion of a joint, rad or m, below which an edge is not divided further, where distances are too small for a
    /// proof that it is free.
    pub resolution: f64,
    /// The length of the longest edge of a tree, rad.
    pub range: f64,
    /// The number of configurations checked after which no further one is sampled, and the largest number per line.
    pub most_checks: usize,
    /// The number of configurations checked after which no path beyond the first one is planned or continued.
    pub further_checks: usize,
    /// The number of shortcuts tried.
    pub shortcuts: usize,
    /// The number of passes in which corners are rounded.
    pub roundings: usize,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self {
            seed: 0,
            number: 0,
            paths: 8,
            margin: 0.005,
            resolution: 0.002,
            range: 0.5,
            most_checks: 1_000_000,
            // Some 20 ms of an arm of seven joints.
            further_checks: 40_000,
            shortcuts: 60,
            roundings: 6,
        }
    }
}

impl PlanSettings {
    /// # Errors
    /// A setting is out of range.
    fn check(&self) -> Result<()> {
        for (what, value) in [("resolution", self.resolution), ("range", self.range)] {
            check_positive("planner", what, value)?;
        }
        if !(self.margin >= 0.0 && self.margin.is_finite()) {
            let condition = format!("it is {} and must be zero or a positive number", self.margin);
            return Err(Error::input("planner", "margin", condition));
        }
        check_count("paths", self.paths, 1..=usize::MAX)?;
        check_count("most_checks", self.most_checks, 1..=usize::MAX)
    }

    /// The random number generator of one of the paths; the first one has the number itself.
    fn generator(&self, path: usize) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.number ^ (path as u64).rotate_right(16));
        rng.set_stream(self.seed);
        rng
    }
}

/// The result of a planner.
#[derive(Clone, Debug, PartialEq)]
pub enum Plan {
    /// Waypoints from start to goal, `N` entries each; straight lines between them are free.
    Found(Vec<Vec<f64>>),
    /// The start or the goal is not free.
    EndBlocked {
        /// True if it is the goal.
        goal: bool,
        /// The row of the constraint with the largest violation.
        row: usize,
        /// The violation, in the unit of the row.
        by: f64,
    },
    /// The trees did not meet within the allowed number of configurations.
    OutOfBudget {
        /// The number of checked configurations.
        checks: usize,
    },
    /// The planner was interrupted before it found a path.
    Stopped,
}

/// Plans a path from the start to the goal of `problem` on which every row of `constraint` is within its bound at rest.
///
/// Joints are sampled within their limits, extended to include start and goal; revolute ones at most half a turn beyond
/// both, as the robot takes the same pose after a whole one, and sliders without limits 1 m. Edges are divided until no
/// link can travel its distance from an obstacle or another link within a part, which proves them free, or down to the
/// [resolution](PlanSettings::resolution). Cost per configuration: the placements and the distances that may not be
/// kept in its part of the edge, four configurations side by side, and all rows if some are neither distances nor
/// bounds; per sample O(N) per node of a tree.
///
/// # Errors
/// A setting is out of range, a row is an equality but none of a set of poses, or the constraint refers to a joint or
/// body that the robot does not have.
pub fn plan<K: Constraint + ?Sized>(
    problem: &Problem<'_>,
    constraint: &K,
    settings: &PlanSettings,
    stopped: &dyn Fn() -> bool,
) -> Result<Plan> {
    settings.check()?;
    let sets = sets_with_equalities(constraint)?;
    let n = problem.model().dof();
    let ends = [problem.start(), problem.goal()].map(|state| &state[..n]);
    let mut checker = Checker::new(problem.model(), constraint, settings.resolution)?;
    for (goal, end) in [(false, ends[0]), (true, ends[1])] {
        let (row, by) = checker.worst(end)?;
        if by > END_TOLERANCE {
            return Ok(Plan::EndBlocked { goal, row, by });
        }
    }
    checker.keep(settings.margin, ends)?;
    checker.limit(settings.most_checks);
    let mut sampler = Sampler { ends, ranges: ranges(problem.model(), ends), shortest: None };
    checker.project_onto(&sets, sampler.ranges.clone())?;
    let mut shortest = one(0, &mut checker, &sampler, (settings, stopped))?;
    let further = PlanSettings { most_checks: settings.most_checks.min(settings.further_checks), ..settings.clone() };
    let length = |waypoints: &[Vec<f64>]| Along::new(waypoints).length();
    for path in 1..settings.paths {
        let Plan::Found(waypoints) = &shortest else {
            break;
        };
        let least = length(waypoints);
        if least <= SHORT * distance(ends[0], ends[1]) {
            break;
        }
        sampler.shortest = Some(least);
        match one(path, &mut checker, &sampler, (&further, stopped))? {
            Plan::Found(other) if length(&other) < least => shortest = Plan::Found(other),
            Plan::Stopped => break,
            _ => {}
        }
    }
    Ok(shortest)
}

/// Plans a path by trees and shortens it.
fn one<K: Constraint + ?Sized>(
    path: usize,
    checker: &mut Checker<'_, K>,
    sampler: &Sampler<'_>,
    (settings, stopped): (&PlanSettings, &dyn Fn() -> bool),
) -> Result<Plan> {
    let mut rng = settings.generator(path);
    let found = tree::connect(checker, sampler, settings, &mut rng, stopped)?;
    let Plan::Found(mut waypoints) = found else {
        return Ok(found);
    };
    shorten::shorten(checker, &mut waypoints, settings, &mut rng, stopped)?;
    Ok(Plan::Found(waypoints))
}

/// The sets of poses with equalities, onto which configurations can be projected.
///
/// # Errors
/// Another row is an equality, which no sampled configuration meets.
pub(crate) fn sets_with_equalities<K: Constraint + ?Sized>(constraint: &K) -> Result<Vec<AnyConstraint>> {
    let equalities = |of: &AnyConstraint| (0..of.dim()).filter(|row| of.row_set(*row).is_equality).count();
    let mut parts = Vec::new();
    constraint.parts(&mut parts);
    let parts = parts.into_iter();
    let sets = parts.filter(|part| matches!(part, AnyConstraint::Frame(_)) && equalities(part) > 0);
    let sets: Vec<_> = sets.cloned().collect();
    let known: usize = sets.iter().map(equalities).sum();
    let mut all = (0..constraint.dim()).filter(|row| constraint.row_set(*row).is_equality);
    if all.clone().count() > known {
        let row = all.next().unwrap_or_default();
        let condition = "it is an equality, which no sampled configuration meets";
        Err(Error::input("planner", format!("row {row}"), condition))
    } else {
        Ok(sets)
    }
}

/// The ranges in which joints are sampled.
fn ranges(model: &Model, ends: [&[f64]; 2]) -> Vec<[f64; 2]> {
    let joints = model.joints().iter().zip(ends[0].iter().zip(ends[1]));
    joints
        .map(|(joint, (start, goal))| {
            let limits = joint.limits();
            let (least, most) = (start.min(*goal), start.max(*goal));
            let [lower, upper] = match joint.kind() {
                JointKind::Revolute | JointKind::Continuous => {
                    [limits.lower.max(least - PI), limits.upper.min(most + PI)]
                }
                JointKind::Prismatic => {
                    let or = |limit: f64, other| if limit.is_finite() { limit } else { other };
                    [or(limits.lower, least - 1.0), or(limits.upper, most + 1.0)]
                }
            };
            [lower.min(least), upper.max(most)]
        })
        .collect()
}

/// The configurations at equal lengths along a path, so many that there are `lines` lines between them; the path itself
/// if it has no more.
pub(crate) fn thinned(path: Vec<Vec<f64>>, lines: usize) -> Vec<Vec<f64>> {
    if path.len() <= lines + 1 {
        return path;
    }
    let along = Along::new(&path);
    let at = |k: usize| along.at(&path, along.length() * k as f64 / lines as f64).1;
    let mut thin: Vec<_> = (0..lines).map(at).collect();
    thin.extend(path.last().cloned());
    thin
}

/// The Euclidean distance of two configurations.
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

/// The point at the fraction `share` of the line from `a` to `b`.
fn between(a: &[f64], b: &[f64], share: f64) -> Vec<f64> {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| a + share * (b - a)).collect()
}
