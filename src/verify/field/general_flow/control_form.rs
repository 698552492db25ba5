//! The control form with weights, duals and costs, and its Jacobian, against the definition of the flow.

use super::made_up::{Coupled, MatrixAlone, Place, Windy, lagrangian, weights};
use crate::error::Result;
use crate::flow::jacobian::{ControlFormJacobian, NodeBlocks, NodeJacobian};
use crate::flow::{
    ActuationMetric, ActuationWeights, AffineLagrangian, AghfLagrangian, ControlForm, ControlLagrangian, Drift,
    FreeDynamics, Lagrangian, LagrangianFlow, Metric, RightHandSide, StateCostTerm, Sum, WithStateCost,
    constrained_lagrangian,
};
use crate::verify::field::constraint_kinds::{pair, rows, set};
use crate::verify::field::theorem_b3::omega_of;
use crate::verify::field::wrt::{Wrt, derivative};
use crate::verify::field::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::verify::reference::{constant, gradient, variation, vector};
use nalgebra::DVector;
use num_traits::{One, Zero};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let identity = |label, statement, claims| Identity {
        label,
        statement,
        convention: "d/dt moves t, x and xdot; W is diagonal; any weights, duals and costs",
        claims,
    };
    vec![
        identity(
            "general control form",
            "flow of k|e|^2 + lambda^T e + u^T W u + sum l(t, u) in diag(kI, HWH)",
            control_form,
        ),
        identity("general control form Jacobian", "its three blocks", jacobian_of_control_form),
        identity("paper as a special case", "W = I and no duals give the paper's flow and Jacobian", paper),
        identity("affine Lagrangian", "(xdot - F_d)^T G (xdot - F_d) for any drift and metric", affine),
        identity("state cost", "flow of L + psi(t, x)", state_cost),
        identity("weighted penalties on the state", "(A4) and its Jacobian in diag(kI, HWH)", weighted_penalties),
    ]
}

/// $\Omega$ by its definition: the variation by nested dual numbers, times the inverse of the metric.
fn definition(p: &RandomInstance, lagrangian: &impl Lagrangian<Gf>, metric: &impl Metric<Gf>) -> Result<DVector<Gf>> {
    let node = p.node();
    let v = variation(node, |t, x, xdot| lagrangian.value(&p.model, t, x, xdot, p.k))?;
    let mut omega = v.momentum_rate - v.by_x;
    metric.raise(&p.model, node.t, node.x, p.k, omega.as_mut_slice())?;
    Ok(omega)
}

fn control_form(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (model, l) = (&p.model, lagrangian(p)?);
    let by_matrix = MatrixAlone(l.metric());
    let left = omega_of(p, ControlForm::of(model, l.clone()))?;
    let by_flow = omega_of(p, LagrangianFlow::in_metric(model, &l, l.metric()))?;
    let right = definition(p, &l, &by_matrix)?;
    let affine = AffineLagrangian { drift: Windy, metric: Coupled };
    let of_affine = omega_of(p, LagrangianFlow::in_metric(model, &affine, &Coupled))?;
    Ok(vec![
        Equality::vectors("control form", &left, &right),
        Equality::vectors("flow of the Lagrangian", &by_flow, &right),
        Equality::vectors("flow in any metric", &of_affine, &definition(p, &affine, &Coupled)?),
    ])
}

/// Compares the blocks of a Jacobian with dual numbers of a right-hand side.
fn blocks<R: RightHandSide<Gf, Jet1>>(
    p: &RandomInstance,
    mut jacobian: impl NodeJacobian<Gf, Gf>,
    rhs: impl Fn() -> R,
) -> Result<Vec<Equality>> {
    let mut out = NodeBlocks::new(p.dof());
    jacobian.evaluate(p.node(), p.k, &mut out)?;
    let by_duals = |part| {
        derivative(p, part, |at| {
            let mut omega = DVector::zeros(2 * p.dof());
            rhs().omega(at.node, at.k, omega.as_mut_slice())?;
            Ok(omega)
        })
    };
    Ok(vec![
        Equality::new("dx", out.dx, by_duals(Wrt::X)?),
        Equality::new("dxdot", out.dxdot, by_duals(Wrt::Xdot)?),
        Equality::new("dxddot", out.dxddot, by_duals(Wrt::Xddot)?),
    ])
}

fn jacobian_of_control_form(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (model, l) = (&p.model, lagrangian(p)?);
    let ours = ControlFormJacobian::of(model, l.clone());
    blocks(p, ours, || LagrangianFlow::in_metric(model, &l, l.metric()))
}

fn paper(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (model, node) = (&p.model, p.node());
    let spelt_out: ControlLagrangian<Gf> = ControlLagrangian {
        weights: ActuationWeights::diagonal(vec![Gf::one(); p.dof()])?,
        ..ControlLagrangian::default()
    };
    let mut claims = Vec::new();
    for l in [ControlLagrangian::default(), spelt_out] {
        let value = l.value(model, node.t, node.x, node.xdot, p.k)?;
        let right = AghfLagrangian.value(model, node.t, node.x, node.xdot, p.k)?;
        claims.push(Equality::numbers("value", value, right));
        claims.push(Equality::vectors(
            "Omega",
            &omega_of(p, ControlForm::of(model, l.clone()))?,
            &omega_of(p, ControlForm::new(model))?,
        ));
        claims.extend(blocks(p, ControlFormJacobian::of(model, l), || ControlForm::new(model))?);
    }
    Ok(claims)
}

fn affine(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (model, node) = (&p.model, p.node());
    let control: ControlLagrangian<Gf> = ControlLagrangian { weights: weights(p)?, ..ControlLagrangian::default() };
    let affine = AffineLagrangian { drift: FreeDynamics, metric: control.metric() };
    // The momentum of any affine Lagrangian is 2 G (xdot - F_d).
    let general = AffineLagrangian { drift: Windy, metric: Coupled };
    let x = constant(node.x);
    let momentum = gradient(node.xdot, |xdot| general.value(model, Jet1::constant(node.t), &x, xdot, p.k))?;
    let away = vector(node.xdot) - Windy.rate(model, node.t, node.x)?;
    let doubled = away * (Gf::one() + Gf::one());
    let g = Coupled.matrix(model, node.t, node.x, p.k)?;
    Ok(vec![
        Equality::numbers(
            "value",
            affine.value(model, node.t, node.x, node.xdot, p.k)?,
            control.value(model, node.t, node.x, node.xdot, p.k)?,
        ),
        Equality::vectors("momentum", &momentum, &(g * doubled)),
        Equality::vectors(
            "Omega",
            &definition(p, &affine, &MatrixAlone(control.metric()))?,
            &omega_of(p, ControlForm::of(model, control))?,
        ),
    ])
}

fn state_cost(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (model, lagrangian) = (&p.model, lagrangian(p)?);
    let weights = || lagrangian.weights.clone();
    let whole = WithStateCost { lagrangian: &lagrangian, cost: Place };
    let flow = Sum::new(ControlForm::of(model, lagrangian.clone()), StateCostTerm::new(model, weights(), Place));
    let right = definition(p, &whole, &MatrixAlone(lagrangian.metric()))?;
    let term = StateCostTerm::new(model, weights(), Place);
    let mut claims = blocks(p, term, || StateCostTerm::new(model, weights(), Place))?;
    claims.push(Equality::vectors("Omega", &omega_of(p, flow)?, &right));
    Ok(claims)
}

fn weighted_penalties(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (model, set, weights) = (&p.model, set(p), weights(p)?);
    let metric = MatrixAlone(ActuationMetric { weights: weights.clone() });
    let by_x = gradient(p.x.as_slice(), |x| {
        let g = rows(p, &set.constraints.state, x)?;
        let penalty = pair(p);
        let (k_cons, c_cons) = (penalty.k_cons, penalty.c_cons);
        Ok(constrained_lagrangian(Jet1::zero(), g.iter().copied(), k_cons, c_cons))
    })?;
    let mut right = -by_x;
    let node = p.node();
    metric.raise(model, node.t, node.x, p.k, right.as_mut_slice())?;
    let left = omega_of(p, set.state_penalty(model).weighted(weights.clone()))?;
    let ours = set.state_penalty(model).weighted(weights.clone());
    let mut claims = blocks(p, ours, || set.state_penalty(model).weighted(weights.clone()))?;
    claims.push(Equality::vectors("Omega", &left, &right));

    let lagrangian = lagrangian(p)?;
    let with_torque = lagrangian.clone().and_cost(set.torque_penalty());
    let whole = omega_of(p, set.right_hand_side_of(model, lagrangian.clone()))?;
    let sum = definition(p, &with_torque, &metric)? + right;
    claims.push(Equality::vectors("all constraints", &whole, &sum));
    let ours = set.jacobian_of(model, lagrangian.clone());
    claims.extend(blocks(p, ours, || set.right_hand_side_of(model, lagrangian.clone()))?);
    Ok(claims)
}
