//! Stiff initial value problems by variable-order, variable-step BDF.
//!
//! [`integrate`] is a thin layer over diffsol's BDF (orders 1 to 5, NDF coefficients, modified
//! Newton iteration with a dense LU factorisation). This layer adds
//! * a dense Jacobian that the system writes itself, and counters of the real calls;
//! * an initial step that suits problems with eigenvalues of any size;
//! * limits that end in a [`Failure`] where diffsol would give up too early or not at all.
//!
//! The same call in the same program gives the same bits: there are no threads, and no clocks but a system's own.

use diffsol::ode_solver::OdeSolverStatistics;
use diffsol::{
    BdfState, ConstantOp, Matrix, NalgebraContext, NalgebraLU, NalgebraMat, NalgebraVec,
    NonLinearOp, NonLinearOpJacobian, OdeBuilder, OdeEquations, OdeEquationsRef, OdeSolverMethod,
    OdeSolverProblem, OdeSolverState, OdeSolverStopReason, Op, UnitCallable, Vector, VectorCommon,
};
use nalgebra::DMatrix;
use std::cell::RefCell;
use std::error::Error;
use std::fmt;

/// Accepted steps after which [`integrate`] gives up.
pub const STEP_LIMIT: usize = 100_000;
/// Newton failures within one step after which it is given up (each shrinks the step to 0.3).
const NEWTON_FAILURE_LIMIT: usize = 80;
/// Error test failures within one step after which it is given up (each at least halves it).
const ERROR_FAILURE_LIMIT: usize = 80;
/// Most a step may grow at once. diffsol's 2 makes the way from 1e-17 to 0.1 needlessly long.
const STEP_GROWTH: f64 = 10.0;
/// Smallest step, relative to the whole interval.
const SMALLEST_STEP: f64 = 1e-30;
/// A state entry larger than this counts as non-finite, so that no norm overflows to a NaN.
const LARGEST_STATE: f64 = 1e150;

/// A system dy/ds = f(s, y) with a dense Jacobian.
pub trait Ode {
    /// Number of entries of y.
    fn dim(&self) -> usize;
    /// Writes f(s, y) to dy. A non-finite entry makes the integrator shorten its step.
    fn rhs(&mut self, s: f64, y: &[f64], dy: &mut [f64]);
    /// Writes df/dy, dim x dim. The matrix is zero on entry.
    fn jacobian(&mut self, s: f64, y: &[f64], jac: &mut DMatrix<f64>);
    /// Asked before each step: a reason to stop there, if there is one.
    fn stop(&mut self) -> Option<String> {
        None
    }
}

/// Local error tolerances, both positive.
///
/// A step is accepted when its local error estimate `e` satisfies
///
/// ```text
/// sqrt(1/n sum_i (e_i / (relative |y_i| + absolute))^2) <= 1
/// ```
///
/// with `y` the state at the start of the step: a weighted root mean square, so one of `n` entries may exceed its own
/// weight by up to `sqrt(n)`. This bounds the error of one step; that of the whole solution is typically one to two orders
/// of magnitude above the tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Tolerance relative to the size of each entry of y.
    pub relative: f64,
    /// Tolerance for entries of y near zero.
    pub absolute: f64,
}

/// What an integration cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Attempts at a step that were thrown away: error too large, or Newton did not converge.
    pub rejected_steps: usize,
    /// Calls of [`Ode::rhs`].
    pub rhs_evaluations: usize,
    /// Calls of [`Ode::jacobian`].
    pub jacobian_evaluations: usize,
    /// LU factorisations of the Newton matrix.
    pub factorisations: usize,
}

/// Where a right-hand side was not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonFinite {
    /// Where it was evaluated.
    pub s: f64,
    /// Index of the first non-finite entry of dy.
    pub entry: usize,
}

/// Why and where an integration ended early.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The last s reached.
    pub s: f64,
    /// The last accepted state, at `s`.
    pub y: Vec<f64>,
    /// The last non-finite right-hand side since the last accepted step, if any.
    pub non_finite: Option<NonFinite>,
    /// What went wrong, in diffsol's words where it is diffsol that gave up.
    pub reason: String,
    /// The cost up to here.
    pub statistics: Statistics,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "integration stopped at s = {}: {}", self.s, self.reason)?;
        if let Some(NonFinite { s, entry }) = self.non_finite {
            write!(f, " (entry {entry} of f not finite at s = {s})")?;
        }
        Ok(())
    }
}

impl Error for Failure {}

/// Integrates from (s0, y0) through all `outputs` (ascending, > s0), calling `observe(s, y)` at
/// each, by variable-order variable-step BDF.
///
/// The last output is the end of the last step, and the system is never evaluated beyond it.
/// Earlier outputs are interpolated and do not influence the steps. An empty `outputs` is no work.
///
/// # Errors
///
/// Invalid input (nothing is evaluated then), an f that is not finite at (s0, y0), a step size that
/// has become too small (f or its Jacobian not finite, y beyond 1e150, a wrong Jacobian), more
/// than [`STEP_LIMIT`] steps, or a system that asks to stop. What was observed until then is valid.
pub fn integrate(
    system: &mut impl Ode,
    s0: f64,
    y0: &[f64],
    outputs: &[f64],
    tolerance: Tolerance,
    observe: &mut dyn FnMut(f64, &[f64]),
) -> Result<Statistics, Failure> {
    let progress = Failure {
        s: s0,
        y: y0.to_vec(),
        non_finite: None,
        reason: String::new(),
        statistics: Statistics::default(),
    };
    let refused = |reason: String| Failure {
        reason,
        ..progress.clone()
    };
    validate(system.dim(), s0, y0, outputs, tolerance)
        .map_err(|reason| refused(format!("invalid input: {reason}")))?;
    let Some(&end) = outputs.last() else {
        return Ok(progress.statistics);
    };
    let mut problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(tolerance.relative)
        .atol([tolerance.absolute])
        .build_from_eqn(Equations {
            core: RefCell::new(Core {
                system,
                progress: progress.clone(),
            }),
            s0,
            end,
            y0,
            context: NalgebraContext::default(),
        })
        .map_err(|e| refused(e.to_string()))?;
    problem.ode_options.max_timestep_growth = Some(STEP_GROWTH);
    problem.ode_options.max_error_test_failures = ERROR_FAILURE_LIMIT;
    let result = advance(&problem, outputs, observe).map_err(|e| e.to_string());
    let progress = problem.eqn.core.into_inner().progress;
    result
        .map(|()| progress.statistics)
        .map_err(|reason| Failure {
            reason: reason + &progress.reason,
            ..progress
        })
}

/// Says what is wrong with the input, if anything.
fn validate(n: usize, s0: f64, y0: &[f64], outputs: &[f64], tol: Tolerance) -> Result<(), String> {
    let positive = |x: f64| x.is_normal() && x > 0.0;
    let span = outputs.last().map_or(1.0, |end| end - s0);
    if n == 0 || n != y0.len() {
        Err(format!("dimension {n}, but {} initial values", y0.len()))
    } else if let Some(i) = y0.iter().position(|y| !reasonable(*y)) {
        Err(format!("initial value {i} is {}", y0[i]))
    } else if !s0.is_finite() || !span.is_finite() {
        Err("the interval is not finite".into())
    } else if !(outputs.iter().all(|s| *s > s0) && outputs.is_sorted_by(|a, b| a < b)) {
        Err("the outputs do not ascend from s0".into())
    } else if !(positive(tol.relative) && positive(tol.absolute)) {
        Err("a tolerance is not positive".into())
    } else {
        Ok(())
    }
}

fn reasonable(y: f64) -> bool {
    y.abs() <= LARGEST_STATE
}

/// Takes the steps. diffsol's time is t = s - s0: small steps at the start then stay exact for any
/// s0, and its test for the stop time, whose margin is relative to t, cannot be overrun (a panic).
fn advance(
    problem: &OdeSolverProblem<Equations>,
    outputs: &[f64],
    observe: &mut dyn FnMut(f64, &[f64]),
) -> Result<(), Box<dyn Error>> {
    let Equations { core, s0, end, .. } = &problem.eqn;
    let span = end - s0;
    let mut state = BdfState::<NalgebraVec<f64>>::new_without_initialise(problem)?;
    if core.borrow().progress.non_finite.is_some() {
        return Err("f is not finite at the initial state".into());
    }
    *state.as_mut().h = initial_step(problem, state.as_ref().y, state.as_ref().dy, span);
    let mut solver = problem.bdf_solver::<NalgebraLU<f64>>(state)?;
    solver.set_stop_time(span)?;
    let mut outputs = outputs.iter().copied().peekable();
    for _ in 0..STEP_LIMIT {
        if let Some(reason) = core.borrow_mut().system.stop() {
            return Err(reason.into());
        }
        // diffsol counts Newton failures over the whole run, and its smallest step is a constant
        let before = solver.state().t;
        let failures = solver.get_statistics().number_of_nonlinear_solver_fails;
        let config = solver.config_mut();
        config.maximum_newton_fails = failures + NEWTON_FAILURE_LIMIT;
        config.minimum_timestep = (SMALLEST_STEP * span).max(f64::EPSILON * before);
        let result = solver.step();
        let (t, y) = (solver.state().t, solver.state().y.inner().as_slice());
        core.borrow_mut()
            .record(problem.eqn.s(t), y, t > before, solver.get_statistics());
        let finished = matches!(result, Ok(OdeSolverStopReason::TstopReached));
        while let Some(s) = outputs.next_if(|s| finished || s - s0 <= t) {
            if s < *end && s - s0 < t {
                observe(s, solver.interpolate(s - s0)?.inner().as_slice());
            } else {
                observe(s, y);
            }
        }
        result?;
        if finished {
            return Ok(());
        }
    }
    Err(format!("not finished after {STEP_LIMIT} steps").into())
}

/// A first step for order 1: its error h^2/2 |y''| is to be a quarter of the tolerance, with
/// y'' = df/ds + J f from one more evaluation of f, a little along the solution. It changes y by at
/// most a tenth (or by the tolerance, near zero) and covers at most a tenth of the interval.
fn initial_step(
    problem: &OdeSolverProblem<Equations>,
    y0: &NalgebraVec<f64>,
    f0: &NalgebraVec<f64>,
    span: f64,
) -> f64 {
    let norm = |v: &NalgebraVec<f64>| v.squared_norm(y0, &problem.atol, problem.rtol).sqrt();
    let (size, slope) = (norm(y0).max(1.0), norm(f0));
    let mut probe = (0.01 * size / slope).min(1e-3 * span);
    let smallest = 10.0 * SMALLEST_STEP * span;
    for _ in 0..8 {
        let mut y1 = y0.clone();
        y1.axpy(probe, f0, 1.0);
        let curvature = norm(&(NonLinearOp::call(&problem.eqn, &y1, probe) - f0)) / probe;
        if !curvature.is_nan() {
            return (0.5 / curvature)
                .sqrt()
                .min((0.1 * size).max(1.0) / slope)
                .min(0.1 * span)
                .max(smallest);
        }
        probe *= 0.1;
    }
    probe.max(smallest)
}

/// The system in diffsol's terms, which are `&self`; hence the `RefCell`.
struct Equations<'a> {
    core: RefCell<Core<'a>>,
    s0: f64,
    end: f64,
    y0: &'a [f64],
    context: NalgebraContext,
}

impl Equations<'_> {
    fn s(&self, t: f64) -> f64 {
        (self.s0 + t).min(self.end)
    }
}

struct Core<'a> {
    system: &'a mut dyn Ode,
    /// What a failure would have to say; `reason` holds a remark about the Jacobian.
    progress: Failure,
}

impl Core<'_> {
    /// Takes note of the outcome of a step.
    fn record(&mut self, s: f64, y: &[f64], accepted: bool, steps: &OdeSolverStatistics) {
        let progress = &mut self.progress;
        if accepted {
            progress.s = s;
            progress.y.copy_from_slice(y);
            progress.non_finite = None;
        }
        progress.statistics.steps = steps.number_of_steps;
        progress.statistics.rejected_steps =
            steps.number_of_error_test_failures + steps.number_of_nonlinear_solver_fails;
        progress.statistics.factorisations = steps.number_of_linear_solver_setups;
    }
}

impl Op for Equations<'_> {
    type T = f64;
    type V = NalgebraVec<f64>;
    type M = NalgebraMat<f64>;
    type C = NalgebraContext;
    fn context(&self) -> &Self::C {
        &self.context
    }
    fn nstates(&self) -> usize {
        self.y0.len()
    }
    fn nout(&self) -> usize {
        self.y0.len()
    }
    fn nparams(&self) -> usize {
        0
    }
}

impl ConstantOp for Equations<'_> {
    fn call_inplace(&self, _t: f64, y: &mut Self::V) {
        y.inner_mut().as_mut_slice().copy_from_slice(self.y0);
    }
}

impl NonLinearOp for Equations<'_> {
    /// The right-hand side. NaN is how diffsol is told of a failure: the Newton iteration then does
    /// not converge. Its remaining iterations come here with a NaN state and stay here.
    fn call_inplace(&self, y: &Self::V, t: f64, dy: &mut Self::V) {
        let core = &mut *self.core.borrow_mut();
        let (y, dy) = (y.inner().as_slice(), dy.inner_mut().as_mut_slice());
        if !y.iter().all(|y| reasonable(*y)) {
            return dy.fill(f64::NAN);
        }
        let s = self.s(t);
        core.system.rhs(s, y, dy);
        core.progress.statistics.rhs_evaluations += 1;
        if let Some(entry) = dy.iter().position(|x| !x.is_finite()) {
            core.progress.non_finite = Some(NonFinite { s, entry });
            dy.fill(f64::NAN);
        }
    }
}

impl NonLinearOpJacobian for Equations<'_> {
    fn jacobian_inplace(&self, y: &Self::V, t: f64, jac: &mut Self::M) {
        let core = &mut *self.core.borrow_mut();
        let (s, jac) = (self.s(t), jac.inner_mut());
        jac.fill(0.0);
        core.system.jacobian(s, y.inner().as_slice(), jac);
        core.progress.statistics.jacobian_evaluations += 1;
        core.progress.reason = match jac.iter().position(|x| !x.is_finite()) {
            Some(_) => format!("; the Jacobian at s = {s} is not finite"),
            None => String::new(),
        };
    }

    /// J v. Only sensitivities and adjoints would need it.
    fn jac_mul_inplace(&self, y: &Self::V, t: f64, v: &Self::V, jv: &mut Self::V) {
        self.jacobian(y, t).gemv(1.0, v, 0.0, jv);
    }
}

impl<'a> OdeEquationsRef<'a> for Equations<'_> {
    type Rhs = &'a Self;
    type Init = &'a Self;
    type Mass = UnitCallable<Self::M>;
    type Root = UnitCallable<Self::M>;
    type Out = UnitCallable<Self::M>;
    type Reset = UnitCallable<Self::M>;
}

impl OdeEquations for Equations<'_> {
    fn rhs(&self) -> &Self {
        self
    }
    fn init(&self) -> &Self {
        self
    }
    fn mass(&self) -> Option<UnitCallable<Self::M>> {
        None
    }
    fn set_params(&mut self, _p: &Self::V) {}
    fn get_params(&self, _p: &mut Self::V) {}
}
