//! The nonlinear program of a curve in a basis.

use super::ends::PeriodicEnds;
use super::finer::Finer;
use super::grid_rows::GridRows;
use super::points::PointBlock;
use super::unknowns::Unknowns;
use super::{Candidate, Context, Stage};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::direct::SearchOptions;
use crate::error::Result;
use crate::motion::{Problem, Watch};
use crate::nlp::{Bordered, Equality, Iterate, Kkt, Nlp, Row, Tightened};
use crate::transcription::{Derivatives, Grid};
use nalgebra::DVector;
use std::sync::Arc;

/// The nonlinear program of a curve in a basis: unknowns, and blocks of rows. Each block has the margins
/// $m_j \ge 0$ by which its rows are larger near a point than at it.
///
/// The rows are those at the points of the quadrature; then those at single times; then those that are linear in times
/// and horizon.
pub(in crate::direct) struct Program<'g, 'a: 'g, K, P> {
    pub(super) unknowns: Unknowns,
    pub(super) grid_rows: GridRows<'g, 'a, K, P>,
    pub(super) points: PointBlock<'g>,
    pub(super) finer: Finer<'g, P>,
    pub(super) derivatives: Derivatives<f64>,
    /// Memory for the multipliers of all rows.
    multipliers: Vec<f64>,
    pub(super) stage: Stage,
    pub(super) search: SearchOptions,
    /// Unknowns that appeared to satisfy the constraints, the last one last.
    pub feasible_iterates: Vec<DVector<f64>>,
    watch: Watch,
}

impl<'g, 'a, K: Constraint, P: CostWithControl> Program<'g, 'a, K, P> {
    /// The program of a candidate without rows at single times, on a grid and with a finer one if there is one.
    pub fn new(
        context: Context<'_, 'a, K, P>,
        candidate: &Candidate,
        (grid, finer): (Arc<Grid<f64>>, Option<Arc<Grid<f64>>>),
        (stage, is_refinable): (Stage, bool),
    ) -> Self {
        let n = context.problem.model().dof();
        let mut grid_rows = GridRows::new(context, candidate, &grid, stage);
        let unknowns = Unknowns::new(context, candidate, grid.clone());
        if !unknowns.free.parts.is_empty() {
            grid_rows.objective.free_horizon(unknowns.rates.clone());
        }
        Self {
            points: PointBlock::new(grid_rows.margins.len(), candidate.horizons.whole()),
            finer: Finer::new(finer, &context.rows.cost, n, is_refinable),
            derivatives: Derivatives::new(&grid, n),
            multipliers: Vec::new(),
            stage,
            search: context.settings.search.clone(),
            feasible_iterates: Vec::new(),
            watch: context.watch.clone(),
            unknowns,
            grid_rows,
        }
    }

    /// The program of a search from a candidate with all its rows and first margins, and its unknowns.
    pub fn of_search(
        context: Context<'g, 'a, K, P>,
        candidate: &Candidate,
        grids: (Arc<Grid<f64>>, Option<Arc<Grid<f64>>>),
        stage: (Stage, bool),
    ) -> Result<(Self, DVector<f64>)> {
        let mut program = Self::new(context, candidate, grids, stage);
        let Context { settings, rows, goal, .. } = context;
        let goal = goal.map(|goal| &goal.alternatives[candidate.alternative][..]);
        let Self { unknowns, points, derivatives, .. } = &mut program;
        points.add_goal_and_waypoints(rows.model, &settings.waypoints, goal);
        let unknown = settings.waypoints.iter().map(|waypoint| waypoint.share.is_none());
        let unknown = unknown.enumerate().filter(|(_, unknown)| *unknown);
        unknowns.moving = unknown.map(|(k, _)| k).collect();
        points.add_windows(rows.model, &rows.constraints, unknowns);
        unknowns.period = settings.period.as_ref().map(|period| {
            let matrix = derivatives.hessian.clone();
            PeriodicEnds::new(period.clone(), Bordered::with_border(matrix, unknowns.border()))
        });
        let x = program.unknowns.vector(candidate);
        program.set_first_margins(&x)?;
        if settings.start_is_minimum && stage.0.last {
            program.maxima(true)?;
            program.set_margins(false);
        }
        Ok((program, x))
    }

    /// Begins anew at another candidate in the same basis, with the memory of this program.
    pub fn restart(&mut self, problem: &Problem<'a>, candidate: &Candidate) {
        self.unknowns.restart(problem, candidate);
        self.points.measure = candidate.horizons.whole();
        self.grid_rows.restart(problem, &self.unknowns, &self.search);
        self.points.margins.fill(0.0);
        self.feasible_iterates.clear();
    }

    /// Allocates memory for a working set of all rows.
    pub fn allocate(&mut self) {
        self.grid_rows.allocate();
    }

    /// The number of all rows.
    pub fn rows(&self) -> usize {
        self.points.range().end + self.unknowns.linear_rows().count()
    }

    /// The margins of the rows at the points of the quadrature, then of those at single times.
    pub fn margins_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.grid_rows.margins.iter_mut().chain(&mut self.points.margins)
    }

    /// Sets coefficients, horizons and times.
    pub(super) fn place(&mut self, x: &DVector<f64>) {
        self.unknowns.set(x);
        self.grid_rows.objective.set_horizons(&self.unknowns.horizons);
        self.grid_rows.objective.set_rates(&self.unknowns.rates);
    }

    /// Sets path, horizons and times of waypoints of a candidate to those of unknowns.
    pub fn put(&mut self, x: &DVector<f64>, candidate: &mut Candidate) {
        self.place(x);
        self.unknowns.put(candidate);
    }

    /// The known multipliers at the points, without those of rows beside ends that another program had.
    pub fn known_multipliers<'k>(&self, of: &Candidate, known: &'k mut Vec<f64>) -> Option<&'k [f64]> {
        let count = self.grid_rows.objective.cost().rows.count();
        of.multipliers.at_in(&self.unknowns.grid.times, count, known)?;
        known.truncate(self.points.range().end);
        Some(known)
    }

    /// Sets the multipliers of a candidate to those of an iterate, but those of waypoints and of a goal.
    pub fn put_multipliers(&mut self, iterate: &Iterate, candidate: &mut Candidate) {
        iterate.multipliers_in(self.rows(), &mut self.multipliers);
        let (all, rows) = (&self.multipliers, &self.grid_rows.objective.cost().rows);
        candidate.multipliers.put(&self.unknowns.grid, rows, all);
    }

    /// Sets all multipliers of a candidate to those of an iterate.
    pub fn put_all_multipliers(&mut self, iterate: &Iterate, candidate: &mut Candidate) {
        self.put_multipliers(iterate, candidate);
        candidate.multipliers.of_points = self.multipliers[self.points.range()].to_vec();
    }

    /// The norm of steps: the mean square of the velocities in normalised time, that of the
    /// [border](Unknowns::norm_of_border), and the square of the change of the configuration at the ends of a periodic
    /// motion.
    pub fn kkt(&self) -> Option<Kkt> {
        let objective = &self.grid_rows.objective;
        let mut norm = Bordered::with_border(objective.gram(), self.unknowns.border());
        self.unknowns.norm_of_border(&mut norm.corner);
        if let Some(period) = &self.unknowns.period {
            norm = period.reduced(&norm);
            let (n, order) = (objective.dof(), norm.corner.nrows());
            for value in order - n..order {
                norm.corner[(value, value)] += 1.0;
            }
        }
        Kkt::new(norm)
    }

    /// Begins with the norm of the current horizon and times.
    pub fn restart_kkt(&self, kkt: &mut Kkt) {
        kkt.restart(|corner| self.unknowns.norm_of_border(corner));
    }

    /// Returns true if a finer quadrature gives a different cost; the tolerance is larger before the `end`.
    pub fn is_coarse(&mut self, end: bool) -> Result<bool> {
        let cost = self.grid_rows.cost(&self.unknowns)?;
        let on_the_way = if end { 0.0 } else { self.search.quadrature_on_the_way };
        self.finer.is_coarse(&self.unknowns, cost, self.stage.quadrature_tolerance.max(on_the_way))
    }

    /// The largest violation of a row at `x`, between the points too, in its unit.
    pub fn violation(&mut self, x: &DVector<f64>) -> Result<f64> {
        self.place(x);
        self.is_coarse(true)?;
        self.maxima(true)
    }

    /// Computes the derivatives in all free coefficients and the border, at the coefficients.
    fn derivatives_here(&mut self, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        let Self { unknowns, grid_rows, points, derivatives, .. } = self;
        grid_rows.set_terms(iterate);
        grid_rows.objective.gradient_and_hessian(&unknowns.coefficients, derivatives)?;
        let own = derivatives.gradient.len();
        out.gradient.rows_mut(0, own).copy_from(&derivatives.gradient);
        std::mem::swap(&mut out.hessian.matrix, &mut derivatives.hessian);
        out.hessian.border.fill(0.0);
        out.hessian.corner.fill(0.0);
        out.gradient.rows_mut(own, unknowns.border()).fill(0.0);
        for (k, (part, _)) in unknowns.free.parts.iter().enumerate() {
            let of = &derivatives.horizons[*part];
            out.hessian.border.set_column(k, &of.mixed);
            out.gradient[own + k] = of.first + unknowns.free.weight * unknowns.horizons.share();
            out.hessian.corner[(k, k)] = of.second;
        }
        unknowns.add_linear_rows(iterate, points.range().end, out);
        points.add_derivatives(unknowns, iterate, out)
    }
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// Calls a function for each equality, in the order of their rows, with its segment and its gradient in all
    /// unknowns.
    pub(super) fn equality_gradients(&mut self, each: &mut dyn FnMut(usize, &DVector<f64>)) -> Result<()> {
        let Self { unknowns, grid_rows, points, .. } = self;
        let (unknowns, own) = (&*unknowns, unknowns.grid.free.len() * unknowns.coefficients.nrows());
        let mut reduced = |segment, gradient: &DVector<f64>| match &unknowns.period {
            None => each(segment, gradient),
            Some(period) => each(segment, &period.reduced_gradient(gradient)),
        };
        grid_rows.equality_gradients(unknowns, &mut |segment, by_coefficients, by_horizon| {
            let part = unknowns.horizons.part(segment, unknowns.grid.segments);
            let mut gradient = by_coefficients.clone().resize_vertically(own + unknowns.border(), 0.0);
            if let Some(k) = unknowns.free.parts.iter().position(|(of, _)| *of == part) {
                gradient[own + k] = by_horizon;
            }
            reduced(segment, &gradient);
        })?;
        points.equality_gradients(unknowns, &mut reduced)
    }
}

impl<K: Constraint, P: CostWithControl> Nlp for Program<'_, '_, K, P> {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        self.place(x);
        let Self { unknowns, grid_rows, points, .. } = self;
        let cost = grid_rows.cost(unknowns)?;
        points.evaluate(unknowns)?;
        grid_rows.values(h);
        h.extend(points.values());
        h.extend(unknowns.linear_rows().map(|row| row.value));
        if unknowns.horizons.parts().iter().any(|horizon| *horizon <= 0.0) || grid_rows.is_left(h) {
            return Ok(f64::INFINITY);
        }
        let Unknowns { free, horizons, .. } = unknowns;
        Ok(if free.parts.is_empty() { cost } else { cost + free.weight * horizons.whole() })
    }

    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        self.place(x);
        match self.unknowns.period.take() {
            None => self.derivatives_here(iterate, out)?,
            Some(mut period) => {
                period.exchange(out);
                let found = self.derivatives_here(iterate, out);
                period.exchange(out);
                period.reduce(out);
                self.unknowns.period = Some(period);
                found?;
            }
        }
        let Kkt { hessian, equalities, .. } = out;
        equalities.clear();
        self.equality_gradients(&mut |segment, gradient| equalities.push(hessian, segment, gradient))
    }

    fn measure(&self, x: &DVector<f64>) -> f64 {
        self.unknowns.whole_at(x)
    }

    fn row_measure(&self, x: &DVector<f64>, row: usize) -> f64 {
        let (unknowns, of_points) = (&self.unknowns, self.points.range());
        if row >= of_points.end {
            unknowns.whole_at(x)
        } else if row >= of_points.start {
            self.points.measure
        } else {
            let grid = &unknowns.grid;
            let segment = row / self.grid_rows.objective.cost().rows.count() / grid.points();
            unknowns.horizon_at(x, unknowns.horizons.part(segment, grid.segments))
        }
    }

    fn max_step_fraction(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64 {
        self.unknowns.max_step_fraction(x, step)
    }

    fn equalities(&self) -> Vec<Equality> {
        let mut all = self.grid_rows.equalities(&self.unknowns.grid);
        all.extend(self.points.equalities());
        all
    }

    fn working_set(&mut self, h: &[f64], all: &mut Vec<Row>) {
        self.grid_rows.list(&self.unknowns, h, all);
        let of_border = self.points.range().end..h.len();
        all.extend(self.points.inequalities().chain(of_border).map(|at| Row::new(at, 1.0)));
    }

    fn tighten(&mut self, x: &DVector<f64>, h: &mut Vec<f64>, round: usize) -> Result<Tightened> {
        let end = round > 0;
        self.place(x);
        if self.is_coarse(end)? {
            return Ok(Tightened::QuadratureTooCoarse);
        }
        let violation = self.maxima(end)?;
        self.value(x, h)?;
        if self.stage.last && violation <= self.stage.feasible {
            self.feasible_iterates.push(x.clone());
        }
        // Exact margins at first; then they only grow, so that the search ends.
        let grow = round > self.search.exact_margins;
        // The reserve is there to keep the bounds themselves, not only to within the tolerance.
        let is_beyond = self.set_margins(grow) && violation <= self.stage.feasible;
        let again = end && self.stage.last && is_beyond;
        Ok(if again { Tightened::Beyond } else { Tightened::Violation(violation) })
    }

    fn is_stopped(&self) -> bool {
        self.watch.stopped().is_some()
    }
}
