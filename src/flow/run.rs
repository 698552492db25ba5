//! Algorithm B3: the flow at the nodes as a stiff system of ordinary differential equations.

use super::jacobian::{ForwardDual, NodeBlocks, NodeJacobian};
use super::{
    Collocation, ControlForm, FlowSettings, FootPenalty, Lagrangian, LagrangianFlow, Metric, Penalised, RightHandSide,
    Sum, assemble_jacobian, lagrangian_of_control,
};
use crate::constraint::Constraint;
use crate::curve::{Chebyshev, Curve};
use crate::dynamics::{Data, rnea};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::motion::{Problem, Stopped, Watch};
use crate::ode::{Failure, Integrator, NonFinite, Ode, Statistics, Tolerance};
use nalgebra::DMatrix;

/// The number of values of `s` in the output between its first and `s_max`, on a logarithmic grid.
const OUTPUTS: usize = 50;
/// The first value of `s` after zero.
const FIRST_OUTPUT: f64 = 1e-6;

/// The progress of the flow at one value of `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowRecord {
    /// The homotopy variable.
    pub s: f64,
    /// The action by Clenshaw-Curtis quadrature over the nodes.
    pub action_at_nodes: f64,
}

/// The result of a flow.
#[derive(Clone, Debug)]
pub struct FlowSolution {
    /// The curve at the last `s` of the history.
    pub curve: Curve,
    /// The action at `s = 0` and at 50 values of `s` on a logarithmic grid, up to `s_max` or the last `s` that was
    /// reached.
    pub history: Vec<FlowRecord>,
    /// The reason if the flow did not reach `s_max`.
    pub failure: Option<String>,
    /// The external reason of an early stop, if there was one; without it, the integration itself failed.
    pub stopped: Option<Stopped>,
    /// The work of the integrator.
    pub statistics: Statistics,
}

/// The flow (Algorithm B3) of a problem from its guess to `s_max`: by default that of the paper's Lagrangian in control
/// form, without constraints.
///
/// ```
/// use aghf::flow::{Flow, FlowSettings};
/// use aghf::motion::Problem;
/// let model = aghf::urdf::builtin_robot("pendulum_2")?;
/// let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.5, 0.0, 0.0], 2.0)?;
/// let solution = Flow::new(&problem, FlowSettings::new(9, 1e3, 1.0)).run()?;
/// assert_eq!(solution.failure, None);
/// # Ok::<(), aghf::Error>(())
/// ```
pub struct Flow<'a> {
    problem: &'a Problem<'a>,
    settings: FlowSettings,
    form: Result<Form<'a>>,
    integrator: Box<dyn Integrator + 'a>,
    observe: Box<dyn FnMut(&FlowRecord) + 'a>,
}

/// A right-hand side and its Jacobian.
struct Form<'a> {
    rhs: Box<dyn RightHandSide + 'a>,
    jacobian: Box<dyn NodeJacobian + 'a>,
}

impl<'a> Flow<'a> {
    /// The flow with the Jacobian and the integrator of the settings.
    #[must_use]
    pub fn new(problem: &'a Problem<'a>, settings: FlowSettings) -> Self {
        let model = problem.model();
        Self {
            problem,
            form: Ok(Form { rhs: Box::new(ControlForm::new(model)), jacobian: settings.jacobian.build(model) }),
            integrator: settings.integrator.build(),
            settings,
            observe: Box::new(|_| {}),
        }
    }

    /// Replaces right-hand side and Jacobian by those of the constrained flow (A4): penalties join the paper's
    /// Lagrangian. The Jacobian is of the kind in the settings.
    #[must_use]
    pub fn constraints<K: Constraint>(self, constraints: &'a Penalised<K>) -> Self {
        let (model, kind) = (self.problem.model(), self.settings.jacobian);
        let form = constraints.refuse_equalities(model).map(|()| {
            let own = constraints.right_hand_side(model);
            let rhs: Box<dyn RightHandSide + 'a> = match &constraints.constraints.stage.foot {
                None => Box::new(own),
                Some(foot) => {
                    let penalty = constraints.weights.torque;
                    Box::new(Sum::new(own, FootPenalty::new(model, foot, penalty)))
                }
            };
            let jacobian = kind.build_constrained(model, constraints);
            Form { rhs, jacobian }
        });
        Self { form, ..self }
    }

    /// Replaces right-hand side and Jacobian by those of any Lagrangian in any metric, by dual numbers:
    /// [`LagrangianFlow`] and [`ForwardDual`].
    #[must_use]
    pub fn lagrangian<L, M>(self, lagrangian: L, metric: M) -> Self
    where
        L: Lagrangian + Clone + 'a,
        M: Metric + Clone + 'a,
    {
        let model = self.problem.model();
        let rhs = LagrangianFlow::in_metric(model, lagrangian, metric);
        self.right_hand_side(rhs.clone(), ForwardDual::of(rhs, model.dof()))
    }

    /// Replaces right-hand side and Jacobian by any others.
    #[must_use]
    pub fn right_hand_side(self, rhs: impl RightHandSide + 'a, jacobian: impl NodeJacobian + 'a) -> Self {
        let (rhs, jacobian) = (Box::new(rhs), Box::new(jacobian));
        let form = Ok(Form { rhs, jacobian });
        Self { form, ..self }
    }

    /// Replaces the Jacobian alone.
    #[must_use]
    pub fn jacobian(self, jacobian: impl NodeJacobian + 'a) -> Self {
        let jacobian = Box::new(jacobian);
        let form = self.form.map(|form| Form { jacobian, ..form });
        Self { form, ..self }
    }

    /// Replaces the integrator.
    #[must_use]
    pub fn integrator(self, integrator: impl Integrator + 'a) -> Self {
        let integrator = Box::new(integrator);
        Self { integrator, ..self }
    }

    /// Sets a function that is called at each value of `s` of the history.
    #[must_use]
    pub fn observe(self, observe: impl FnMut(&FlowRecord) + 'a) -> Self {
        let observe = Box::new(observe);
        Self { observe, ..self }
    }

    /// Runs the flow. The history records the paper's action for any right-hand side.
    ///
    /// # Errors
    /// A setting is not positive and finite, or the degree is out of range; constraints, right-hand side or Jacobian
    /// have another number of joints; or a row of the state is an equality, because a penalty is one-sided. A flow that
    /// does not reach `s_max` is not an error: [`FlowSolution::failure`] has the reason.
    pub fn run(mut self) -> Result<FlowSolution> {
        let (problem, settings) = (self.problem, &self.settings);
        let model = problem.model();
        let form = self.form?;
        settings.check(model.dof())?;
        let chebyshev = Chebyshev::new(settings.degree, problem.horizon())?;
        let guess = problem.guess(settings.guess, &chebyshev);
        let collocation = Collocation::new(&chebyshev, problem.start(), problem.goal())?;
        let interior = guess.columns_range(collocation.interior());
        let unknowns: Vec<f64> = interior.iter().copied().collect();
        let mut system = CollocatedFlow {
            form,
            blocks: NodeBlocks::new(model.dof()),
            collocation: collocation.clone(),
            k: settings.k,
            watch: Watch::start(settings.time_limit, &settings.interrupt),
            stopped: None,
            error: None,
        };
        let mut recorder = Recorder { problem, k: settings.k, chebyshev, collocation, history: Vec::new() };
        (self.observe)(&recorder.record(0.0, &unknowns)?);
        let mut error = None;
        let outcome = self.integrator.integrate(
            &mut system,
            0.0,
            &unknowns,
            &outputs(settings.s_max),
            Tolerance { relative: settings.tolerance, absolute: settings.tolerance },
            &mut |s, y| match recorder.record(s, y) {
                Ok(record) => (self.observe)(&record),
                Err(e) => error = Some(e),
            },
        );
        if let Some(error) = error.or(system.error) {
            return Err(error);
        }
        let (failure, statistics) = match outcome {
            Ok(statistics) => (None, statistics),
            Err(failure) => {
                recorder.record(failure.s, &failure.y)?;
                (Some(words(&failure, model)), failure.statistics)
            }
        };
        Ok(FlowSolution {
            curve: Curve::new(recorder.chebyshev, recorder.collocation.xi().clone())?,
            history: recorder.history,
            stopped: failure.as_ref().and(system.stopped),
            failure,
            statistics,
        })
    }
}

/// A failure of the integrator in words.
fn words(failure: &Failure, model: &Model) -> String {
    let Failure { s, reason, .. } = failure;
    let mut words = format!("the flow stopped at s = {s:e}: {reason}");
    if let Some(NonFinite { entry, .. }) = failure.non_finite {
        let m = 2 * model.dof();
        let (node, entry) = (entry / m + 1, entry % m);
        words += &format!(" (entry {entry} of Omega at node {node} is not finite)");
    }
    words
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
    form: Form<'a>,
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
        let Self { form, collocation, k, .. } = self;
        let rates = collocation.set(y).and_then(|()| collocation.rates(&mut *form.rhs, *k, dy));
        if let Err(error) = rates {
            dy.fill(f64::NAN);
            self.error = Some(error);
        }
    }

    fn jacobian(&mut self, _s: f64, y: &[f64], jac: &mut DMatrix<f64>) {
        let Self { form, collocation, blocks, k, .. } = self;
        let assembled =
            collocation.set(y).and_then(|()| assemble_jacobian(collocation, &mut *form.jacobian, *k, blocks, jac));
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
            rnea(model, &mut data, node.x_p1(), node.x_p2(), node.xdot_p2(), &mut u)?;
            let lagrangian = lagrangian_of_control(node.xdot_p1(), node.x_p2(), &u, self.k)?;
            action_at_nodes += weight * lagrangian;
        }
        let record = FlowRecord { s, action_at_nodes };
        self.history.push(record);
        Ok(record)
    }
}
