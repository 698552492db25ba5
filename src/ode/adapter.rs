//! The common layer of the integrators from diffsol.
//!
//! diffsol's methods include a modified Newton iteration and a dense LU factorisation. This layer adds
//! * a dense Jacobian that the system writes itself, and exact counters of calls;
//! * an initial step for problems with eigenvalues of any size;
//! * limits that end in a [`Failure`] in cases where diffsol would stop too early or not at all.

use super::{Failure, Integrator, NonFinite, Ode, Statistics, Tolerance};
use diffsol::error::DiffsolError;
use diffsol::ode_solver::OdeSolverStatistics;
use diffsol::{
    ConstantOp, Matrix, NalgebraContext, NalgebraMat, NalgebraVec, NonLinearOp, NonLinearOpJacobian, OdeBuilder,
    OdeEquations, OdeEquationsRef, OdeSolverConfig, OdeSolverMethod, OdeSolverProblem, OdeSolverState,
    OdeSolverStopReason, Op, UnitCallable, Vector, VectorCommon,
};
use std::cell::RefCell;
use std::error::Error;

/// The number of accepted steps after which the integrators give up.
pub const STEP_LIMIT: usize = 100_000;
/// The number of Newton failures after which a step is given up (each shrinks the step to 0.3).
const NEWTON_FAILURE_LIMIT: usize = 80;
/// The number of error test failures after which a step is given up (each at least halves it).
const ERROR_FAILURE_LIMIT: usize = 80;
/// The largest growth factor of a step. With diffsol's 2 the steps from 1e-17 to 0.1 would be needlessly many.
const STEP_GROWTH: f64 = 10.0;
/// The smallest step, relative to the whole interval.
const MIN_STEP: f64 = 1e-30;
/// The size from which a state entry counts as non-finite, so that no norm overflows to NaN.
const MAX_STATE: f64 = 1e150;

/// The problem in diffsol's form.
pub(super) type Problem<'a> = OdeSolverProblem<Equations<'a>>;

/// The state of a solver.
pub(super) type State<'p, 'a, M> = <<M as Method>::Solver<'p, 'a> as OdeSolverMethod<'p, Equations<'a>>>::State;

/// The configuration of a solver.
pub(super) type Config<'p, 'a, M> = <<M as Method>::Solver<'p, 'a> as OdeSolverMethod<'p, Equations<'a>>>::Config;

/// An implicit method of diffsol.
pub(super) trait Method: Sized {
    /// The solver.
    type Solver<'p, 'a: 'p>: OdeSolverMethod<'p, Equations<'a>>;

    /// Starts the solver of `problem` from `state`.
    fn start<'p, 'a>(
        problem: &'p Problem<'a>,
        state: State<'p, 'a, Self>,
    ) -> Result<Self::Solver<'p, 'a>, DiffsolError>;

    /// Sets the number of Newton failures allowed over the whole run.
    fn limit_newton_failures<'p, 'a: 'p>(config: &mut Config<'p, 'a, Self>, limit: usize);
}

/// Outputs except the last are interpolated and do not influence the steps. A `y` beyond 1e150 counts as not finite.
impl<M: Method> Integrator for M {
    fn integrate(
        &mut self,
        system: &mut dyn Ode,
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
        let refused = |reason: String| Failure { reason, ..progress.clone() };
        validate(system.dim(), s0, y0, outputs, tolerance)
            .map_err(|reason| refused(format!("invalid input: {reason}")))?;
        let Some(&end) = outputs.last() else {
            return Ok(progress.statistics);
        };
        let mut problem = OdeBuilder::<NalgebraMat<f64>>::new()
            .rtol(tolerance.relative)
            .atol([tolerance.absolute])
            .build_from_eqn(Equations {
                core: RefCell::new(Core { system, progress: progress.clone() }),
                s0,
                end,
                y0,
                context: NalgebraContext::default(),
            })
            .map_err(|e| refused(e.to_string()))?;
        problem.ode_options.max_timestep_growth = Some(STEP_GROWTH);
        problem.ode_options.max_error_test_failures = ERROR_FAILURE_LIMIT;
        let result = advance::<M>(&problem, outputs, observe).map_err(|e| e.to_string());
        let progress = problem.eqn.core.into_inner().progress;
        result.map(|()| progress.statistics).map_err(|reason| Failure { reason: reason + &progress.reason, ..progress })
    }
}

/// Checks the input; the error names the fault.
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
    y.abs() <= MAX_STATE
}

/// Takes the steps. diffsol's time is t = s - s0: small steps at the start then stay exact for any s0, and its test for
/// the stop time, whose margin is relative to t, cannot be overrun (a panic).
fn advance<M: Method>(
    problem: &Problem<'_>,
    outputs: &[f64],
    observe: &mut dyn FnMut(f64, &[f64]),
) -> Result<(), Box<dyn Error>> {
    let Equations { core, s0, end, .. } = &problem.eqn;
    let span = end - s0;
    let mut state = State::<M>::new_without_initialise(problem)?;
    if core.borrow().progress.non_finite.is_some() {
        return Err("f is not finite at the initial state".into());
    }
    *state.as_mut().h = initial_step(problem, state.as_ref().y, state.as_ref().dy, span);
    let mut solver = M::start(problem, state)?;
    solver.set_stop_time(span)?;
    let mut outputs = outputs.iter().copied().peekable();
    for _ in 0..STEP_LIMIT {
        if let Some(reason) = core.borrow_mut().system.stop() {
            return Err(reason.into());
        }
        // diffsol counts Newton failures over the whole run, and its smallest step is constant: both are updated here.
        let before = solver.state().t;
        let failures = solver.get_statistics().number_of_nonlinear_solver_fails;
        let config = solver.config_mut();
        M::limit_newton_failures(config, failures + NEWTON_FAILURE_LIMIT);
        *config.as_base_mut().minimum_timestep = (MIN_STEP * span).max(f64::EPSILON * before);
        let result = solver.step();
        let (t, y) = (solver.state().t, solver.state().y.inner().as_slice());
        core.borrow_mut().record(problem.eqn.s(t), y, t > before, solver.get_statistics());
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

/// A first step for order 1: its error h^2/2 |y''| should be a quarter of the tolerance, with y'' = df/ds + J f from
/// one more evaluation of f slightly along the solution. It changes y by at most a tenth (or by the tolerance, near
/// zero) and covers at most a tenth of the interval.
fn initial_step(problem: &Problem<'_>, y0: &NalgebraVec<f64>, f0: &NalgebraVec<f64>, span: f64) -> f64 {
    let norm = |v: &NalgebraVec<f64>| v.squared_norm(y0, &problem.atol, problem.rtol).sqrt();
    let (size, slope) = (norm(y0).max(1.0), norm(f0));
    let mut probe = (0.01 * size / slope).min(1e-3 * span);
    let smallest = 10.0 * MIN_STEP * span;
    for _ in 0..8 {
        let mut y1 = y0.clone();
        y1.axpy(probe, f0, 1.0);
        let curvature = norm(&(NonLinearOp::call(&problem.eqn, &y1, probe) - f0)) / probe;
        if !curvature.is_nan() {
            return (0.5 / curvature).sqrt().min((0.1 * size).max(1.0) / slope).min(0.1 * span).max(smallest);
        }
        probe *= 0.1;
    }
    probe.max(smallest)
}

/// The system in diffsol's interface, whose methods take `&self`; hence the `RefCell`.
pub(super) struct Equations<'a> {
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
    /// The data of a possible failure; `reason` holds a remark about the Jacobian.
    progress: Failure,
}

impl Core<'_> {
    /// Records the outcome of a step.
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
    /// The right-hand side. NaN signals a failure to diffsol: the Newton iteration then does not converge. Its
    /// remaining iterations have a NaN state and stop here.
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

    /// The product J v, which only sensitivities and adjoints need.
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
