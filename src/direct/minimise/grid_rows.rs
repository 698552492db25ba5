//! The block of the rows at the points of the quadrature.

use super::integrand::Integrand;
use super::margins::{beside, share_in_phase};
use super::unknowns::Unknowns;
use super::working_set::{WorkingSet, equalities};
use super::{Candidate, Context, Stage};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::direct::SearchOptions;
use crate::error::Result;
use crate::motion::Problem;
use crate::nlp::{Equality, Iterate, Row};
use crate::transcription::{Grid, Horizons, Objective, Scan, ScanWorkspace};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The running cost and the rows at the points of the quadrature, with margins by which rows are larger near a point
/// than at it. They are the first of all rows.
pub(super) struct GridRows<'g, 'a: 'g, K, P> {
    pub objective: Objective<'g, f64, Integrand<'a, K, P>>,
    /// The coefficients and the horizons at which the objective and the rows were evaluated last, and the cost.
    evaluated_at: (DMatrix<f64>, Horizons<f64>),
    evaluated: Option<f64>,
    /// The times between the points at which rows are evaluated, during the search and at its end.
    scans: [Arc<Scan>; 2],
    /// The last check between the points, with the largest deviation of an equality of the state, in its unit.
    pub scanned: ScanWorkspace,
    pub deviation: f64,
    pub margins: Vec<f64>,
    /// The margin of each row against rounding.
    pub reserves: Vec<f64>,
    working: WorkingSet,
    /// The rows that are at their bounds at the start, and at the end.
    pub at_bound: [Vec<usize>; 2],
}

impl<'g, 'a, K: Constraint, P: CostWithControl> GridRows<'g, 'a, K, P> {
    /// The rows of a candidate, without margins.
    pub fn new(context: Context<'_, 'a, K, P>, candidate: &Candidate, grid: &Arc<Grid<f64>>, stage: Stage) -> Self {
        let Context { problem, rows, settings, .. } = context;
        let (search, path) = (&settings.search, &candidate.path);
        let looks = search.scan * grid.points();
        let last = if stage.last { looks.max(search.last_scan / path.basis.segments()) } else { looks };
        let points = grid.points() * grid.segments;
        let integrand = Integrand::new(rows.clone(), points);
        let mut block = Self {
            objective: Objective::new(grid.clone(), integrand, problem.model().dof()),
            evaluated_at: (path.coefficients.clone(), candidate.horizons.clone()),
            evaluated: None,
            scans: [looks, last].map(|times| context.grids.scan(&path.basis, times)),
            scanned: ScanWorkspace::default(),
            deviation: 0.0,
            margins: vec![0.0; points * rows.count()],
            reserves: Vec::new(),
            working: WorkingSet::new(problem, rows, search),
            at_bound: Default::default(),
        };
        let rows = &mut block.objective.cost_mut().rows;
        block.working.begin_lists(grid, rows, search);
        block
    }

    /// Begins anew at another candidate in the same basis, whose unknowns are set.
    pub fn restart(&mut self, problem: &Problem<'_>, unknowns: &Unknowns, search: &SearchOptions) {
        self.evaluated = None;
        self.objective.set_rates(&unknowns.rates);
        let rows = &mut self.objective.cost_mut().rows;
        rows.near.release();
        if self.working.restart(problem, rows, search) {
            self.working.begin_lists(&unknowns.grid, rows, search);
        }
        self.margins.fill(0.0);
    }

    /// Allocates memory for a working set of all rows.
    pub fn allocate(&mut self) {
        let integrand = self.objective.cost_mut();
        let count = integrand.rows.count();
        for terms in &mut integrand.terms {
            terms.reserve(count);
        }
        integrand.rows.allocate();
        self.working.allocate(self.margins.len());
    }

    /// Returns true if cost and rows were last evaluated at these unknowns.
    fn is_evaluated(&self, unknowns: &Unknowns) -> bool {
        let (coefficients, horizons) = &self.evaluated_at;
        (coefficients, horizons) == (&unknowns.coefficients, &unknowns.horizons)
    }

    /// Evaluates the cost and the rows, unless that was done at the same unknowns last.
    pub fn cost(&mut self, unknowns: &Unknowns) -> Result<f64> {
        if let Some(cost) = self.evaluated.filter(|_| self.is_evaluated(unknowns)) {
            return Ok(cost);
        }
        let cost = self.objective.value(&unknowns.coefficients)?;
        let (coefficients, horizons) = &mut self.evaluated_at;
        coefficients.copy_from(&unknowns.coefficients);
        horizons.assign(&unknowns.horizons);
        self.evaluated = Some(cost);
        Ok(cost)
    }

    /// Prepares derivatives at the unknowns: passes the terms of the rows to the integrand.
    pub fn set_terms(&mut self, iterate: &Iterate) {
        let (integrand, margins) = (self.objective.cost_mut(), &self.margins);
        for terms in &mut integrand.terms {
            terms.clear();
        }
        let (count, all) = (integrand.rows.count(), margins.len());
        for state in iterate.working.iter().filter(|of| of.row.at < all) {
            let at = state.row.at;
            let term = iterate.term(state, integrand.h[at] + margins[at]);
            integrand.terms[at / count].push((at % count, term));
        }
        let held = iterate.equalities.iter();
        for equality in held.filter(|held| held.row.at < all) {
            let at = equality.row.at;
            // Their rule has a small share of the quadrature.
            let term = equality.term(integrand.h[at]).times(1.0 / Grid::COLLOCATED);
            integrand.terms[at / count].push((at % count, term));
        }
    }

    /// Puts the values of the rows with their margins at the beginning of `h`.
    pub fn values(&self, h: &mut Vec<f64>) {
        self.objective.cost().with_margins(&self.margins, h);
    }

    /// Returns true if a clearance outside the working set is violated, for the values `h` of the rows.
    pub fn is_left(&self, h: &[f64]) -> bool {
        self.working.is_left(&self.objective.cost().rows, &h[..self.margins.len()])
    }

    /// Lists the inequalities of the working set in `all`, for the values `h` of the rows.
    pub fn list(&mut self, unknowns: &Unknowns, h: &[f64], all: &mut Vec<Row>) {
        let rows = &mut self.objective.cost_mut().rows;
        self.working.list(&unknowns.grid, rows, unknowns.fixed_ends(), h, all);
    }

    /// The equalities.
    pub fn equalities(&self, grid: &Grid<f64>) -> Vec<Equality> {
        equalities(grid, &self.objective.cost().rows)
    }

    /// Calls a function for each equality, in the order of their rows, with its segment, its gradient in the unknown
    /// coefficients, and its derivative in the horizon of the part of the segment.
    pub fn equality_gradients(
        &mut self,
        unknowns: &Unknowns,
        each: &mut dyn FnMut(usize, &DVector<f64>, f64),
    ) -> Result<()> {
        let at_points = |integrand: &mut Integrand<'a, K, P>, states: &_| integrand.rows.equality_gradients(states);
        self.objective.equality_gradients(&unknowns.coefficients, at_points, each)
    }

    /// Finds the local maxima of the rows between the points above `floor`; returns the largest violation between and
    /// at the points, in its unit.
    pub fn maxima(&mut self, unknowns: &Unknowns, end: bool, floor: f64) -> Result<f64> {
        let scan = self.scans[usize::from(end)].clone();
        let (horizons, coefficients) = (&unknowns.horizons, &unknowns.coefficients);
        let rows = &mut self.objective.cost_mut().rows;
        self.deviation = scan.maxima(rows, coefficients, horizons, floor, &mut self.scanned)?;
        self.evaluate_beside(unknowns)?;
        let (integrand, grid) = (self.objective.cost(), &unknowns.grid);
        let attributes = integrand.rows.attributes();
        let (units, equalities) = (&attributes.units, &attributes.equalities);
        let maxima = self.scanned.found.iter();
        let highest = maxima.map(|maximum| maximum.height * units[maximum.row]);
        let mut largest = highest.fold(0.0, f64::max);
        let count = integrand.rows.count();
        for (g, h) in integrand.h.chunks_exact(count.max(1)).enumerate() {
            if grid.collocated[g % grid.points()] {
                for (row, h) in h.iter().enumerate().filter(|(row, _)| equalities[*row]) {
                    largest = largest.max(h.abs() * units[row]);
                }
            }
        }
        Ok(largest)
    }

    /// Evaluates the rows beside their maxima at the points where they were far.
    fn evaluate_beside(&mut self, unknowns: &Unknowns) -> Result<()> {
        let near = &mut self.objective.cost_mut().rows.near;
        for maximum in &self.scanned.found {
            for g in beside(&unknowns.grid, maximum).into_iter().flatten() {
                if near.hold(g, maximum.row) {
                    self.evaluated = None;
                }
            }
        }
        self.cost(unknowns).map(|_| ())
    }

    /// Sets the margin of each row against rounding: at most the distance of a fixed start or end from the bound, as no
    /// motion has a larger distance right beside that start or end. A larger margin would be a violation that no
    /// penalty removes.
    pub fn set_reserves(&mut self, unknowns: &Unknowns, search: &SearchOptions, feasible: f64) {
        let (fixed, integrand) = (unknowns.fixed_ends(), self.objective.cost());
        let rows = &integrand.rows;
        let (states, attributes) = (rows.states(), rows.attributes());
        let with_ends = unknowns.grid.times[0] == 0.0;
        let last = integrand.h.len() - rows.count();
        let reserve = |row: usize| {
            if attributes.equalities[row] {
                return 0.0;
            }
            // The foot of a phase has none at the ends of its phase.
            if rows.is_of_phase(row) {
                return search.reserve;
            }
            let ends = [row, last + row].into_iter().zip(fixed);
            let ends = ends.filter(|(_, fixed)| *fixed && with_ends && row < states);
            let distances = ends.map(|(at, _)| -integrand.h[at]);
            // An end that is outside by more than is accepted does not widen its bound.
            let least = -feasible / attributes.units[row];
            let distances = distances.filter(|distance| *distance >= least);
            distances.fold(search.reserve, f64::min)
        };
        self.reserves.clear();
        self.reserves.extend((0..rows.count()).map(reserve));
    }

    /// Sets the margins to those against rounding.
    pub fn reserve(&mut self, grid: &Grid<f64>) {
        for (margin, of_row) in self.margins.iter_mut().zip(self.reserves.iter().cycle()) {
            *margin = *of_row;
        }
        let rows = &self.objective.cost().rows;
        let (count, phases) = (rows.count(), rows.cost.phases());
        for phase in &rows.constraints.stage.phases {
            let points = self.margins.chunks_exact_mut(count).zip(&grid.times);
            for (margins, time) in points {
                for margin in &mut margins[phase.rows.clone()] {
                    *margin *= share_in_phase(phases, *time);
                }
            }
        }
    }
}
