//! The path from one guess to rest, stage by stage.

use super::stage::{Demands, Outcome, Stage, Walk};
use super::{RestRecord, RestSettings, RestSolution};
use crate::constraint::{Constraint, Constraints};
use crate::curve::{Basis, Continuity, Curve};
use crate::error::Result;
use crate::flow::weak::{AnalyticLagrangian, StateGrid};
use crate::motion::{Problem, Watch};
use std::collections::VecDeque;

/// The initial number of quadrature points per degree, without and with rows, and the largest.
const POINTS: [f64; 2] = [3.0, 3.5];
const MOST_POINTS: usize = 16;
/// The accepted torque of a passive joint, relative to the largest torque; above it the number of segments is
/// increased.
const PASSIVE_SHARE: f64 = 5e-4;

/// The data that the walks from all guesses share.
pub(super) struct WalkOf<'w, 'a, K> {
    pub problem: &'w Problem<'a>,
    pub settings: &'w RestSettings,
    pub lagrangian: &'w AnalyticLagrangian<'w>,
    pub constraints: &'w Constraints<K>,
    /// True if there are passive joints.
    pub passive: bool,
    /// The action above which the number of segments is not increased.
    pub least: f64,
    pub watch: &'w Watch,
}

impl<K: Constraint> WalkOf<'_, '_, K> {
    /// Follows the flow from the guess of this number to rest.
    pub fn from(
        &self,
        guess: usize,
        curve: Curve,
        observe: &mut dyn FnMut(&RestRecord),
    ) -> Result<RestSolution> {
        let Self {
            problem,
            settings,
            lagrangian,
            constraints,
            passive,
            least,
            watch,
        } = *self;
        let kind = usize::from(constraints.dim() > 0);
        let mut history = Vec::new();
        let mut record = |record: RestRecord| {
            observe(&record);
            history.push(record);
        };
        let mut walk = Walk {
            curve,
            s: 0.0,
            steps: 0,
            factorisations: 0,
            rounds: 0,
            duals: None,
            watch,
            observe: &mut record,
        };
        let mut outcome = Outcome::default();
        let horizon = problem.horizon();
        let mut stages: VecDeque<_> = settings.stages(kind == 1, passive).into();
        while let Some(demands) = stages.pop_front() {
            let (segments, degree) = demands.basis;
            let mut points = (POINTS[kind] * degree as f64) as usize + 4;
            let collocated = if passive { degree - 1 } else { 0 };
            loop {
                let grid = StateGrid::collocated(segments, degree, points, collocated, horizon);
                let plain = lagrangian.clone();
                let stage = Stage::new(problem, settings, constraints, plain, demands, &grid)?;
                outcome = stage.run(&mut walk)?;
                let coarse = outcome.quadrature_error > demands.quadrature;
                if !coarse || points >= MOST_POINTS * degree || watch.stopped().is_some() {
                    break;
                }
                points = points * 3 / 2;
            }
            if watch.stopped().is_some() {
                outcome.at_rest = false;
                break;
            }
            let left = outcome.passive_share > PASSIVE_SHARE && outcome.action < least;
            let finer = Basis::new(segments, degree, Continuity::default())
                .finer(RestSettings::LARGEST_SIZE);
            if let (true, true, Some(finer)) = (stages.is_empty(), left, finer) {
                let basis = (finer.segments(), finer.degree());
                stages.push_back(Demands { basis, ..demands });
            }
        }
        outcome.at_rest &= outcome.passive_share <= PASSIVE_SHARE;
        let Walk {
            curve,
            steps,
            factorisations,
            rounds,
            ..
        } = walk;
        Ok(RestSolution {
            curve,
            action: outcome.action,
            gradient_norm: outcome.gradient_norm,
            slip: outcome.slip,
            violation: outcome.violation,
            quadrature_error: outcome.quadrature_error,
            passive_share: outcome.passive_share,
            at_rest: outcome.at_rest,
            guess,
            starts: 1,
            steps,
            factorisations,
            rounds,
            history,
            stopped: watch.stopped(),
        })
    }
}
