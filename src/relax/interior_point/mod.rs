//! A minimum in a basis within constraints: Newton's method on the running cost with barriers, and duals of equalities.
//!
//! The rows at the points of the quadrature are not constraints of the minimiser: each has a [`Barrier`] that is finite everywhere, so
//! that every curve may be tried, and no start has to be feasible. What is minimised is therefore smooth and has no constraints,
//!
//! $$ \phi(c) = \int l_0 + \sum_j \psi_{\mu, \nu}(h_j + m_j)\\, dt , $$
//!
//! and a trust region does it. The Hessian is that of primal-dual interior points, whose multipliers are iterates of their own, so
//! that few steps are needed when $\mu$ becomes smaller.
//!
//! The barrier of a clearance fades out at a distance, with two continuous derivatives, and rows that are far from everywhere on the curve are
//! left out until they come near: of hundreds a few dozen matter.
//!
//! 1. A step is made with the weight $\mu$ as it is. When the next promises little, $\mu$ becomes smaller.
//! 2. With each new $\mu$ the rows are looked at between the points as well. What a row exceeds there is a margin at the points beside.
//! 3. Every few steps a finer quadrature looks at the cost; where the two do not agree there are more points.
//! 4. At the last $\mu$ the gradient has to vanish. If a row is still broken its price $\nu$ was too low, and grows.
//! 5. Equalities have the terms of an augmented Lagrangian ([`Equalities`]) at the collocated points. Their duals follow with each new $\mu$, and
//!    at the last one until the equalities hold.
//! 6. Where the search ends outside the constraints the motion is the last one on the way that kept them, if there was any.
//! 7. Where the Hessian of the end has a direction of negative curvature the search goes on along it.

mod barrier;
mod barrier_cost;
mod candidate;
mod equality;
mod iterate;
mod listing;
mod margins;
mod near;
mod newton;
mod row;
mod schedule;
mod search;
mod terms;
mod trial;

pub use barrier::Barrier;
pub use barrier_cost::BarrierCost;
pub(super) use candidate::{Candidate, Multipliers};
pub use equality::Equalities;

use super::running_cost::check_integral;
use super::transcription::{Grids, Rows};
use super::tuning::{FINE, PASSIVE_SHARE, POINTS, ROUGH, ROUGH_POINTS};
use super::{CostWithControl, Iteration};
use crate::constraint::Constraint;
use crate::error::Result;
use crate::motion::{Problem, Watch, curve_of, passive_share};
use search::{End, search};

/// The demands on one minimisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stage {
    /// The relative gradient norm.
    pub tolerance: f64,
    /// Steps.
    pub iterations: usize,
    /// After so many steps the metric of Gauss and Newton is computed anew, which takes as long as the Hessian.
    pub fresh: usize,
    /// The largest relative difference of the quadrature and a finer one.
    pub quadrature_tolerance: f64,
    /// The last weight of the barriers, relative to the cost.
    pub last_barrier: f64,
    /// The excess of a row that does no harm, in its unit.
    pub feasible: f64,
    /// True if the derivative of the cost in the horizon is asked for.
    pub slope: bool,
    /// True if to see to it that it is a minimum within the constraints.
    pub last: bool,
}

/// A problem with everything that its minimisations have in common.
pub(super) struct Context<'c, 'a, K, P> {
    pub problem: &'c Problem<'a>,
    pub grids: &'c Grids,
    pub rows: &'c Rows<'a, K, P>,
    pub watch: &'c Watch,
}

impl<K, P> Clone for Context<'_, '_, K, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<K, P> Copy for Context<'_, '_, K, P> {}

/// Minimises the running cost within the rows from a candidate, in its basis.
pub(super) fn minimise<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    mut candidate: Candidate,
    stage: Stage,
    observe: &mut dyn FnMut(Iteration),
) -> Result<Candidate> {
    let (segments, degree) = (
        candidate.path.basis.segments(),
        candidate.path.basis.degree(),
    );
    let kind = usize::from(context.rows.count() > 0);
    let rough = kind == 1 && segments > 1 && stage.tolerance >= ROUGH;
    let per_degree = if rough { ROUGH_POINTS } else { POINTS[kind] };
    candidate.points = (per_degree * degree as f64) as usize + 4;
    // Where it kept the constraints, as far as that was looked at, the last one last.
    let mut kept = Vec::new();
    loop {
        let end = search(context, &mut candidate, &mut kept, stage, observe)?;
        check_integral(candidate.cost)?;
        match end {
            End::Done => {
                if stage.last {
                    look_at_passive_joints(context, &mut candidate)?;
                }
                return Ok(candidate);
            }
            _ if context.watch.stopped().is_some() => {
                candidate.converged = false;
                return Ok(candidate);
            }
            End::Coarse => {
                // Multipliers at other points and a weak barrier hold the curve where it is.
                candidate.points = candidate.points * 3 / 2;
                candidate.barrier = None;
                candidate.penalties = None;
                candidate.multipliers = Multipliers::default();
            }
            End::Saddle => (),
        }
    }
}

/// What is left of the torques of passive joints, of which a motion has to have hardly any.
fn look_at_passive_joints<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    candidate: &mut Candidate,
) -> Result<()> {
    let limits = &context.rows.constraints.torque;
    if limits.has_passive() {
        let curve = curve_of(context.problem, &candidate.path)?;
        let times = FINE.div_ceil(curve.segments());
        let model = context.problem.model();
        candidate.passive_share = passive_share(model, &curve, limits, times)?;
        candidate.converged &= candidate.passive_share <= PASSIVE_SHARE;
    }
    Ok(())
}
