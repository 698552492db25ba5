//! The nonlinear program of a curve in a basis.

use super::goal_rows::GoalRows;
use super::integrand::Integrand;
use super::working_set::{WorkingSet, equalities};
use super::{Candidate, Context, Stage};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::curve::Basis;
use crate::direct::{FreeHorizon, SearchOptions};
use crate::error::Result;
use crate::motion::Watch;
use crate::nlp::{Bordered, Equality, Iterate, Kkt, Nlp, Row, RowState, Term, Tightened};
use crate::transcription::{Derivatives, Objective};
use crate::transcription::{Grid, Scan};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The nonlinear program of a curve in a basis: the unknowns are its free coefficients, then the horizon if it is free.
///
/// The rows are those of the constraints at the points of the quadrature, with margins $m_j \ge 0$ by which they are
/// larger near a point than at it; then those of a goal that is a set; then the two bounds of a free horizon.
pub(super) struct Program<'g, 'a, K, P> {
    pub(super) grid: &'g Grid<f64>,
    /// The times between the points at which rows are evaluated, during the search and at its end.
    pub(super) scans: [Arc<Scan>; 2],
    pub(super) objective: Objective<'g, f64, Integrand<'a, K, P>>,
    /// The cost alone by a finer quadrature, with the cost of the last evaluation and its relative difference.
    pub(super) finer: Objective<'g, f64, P>,
    pub finer_cost: [f64; 2],
    pub(super) derivatives: Derivatives<f64>,
    /// The coefficients, those of the boundary conditions included.
    pub(super) coefficients: DMatrix<f64>,
    pub(super) basis: Basis,
    rates: DMatrix<f64>,
    pub(super) horizon: f64,
    pub(super) free_horizon: Option<FreeHorizon>,
    pub(super) goal: GoalRows<'g>,
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
        let bounds = if free_horizon.is_some() { 2 } else { 0 };
        let goal = goal.map_or(&[][..], |goal| &goal.alternatives[*alternative]);
        let goal = GoalRows::new(problem.model(), goal, points * rows.count());
        let count = goal.range().end + bounds;
        let mut program = Self {
            scans: [looks, last].map(|times| grids.scan(basis, times)),
            finer: Objective::new(finer, rows.cost.clone(), n),
            finer_cost: [f64::NAN; 2],
            derivatives: Derivatives::new(grid, n),
            coefficients: path.coefficients.clone(),
            rates,
            basis: basis.clone(),
            horizon: *horizon,
            free_horizon,
            goal,
            margins: vec![0.0; count],
            working: WorkingSet::new(problem, rows, search),
            refinable,
            lagrangian: false,
            kept: Vec::new(),
            grid,
            objective,
            stage,
            search,
            equality_penalty: 1.0,
            watch,
        };
        program.reserve();
        program
    }

    /// The unknowns of a curve in the basis.
    pub fn unknowns(&self, Candidate { path, horizon, .. }: &Candidate) -> DVector<f64> {
        let horizon = self.free_horizon.map(|_| *horizon);
        let own = self.derivatives.gradient.len();
        let free = self.grid.free.iter();
        let all =
            free.flat_map(|function| path.coefficients.column(*function).into_iter().copied());
        DVector::from_iterator(own + usize::from(horizon.is_some()), all.chain(horizon))
    }

    /// The coefficients and the horizon of unknowns.
    pub fn curve(&mut self, x: &DVector<f64>) -> (DMatrix<f64>, f64) {
        self.place(x);
        (self.coefficients.clone(), self.horizon)
    }

    /// Sets coefficients and horizon.
    fn place(&mut self, x: &DVector<f64>) {
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
        self.objective.set_horizon(self.horizon);
    }

    /// The norm of steps: the mean square of the velocities in normalised time, and the relative change of the horizon.
    pub fn kkt(&self) -> Option<Kkt> {
        let matrix = self.objective.gram();
        let zeros = DVector::zeros(matrix.order());
        let corner = self.horizon.powi(-2);
        let border = self.free_horizon.map(|_| (zeros, corner));
        Kkt::new(Bordered { matrix, border })
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
        if let Some(of) = self.of_goal(iterate)? {
            of.add_hessian(self.horizon, self.grid, &mut self.derivatives.hessian);
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
        let first = self.goal.first;
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

    /// The values of the two bounds of a free horizon, relative to the initial one.
    pub(super) fn bounds(&self) -> [f64; 2] {
        let Some(free) = self.free_horizon else {
            return [0.0; 2];
        };
        [
            (free.shortest - self.horizon) / free.longest,
            (self.horizon - free.longest) / free.longest,
        ]
    }
}

impl<K: Constraint, P: CostWithControl> Nlp for Program<'_, '_, K, P> {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        self.place(x);
        let cost = self.objective.value(&self.coefficients)?;
        self.evaluate_goal()?;
        let bounds = self.bounds();
        let rows = self.objective.cost().h.iter().chain(&self.goal.h);
        h.clear();
        h.extend(rows.zip(&self.margins).map(|(h, margin)| h + margin));
        let mut objective = cost;
        if let Some(free) = self.free_horizon {
            h.extend(bounds);
            if self.horizon <= 0.0 {
                return Ok(f64::INFINITY);
            }
            objective += free.weight * self.horizon;
        }
        Ok(match self.working.is_left(&h[..self.goal.first]) {
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
        let (bounds, horizon) = (self.bounds(), self.horizon);
        if let (Some(free), Some((border, corner))) = (self.free_horizon, &mut out.hessian.border) {
            let of = &self.derivatives.horizon;
            border.copy_from(&of.mixed);
            out.gradient[own] = of.first + free.weight;
            *corner = of.second;
            let first = self.margins.len() - 2;
            for state in iterate.working.iter().filter(|of| of.row.at >= first) {
                let (row, side) = (state.row, state.row.at - first);
                let slope = [-1.0, 1.0][side] / free.longest;
                let term = self.term(iterate, state, bounds[side]);
                out.gradient[own] +=
                    horizon * row.weight * term.slope * slope + row.weight * term.cost;
                *corner += horizon * row.weight * term.curvature * slope * slope;
            }
        }
        self.add_goal(iterate, out)
    }

    fn measure(&self, x: &DVector<f64>) -> f64 {
        match self.free_horizon {
            Some(_) => x[x.len() - 1],
            None => self.horizon,
        }
    }

    fn longest(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64 {
        match self.free_horizon {
            Some(_) => (0.5 * x[x.len() - 1] / step[x.len() - 1].abs()).min(1.0),
            None => 1.0,
        }
    }

    fn equalities(&self, density: f64) -> Vec<Equality> {
        let (rows, factor) = (&self.objective.cost().rows, self.equality_penalty);
        let mut all = equalities(self.grid, rows, self.search, [density, factor]);
        let of_goal = self.goal.range().zip(&self.goal.equalities);
        all.extend(of_goal.filter(|(_, held)| **held).map(|(at, _)| {
            let first = self.search.equality_penalty * density;
            Equality::new(Row { at, weight: 1.0 }, first, factor)
        }));
        all
    }

    fn working_set(&mut self, h: &[f64]) -> Vec<Row> {
        let ends = self.basis.continuity();
        let free = ends.free_final_velocity || ends.free_final_position;
        let rows = &self.objective.cost().rows;
        let mut rows = self.working.list(self.grid, rows, [true, !free], h);
        let of_goal = self.goal.range().zip(&self.goal.equalities);
        let of_goal = of_goal.filter_map(|(at, held)| (!held).then_some(at));
        let bounds = self.goal.range().end..h.len();
        rows.extend(of_goal.chain(bounds).map(|at| Row { at, weight: 1.0 }));
        rows
    }

    fn tighten(&mut self, x: &DVector<f64>, round: usize) -> Result<Tightened> {
        let end = round > 0;
        self.place(x);
        if self.is_coarse(end)? {
            return Ok(Tightened::Coarse);
        }
        let (peaks, violation) = self.peaks(end)?;
        if violation <= self.stage.feasible {
            self.kept.push(x.clone());
        }
        // Exact margins at first; then they only grow, so that the search ends.
        self.set_margins(&peaks, round > self.search.exact_margins);
        Ok(Tightened::Violation(violation))
    }

    fn violation(&mut self, x: &DVector<f64>) -> Result<f64> {
        self.place(x);
        self.is_coarse(true)?;
        Ok(self.peaks(true)?.1)
    }

    fn is_stopped(&self) -> bool {
        self.watch.stopped().is_some()
    }
}
