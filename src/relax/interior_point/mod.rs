//! A minimum in a basis within constraints: Newton's method on the running cost with barriers, and duals of equalities.
//!
//! The rows at the quadrature points are not constraints of the minimiser: each has a [`Barrier`] that is finite
//! everywhere, so that any curve may be tried and no start has to be feasible. The objective is therefore smooth and
//! unconstrained,
//!
//! $$ \phi(c) = \int l_0 + \sum_j \psi_{\mu, \nu}(h_j + m_j)\\, dt , $$
//!
//! and is minimised in a trust region. The Hessian is that of primal-dual interior points with independent multipliers,
//! so that few steps are needed after each reduction of $\mu$.
//!
//! The barrier of a clearance fades out at a distance, with two continuous derivatives, and rows that are far from
//! their bound on the whole curve are left out until they come near: of hundreds, a few dozen are active.
//!
//! 1. Each step uses the current weight $\mu$. When the next step promises little, $\mu$ is reduced.
//! 2. After each reduction of $\mu$ the rows are also evaluated between the points. A violation found there becomes a
//!    margin at the two neighbouring points.
//! 3. Every few steps a finer quadrature evaluates the cost; if the two disagree, the number of points is increased.
//! 4. At the last $\mu$ the gradient has to vanish. If a row is still violated, its price $\nu$ was too low and is
//!    increased.
//! 5. Equalities have the terms of an augmented Lagrangian ([`Equalities`]) at the collocated points. Their duals are
//!    updated with each reduction of $\mu$, and at the last one until the equalities are satisfied.
//! 6. If the search ends outside the constraints, the result is the last iterate that satisfied them, if there was one.
//! 7. If the final Hessian has a direction of negative curvature, the search continues along it.

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

/// The termination criteria of one minimisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stage {
    /// The relative gradient norm.
    pub tolerance: f64,
    /// The largest number of steps.
    pub iterations: usize,
    /// The number of steps after which the Gauss-Newton metric is recomputed, which costs as much as the Hessian.
    pub fresh: usize,
    /// The largest relative difference between the quadrature and a finer one.
    pub quadrature_tolerance: f64,
    /// The last weight of the barriers, relative to the cost.
    pub last_barrier: f64,
    /// The accepted excess of a row, in its unit.
    pub feasible: f64,
    /// True if the derivative of the cost with respect to the horizon is needed.
    pub slope: bool,
    /// True if the end is checked to be a minimum within the constraints.
    pub last: bool,
}

/// A problem with the data that its minimisations share.
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

/// Minimises the running cost within the rows, from a candidate and in its basis.
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

/// Evaluates the residual torques of passive joints.
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
