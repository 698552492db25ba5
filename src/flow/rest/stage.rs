//! The flow to rest in one basis with one quadrature.

use super::euler::{Euler, Progress, Stretch};
use super::{RestRecord, RestSettings};
use crate::constraint::{Constraint, Constraints};
use crate::curve::Curve;
use crate::error::Result;
use crate::flow::weak::{
    Action, AnalyticLagrangian, AugmentedLagrangian, RowDuals, RowTerms, StateGrid,
};
use crate::motion::{Problem, Watch, passive_share, violations};
use nalgebra::DMatrix;

/// The number of steps between two checks of the quadrature.
const LOOK: usize = 6;
/// The accepted relative difference of quadratures before the end.
const ON_THE_WAY: f64 = 0.05;
/// The first penalty of a row, relative to the action per second, its growth factor, and the largest one.
const FIRST_PENALTY: f64 = 1e3;
const PENALTY_FACTOR: f64 = 10.0;
const LARGEST_PENALTY: f64 = 1e9;
/// The first penalty of the torque of a passive joint, that of a motor, whose torque costs its square; and the largest,
/// beyond which steps become short and the duals suffice.
const MOTOR: f64 = 2.0;
const LARGEST_MOTOR: f64 = 2e4;
/// The fraction of its violation that a row may keep from one round to the next before its penalty grows.
const PROGRESS: f64 = 0.25;
/// The factor of the tolerance from one round of duals to the next.
const TIGHTER: f64 = 0.1;
/// The slip at which its duals are no longer updated, rad/s or m/s.
const SLIP: f64 = 1e-6;
/// The number of times between the points at which rows are evaluated.
const TIMES: usize = 2000;

/// The termination criteria of one stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demands {
    /// The number of segments and their degree.
    pub basis: (usize, usize),
    /// The relative gradient norm, the largest number of steps between two updates of the duals, and of these updates.
    pub tolerance: f64,
    pub steps: usize,
    pub rounds: usize,
    /// The number of steps after which the metric is recomputed.
    pub fresh: usize,
    /// The accepted violation of a row, in its unit.
    pub feasible: f64,
    /// The largest relative difference between the quadrature and a finer one.
    pub quadrature: f64,
    /// The factor of the running cost; below one the constraints take precedence.
    pub cost: f64,
    /// True if rows must also be satisfied between the points.
    pub dense: bool,
}

/// The result of a stage.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    pub action: f64,
    pub gradient_norm: f64,
    pub slip: f64,
    pub violation: f64,
    pub quadrature_error: f64,
    /// The largest torque of a passive joint, relative to the largest torque; zero without passive joints.
    pub passive_share: f64,
    pub at_rest: bool,
}

/// The state of the flow that is passed from stage to stage.
pub(super) struct Walk<'w> {
    pub curve: Curve,
    pub s: f64,
    pub steps: usize,
    pub factorisations: usize,
    pub rounds: usize,
    /// The duals of the rows at the end of the previous stage.
    pub duals: Option<Vec<RowDuals>>,
    pub watch: &'w Watch,
    pub observe: &'w mut dyn FnMut(RestRecord),
}

/// One stage: a basis and a quadrature.
pub(super) struct Stage<'s, 'g, 'a, K> {
    problem: &'s Problem<'a>,
    settings: &'s RestSettings,
    constraints: &'s Constraints<K>,
    demands: Demands,
    grid: &'g StateGrid<f64>,
    /// The grid of the stage, and a finer one.
    own: StateGrid<f64>,
    finer: StateGrid<f64>,
    action: Action<'g, f64, AugmentedLagrangian<'s, K>>,
    plain: AnalyticLagrangian<'s>,
}

impl<'s, 'g, 'a, K: Constraint> Stage<'s, 'g, 'a, K> {
    /// A stage on `grid`, for the Lagrangian `plain` without constraints.
    pub fn new(
        problem: &'s Problem<'a>,
        settings: &'s RestSettings,
        constraints: &'s Constraints<K>,
        mut plain: AnalyticLagrangian<'s>,
        demands: Demands,
        grid: &'g StateGrid<f64>,
    ) -> Result<Self> {
        for weights in &mut plain.weights {
            *weights *= demands.cost;
        }
        let mut held = plain.clone();
        held.silent = (0..grid.times().len())
            .map(|g| grid.is_collocated(g))
            .collect();
        let augmented = AugmentedLagrangian::new(held, constraints, grid)?;
        let (segments, degree) = demands.basis;
        let points = grid.quadrature_points();
        Ok(Self {
            problem,
            settings,
            constraints,
            demands,
            grid,
            // Not a multiple, so that it sees between the points.
            own: StateGrid::new(segments, degree, points, problem.horizon()),
            finer: StateGrid::new(segments, degree, points * 3 / 2 + 7, problem.horizon()),
            action: Action::new(grid, augmented, problem.model().dof()),
            plain,
        })
    }

    /// Continues the flow from the current state of `walk`.
    pub fn run(mut self, walk: &mut Walk<'_>) -> Result<Outcome> {
        let demands = self.demands;
        let mut progress = Progress::new(self.grid.fit(&walk.curve), walk.s);
        let mut euler = Euler::new(&self.action);
        let (grid, rows) = (self.grid, self.constraints.dim());
        let density = self.action.value(&progress.coefficients)?.abs() / self.problem.horizon();
        match &walk.duals {
            Some(known) => self.terms().take_over(known, grid.times()),
            None => self.first_penalties(density),
        }
        let mut before = vec![f64::INFINITY; rows];
        let mut outcome = Outcome::default();
        let mut asked = if rows > 0 { TIGHTER } else { demands.tolerance };
        for _ in 0..demands.rounds {
            walk.rounds += 1;
            asked = asked.max(demands.tolerance);
            let coarse = self.stretch(&mut euler, &mut progress, asked, walk)?;
            outcome.action = progress.action;
            outcome.gradient_norm = progress.gradient_norm;
            let settled = progress.gradient_norm <= demands.tolerance;
            let reached = progress.gradient_norm <= asked;
            outcome.slip = self.look_at_slip(&progress.coefficients, self.settings.duals);
            let largest = self.terms().largest();
            outcome.violation = largest.iter().copied().fold(0.0, f64::max);
            if coarse || walk.watch.stopped().is_some() {
                break;
            }
            let kept = outcome.violation <= demands.feasible
                && (outcome.slip <= SLIP || !self.settings.duals);
            if settled && kept {
                if demands.dense {
                    outcome.violation = outcome.violation.max(self.look_between(&progress)?);
                }
                outcome.at_rest = outcome.violation <= demands.feasible;
                if outcome.at_rest {
                    break;
                }
            }
            if reached {
                if self.settings.duals {
                    self.terms().update_duals();
                }
                self.raise_penalties(&largest, &before, density);
            }
            before = largest;
            asked *= TIGHTER;
            euler.refresh();
        }
        outcome.quadrature_error =
            quadrature_error(&self.own, &self.finer, &self.plain, &progress.coefficients)?;
        walk.curve = self.curve(&progress)?;
        if demands.dense {
            let times = TIMES.div_ceil(grid.segments());
            let (model, limits) = (self.problem.model(), &self.constraints.torque);
            outcome.passive_share = passive_share(model, &walk.curve, limits, times)?;
        }
        walk.duals = Some(self.terms().over_time(grid.times()));
        walk.s = progress.s;
        walk.steps += progress.steps;
        walk.factorisations += progress.factorisations;
        Ok(outcome)
    }

    /// The current curve.
    fn curve(&self, progress: &Progress) -> Result<Curve> {
        self.grid
            .curve(&progress.coefficients, self.problem.horizon())
    }

    /// The terms of the rows.
    fn terms(&mut self) -> &mut RowTerms<'s, K> {
        &mut self.action.lagrangian.rows
    }

    /// Sets the first penalties of new rows. A passive joint starts as a motor, because no other start is as easy.
    fn first_penalties(&mut self, density: f64) {
        let constraints = self.constraints;
        for (row, penalty) in self.terms().penalties.iter_mut().enumerate() {
            let passive = constraints.is_passive(row);
            *penalty = if passive {
                MOTOR
            } else {
                FIRST_PENALTY * density
            };
        }
    }

    /// Increases the penalties of rows whose violation has not decreased enough since the previous round.
    fn raise_penalties(&mut self, largest: &[f64], before: &[f64], density: f64) {
        let (constraints, feasible) = (self.constraints, self.demands.feasible);
        for (row, penalty) in self.terms().penalties.iter_mut().enumerate() {
            let passive = constraints.is_passive(row);
            let most = if passive {
                LARGEST_MOTOR
            } else {
                LARGEST_PENALTY * density
            };
            if largest[row] > feasible && largest[row] > PROGRESS * before[row] {
                *penalty = (*penalty * PENALTY_FACTOR).min(most);
            }
        }
    }

    /// Follows the flow with constant duals; returns true if the quadrature turned out to be far too coarse.
    fn stretch(
        &mut self,
        euler: &mut Euler,
        progress: &mut Progress,
        tolerance: f64,
        walk: &mut Walk<'_>,
    ) -> Result<bool> {
        let Demands {
            basis,
            steps,
            fresh,
            ..
        } = self.demands;
        let stretch = Stretch {
            tolerance,
            steps,
            fresh,
            metric: self.settings.metric,
        };
        let (grid, finer, plain) = (&self.own, &self.finer, &self.plain);
        let (mut coarse, mut looks) = (false, 0);
        let (watch, observe) = (walk.watch, &mut walk.observe);
        let mut look = |progress: &Progress| {
            observe(progress.record(basis));
            looks += 1;
            if looks % LOOK == 0 {
                let error = quadrature_error(grid, finer, plain, &progress.coefficients)?;
                coarse = error > ON_THE_WAY;
            }
            Ok(!coarse)
        };
        euler.run(&mut self.action, progress, stretch, watch, &mut look)?;
        Ok(coarse)
    }

    /// The largest violation of a row between the points, in its unit; the margins of violated rows are increased.
    /// Equalities in the control are excluded, because no polynomial satisfies them everywhere.
    fn look_between(&mut self, progress: &Progress) -> Result<f64> {
        if self.constraints.dim() == 0 {
            return Ok(0.0);
        }
        let curve = self.curve(progress)?;
        let times = TIMES.div_ceil(self.grid.segments());
        let mut largest = 0.0_f64;
        for violation in violations(self.problem.model(), &curve, self.constraints, times)? {
            let row = violation.row;
            if self.constraints.is_equality(row) {
                continue;
            }
            if violation.by > self.demands.feasible {
                let terms = self.terms();
                terms.margins[row] += violation.by / terms.units[row];
            }
            largest = largest.max(violation.by);
        }
        Ok(largest)
    }

    /// The largest slip at the points; with `duals`, the duals are updated to $\lambda + 2 k e$.
    fn look_at_slip(&mut self, coefficients: &DMatrix<f64>, duals: bool) -> f64 {
        let grid = self.grid;
        let lagrangian = &mut self.action.lagrangian.lagrangian;
        if duals && lagrangian.slip_duals.ncols() == 0 {
            let n = lagrangian.weights[0].len();
            lagrangian.slip_duals = DMatrix::zeros(n, grid.times().len());
        }
        let mut largest = 0.0_f64;
        for e in 0..grid.segments() {
            for (g, slip) in grid.slips(coefficients, e).column_iter().enumerate() {
                largest = largest.max(slip.amax());
                if duals {
                    let column = e * grid.points() + g;
                    let mut dual = lagrangian.slip_duals.column_mut(column);
                    dual.axpy(2.0 * lagrangian.k, &slip, 1.0);
                }
            }
        }
        largest
    }
}

/// The relative difference of the action on a grid and on a finer one.
fn quadrature_error(
    grid: &StateGrid<f64>,
    finer: &StateGrid<f64>,
    lagrangian: &AnalyticLagrangian<'_>,
    coefficients: &DMatrix<f64>,
) -> Result<f64> {
    let n = lagrangian.model().dof();
    let value = |grid| Action::new(grid, lagrangian.clone(), n).value(coefficients);
    let (coarse, fine) = (value(grid)?, value(finer)?);
    Ok((fine - coarse).abs() / fine.abs().max(f64::EPSILON))
}
