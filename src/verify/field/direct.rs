//! The direct method: the derivatives of its objective, and its relation to the flow.

use super::discretisation::Discretisation;
use super::reference::{Reference, stack};
use super::theorem_b3::omega_of;
use super::{Equality, Gf, Identity, RandomInstance};
use crate::cost::{ControlEffort, Point as CurvePoint, PointCost, PointDerivatives};
use crate::error::Result;
use crate::flow::ControlForm;
use crate::scalar::AlgebraOver;
use crate::transcription::{Derivatives, Objective};
use crate::verify::reference::{gradient, rate};
use num_traits::Zero;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let identity = |label, statement, convention, claims| Identity { label, statement, convention, claims };
    let objective = "J is a sum over quadrature points; any functions, weights and coefficients";
    let curve = "at a point with xdot_P1 = x_P2 and xddot_P1 = xdot_P2, for the variation (phi, phi')";
    vec![
        identity("transcription gradient", "the gradient of J is that by duals", objective, objective_gradient),
        identity(
            "transcription Hessian",
            "the Hessian of J is that by duals of the gradient by duals",
            objective,
            objective_hessian,
        ),
        identity(
            "transcription and flow",
            "the variation of |u|^2 is d/dt (p . dx) - dx^T G Omega",
            curve,
            flow_of_the_objective,
        ),
    ]
}

/// The effort of a discretised curve with other values of the unknowns, over any scalar.
fn effort_of<S: AlgebraOver<Gf>>(p: &RandomInstance, curve: &Discretisation, unknowns: &[S]) -> Result<S> {
    let grid = curve.grid().map(S::lift);
    let cost = ControlEffort::new(&p.model);
    Objective::new(&grid, cost, p.dof()).value(&curve.with_unknowns(unknowns))
}

/// The effort and its derivatives.
fn derivatives(p: &RandomInstance, curve: &Discretisation) -> Result<(Gf, Derivatives<Gf>)> {
    let grid = curve.grid();
    let mut derivatives = Derivatives::new(&grid, p.dof());
    let mut objective = Objective::new(&grid, ControlEffort::new(&p.model), p.dof());
    let value = objective.derivatives(&curve.coefficients, &mut derivatives)?;
    Ok((value, derivatives))
}

fn objective_gradient(p: &RandomInstance) -> Result<Vec<Equality>> {
    let curve = Discretisation::new(p);
    let (value, derivatives) = derivatives(p, &curve)?;
    let right = effort_of(p, &curve, curve.unknowns())?;
    let by_duals = gradient(curve.unknowns(), |c| effort_of(p, &curve, c))?;
    Ok(vec![Equality::numbers("J", value, right), Equality::vectors("gradient", &derivatives.gradient, &by_duals)])
}

/// Tests the Hessian along a random direction: a wrong matrix gives the right vector only with the probability of the
/// bound.
fn objective_hessian(p: &RandomInstance) -> Result<Vec<Equality>> {
    let curve = Discretisation::new(p);
    let (_, derivatives) = derivatives(p, &curve)?;
    let right = rate(curve.unknowns(), curve.direction.as_slice(), |c| gradient(c, |c| effort_of(p, &curve, c)))?;
    let left = derivatives.hessian.to_dense() * &curve.direction;
    Ok(vec![Equality::vectors("Hessian", &left, &right)])
}

/// The instance projected on the manifold $v = \dot q$.
fn on_the_manifold(p: &RandomInstance) -> RandomInstance {
    let n = p.dof();
    let (v, a) = (p.x.rows(n, n), p.xdot.rows(n, n));
    RandomInstance {
        model: p.model.clone(),
        weightless: p.weightless.clone(),
        xdot: stack(&v.into_owned(), &a.into_owned()),
        xddot: stack(&a.into_owned(), &p.xddot.rows(n, n).into_owned()),
        x: p.x.clone(),
        w: p.w.clone(),
        ..*p
    }
}

fn flow_of_the_objective(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (p, n) = (&on_the_manifold(p), p.dof());
    let moves = [&p.w, &(&p.w * p.extra[0]), &(&p.w * p.extra[1] + &p.w.map(|w| w * w))];
    let state = [p.x.rows(0, n), p.x.rows(n, n), p.xdot.rows(n, n)];

    let mut cost = ControlEffort::new(&p.model);
    let mut derivatives = PointDerivatives::new(n);
    let [q, v, a] = state.each_ref().map(|part| part.as_slice());
    let point = CurvePoint { index: 0, phase: 0, time: Gf::zero(), q, v, a };
    cost.derivatives(point, &mut derivatives)?;
    let left = (0..3).fold(Gf::zero(), |sum, i| sum + derivatives.gradient.rows(i * n, n).dot(moves[i]));

    let (reference, omega) = (Reference::at(p)?, omega_of(p, ControlForm::new(&p.model))?);
    let by_lagrangian = reference.variation()?;
    let (dx, dxdot) = (stack(moves[0], moves[1]), stack(moves[1], moves[2]));
    let flow = reference.metric() * omega;
    let momentum = by_lagrangian.by_xdot.dot(&dxdot) + by_lagrangian.momentum_rate.dot(&dx);
    Ok(vec![Equality::numbers("variation", left, momentum - dx.dot(&flow))])
}
