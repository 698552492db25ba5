//! A few iterations on a motion that is replanned while it is followed.

use super::program::Program;
use super::{Candidate, Context, Stage};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::error::{Error, Result};
use crate::motion::Problem;
use crate::nlp::{Iterate, Nlp, Options, Row, State, iterate};
use nalgebra::DVector;

/// The factor by which margins shrink at most from one call to the next. Exact margins oscillate where a maximum is
/// between two points: a row that is violated gets a margin, keeps its bound, loses the margin and is violated again.
const SHRINK: f64 = 0.9;

/// The result of a few iterations.
pub(in crate::direct) struct Iterations {
    /// The number of iterations.
    pub count: usize,
    /// True if further iterations would change the objective by less than the tolerance.
    pub converged: bool,
    /// The decrease of the barrier function from that of the reference, relative to the objective.
    pub gain: f64,
}

/// A few iterations at a time with a fixed barrier parameter, summed over all rows and relative to the objective (Wang
/// and Boyd, *Fast model predictive control using online optimization*, 2010), on candidates in one basis and on one
/// number of points. Its memory is kept.
pub(in crate::direct) struct RealTime<'a, K, P> {
    program: Program<'a, 'a, K, P>,
    state: State,
    options: Options,
    /// The decrease of the objective that is accepted as none.
    tolerance: f64,
    known: Vec<f64>,
    other: Other,
    /// The margins of the call before.
    margins: Vec<f64>,
}

/// A motion with which others are compared.
struct Other {
    x: DVector<f64>,
    f: f64,
    h: Vec<f64>,
    rows: Vec<Row>,
    iterate: Iterate,
}

impl<'a, K: Constraint, P: CostWithControl> RealTime<'a, K, P> {
    /// The iterations for candidates with the basis and the points of this one.
    pub fn new(context: Context<'_, 'a, K, P>, candidate: &Candidate, barrier: f64) -> Result<Self> {
        let settings = context.settings;
        let grid = super::grid(context, &candidate.path.basis, candidate.points);
        let stage = Stage { last: false, ..settings.highest() };
        // The search before chose the points, so there is no finer quadrature.
        let mut program = Program::new(context, candidate, (grid, None), (stage, false));
        let kkt = program.kkt().ok_or_else(|| {
            let condition = "the norm of velocities is not positive definite";
            Error::input("basis", "norm", condition)
        })?;
        let options = Options {
            // The caller ends the search.
            tolerance: 0.0,
            iterations: usize::MAX,
            warm_barrier: barrier,
            first_barrier: barrier,
            last_barrier: barrier,
            penalty: settings.search.planned_penalty,
            ..settings.nlp.clone()
        };
        let x = program.unknowns.vector(candidate);
        let mut state = State::idle(x.clone(), kkt);
        let rows = program.rows();
        program.allocate();
        state.allocate(rows);
        let mut other = Other {
            x,
            f: f64::NAN,
            h: Vec::with_capacity(rows),
            rows: Vec::with_capacity(rows),
            iterate: Iterate::default(),
        };
        other.iterate.allocate(rows);
        Ok(Self {
            program,
            state,
            options,
            tolerance: settings.tolerance,
            known: Vec::with_capacity(rows),
            other,
            margins: Vec::with_capacity(rows),
        })
    }

    /// Takes iterations from a candidate as long as `should_continue` returns true for their number so far. The
    /// reference is a motion between the same ends. If the candidate is the same as in the call before, its margins
    /// shrink slowly.
    pub fn improve(
        &mut self,
        problem: &Problem<'a>,
        candidate: &mut Candidate,
        (reference, is_same): (&Candidate, bool),
        should_continue: &mut dyn FnMut(usize) -> bool,
    ) -> Result<Iterations> {
        let Self { program, state, options, known, other, margins, .. } = self;
        margins.clear();
        margins.extend(program.margins_mut().map(|margin| *margin));
        program.restart(problem, candidate);
        program.restart_kkt(&mut state.kkt);
        program.unknowns.vector_in(candidate, &mut state.x);
        program.tighten(&state.x, &mut state.h, 0)?;
        if is_same {
            for (margin, before) in program.margins_mut().zip(margins) {
                *margin = margin.max(SHRINK * *before);
            }
        }
        let known = program.known_multipliers(candidate, known);
        state.begin(program, known, options)?;
        program.unknowns.vector_in(reference, &mut other.x);
        // A search often begins at the reference, where everything is known.
        let is_known = other.x == state.x;
        if is_known {
            other.f = state.f;
            other.h.clone_from(&state.h);
            other.rows.clone_from(&state.rows);
        }
        let (mut count, mut converged) = (0, false);
        while !converged && should_continue(count) {
            let over = iterate(program, state, options, &mut |_| {})?;
            count += 1;
            // The decrement after a Newton step is of the order of the square of that before.
            converged = over.is_some() || state.progress.stationarity.powi(2) <= self.tolerance;
        }
        program.put_multipliers(&state.iterate, candidate);
        if !is_known {
            other.f = program.value(&other.x, &mut other.h)?;
            program.working_set(&other.h, &mut other.rows);
        }
        let [mut before, mut after] = [other.f, state.f];
        let barrier = state.iterate.barrier;
        for (f, x, h, rows) in
            [(&mut before, &other.x, &other.h, &other.rows), (&mut after, &state.x, &state.h, &state.rows)]
        {
            // With the barrier of the search and the best slacks.
            other.iterate.restart(barrier, Vec::new());
            other.iterate.set_working(rows, h);
            *f += other.iterate.barrier_terms(|row| program.row_measure(x, row));
        }
        program.put(&state.x, candidate);
        Ok(Iterations { count, converged, gain: (before - after) / state.scale() })
    }
}
