//! A few iterations on a motion that is replanned while it is followed.

use super::program::Program;
use super::{Candidate, Context, Multipliers, Stage};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::error::{Error, Result};
use crate::nlp::{Iterate, Nlp, Options, State, iterate};
use nalgebra::DVector;

/// The result of a few iterations.
pub(in crate::direct) struct Iterations {
    /// The number of iterations.
    pub count: usize,
    /// True if further iterations would change the objective by less than the tolerance.
    pub converged: bool,
    /// The decrease of the barrier function from that of the reference, relative to the objective.
    pub gain: f64,
}

/// Takes iterations with a fixed barrier parameter, summed over all rows and relative to the objective, from a
/// candidate in its basis and on its number of points, as long as `goes_on` returns true for their number so far
/// (Wang and Boyd, *Fast model predictive control using online optimization*, 2010). The reference is a motion between
/// the same ends.
pub(in crate::direct) fn improve<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    candidate: &mut Candidate,
    reference: &Candidate,
    barrier: f64,
    goes_on: &mut dyn FnMut(usize) -> bool,
) -> Result<Iterations> {
    let Context { rows, settings, .. } = context;
    let grid = super::grid(context, &candidate.path.basis, candidate.points);
    let stage = Stage {
        last: false,
        ..settings.highest()
    };
    // The search before chose the points, so there is no finer quadrature.
    let mut program = Program::new(context, candidate, [&*grid, &*grid], stage, false);
    let kkt = program.kkt().ok_or_else(|| {
        let condition = "the norm of velocities is not positive definite";
        Error::input("basis", "norm", condition)
    })?;
    let x = program.unknowns(candidate);
    program.tighten(&x, 0)?;
    let known = program.known_multipliers(candidate);
    let options = Options {
        // The loop below ends the search.
        tolerance: 0.0,
        iterations: usize::MAX,
        warm_barrier: barrier,
        first_barrier: barrier,
        last_barrier: barrier,
        penalty: settings.search.planned_penalty,
        ..settings.nlp.clone()
    };
    let mut state = State::new(&mut program, x, known.as_deref(), kkt, &options)?;
    let other = program.unknowns(reference);
    // A search often begins at the reference, where all is known.
    let known = (other == state.x).then(|| (state.f, state.h.clone()));
    let (mut count, mut converged) = (0, false);
    while !converged && goes_on(count) {
        let over = iterate(&mut program, &mut state, &options, &mut |_| {})?;
        count += 1;
        // The decrement after a Newton step is of the order of the square of that before.
        converged = over.is_some() || state.progress.stationarity.powi(2) <= settings.tolerance;
    }
    let all = state.iterate.multipliers(program.margins.len());
    candidate.multipliers = Multipliers::new(&grid, rows, &all, Vec::new());
    let (f, h) = match known {
        Some(known) => known,
        None => {
            let mut h = Vec::new();
            (program.value(&other, &mut h)?, h)
        }
    };
    let before = barrier_function(&mut program, (&other, f, &h), &state);
    let after = barrier_function(&mut program, (&state.x, state.f, &state.h), &state);
    (candidate.path.coefficients, candidate.horizon, _) = program.curve(&state.x);
    Ok(Iterations {
        count,
        converged,
        gain: (before - after) / state.scale(),
    })
}

/// The barrier function of a state at unknowns with an objective and rows, with the best slacks.
fn barrier_function<P: Nlp>(
    program: &mut P,
    (x, f, h): (&DVector<f64>, f64, &[f64]),
    state: &State,
) -> f64 {
    let mut iterate = Iterate::new(state.iterate.barrier, Vec::new());
    iterate.set_working(&program.working_set(h), h);
    f + program.measure(x) * iterate.barrier_terms(h)
}
