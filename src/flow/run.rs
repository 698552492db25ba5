//! Algorithm B3: the flow at the nodes as a stiff system of ordinary differential equations.

use super::jacobian::{JacobianKind, NodeBlocks, NodeJacobian};
use super::{
    Collocation, ControlForm, Penalised, RightHandSide, assemble_jacobian, lagrangian_of_control,
};
use crate::constraint::Constraint;
use crate::curve::{Chebyshev, Curve};
use crate::dynamics::{Data, rnea};
use crate::error::{Error, Result, check_positive};
use crate::motion::{Guess, Interrupt, Problem, Stopped, Watch};
use crate::ode::{Failure, Integrator, IntegratorKind, Ode, Statistics, Tolerance};
use nalgebra::DMatrix;
use std::fmt;
use std::time::Duration;

/// The number of values of `s` in the output between its first and `s_max`, on a logarithmic grid.
const OUTPUTS: usize = 50;
/// The first value of `s` after zero.
const FIRST_OUTPUT: f64 = 1e-6;

/// The largest number of unknowns: one Jacobian of this size takes 800 MB, and there are three.
const MOST_UNKNOWNS: usize = 10_000;

/// The parameters of the flow.
#[derive(Clone, Debug)]
pub struct FlowSettings {
    /// The degree of the polynomial.
    pub p: usize,
    /// The penalty on $\dot x_{P1} \ne x_{P2}$ in (11).
    pub k: f64,
    /// The value of `s` at which the flow stops.
    pub s_max: f64,
    /// Absolute and relative tolerance of the integrator.
    pub tolerance: f64,
    /// The initial curve, at `s = 0`.
    pub guess: Guess,
    /// The method of computing the Jacobian.
    pub jacobian: JacobianKind,
    /// The integrator over `s`.
    pub integrator: IntegratorKind,
    /// The wall time after which the flow fails.
    pub time_limit: Option<Duration>,
    /// The handle by which another thread stops the flow in the same way.
    pub interrupt: Interrupt,
}

impl FlowSettings {
    /// The paper's tolerance, which is the default.
    pub const TOLERANCE: f64 = 1e-4;

    /// Settings with the default tolerance, guess, Jacobian and integrator.
    #[must_use]
    pub fn new(p: usize, k: f64, s_max: f64) -> Self {
        Self {
            p,
            k,
            s_max,
            tolerance: Self::TOLERANCE,
            guess: Guess::default(),
            jacobian: JacobianKind::default(),
            integrator: IntegratorKind::default(),
            time_limit: None,
            interrupt: Interrupt::default(),
        }
    }

    /// Replaces the Jacobian.
    #[must_use]
    pub fn with_jacobian(self, jacobian: JacobianKind) -> Self {
        Self { jacobian, ..self }
    }

    /// Replaces the integrator.
    #[must_use]
    pub fn with_integrator(self, integrator: IntegratorKind) -> Self {
        Self { integrator, ..self }
    }

    /// # Errors
    /// A number is not positive and finite, or the Jacobian of a robot with `dof` joints does not fit into memory.
    fn check(&self, dof: usize) -> Result<()> {
        let (p, unknowns) = (self.p, dof * 2 * self.p.saturating_sub(1));
        if unknowns > MOST_UNKNOWNS {
            let condition = format!(
                "it is {p}, with {dof} joints {unknowns} unknowns; at most {MOST_UNKNOWNS}"
            );
            return Err(Error::input("settings", "p", condition));
        }
        for (what, value) in [
            ("k", self.k),
            ("s_max", self.s_max),
            ("tolerance", self.tolerance),
        ] {
            check_positive("settings", what, value)?;
        }
        Ok(())
    }
}

/// The progress of the flow at one value of `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowRecord {
    /// The homotopy variable.
    pub s: f64,
    /// The action by Clenshaw-Curtis quadrature over the nodes.
    pub action_at_nodes: f64,
}

/// The result of a flow that reached `s_max`.
#[derive(Clone, Debug)]
pub struct FlowSolution {
    /// The curve at `s_max`.
    pub curve: Curve,
    /// The action at `s = 0` and at 50 values of `s` on a logarithmic grid.
    pub history: Vec<FlowRecord>,
    /// The work of the integrator.
    pub statistics: Statistics,
}

/// A flow that did not reach `s_max`.
#[derive(Clone, Debug)]
pub struct FlowFailure {
    /// The value of `s` that was reached.
    pub s: f64,
    /// The interior node at which the right-hand side was last not finite, and the index of that entry of $\Omega$.
    pub non_finite: Option<(usize, usize)>,
    /// The curve at `s`.
    pub last_good: Curve,
    /// The history up to `s`.
    pub history: Vec<FlowRecord>,
    /// The reason of the failure.
    pub reason: String,
    /// The external reason of the stop; `None` if the integration itself failed.
    pub stopped: Option<Stopped>,
    /// The work of the integrator.
    pub statistics: Statistics,
}

impl fmt::Display for FlowFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the flow stopped at s = {:e}: {}", self.s, self.reason)?;
        if let Some((node, entry)) = self.non_finite {
            write!(f, " (entry {entry} of Omega at node {node} is not finite)")?;
        }
        Ok(())
    }
}

impl std::error::Error for FlowFailure {}

/// The result of a flow: a curve, or a failure with the last good curve.
pub type FlowOutcome = std::result::Result<FlowSolution, Box<FlowFailure>>;

/// Runs the flow (Algorithm B3) from the guess to `s_max` with the control form of $\Omega$ and the Jacobian of the
/// settings. `observe` is called at each value of `s` of the history.
///
/// # Errors
/// A setting is not positive and finite, or the degree is out of range.
pub fn flow(
    problem: &Problem<'_>,
    settings: &FlowSettings,
    observe: &mut dyn FnMut(&FlowRecord),
) -> Result<FlowOutcome> {
    let model = problem.model();
    let jacobian = &mut *settings.jacobian.build(model);
    flow_with(
        problem,
        settings,
        &mut ControlForm::new(model),
        jacobian,
        observe,
    )
}

/// Runs the constrained flow (A4) in the same way as [`flow`].
///
/// # Errors
/// Those of [`flow`]; the constraints have another number of joints; or a row of the state is an equality, because a
/// penalty is one-sided.
pub fn flow_constrained<K: Constraint>(
    problem: &Problem<'_>,
    settings: &FlowSettings,
    constraints: &Penalised<K>,
    observe: &mut dyn FnMut(&FlowRecord),
) -> Result<FlowOutcome> {
    let model = problem.model();
    constraints.refuse_equalities(model)?;
    let jacobian = &mut *settings.jacobian.build_constrained(model, constraints);
    let rhs = &mut constraints.right_hand_side(model);
    flow_with(problem, settings, rhs, jacobian, observe)
}

/// Runs the flow of any right-hand side with any Jacobian and the integrator of the settings. The history records the
/// paper's action for any right-hand side. See the guide on [Jacobians](crate::guide::jacobian) and
/// [Lagrangians](crate::guide::lagrangian).
///
/// # Errors
/// Those of [`flow`], or `rhs` or `jacobian` has another number of joints.
pub fn flow_with(
    problem: &Problem<'_>,
    settings: &FlowSettings,
    rhs: &mut dyn RightHandSide<f64, f64>,
    jacobian: &mut dyn NodeJacobian,
    observe: &mut dyn FnMut(&FlowRecord),
) -> Result<FlowOutcome> {
    let integrator = &mut *settings.integrator.build();
    flow_with_integrator(problem, settings, rhs, jacobian, integrator, observe)
}

/// Runs the flow with any integrator in place of that of the settings, otherwise as [`flow_with`]. See the guide on
/// [integrators](crate::guide::integrator).
///
/// # Errors
/// Those of [`flow_with`].
pub fn flow_with_integrator(
    problem: &Problem<'_>,
    settings: &FlowSettings,
    rhs: &mut dyn RightHandSide<f64, f64>,
    jacobian: &mut dyn NodeJacobian,
    integrator: &mut dyn Integrator,
    observe: &mut dyn FnMut(&FlowRecord),
) -> Result<FlowOutcome> {
    let model = problem.model();
    settings.check(model.dof())?;
    let chebyshev = Chebyshev::new(settings.p, problem.horizon())?;
    let guess = problem.guess(settings.guess, &chebyshev);
    let collocation = Collocation::new(&chebyshev, problem.start(), problem.goal())?;
    let interior = guess.columns_range(collocation.interior());
    let unknowns: Vec<f64> = interior.iter().copied().collect();
    let mut system = CollocatedFlow {
        rhs,
        jacobian,
        blocks: NodeBlocks::new(model.dof()),
        collocation: collocation.clone(),
        k: settings.k,
        watch: Watch::start(settings.time_limit, &settings.interrupt),
        stopped: None,
        error: None,
    };
    let mut recorder = Recorder {
        problem,
        k: settings.k,
        chebyshev,
        collocation,
        history: Vec::new(),
    };
    observe(&recorder.record(0.0, &unknowns)?);
    let mut error = None;
    let outcome = integrator.integrate(
        &mut system,
        0.0,
        &unknowns,
        &outputs(settings.s_max),
        Tolerance {
            relative: settings.tolerance,
            absolute: settings.tolerance,
        },
        &mut |s, y| match recorder.record(s, y) {
            Ok(record) => observe(&record),
            Err(e) => error = Some(e),
        },
    );
    if let Some(error) = error.or(system.error) {
        return Err(error);
    }
    Ok(match outcome {
        Ok(statistics) => Ok(FlowSolution {
            curve: recorder.curve()?,
            history: recorder.history,
            statistics,
        }),
        Err(failure) => Err(Box::new(recorder.failure(failure, system.stopped)?)),
    })
}

/// The number of records in the history of a flow to `s_max`.
#[must_use]
pub fn output_count(s_max: f64) -> u64 {
    1 + outputs(s_max).len() as u64
}

/// The values of `s` after zero.
fn outputs(s_max: f64) -> Vec<f64> {
    if s_max <= FIRST_OUTPUT {
        return vec![s_max];
    }
    let step = (s_max / FIRST_OUTPUT).ln() / (OUTPUTS - 1) as f64;
    let inner = (0..OUTPUTS - 1).map(|i| FIRST_OUTPUT * (step * i as f64).exp());
    inner.filter(|s| *s < s_max).chain([s_max]).collect()
}

/// The collocated flow as a problem for the integrator.
struct CollocatedFlow<'a> {
    rhs: &'a mut dyn RightHandSide<f64, f64>,
    jacobian: &'a mut dyn NodeJacobian,
    blocks: NodeBlocks,
    collocation: Collocation<f64, f64>,
    k: f64,
    watch: Watch,
    stopped: Option<Stopped>,
    error: Option<Error>,
}

impl Ode for CollocatedFlow<'_> {
    fn dim(&self) -> usize {
        self.collocation.unknowns()
    }

    fn rhs(&mut self, _s: f64, y: &[f64], dy: &mut [f64]) {
        let Self {
            rhs,
            collocation,
            k,
            ..
        } = self;
        let rates = collocation
            .set(y)
            .and_then(|()| collocation.rates(*rhs, *k, dy));
        if let Err(error) = rates {
            dy.fill(f64::NAN);
            self.error = Some(error);
        }
    }

    fn jacobian(&mut self, _s: f64, y: &[f64], jac: &mut DMatrix<f64>) {
        let Self {
            jacobian,
            collocation,
            blocks,
            k,
            ..
        } = self;
        let assembled = (collocation.set(y))
            .and_then(|()| assemble_jacobian(collocation, *jacobian, *k, blocks, jac));
        if let Err(error) = assembled {
            jac.fill(f64::NAN);
            self.error = Some(error);
        }
    }

    fn stop(&mut self) -> Option<String> {
        self.stopped = self.watch.stopped();
        self.stopped.map(|stopped| stopped.to_string())
    }
}

/// A recorder of the integrator's output.
struct Recorder<'a, 'm> {
    problem: &'a Problem<'m>,
    k: f64,
    chebyshev: Chebyshev,
    collocation: Collocation<f64, f64>,
    history: Vec<FlowRecord>,
}

impl Recorder<'_, '_> {
    fn record(&mut self, s: f64, y: &[f64]) -> Result<FlowRecord> {
        self.collocation.set(y)?;
        let model = self.problem.model();
        let (mut data, mut u) = (Data::new(model), vec![0.0; model.dof()]);
        let mut action_at_nodes = 0.0;
        for (i, weight) in self.chebyshev.weights().iter().enumerate() {
            let node = self.collocation.node(i);
            rnea(
                model,
                &mut data,
                node.x_p1(),
                node.x_p2(),
                node.xdot_p2(),
                &mut u,
            )?;
            let lagrangian = lagrangian_of_control(node.xdot_p1(), node.x_p2(), &u, self.k)?;
            action_at_nodes += weight * lagrangian;
        }
        let record = FlowRecord { s, action_at_nodes };
        self.history.push(record);
        Ok(record)
    }

    fn curve(&self) -> Result<Curve> {
        Curve::new(self.chebyshev.clone(), self.collocation.xi().clone())
    }

    fn failure(mut self, failure: Failure, stopped: Option<Stopped>) -> Result<FlowFailure> {
        self.record(failure.s, &failure.y)?;
        let m = self.problem.start().len();
        Ok(FlowFailure {
            s: failure.s,
            non_finite: failure.non_finite.map(|n| (n.entry / m + 1, n.entry % m)),
            last_good: self.curve()?,
            history: self.history,
            reason: failure.reason,
            stopped,
            statistics: failure.statistics,
        })
    }
}
