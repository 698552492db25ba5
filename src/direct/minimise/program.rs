//! The nonlinear program of a curve in a basis.

use super::ends::PeriodicEnds;
use super::free::Free;
use super::integrand::Integrand;
use super::point_rows::PointRows;
use super::windows::Window;
use super::working_set::{WorkingSet, equalities};
use super::{Candidate, Context, Stage};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::curve::Basis;
use crate::direct::{Period, SearchOptions};
use crate::error::Result;
use crate::model::Model;
use crate::motion::{Problem, Watch};
use crate::nlp::{Bordered, Equality, Iterate, Kkt, Nlp, Row, Tightened};
use crate::transcription::{Derivatives, Grid, Horizons, Objective, Scan, ScanWorkspace};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The nonlinear program of a curve in a basis: the unknowns are its free coefficients, then the horizon if it is free,
/// then the times of waypoints that have none, then the ends of a periodic motion.
///
/// The rows are those of the constraints at the points of the quadrature, with margins $m_j \ge 0$ by which they are
/// larger near a point than at it; then those of waypoints, of a goal that is a set, and of ends at a bound; then those
/// that are linear in times and horizon.
pub(in crate::direct) struct Program<'g, 'a, K, P> {
    pub(super) grid: Arc<Grid<f64>>,
    pub(super) model: &'g Model,
    /// The times between the points at which rows are evaluated, during the search and at its end.
    pub(super) scans: [Arc<Scan>; 2],
    pub(super) objective: Objective<'g, f64, Integrand<'a, K, P>>,
    /// The coefficients and the horizons at which the objective and the rows were evaluated last, and the cost.
    evaluated_at: (DMatrix<f64>, Horizons<f64>),
    pub(super) evaluated: Option<f64>,
    /// The cost alone by a finer quadrature if there is one, with the cost of the last evaluation and its relative
    /// difference.
    pub(super) finer: Option<Objective<'g, f64, P>>,
    pub finer_cost: [f64; 2],
    /// The largest deviation of an equality of the state at the last scan, in its unit.
    pub deviation: f64,
    pub(super) derivatives: Derivatives<f64>,
    /// The coefficients, those of the boundary conditions included.
    pub(super) coefficients: DMatrix<f64>,
    pub(super) basis: Basis,
    pub(super) rates: DMatrix<f64>,
    pub(super) horizons: Horizons<f64>,
    pub(super) free: Free,
    /// The rows of the waypoints, those of a goal and those of ends, and the index of the first one among all rows.
    pub(super) points: Vec<PointRows<'g>>,
    pub(super) first_of_points: usize,
    /// The factor of the weights of these rows: the horizon at the beginning. With the current one the penalty of a
    /// goal would vanish with the horizon, and a search could shrink to a motion that goes nowhere in no time.
    pub(super) measure_of_points: f64,
    pub(super) windows: Vec<Window>,
    /// The rows that are at their bounds at the start, and at the end.
    pub(super) rows_of_ends: [Vec<usize>; 2],
    /// The normalised times of the waypoints, and the indices of those whose times are unknown.
    pub(super) times: Vec<f64>,
    pub(super) moving: Vec<usize>,
    /// The ends of a periodic motion.
    pub(super) period: Option<PeriodicEnds>,
    pub(super) margins: Vec<f64>,
    /// The margin of each row against rounding.
    pub(super) reserves: Vec<f64>,
    /// The last check between the points.
    pub(super) scanned: ScanWorkspace,
    /// The multipliers of all rows.
    pub(super) multipliers: Vec<f64>,
    pub(super) working: WorkingSet,
    pub(super) stage: Stage,
    pub(super) search: SearchOptions,
    /// The penalties of equalities to begin with, relative to those without a search before.
    pub equality_penalty: f64,
    /// True if the number of points may increase.
    pub(super) refinable: bool,
    /// True for the derivatives of the Lagrangian in place of those of the barrier function.
    pub(super) lagrangian: bool,
    /// Unknowns that appeared to satisfy the constraints, the last one last.
    pub kept: Vec<DVector<f64>>,
    watch: Watch,
}

impl<'g, 'a, K: Constraint, P: CostWithControl> Program<'g, 'a, K, P> {
    /// The program of a candidate without rows of waypoints and of a goal.
    pub fn new(
        context: Context<'_, 'a, K, P>,
        candidate: &Candidate,
        (grid, finer): (Arc<Grid<f64>>, Option<Arc<Grid<f64>>>),
        stage: Stage,
        refinable: bool,
    ) -> Self
    where
        'a: 'g,
    {
        let Context { problem, rows, .. } = context;
        let (search, path) = (context.settings.search.clone(), &candidate.path);
        let (n, basis) = (problem.model().dof(), &path.basis);
        let looks = search.scan * grid.points();
        let last = if stage.last { looks.max(search.last_scan / basis.segments()) } else { looks };
        let points = grid.points() * grid.segments;
        let mut program = Self {
            scans: [looks, last].map(|times| context.grids.scan(basis, times)),
            finer: finer.map(|finer| Objective::new(finer, rows.cost.clone(), n)),
            finer_cost: [f64::NAN; 2],
            evaluated_at: (path.coefficients.clone(), candidate.horizons.clone()),
            deviation: 0.0,
            evaluated: None,
            derivatives: Derivatives::new(&grid, n),
            coefficients: path.coefficients.clone(),
            rates: path.rates(problem),
            basis: basis.clone(),
            horizons: candidate.horizons.clone(),
            free: Free::new(context.free_horizon, &context.settings.parts, search.reserve),
            points: Vec::new(),
            windows: Vec::new(),
            first_of_points: points * rows.count(),
            measure_of_points: candidate.horizons.whole(),
            rows_of_ends: Default::default(),
            times: candidate.times.clone(),
            moving: Vec::new(),
            period: None,
            margins: Vec::new(),
            reserves: Vec::new(),
            scanned: ScanWorkspace::default(),
            multipliers: Vec::new(),
            working: WorkingSet::new(problem, rows, &search),
            refinable,
            lagrangian: false,
            kept: Vec::new(),
            model: problem.model(),
            objective: Objective::new(grid.clone(), Integrand::new(rows.clone(), points), n),
            grid,
            stage,
            search,
            equality_penalty: 1.0,
            watch: context.watch.clone(),
        };
        if !program.free.parts.is_empty() {
            program.objective.free_horizon(program.rates.clone());
        }
        program.count_margins();
        let rows = &mut program.objective.cost_mut().rows;
        let (grid, search) = (&program.grid, &program.search);
        program.working.begin_lists(grid, rows, search);
        program
    }

    /// Makes the ends unknowns of a periodic motion; after [`add_goal_and_waypoints`](Self::add_goal_and_waypoints).
    pub fn set_period(&mut self, period: &Period) {
        let matrix = self.derivatives.hessian.clone();
        let full = Bordered::with_border(matrix, self.border());
        self.period = Some(PeriodicEnds::new(period.clone(), full));
    }

    /// Begins anew at another candidate in the same basis, with the memory of this program.
    pub fn restart(&mut self, problem: &Problem<'a>, candidate: &Candidate) {
        let path = &candidate.path;
        self.evaluated = None;
        self.coefficients.copy_from(&path.coefficients);
        path.rates_in(problem, &mut self.rates);
        self.horizons.assign(&candidate.horizons);
        self.measure_of_points = candidate.horizons.whole();
        self.objective.set_rates(&self.rates);
        let rows = &mut self.objective.cost_mut().rows;
        rows.near.release();
        rows.near.forget_active_pairs();
        if self.working.restart(problem, rows, &self.search) {
            self.working.begin_lists(&self.grid, rows, &self.search);
        }
        self.kept.clear();
        self.margins.fill(0.0);
    }

    /// One margin per row, all zero.
    pub(super) fn count_margins(&mut self) {
        let rows = self.first_of_border() + self.linear_rows().count();
        self.margins = vec![0.0; rows];
    }

    /// Returns true if cost and rows were last evaluated at these coefficients.
    fn is_evaluated(&self) -> bool {
        let (coefficients, horizons) = &self.evaluated_at;
        (coefficients, horizons) == (&self.coefficients, &self.horizons)
    }

    /// Evaluates the cost and the rows at the coefficients, unless these were the last ones.
    pub(super) fn cost(&mut self) -> Result<f64> {
        if let Some(cost) = self.evaluated.filter(|_| self.is_evaluated()) {
            return Ok(cost);
        }
        let cost = self.objective.value(&self.coefficients)?;
        let (coefficients, horizons) = &mut self.evaluated_at;
        coefficients.copy_from(&self.coefficients);
        horizons.assign(&self.horizons);
        self.evaluated = Some(cost);
        Ok(cost)
    }

    /// Passes the terms of the rows to the integrand.
    pub(super) fn set_terms(&mut self, iterate: &Iterate) {
        let integrand = self.objective.cost_mut();
        for terms in &mut integrand.terms {
            terms.clear();
        }
        let count = integrand.rows.count();
        let first = self.first_of_points;
        for state in iterate.working.iter().filter(|of| of.row.at < first) {
            let at = state.row.at;
            let h = self.objective.cost().h[at] + self.margins[at];
            let mut term = self.term(iterate, state, h);
            let integrand = self.objective.cost_mut();
            if integrand.rows.attributes().clearances[at % count] {
                term.multiplier *= iterate.share;
            }
            integrand.terms[at / count].push((at % count, term));
        }
        let integrand = self.objective.cost_mut();
        let held = iterate.equalities.iter();
        for equality in held.filter(|held| held.row.at < first) {
            let at = equality.row.at;
            // Their rule has a small share of the quadrature.
            let term = iterate.equality_term(equality, integrand.h[at]);
            let term = term.times(1.0 / Grid::COLLOCATED);
            integrand.terms[at / count].push((at % count, term));
        }
    }

    /// Computes the derivatives in all free coefficients and the border, at the coefficients.
    fn derivatives_here(&mut self, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        if !self.is_evaluated() {
            self.objective.cost_mut().rows.near.forget_active_pairs();
        }
        self.set_terms(iterate);
        self.objective.gradient_and_hessian(&self.coefficients, &mut self.derivatives)?;
        let (own, of) = (self.derivatives.gradient.len(), &self.derivatives);
        out.gradient.rows_mut(0, own).copy_from(&of.gradient);
        std::mem::swap(&mut out.hessian.matrix, &mut self.derivatives.hessian);
        out.hessian.border.fill(0.0);
        out.hessian.corner.fill(0.0);
        out.gradient.rows_mut(own, self.border()).fill(0.0);
        for (k, (part, _)) in self.free.parts.iter().enumerate() {
            let of = &self.derivatives.horizons[*part];
            out.hessian.border.set_column(k, &of.mixed);
            out.gradient[own + k] = of.first + self.free.weight * self.horizons.share();
            out.hessian.corner[(k, k)] = of.second;
        }
        self.add_linear_rows(iterate, self.first_of_border(), out);
        self.add_points(iterate, out)
    }
}

impl<K: Constraint, P: CostWithControl> Nlp for Program<'_, '_, K, P> {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        self.place(x);
        let cost = self.cost()?;
        self.evaluate_points()?;
        let (of_grid, beside) = self.margins.split_at(self.first_of_points);
        self.objective.cost().with_margins(of_grid, h);
        let of_points = self.points.iter().flat_map(|point| &point.h);
        h.extend(of_points.zip(beside).map(|(h, margin)| h + margin));
        h.extend(self.linear_rows().map(|row| row.value));
        if self.horizons.parts().iter().any(|horizon| *horizon <= 0.0) {
            return Ok(f64::INFINITY);
        }
        let objective = if self.free.parts.is_empty() { cost } else { cost + self.free.weight * self.horizons.whole() };
        let rows = &self.objective.cost().rows;
        Ok(if self.working.is_left(rows, &h[..self.first_of_points]) { f64::INFINITY } else { objective })
    }

    fn value_at_trial(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        self.objective.cost_mut().rows.near.reuse_active_pairs = true;
        let found = self.value(x, h);
        self.objective.cost_mut().rows.near.reuse_active_pairs = false;
        // A step that ends here is evaluated with all active pairs.
        self.evaluated = None;
        found
    }

    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        self.place(x);
        let Some(mut period) = self.period.take() else {
            return self.derivatives_here(iterate, out);
        };
        period.exchange(out);
        let found = self.derivatives_here(iterate, out);
        period.exchange(out);
        period.reduce(out);
        self.period = Some(period);
        found
    }

    fn measure(&self, x: &DVector<f64>) -> f64 {
        let parts = self.horizons.parts();
        match &self.free.parts[..] {
            [] => self.horizons.whole(),
            [_] if parts.len() == 1 => x[self.own()],
            _ => (0..parts.len()).map(|part| self.horizon_at(x, part)).sum::<f64>() * self.horizons.share(),
        }
    }

    fn has_parts(&self) -> bool {
        let own = !self.free.parts.is_empty() && !self.points.is_empty();
        own || self.horizons.parts().len() > 1
    }

    fn measure_of(&self, x: &DVector<f64>, row: usize) -> f64 {
        if row >= self.first_of_border() {
            return self.measure(x);
        }
        if row >= self.first_of_points {
            return self.measure_of_points;
        }
        let segment = row / self.objective.cost().rows.count() / self.grid.points();
        self.horizon_at(x, self.horizons.part(segment, self.grid.segments))
    }

    fn longest(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64 {
        self.longest_on_border(x, step)
    }

    fn has_share(&self) -> bool {
        self.working.has_clearances()
    }

    fn equalities(&self, density: f64) -> Vec<Equality> {
        let (rows, factor) = (&self.objective.cost().rows, self.equality_penalty);
        let mut all = equalities(&self.grid, rows, &self.search, [density, factor]);
        let first = self.search.point_penalty * density;
        let of_points = self.points.iter().flat_map(|point| point.penalties(first));
        all.extend(of_points.map(|(at, first)| Equality::new(Row { at, weight: 1.0 }, first, factor)));
        all
    }

    fn working_set(&mut self, h: &[f64], all: &mut Vec<Row>) {
        let fixed = self.fixed_ends();
        let rows = &mut self.objective.cost_mut().rows;
        self.working.list(&self.grid, rows, fixed, h, all);
        let of_points = self.inequalities_of_points();
        let of_border = self.first_of_border()..h.len();
        all.extend(of_points.chain(of_border).map(|at| Row { at, weight: 1.0 }));
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
            self.kept.push(x.clone());
        }
        // Exact margins at first; then they only grow, so that the search ends.
        let grow = round > self.search.exact_margins;
        self.set_margins(grow);
        // The reserve is there to keep the bounds themselves: within the tolerance a row is beyond them only if margins
        // that are set exactly do not help.
        let is_beyond = violation <= self.stage.feasible && self.scanned.found.iter().any(|row| row.height > 0.0);
        let again = end && !grow && self.stage.last && is_beyond;
        Ok(if again { Tightened::Beyond } else { Tightened::Violation(violation) })
    }

    fn violation(&mut self, x: &DVector<f64>) -> Result<f64> {
        self.place(x);
        self.is_coarse(true)?;
        self.maxima(true)
    }

    fn is_stopped(&self) -> bool {
        self.watch.stopped().is_some()
    }
}
