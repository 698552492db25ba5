//! The nonlinear program of a curve in a basis.

use super::integrand::Integrand;
use super::point_rows::PointRows;
use super::working_set::{WorkingSet, equalities};
use super::{Candidate, Context, Stage};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::curve::Basis;
use crate::direct::{FreeHorizon, SearchOptions};
use crate::error::Result;
use crate::model::Model;
use crate::motion::Watch;
use crate::nlp::{Bordered, Equality, Iterate, Kkt, Nlp, Row, RowState, Term, Tightened};
use crate::transcription::{Derivatives, Objective};
use crate::transcription::{Grid, Scan};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The nonlinear program of a curve in a basis: the unknowns are its free coefficients, then the horizon if it is free,
/// then the times of waypoints that have none.
///
/// The rows are those of the constraints at the points of the quadrature, with margins $m_j \ge 0$ by which they are
/// larger near a point than at it; then those of waypoints, of a goal that is a set, and of ends at a bound; then those
/// that are linear in times and horizon.
pub(super) struct Program<'g, 'a, K, P> {
    pub(super) grid: &'g Grid<f64>,
    pub(super) model: &'g Model,
    /// The times between the points at which rows are evaluated, during the search and at its end.
    pub(super) scans: [Arc<Scan>; 2],
    pub(super) objective: Objective<'g, f64, Integrand<'a, K, P>>,
    /// The coefficients and the horizon at which the objective and the rows were evaluated last, with the cost.
    evaluated: Option<(DMatrix<f64>, f64, f64)>,
    /// The cost alone by a finer quadrature, with the cost of the last evaluation and its relative difference.
    pub(super) finer: Objective<'g, f64, P>,
    pub finer_cost: [f64; 2],
    /// The largest deviation of an equality of the state at the last scan, in its unit.
    pub deviation: f64,
    pub(super) derivatives: Derivatives<f64>,
    /// The coefficients, those of the boundary conditions included.
    pub(super) coefficients: DMatrix<f64>,
    pub(super) basis: Basis,
    pub(super) rates: DMatrix<f64>,
    pub(super) horizon: f64,
    pub(super) free_horizon: Option<FreeHorizon>,
    /// The rows of the waypoints, those of a goal and those of ends, and the index of the first one among all rows.
    pub(super) points: Vec<PointRows<'g>>,
    pub(super) first_of_points: usize,
    /// The rows that are at their bounds at the start, and at the end.
    pub(super) rows_of_ends: [Vec<usize>; 2],
    /// The normalised times of the waypoints, and the indices of those whose times are unknown.
    pub(super) times: Vec<f64>,
    pub(super) moving: Vec<usize>,
    pub(super) margins: Vec<f64>,
    working: WorkingSet,
    pub(super) stage: Stage,
    pub(super) search: &'g SearchOptions,
    /// The penalties of equalities to begin with, relative to those without a search before.
    pub equality_penalty: f64,
    /// True if the number of points may increase.
    pub(super) refinable: bool,
    /// True for the derivatives of the Lagrangian in place of those of the barrier function.
    lagrangian: bool,
    /// Unknowns that appeared to satisfy the constraints, the last one last.
    pub kept: Vec<DVector<f64>>,
    watch: &'g Watch,
}

impl<'g, 'a, K: Constraint, P: CostWithControl> Program<'g, 'a, K, P> {
    pub fn new(
        context: Context<'g, 'a, K, P>,
        Candidate {
            path,
            horizon,
            alternative,
            times,
            ..
        }: &Candidate,
        [grid, finer]: [&'g Grid<f64>; 2],
        stage: Stage,
        refinable: bool,
    ) -> Self {
        let Context {
            problem,
            grids,
            rows,
            watch,
            settings,
            free_horizon,
            goal,
        } = context;
        let search = &settings.search;
        let (n, basis) = (problem.model().dof(), &path.basis);
        let looks = search.scan * grid.points();
        let last = if stage.last {
            looks.max(search.last_scan / basis.segments())
        } else {
            looks
        };
        let points = grid.points() * grid.segments;
        let mut objective = Objective::new(grid, Integrand::new(rows.clone(), points), n);
        let rates = path.rates(problem);
        if free_horizon.is_some() {
            objective.free_horizon(rates.clone());
        }
        let (model, first_of_points) = (problem.model(), points * rows.count());
        let (mut points, mut first) = (Vec::new(), first_of_points);
        let waypoints = &settings.waypoints;
        for waypoint in waypoints {
            points.push(PointRows::of_waypoint(model, waypoint, first));
            first = points[points.len() - 1].range().end;
        }
        if let Some(goal) = goal {
            let goal = &goal.alternatives[*alternative];
            points.push(PointRows::of_goal(model, goal, first));
        }
        let unknown = waypoints.iter().map(|waypoint| waypoint.share.is_none());
        let unknown = unknown.enumerate().filter(|(_, unknown)| *unknown);
        let mut program = Self {
            scans: [looks, last].map(|times| grids.scan(basis, times)),
            finer: Objective::new(finer, rows.cost.clone(), n),
            finer_cost: [f64::NAN; 2],
            deviation: 0.0,
            evaluated: None,
            derivatives: Derivatives::new(grid, n),
            coefficients: path.coefficients.clone(),
            rates,
            basis: basis.clone(),
            horizon: *horizon,
            free_horizon,
            points,
            first_of_points,
            rows_of_ends: Default::default(),
            times: times.clone(),
            moving: unknown.map(|(k, _)| k).collect(),
            margins: Vec::new(),
            working: WorkingSet::new(problem, rows, search),
            refinable,
            lagrangian: false,
            kept: Vec::new(),
            grid,
            model,
            objective,
            stage,
            search,
            equality_penalty: 1.0,
            watch,
        };
        program.count_margins();
        program
    }

    /// One margin per row, all zero.
    pub(super) fn count_margins(&mut self) {
        self.margins = vec![0.0; self.first_of_border() + self.linear_rows().len()];
    }

    /// The known multipliers at the points, without those of rows beside ends that another program had.
    pub fn known_multipliers(&self, of: &Candidate) -> Option<Vec<f64>> {
        let count = self.objective.cost().rows.count();
        let mut known = of.multipliers.at(&self.grid.times, count)?;
        known.truncate(self.range_of_points().end);
        Some(known)
    }

    /// The unknowns of a curve in the basis.
    pub fn unknowns(&self, of: &Candidate) -> DVector<f64> {
        let own = self.derivatives.gradient.len();
        let free = self.grid.free.iter();
        let coefficients = &of.path.coefficients;
        let all = free.flat_map(|function| coefficients.column(*function).into_iter().copied());
        let horizon = self.free_horizon.map(|_| of.horizon);
        let times = self.moving.iter().map(|k| of.times[*k]);
        DVector::from_iterator(own + self.border(), all.chain(horizon).chain(times))
    }

    /// The coefficients, the horizon and the times of waypoints of unknowns.
    pub fn curve(&mut self, x: &DVector<f64>) -> (DMatrix<f64>, f64, Vec<f64>) {
        self.place(x);
        (self.coefficients.clone(), self.horizon, self.times.clone())
    }

    /// Sets coefficients, horizon and times.
    pub(super) fn place(&mut self, x: &DVector<f64>) {
        let own = self.derivatives.gradient.len();
        let columns = x.as_slice()[..own].chunks_exact(self.objective.dof());
        for (function, column) in self.grid.free.iter().zip(columns) {
            self.coefficients
                .column_mut(*function)
                .copy_from_slice(column);
        }
        if self.free_horizon.is_some() {
            self.horizon = x[own];
            for column in self.basis.fixed_slopes() {
                let slope = self.rates.column(column) * self.horizon;
                self.coefficients.set_column(column, &slope);
            }
        }
        self.set_times(x);
        self.objective.set_horizon(self.horizon);
    }

    /// Evaluates the cost and the rows at the coefficients, unless these were the last ones.
    pub(super) fn cost(&mut self) -> Result<f64> {
        if let Some((coefficients, horizon, cost)) = &self.evaluated
            && (coefficients, *horizon) == (&self.coefficients, self.horizon)
        {
            return Ok(*cost);
        }
        let cost = self.objective.value(&self.coefficients)?;
        self.evaluated = Some((self.coefficients.clone(), self.horizon, cost));
        Ok(cost)
    }

    /// The norm of steps: the mean square of the velocities in normalised time, the relative change of the horizon, and
    /// the mean way of the curve in the change of the time of a waypoint.
    pub fn kkt(&self) -> Option<Kkt> {
        let matrix = self.objective.gram();
        let way = self.mean_square_slope();
        let mut corner = DMatrix::from_diagonal_element(self.border(), self.border(), way);
        if self.free_horizon.is_some() {
            corner[(0, 0)] = self.horizon.powi(-2);
        }
        Kkt::new(Bordered {
            border: DMatrix::zeros(matrix.order(), self.border()),
            matrix,
            corner,
        })
    }

    /// The norm of the gradient of the Lagrangian relative to the cost, dual to the norm of steps: the residual of the
    /// first of the optimality conditions (NW 19.2a).
    pub fn stationarity(&mut self, x: &DVector<f64>, iterate: &Iterate) -> Result<f64> {
        let Some(mut kkt) = self.kkt() else {
            return Ok(f64::INFINITY);
        };
        self.lagrangian = true;
        let found = self.derivatives(x, iterate, &mut kkt);
        self.lagrangian = false;
        found.map(|()| kkt.dual_length() / self.finer_cost[0].abs())
    }

    /// The term of a row: with its multiplier as slope for the Lagrangian.
    pub(super) fn term(&self, iterate: &Iterate, state: &RowState, h: f64) -> Term {
        let term = iterate.term(state, h);
        match self.lagrangian {
            false => term,
            true => Term {
                slope: term.multiplier,
                cost: 0.0,
                ..term
            },
        }
    }

    /// The derivatives with the metric, at the unknowns of an iterate.
    pub fn with_metric(
        &mut self,
        x: &DVector<f64>,
        iterate: &Iterate,
    ) -> Result<&Derivatives<f64>> {
        self.place(x);
        self.set_terms(iterate);
        self.objective
            .derivatives(&self.coefficients, &mut self.derivatives)?;
        for (place, of) in self.of_points(iterate)? {
            place.add_hessian(self.grid, &of, self.horizon, &mut self.derivatives.hessian);
        }
        Ok(&self.derivatives)
    }

    /// Passes the terms of the rows to the integrand.
    fn set_terms(&mut self, iterate: &Iterate) {
        let integrand = self.objective.cost_mut();
        for terms in &mut integrand.terms {
            terms.clear();
        }
        let count = integrand.rows.count();
        let first = self.first_of_points;
        for state in iterate.working.iter().filter(|of| of.row.at < first) {
            let at = state.row.at;
            let h = self.objective.cost().h[at] + self.margins[at];
            let term = self.term(iterate, state, h);
            let integrand = self.objective.cost_mut();
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
}

impl<K: Constraint, P: CostWithControl> Nlp for Program<'_, '_, K, P> {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        self.place(x);
        let cost = self.cost()?;
        self.evaluate_points()?;
        let rows = self.objective.cost().h.iter();
        let rows = rows.chain(self.points.iter().flat_map(|point| &point.h));
        h.clear();
        h.extend(rows.zip(&self.margins).map(|(h, margin)| h + margin));
        h.extend(self.linear_rows().iter().map(|row| row.value));
        let mut objective = cost;
        if let Some(free) = self.free_horizon {
            if self.horizon <= 0.0 {
                return Ok(f64::INFINITY);
            }
            objective += free.weight * self.horizon;
        }
        Ok(match self.working.is_left(&h[..self.first_of_points]) {
            true => f64::INFINITY,
            false => objective,
        })
    }

    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        self.place(x);
        self.set_terms(iterate);
        self.objective
            .gradient_and_hessian(&self.coefficients, &mut self.derivatives)?;
        let (own, of) = (self.derivatives.gradient.len(), &self.derivatives);
        out.gradient.rows_mut(0, own).copy_from(&of.gradient);
        std::mem::swap(&mut out.hessian.matrix, &mut self.derivatives.hessian);
        out.hessian.border.fill(0.0);
        out.hessian.corner.fill(0.0);
        out.gradient.rows_mut(own, self.border()).fill(0.0);
        if let Some(free) = self.free_horizon {
            let of = &self.derivatives.horizon;
            out.hessian.border.set_column(0, &of.mixed);
            out.gradient[own] = of.first + free.weight;
            out.hessian.corner[(0, 0)] = of.second;
        }
        self.add_linear_rows(iterate, self.first_of_border(), out);
        self.add_points(iterate, out)
    }

    fn measure(&self, x: &DVector<f64>) -> f64 {
        match self.free_horizon {
            Some(_) => x[self.derivatives.gradient.len()],
            None => self.horizon,
        }
    }

    fn longest(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64 {
        self.longest_on_border(x, step)
    }

    fn equalities(&self, density: f64) -> Vec<Equality> {
        let (rows, factor) = (&self.objective.cost().rows, self.equality_penalty);
        let mut all = equalities(self.grid, rows, self.search, [density, factor]);
        all.extend(self.rows_of_points(true).map(|at| {
            let first = self.search.point_penalty * density;
            Equality::new(Row { at, weight: 1.0 }, first, factor)
        }));
        all
    }

    fn working_set(&mut self, h: &[f64]) -> Vec<Row> {
        let fixed = self.fixed_ends();
        let rows = &self.objective.cost().rows;
        let mut rows = self.working.list(self.grid, rows, fixed, h);
        let of_points = self.rows_of_points(false);
        let of_border = self.first_of_border()..h.len();
        rows.extend(of_points.chain(of_border).map(|at| Row { at, weight: 1.0 }));
        rows
    }

    fn tighten(&mut self, x: &DVector<f64>, round: usize) -> Result<Tightened> {
        let end = round > 0;
        self.place(x);
        if self.is_coarse(end)? {
            return Ok(Tightened::Coarse);
        }
        let (maxima, violation) = self.maxima(end)?;
        if violation <= self.stage.feasible {
            self.kept.push(x.clone());
        }
        // Exact margins at first; then they only grow, so that the search ends.
        self.set_margins(&maxima, round > self.search.exact_margins);
        Ok(Tightened::Violation(violation))
    }

    fn violation(&mut self, x: &DVector<f64>) -> Result<f64> {
        self.place(x);
        self.is_coarse(true)?;
        Ok(self.maxima(true)?.1)
    }

    fn is_stopped(&self) -> bool {
        self.watch.stopped().is_some()
    }
}
