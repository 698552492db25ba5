//! The memory of the searches of a tracker, and of the checks of their results.

use super::TrackerOptions;
use super::plan::Plan;
use crate::constraint::{Constraint, Constraints};
use crate::cost::CostWithControl;
use crate::curve::{Basis, Functions};
use crate::direct::FreeHorizon;
use crate::direct::minimise::{Candidate, Context, RealTime};
use crate::error::Result;
use crate::linalg::multiply;
use crate::motion::{Interrupt, LargestRows, Motion, Problem, Watch};
use crate::transcription::{Grids, Rows};
use nalgebra::DMatrix;
use std::sync::Arc;

/// The memory of the searches of a tracker and of the checks of their results, for given constraints.
pub(super) struct Workspace<'a, K, P> {
    pub search: RealTime<'a, K, P>,
    pub rows: LargestRows<'a, K>,
}

impl<'a, K: Constraint, P: CostWithControl> Workspace<'a, K, P> {
    /// The memory for plans in the basis and with the points of a candidate.
    pub fn new(
        (problem, grids): (&Problem<'a>, &Grids),
        (constraints, cost): (&Arc<Constraints<K>>, P),
        candidate: &Candidate,
        options: &TrackerOptions,
    ) -> Result<Self> {
        let model = problem.model();
        let watch = Watch::start(None, &Interrupt::default());
        let rows = Rows::new(model, constraints.clone(), cost)?;
        let context = Context {
            problem,
            grids,
            rows: &rows,
            watch: &watch,
            settings: &options.settings,
            free_horizon: free_horizon(options),
            goal: None,
        };
        let search = RealTime::new(context, candidate, options.barrier)?;
        let rows = LargestRows::near_ends(model, constraints.clone(), options.look * options.settings.degree)?;
        Ok(Self { search, rows })
    }
}

/// The bounds and the weight of a free horizon, which gets shorter on the way.
pub(super) fn free_horizon(options: &TrackerOptions) -> Option<FreeHorizon> {
    let free = options.settings.free_horizon?;
    Some(FreeHorizon { shortest: options.shortest_horizon.min(free.shortest), ..free })
}

/// Tables of the functions of a basis, and the motion of a plan by them.
pub(super) struct OnPlan {
    basis: Basis,
    /// Value and first three derivatives in normalised time, at the regular times.
    table: DMatrix<f64>,
    regular: DMatrix<f64>,
    functions: Functions,
    one: DMatrix<f64>,
    further: Vec<f64>,
}

impl OnPlan {
    pub fn new(candidate: &Candidate, times: impl Iterator<Item = f64>) -> Self {
        let (basis, n) = (&candidate.path.basis, candidate.path.coefficients.nrows());
        let tables: Vec<_> = times.map(|time| basis.functions_at(time).1).collect();
        let mut table = DMatrix::zeros(basis.degree() + 1, 4 * tables.len());
        for (k, of) in tables.iter().enumerate() {
            table.columns_mut(4 * k, 4).copy_from(&of.transpose());
        }
        Self {
            basis: basis.clone(),
            regular: DMatrix::zeros(n, table.ncols()),
            table,
            functions: Functions::default(),
            one: DMatrix::zeros(n, 4),
            further: Vec::new(),
        }
    }

    /// The motion of a plan.
    pub fn of<'p>(&'p mut self, plan: &'p Plan) -> impl Motion {
        (self, plan)
    }
}

impl Motion for (&mut OnPlan, &Plan) {
    fn segments(&self) -> usize {
        1
    }

    fn begin(&self, _: usize) -> f64 {
        0.0
    }

    fn length(&self, _: usize) -> f64 {
        self.1.motion.horizons.whole()
    }

    fn states(&mut self, _: usize, times: &[f64], regular: bool) -> &[f64] {
        let (own, motion) = (&mut *self.0, &self.1.motion);
        let (coefficients, horizon) = (&motion.path.coefficients, motion.horizons.whole());
        let n = coefficients.nrows();
        if regular {
            multiply(coefficients, &own.table, &mut own.regular);
            scale(own.regular.as_mut_slice(), n, horizon);
            return own.regular.as_slice();
        }
        own.further.clear();
        for time in times {
            own.basis.functions_in(2.0 * time / horizon - 1.0, &mut own.functions);
            multiply(coefficients, &own.functions.transposed, &mut own.one);
            own.further.extend_from_slice(own.one.as_slice());
        }
        scale(&mut own.further, n, horizon);
        &own.further
    }
}

/// Divides the derivatives of `n` joints by powers of the horizon.
fn scale(states: &mut [f64], n: usize, horizon: f64) {
    for (d, values) in states.chunks_exact_mut(n).enumerate() {
        let factor = horizon.powi(-(d as i32 % 4));
        for value in values {
            *value *= factor;
        }
    }
}
