//! The nonlinear program of a curve in the state.

use super::free::Free;
use crate::constraint::Constraint;
use crate::cost::{CostWithControl, MIN_COST};
use crate::direct::{Integrand, SearchOptions, Stage, WorkingSet, equalities};
use crate::error::Result;
use crate::flow::weak::WithSlip;
use crate::motion::{Path, Problem, Watch, violations};
use crate::nlp::{Equality, Iterate, Kkt, Nlp, Row, Tightened};
use crate::transcription::{Grid, Objective, Rows};
use nalgebra::{DMatrix, DVector};

/// The weight of a slip among the violations of rows.
const SLIP: f64 = 10.0;

/// The nonlinear program of a curve in the state: the unknowns are its free coefficients.
///
/// The rows are those of the constraints at the points of the quadrature, with a margin per row of the constraints. The
/// slip is part of the action, with the penalty `k` and, unless that is all, multipliers at all points.
pub(super) struct Program<'g, 'a, K, P> {
    problem: &'g Problem<'a>,
    pub free: Free<'g, WithSlip<Integrand<'a, K, P>>>,
    /// The same without rows by a finer quadrature, with the relative difference.
    finer: Objective<'g, f64, WithSlip<P>>,
    pub quadrature_error: f64,
    /// The action by the finer quadrature, without the terms of multipliers.
    pub exact: f64,
    /// True if the slip has multipliers.
    duals: bool,
    /// The largest slip at the last check.
    pub slip: f64,
    /// The number of updates of the multipliers.
    pub updates: usize,
    /// The margin of each row of the constraints.
    margins: Vec<f64>,
    working: WorkingSet,
    search: &'g SearchOptions,
    stage: Stage,
    /// True if the number of points may increase.
    refinable: bool,
}

impl<'g, 'a, K: Constraint, P: CostWithControl> Program<'g, 'a, K, P> {
    pub fn new(
        (problem, watch): (&'g Problem<'a>, &'g Watch),
        rows: &Rows<'a, K, P>,
        [grid, finer]: [&'g Grid<f64>; 2],
        path: Path,
        (k, duals): (f64, bool),
        (stage, refinable): (Stage, bool),
        search: &'g SearchOptions,
    ) -> Self {
        let n = problem.model().dof();
        let points = grid.times.len();
        let integrand = Integrand::new(rows.clone(), points);
        let cost = WithSlip::new(integrand, k, n, points);
        let plain = WithSlip::new(rows.cost.clone(), k, n, finer.times.len());
        let margins = rows.attributes().equalities.iter();
        let mut program = Self {
            problem,
            free: Free::new(grid, cost, path, problem.horizon(), watch),
            finer: Objective::new(finer, plain, 2 * n),
            quadrature_error: f64::INFINITY,
            exact: f64::NAN,
            duals,
            slip: 0.0,
            updates: 0,
            margins: margins.map(|equality| if *equality { 0.0 } else { search.reserve }).collect(),
            working: WorkingSet::new(problem, rows, search),
            search,
            stage,
            refinable,
        };
        program.finer.set_horizon(problem.horizon());
        program
    }

    /// The action of an iterate at its unknowns, with the terms of the equalities.
    pub fn action(&mut self, x: &DVector<f64>, iterate: &Iterate) -> Result<f64> {
        let mut h = Vec::new();
        let action = self.value(x, &mut h)?;
        let held = iterate.equalities.iter();
        let terms = held.map(|held| {
            let Row { at, weight, .. } = held.row;
            weight * held.term(h[at]).cost
        });
        Ok(action + self.problem.horizon() * terms.sum::<f64>())
    }

    /// Passes the terms of the rows to the integrand.
    fn set_terms(&mut self, iterate: &Iterate) {
        let (integrand, margins) = (&mut self.free.objective.cost_mut().cost, &self.margins);
        let count = integrand.rows.count();
        for terms in &mut integrand.terms {
            terms.clear();
        }
        for state in &iterate.working {
            let at = state.row.at;
            let term = iterate.term(state, integrand.h[at] + margins[at % count]);
            integrand.terms[at / count].push((at % count, term));
        }
        for equality in &iterate.equalities {
            let at = equality.row.at;
            // Their rule has a small share of the quadrature.
            let term = equality.term(integrand.h[at]).times(1.0 / Grid::COLLOCATED);
            integrand.terms[at / count].push((at % count, term));
        }
    }

    /// Returns true if a finer quadrature gives a different action; the tolerance is larger before the `end`.
    fn is_coarse(&mut self, end: bool) -> Result<bool> {
        let none = DMatrix::zeros(self.problem.model().dof(), 0);
        let multipliers = std::mem::replace(self.slip_multipliers(), none);
        let action = self.free.action()?;
        *self.slip_multipliers() = multipliers;
        self.exact = self.finer.value(&self.free.path.coefficients)?;
        self.quadrature_error = (self.exact - action).abs() / self.exact.abs().max(MIN_COST);
        let on_the_way = if end { 0.0 } else { self.search.quadrature_on_the_way };
        Ok(self.refinable && self.quadrature_error > self.stage.quadrature_tolerance.max(on_the_way))
    }

    /// The multipliers of the slip at all points, `N` by their number; no columns without them.
    pub fn slip_multipliers(&mut self) -> &mut DMatrix<f64> {
        &mut self.free.objective.cost_mut().multipliers
    }

    /// Updates the multipliers of the slip, $\lambda \leftarrow \lambda + 2 k e$, if it is not small enough. Returns the
    /// slip as a violation.
    fn update_slip(&mut self) -> f64 {
        self.slip = self.free.objective.cost().slips().amax();
        if !self.duals {
            return 0.0;
        }
        let violation = SLIP * self.slip;
        if violation > self.stage.feasible {
            let lagrangian = self.free.objective.cost_mut();
            let by = lagrangian.slips() * (2.0 * lagrangian.k);
            if lagrangian.multipliers.ncols() == 0 {
                lagrangian.multipliers = by;
            } else {
                lagrangian.multipliers += by;
            }
        }
        violation
    }

    /// The largest violation of a row at the points, in its unit.
    fn at_points(&self) -> f64 {
        let integrand = &self.free.objective.cost().cost;
        let attributes = integrand.rows.attributes();
        let mut largest = 0.0_f64;
        for (g, h) in integrand.h.chunks_exact(attributes.scales.len().max(1)).enumerate() {
            let collocated = self.free.grid.collocated[g % self.free.grid.points()];
            for (row, h) in h.iter().enumerate() {
                let by = match attributes.equalities[row] {
                    equality if equality != collocated => 0.0,
                    true => h.abs(),
                    false => *h,
                };
                largest = largest.max(by * attributes.units[row]);
            }
        }
        largest
    }

    /// The largest violation of a row between the points, in its unit. In a `round` of tightening margins become the
    /// excess of a row between the points over those at them; after some rounds they only grow. Equalities in the
    /// control are excluded, because no polynomial satisfies them everywhere.
    fn between_points(&mut self, round: Option<usize>) -> Result<f64> {
        let curve = self.free.path.curve_of_states(self.problem.horizon())?;
        let integrand = &self.free.objective.cost().cost;
        let rows = &integrand.rows;
        if rows.count() == 0 {
            return Ok(0.0);
        }
        let times = self.search.last_scan.div_ceil(curve.segments());
        let (constraints, attributes) = (&*rows.constraints, rows.attributes());
        let mut largest = 0.0_f64;
        for found in violations(self.problem.model(), &curve, constraints, times)? {
            let row = found.row;
            if attributes.equalities[row] {
                continue;
            }
            let by = found.by / attributes.units[row];
            let at_points = integrand.h.iter().skip(row).step_by(rows.count());
            let highest = at_points.copied().fold(f64::NEG_INFINITY, f64::max);
            match round {
                Some(round) if round <= self.search.exact_margins => {
                    self.margins[row] = self.search.reserve + (by - highest).max(0.0);
                }
                Some(_) if by > 0.0 => self.margins[row] += 2.0 * by + self.search.reserve,
                _ => (),
            }
            largest = largest.max(found.by);
        }
        Ok(largest)
    }

    /// The largest violation of a row at the points, and at the end between them too.
    fn look(&mut self, end: bool, round: Option<usize>) -> Result<f64> {
        let mut violation = self.at_points();
        if end && self.stage.last {
            violation = violation.max(self.between_points(round)?);
        }
        Ok(violation)
    }

    /// The largest violation of a row at `x`, between the points too, in its unit.
    pub fn violation(&mut self, x: &DVector<f64>) -> Result<f64> {
        self.free.place(x);
        self.is_coarse(true)?;
        self.slip = self.free.objective.cost().slips().amax();
        self.look(true, None)
    }
}

/// The gradients of the equalities in the state and its rates at points; see [`Rows::equality_gradients`].
fn equality_gradients<K: Constraint, P: CostWithControl>(
    lagrangian: &mut WithSlip<Integrand<'_, K, P>>,
    states: &DMatrix<f64>,
) -> Result<Vec<DMatrix<f64>>> {
    let (n, columns) = (states.nrows() / 2, states.ncols());
    // The places of q, v and a in the state and its rates.
    let place = |i: usize, column: usize| match column % 3 {
        0 => (i, column),
        _ => (n + i, column - 1),
    };
    let own = DMatrix::from_fn(n, columns, |i, column| states[place(i, column)]);
    let all = lagrangian.cost.rows.equality_gradients(&own)?;
    let in_states = all.into_iter().map(|of| {
        let mut gradients = DMatrix::zeros(2 * n, columns);
        for column in 0..columns {
            for i in 0..n {
                gradients[place(i, column)] = of[(i, column)];
            }
        }
        gradients
    });
    Ok(in_states.collect())
}

impl<K: Constraint, P: CostWithControl> Nlp for Program<'_, '_, K, P> {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        self.free.place(x);
        let cost = self.free.action()?;
        let lagrangian = self.free.objective.cost();
        let rows = lagrangian.cost.h.iter().zip(self.margins.iter().cycle());
        h.clear();
        h.extend(rows.map(|(h, margin)| h + margin));
        Ok(if self.working.is_left(&self.free.objective.cost().cost.rows, h) { f64::INFINITY } else { cost })
    }

    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        self.free.place(x);
        self.set_terms(iterate);
        self.free.derive(out)?;
        let Kkt { hessian, equalities, .. } = out;
        equalities.clear();
        let Free { objective, path, .. } = &mut self.free;
        objective.equality_gradients(&path.coefficients, equality_gradients, &mut |segment, gradient, _| {
            equalities.push(hessian, segment, gradient);
        })
    }

    fn measure(&self, _: &DVector<f64>) -> f64 {
        self.problem.horizon()
    }

    fn equalities(&self) -> Vec<Equality> {
        equalities(self.free.grid, &self.free.objective.cost().cost.rows)
    }

    fn working_set(&mut self, h: &[f64], all: &mut Vec<Row>) {
        let rows = &mut self.free.objective.cost_mut().cost.rows;
        self.working.list(self.free.grid, rows, [true; 2], h, all);
    }

    fn tighten(&mut self, x: &DVector<f64>, _: &mut Vec<f64>, round: usize) -> Result<Tightened> {
        let end = round > 0;
        self.free.place(x);
        if self.is_coarse(end)? {
            return Ok(Tightened::QuadratureTooCoarse);
        }
        self.updates += 1;
        let violation = self.look(end, Some(round))?;
        Ok(Tightened::Violation(violation.max(self.update_slip())))
    }

    fn is_stopped(&self) -> bool {
        self.free.is_stopped()
    }
}
