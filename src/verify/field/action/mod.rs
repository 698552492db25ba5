//! The action of a curve in the state, the matrix of the flow's metric, and the Lagrangian at quadrature points.

mod point;

use super::discretisation::numbers;
use super::general_flow::made_up::{Coupled, Place, lagrangian};
use super::{Equality, Gf, Identity, RandomInstance};
use crate::cost::{ControlEffort, PointCost};
use crate::error::Result;
use crate::flow::weak::{DualLagrangian, Norm, RestMetric, WithSlip};
use crate::flow::{ActuationMetric, ActuationWeights, Lagrangian, Metric, WithStateCost};
use crate::scalar::AlgebraOver;
use crate::transcription::{Derivatives, Grid, Objective};
use crate::verify::duals::Written;
use crate::verify::reference::{gradient, rate};
use nalgebra::{DMatrix, DVector};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let identity = |label, statement, convention, claims| Identity { label, statement, convention, claims };
    let action = "A is a sum over quadrature points; any functions, weights and coefficients";
    vec![
        identity("action gradient", "the gradient of A is that by duals of the sum", action, action_gradient),
        identity(
            "action Hessian",
            "the Hessian of A is that by duals of the gradient by duals",
            action,
            action_hessian,
        ),
        identity("metric of the action", "the matrix M is the sum of w phi_m phi_n G", action, metric_of_the_action),
        identity(
            "analytic Lagrangian",
            "derivatives of L at a point are those by duals of the value",
            "any x and xdot; weights and a dual of the slip",
            point::analytic_lagrangian,
        ),
    ]
}

/// Two segments of degree 3 with two points each: functions, weights and coefficients are random.
struct RandomCurve {
    times: Vec<Gf>,
    weights: Vec<Gf>,
    /// Values of the functions of a segment and their first two derivatives, three columns per point.
    table: DMatrix<Gf>,
    /// `2 N` rows, one column per function.
    coefficients: DMatrix<Gf>,
    /// A direction for the unknown coefficients.
    direction: DVector<Gf>,
    /// Duals of the slip at all points.
    duals: DMatrix<Gf>,
}

impl RandomCurve {
    const SEGMENTS: usize = 2;
    const DEGREE: usize = 3;
    const POINTS: usize = 2;

    fn new(p: &RandomInstance) -> Self {
        let (mut number, n) = (numbers(p), p.dof());
        let mut matrix = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| number());
        let count = Self::SEGMENTS * Self::DEGREE + 1;
        let all = Self::SEGMENTS * Self::POINTS;
        Self {
            times: matrix(all, 1).data.into(),
            weights: matrix(Self::POINTS, 1).data.into(),
            table: matrix(Self::DEGREE + 1, 3 * Self::POINTS),
            coefficients: matrix(2 * n, count),
            direction: matrix(2 * n * (count - 2), 1).column(0).into_owned(),
            duals: matrix(n, all),
        }
    }

    fn grid(&self) -> Grid<Gf> {
        let (times, weights) = (self.times.clone(), self.weights.clone());
        let free = (1..Self::SEGMENTS * Self::DEGREE).collect();
        Grid::from_table(Self::SEGMENTS, 1, free, times, weights, self.table.clone())
    }

    /// The unknown coefficients: those of all functions but the first and the last.
    fn unknowns(&self) -> &[Gf] {
        let (all, rows) = (self.coefficients.as_slice(), self.coefficients.nrows());
        &all[rows..all.len() - rows]
    }

    /// The sum over all points of the weights times `at` of the index of a point, its time, $x$ and $\dot x$.
    fn sum<S: AlgebraOver<Gf>>(&self, unknowns: &[S], at: impl Fn(usize, S, &[S], &[S]) -> Result<S>) -> Result<S> {
        let rows = self.coefficients.nrows();
        let mut coefficients = self.coefficients.map(S::lift);
        coefficients.as_mut_slice()[rows..rows + unknowns.len()].copy_from_slice(unknowns);
        let mut sum = S::zero();
        for (index, time) in self.times.iter().enumerate() {
            let (e, g) = (index / Self::POINTS, index % Self::POINTS);
            let own = coefficients.columns(e * Self::DEGREE, Self::DEGREE + 1);
            let [x, xdot] = [3 * g, 3 * g + 1].map(|column| own * self.table.column(column).map(S::lift));
            let value = at(index, S::lift(*time), x.as_slice(), xdot.as_slice())?;
            sum += value.scale(self.weights[g]);
        }
        Ok(sum)
    }
}

/// The weights of an instance, one vector each.
fn weights(p: &RandomInstance) -> [DVector<Gf>; 3] {
    [3, 4, 5].map(|i| p.w.map(|w| w * w + p.extra[i]))
}

/// The analytic Lagrangian with all features at this number of points.
fn analytic<'a>(p: &'a RandomInstance, multipliers: &DMatrix<Gf>) -> Result<WithSlip<ControlEffort<'a, Gf, Gf>, Gf>> {
    let effort = ControlEffort::with_weights(&p.model, &weights(p))?;
    let mut lagrangian = WithSlip::new(effort, p.k, p.dof(), multipliers.ncols());
    lagrangian.multipliers.clone_from(multipliers);
    Ok(lagrangian)
}

/// The Lagrangian at point `index` by its definition.
fn written(p: &RandomInstance, duals: &DMatrix<Gf>, index: usize) -> Written<Gf> {
    Written { weights: weights(p), dual: duals.column(index).into_owned() }
}

/// A time-dependent Lagrangian that couples all variables, by dual numbers.
fn any_lagrangian(p: &RandomInstance) -> Result<impl Lagrangian<Gf>> {
    Ok(WithStateCost { lagrangian: lagrangian(p)?, cost: Place })
}

fn by_duals<L: Lagrangian<Gf>>(p: &RandomInstance, lagrangian: L) -> DualLagrangian<'_, L, Gf> {
    DualLagrangian::new(&p.model, lagrangian, p.k)
}

/// An action and its derivatives.
fn derivatives(
    p: &RandomInstance,
    curve: &RandomCurve,
    lagrangian: impl PointCost<Gf>,
) -> Result<([Gf; 2], Derivatives<Gf>)> {
    let grid = curve.grid();
    let mut action = Objective::new(&grid, lagrangian, 2 * p.dof());
    let mut derivatives = Derivatives::new(&grid, 2 * p.dof());
    let value = action.gradient_and_hessian(&curve.coefficients, &mut derivatives)?;
    Ok(([action.value(&curve.coefficients)?, value], derivatives))
}

fn action_gradient(p: &RandomInstance) -> Result<Vec<Equality>> {
    let curve = &RandomCurve::new(p);
    let any = &any_lagrangian(p)?;
    let mut equalities = Vec::new();
    let (values, ours) = derivatives(p, curve, analytic(p, &curve.duals)?)?;
    let value = curve
        .sum(curve.unknowns(), |index, t, x, xdot| written(p, &curve.duals, index).value(&p.model, t, x, xdot, p.k))?;
    let by_sum = gradient(curve.unknowns(), |c| {
        curve.sum(c, |index, t, x, xdot| written(p, &curve.duals, index).value(&p.model, t, x, xdot, p.k))
    })?;
    equalities.extend(values.map(|ours| Equality::numbers("A", ours, value)));
    equalities.push(Equality::vectors("gradient", &ours.gradient, &by_sum));

    let (values, ours) = derivatives(p, curve, by_duals(p, any))?;
    let value = curve.sum(curve.unknowns(), |_, t, x, xdot| any.value(&p.model, t, x, xdot, p.k))?;
    let by_sum = gradient(curve.unknowns(), |c| curve.sum(c, |_, t, x, xdot| any.value(&p.model, t, x, xdot, p.k)))?;
    equalities.extend(values.map(|ours| Equality::numbers("A of any L", ours, value)));
    equalities.push(Equality::vectors("gradient of any L", &ours.gradient, &by_sum));
    Ok(equalities)
}

/// Tests the Hessian along a random direction: a wrong matrix gives the right vector only with the probability of the
/// bound.
fn action_hessian(p: &RandomInstance) -> Result<Vec<Equality>> {
    let curve = &RandomCurve::new(p);
    let any = &any_lagrangian(p)?;
    let along = curve.direction.as_slice();
    let (_, ours) = derivatives(p, curve, analytic(p, &curve.duals)?)?;
    let by_sum = rate(curve.unknowns(), along, |c| {
        gradient(c, |c| {
            curve.sum(c, |index, t, x, xdot| written(p, &curve.duals, index).value(&p.model, t, x, xdot, p.k))
        })
    })?;
    let analytic = ours.hessian.to_dense() * &curve.direction;
    let (_, ours) = derivatives(p, curve, by_duals(p, any))?;
    let by_sum_of_any = rate(curve.unknowns(), along, |c| {
        gradient(c, |c| curve.sum(c, |_, t, x, xdot| any.value(&p.model, t, x, xdot, p.k)))
    })?;
    let of_any = ours.hessian.to_dense() * &curve.direction;
    Ok(vec![
        Equality::vectors("Hessian", &analytic, &by_sum),
        Equality::vectors("Hessian of any L", &of_any, &by_sum_of_any),
    ])
}

/// $M$ of a metric.
fn matrix(p: &RandomInstance, curve: &RandomCurve, metric: impl Metric<Gf>) -> Result<DMatrix<Gf>> {
    let (grid, size) = (curve.grid(), 2 * p.dof());
    let norm = Norm { model: &p.model, kind: RestMetric::Flow, metric, k: p.k, horizon: p.k };
    let mut derivatives = Derivatives::new(&grid, size);
    Objective::new(&grid, norm, size).derivatives(&curve.coefficients, &mut derivatives)?;
    Ok(derivatives.metric.to_dense())
}

/// $\sum_g w_g \varphi_m \varphi_n G$ for the unknown functions.
fn sum_of_metrics(p: &RandomInstance, curve: &RandomCurve, metric: &impl Metric<Gf>) -> Result<DMatrix<Gf>> {
    let (size, functions) = (2 * p.dof(), curve.coefficients.ncols());
    let mut sum = DMatrix::zeros(size * functions, size * functions);
    for (index, time) in curve.times.iter().enumerate() {
        let (e, g) = (index / RandomCurve::POINTS, index % RandomCurve::POINTS);
        let first = e * RandomCurve::DEGREE;
        let own = curve.coefficients.columns(first, RandomCurve::DEGREE + 1);
        let values = curve.table.column(3 * g);
        let x = own * values;
        let g_here = metric.matrix(&p.model, *time, x.as_slice(), p.k)?;
        for (m, phi_m) in values.iter().enumerate() {
            for (n, phi_n) in values.iter().enumerate() {
                let at = ((first + m) * size, (first + n) * size);
                let mut block = sum.view_mut(at, (size, size));
                block += &g_here * (curve.weights[g] * *phi_m * *phi_n);
            }
        }
    }
    let unknown = size * (functions - 2);
    Ok(sum.view((size, size), (unknown, unknown)).into_owned())
}

fn metric_of_the_action(p: &RandomInstance) -> Result<Vec<Equality>> {
    let curve = &RandomCurve::new(p);
    let paper = ActuationMetric { weights: ActuationWeights::diagonal(p.w.as_slice().to_vec())? };
    Ok(vec![
        Equality::new("metric of the flow", matrix(p, curve, &paper)?, sum_of_metrics(p, curve, &paper)?),
        Equality::new("any metric", matrix(p, curve, Coupled)?, sum_of_metrics(p, curve, &Coupled)?),
    ])
}
