//! Checks of the flow of any Lagrangian in any metric, and of its Jacobian.

use super::{At, CheckOptions, Finding, Findings, State, compare_jacobians};
use crate::constraint::TorqueLimits;
use crate::error::Result;
use crate::flow::jacobian::{ControlFormJacobian, ForwardDual, NodeJacobian};
use crate::flow::{
    ActuationWeights, AffineLagrangian, ControlDual, ControlForm, ControlLagrangian, DualTrajectory, FreeDynamics,
    Lagrangian, LagrangianFlow, Metric, Penalty, RightHandSide, StateCost, StateCostTerm, Sum, TorquePenalty,
    WithStateCost,
};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Tanh};
use crate::verify::reference::{gradient_and_rate, variation};
use nalgebra::{DMatrix, DVector};

/// A user-defined flow, which is compared with the definition of the flow.
pub struct FlowUnderTest<'a, L, M> {
    /// The prefix of the names of the quantities.
    pub name: &'a str,
    /// The Lagrangian.
    pub lagrangian: &'a L,
    /// The metric.
    pub metric: &'a M,
    /// The implementation of $\Omega$ under test.
    pub right_hand_side: &'a mut dyn RightHandSide<f64, f64>,
    /// The implementation of the Jacobian under test.
    pub jacobian: &'a mut dyn NodeJacobian,
}

/// Compares a right-hand side with the definition $G^{-1} (\frac{d}{dt} L_{\dot x} - L_x)$ by nested dual numbers of
/// the Lagrangian, and a Jacobian with dual numbers of that, at random states and times: the worst of each at each
/// penalty, separately for the rows of $\Omega_{P1}$ and $\Omega_{P2}$. Cost: third derivatives, `3 N^2` evaluations of
/// the Lagrangian per state and penalty.
///
/// # Errors
/// Those of the flow, the Lagrangian or the metric.
pub fn check_flow<L: Lagrangian, M: Metric>(
    model: &Model,
    flow: FlowUnderTest<'_, L, M>,
    options: &CheckOptions,
) -> Result<Vec<Finding>> {
    let FlowUnderTest { name, lagrangian, metric, right_hand_side, jacobian } = flow;
    let of = (lagrangian, metric);
    let mut findings = check_right_hand_side(model, name, of, right_hand_side, options)?;
    let definition = LagrangianFlow::in_metric(model, lagrangian, metric);
    findings.extend(compare_jacobians(
        model,
        name,
        jacobian,
        &mut ForwardDual::of(definition, model.dof()),
        &options.states(model)?,
        &options.penalties,
    )?);
    Ok(findings)
}

/// Performs the first half of [`check_flow`], for a Lagrangian and a metric.
fn check_right_hand_side<L: Lagrangian, M: Metric>(
    model: &Model,
    name: &str,
    (lagrangian, metric): (&L, &M),
    right_hand_side: &mut dyn RightHandSide<f64, f64>,
    options: &CheckOptions,
) -> Result<Vec<Finding>> {
    let n = model.dof();
    let mut findings = Findings::default();
    for (sample, state) in options.states(model)?.iter().enumerate() {
        let (at, node) = (At::new(model, sample, state)?, state.node());
        for k in &options.penalties {
            let v = variation(node, |t, x, xdot| lagrangian.value(model, t, x, xdot, *k))?;
            let mut expected = v.momentum_rate - v.by_x;
            metric.raise(model, node.t, node.x, *k, expected.as_mut_slice())?;
            let mut ours = DVector::zeros(2 * n);
            right_hand_side.omega(node, *k, ours.as_mut_slice())?;
            let at = at.under(*k);
            for (part, row) in [("Omega_P1", 0), ("Omega_P2", n)] {
                let quantity = format!("{name}: {part}");
                let (a, b) = (ours.rows(row, n), expected.rows(row, n));
                let (a, b) = (a.as_view(), b.as_view());
                findings.compare(at.divided_twice(), &quantity, at, a, b);
            }
        }
    }
    Ok(findings.all)
}

/// A running cost of the state: the distance from rest, with a weight that grows with time.
struct LateRest;

impl StateCost for LateRest {
    fn value<S: AlgebraOver<f64> + Tanh>(&self, _: &Model, t: S, x: &[S]) -> Result<S> {
        let square = x.iter().fold(S::zero(), |sum, x| sum + *x * *x);
        Ok(t * square * square)
    }
}

/// Checks the flow beyond the paper's for the built-in extensions: a [`ControlLagrangian`] with every third joint
/// passive, dual trajectories of the slip and of the torque, torque limits as penalties, and a [`StateCost`]; the
/// [`AffineLagrangian`] of the free dynamics; and the metric.
///
/// # Errors
/// None for a loaded model.
pub fn check_general_flow(model: &Model, options: &CheckOptions) -> Result<Vec<Finding>> {
    let (n, control) = (model.dof(), made_up(model.dof())?);
    let (weights, metric) = (&control.weights, control.metric());
    let whole = WithStateCost { lagrangian: &control, cost: LateRest };
    let name = "general flow";
    let ours =
        &mut Sum::new(ControlForm::of(model, control.clone()), StateCostTerm::new(model, weights.clone(), LateRest));
    let mut all = check_right_hand_side(model, name, (&whole, &metric), ours, options)?;
    let by_duals =
        Sum::new(ControlForm::of(model, control.clone()), StateCostTerm::new(model, weights.clone(), LateRest));
    all.extend(compare_jacobians(
        model,
        name,
        &mut Sum::new(
            ControlFormJacobian::of(model, control.clone()),
            StateCostTerm::new(model, weights.clone(), LateRest),
        ),
        &mut ForwardDual::of(by_duals, n),
        &options.states(model)?,
        &options.penalties,
    )?);
    all.extend(metric_and_affine(model, weights, options)?);
    Ok(all)
}

/// Distinct numbers, none of which is zero.
pub(super) fn wave(i: usize, j: usize) -> f64 {
    (1.0 + i as f64 + 0.7 * j as f64).sin()
}

/// A Lagrangian with all features of [`ControlLagrangian`], for `n` joints.
fn made_up(n: usize) -> Result<ControlLagrangian<f64, (ControlDual, TorquePenalty)>> {
    let trajectory = |shift: usize| {
        let coefficients = DMatrix::from_fn(n, 5, |i, j| wave(i + shift, j));
        DualTrajectory::new(3.0, coefficients)
    };
    let weight = |joint: usize| {
        if joint % 3 == 2 { 100.0 } else { 1.0 + 0.1 * joint as f64 }
    };
    let limits = (0..n).map(|i| (i % 2 == 0).then_some(1.0 + i as f64));
    let torque =
        TorquePenalty { limits: TorqueLimits(limits.collect()), penalty: Penalty { k_cons: 3.0, c_cons: 0.7 } };
    Ok(ControlLagrangian {
        weights: ActuationWeights::diagonal((0..n).map(weight).collect())?,
        slip_dual: Some(trajectory(0)?),
        cost: (ControlDual(trajectory(n)?), torque),
    })
}

/// Compares the affine Lagrangian with that of the control, and twice the metric with the Hessian of the Lagrangian in
/// $\dot x$, along $\ddot x$.
fn metric_and_affine(model: &Model, weights: &ActuationWeights, options: &CheckOptions) -> Result<Vec<Finding>> {
    let control: ControlLagrangian = ControlLagrangian { weights: weights.clone(), ..ControlLagrangian::default() };
    let metric = &control.metric();
    let affine = AffineLagrangian { drift: FreeDynamics, metric };
    let mut findings = Findings::default();
    for (sample, state) in options.states(model)?.iter().enumerate() {
        let at = At::new(model, sample, state)?;
        let State { t, x, xdot, xddot } = state;
        for k in &options.penalties {
            let at = at.under(*k);
            let one = |x: f64| DMatrix::from_element(1, 1, x);
            let (a, b) = (one(affine.value(model, *t, x, xdot, *k)?), one(control.value(model, *t, x, xdot, *k)?));
            let (a, b) = (a.as_view(), b.as_view());
            findings.compare(at.divided_twice(), "affine Lagrangian: value", at, a, b);
            let still = vec![0.0; x.len()];
            let (y, along) = ([&x[..], xdot].concat(), [&still[..], xddot].concat());
            let [_, rates] =
                gradient_and_rate(&y, &along, |x, xdot| control.value(model, AlgebraOver::lift(*t), x, xdot, *k))?;
            let twice = metric.matrix(model, *t, x, *k)? * DVector::from_column_slice(xddot) * 2.0;
            let (n, quantity) = (model.dof(), "metric: Hessian of the affine Lagrangian");
            for row in [0, n] {
                let (a, b) = (twice.rows(row, n), rates.rows(2 * n + row, n));
                let (a, b) = (a.as_view(), b.as_view());
                findings.compare(at.divided_twice(), quantity, at, a, b);
            }
        }
    }
    Ok(findings.all)
}
