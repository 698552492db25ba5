//! The direct method with a user-defined running cost and a free horizon.

use super::discretisation::{Discretisation, numbers};
use super::{Equality, Gf, Identity, RandomInstance};
use crate::cost::{ChainRule, ControlEffort, Point as CurvePoint, PointCost, PointDerivatives, StageDerivatives};
use crate::error::Result;
use crate::scalar::AlgebraOver;
use crate::transcription::{Derivatives, HorizonDerivatives, Horizons, Objective};
use crate::verify::reference::{gradient, inverse_dynamics, jacobian, rate, unit, vector};
use nalgebra::{DMatrix, DVector};
use num_traits::Zero;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    vec![
        Identity {
            label: "running cost chain rule",
            statement: "gradient and Hessian of l(z, ID(z)) in z are those by duals",
            convention: "y = [z; u], z = [q; v; a]; l any cubic in y",
            claims: chain_rule,
        },
        Identity {
            label: "transcription horizon",
            statement: "the derivatives of J in T are those by duals, nested ones for the second and mixed ones",
            convention: "l = t |u|^2 and |u|^2; any functions, weights and coefficients that are affine in T",
            claims: horizon,
        },
        Identity {
            label: "transcription parts",
            statement: "the derivatives of J in coefficients and in horizons of parts are those by duals of a sum",
            convention: "l = |u|^2, and t |u|^2 for the slopes; any functions, weights, coefficients and reference",
            claims: parts,
        },
    ]
}

/// A cubic that couples every entry of `y` with others.
fn cubic<S: AlgebraOver<Gf>>(weights: &[Gf], y: &[S]) -> S {
    let count = y.len();
    (0..count).fold(S::zero(), |sum, i| {
        let (next, far) = (y[(i + 1) % count], y[(i + count / 2 + 1) % count]);
        sum + y[i].scale(weights[i]) * (S::one() + next + y[i] * far)
    })
}

/// The cubic with the control as the last entries.
fn along_motions<S: AlgebraOver<Gf>>(p: &RandomInstance, weights: &[Gf], z: &[S]) -> Result<S> {
    let n = p.dof();
    let u = inverse_dynamics(&p.model, &z[..n], &z[n..2 * n], &z[2 * n..])?;
    Ok(cubic(weights, &[z, u.as_slice()].concat()))
}

fn chain_rule(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, mut number) = (p.dof(), numbers(p));
    let weights: Vec<Gf> = (0..4 * n).map(|_| number()).collect();
    let z = [p.x.as_slice(), &p.xdot.as_slice()[n..]].concat();
    let point = CurvePoint { index: 0, phase: 0, time: Gf::zero(), q: &z[..n], v: &z[n..2 * n], a: &z[2 * n..] };
    let mut rule = ChainRule::new(&p.model);
    let y = [&z, rule.linearise(point)?].concat();
    let mut by_y = StageDerivatives::new(n);
    by_y.gradient = gradient(&y, |y| Ok(cubic(&weights, y)))?;
    by_y.hessian = jacobian(&y, |y| gradient(y, |y| Ok(cubic(&weights, y))))?;
    let (mut left, mut hessian) = (DVector::zeros(3 * n), DMatrix::zeros(3 * n, 3 * n));
    rule.gradient(&by_y.gradient, &mut left);
    rule.pull_back(&by_y.hessian, &mut hessian);
    let by_u = &by_y.gradient.as_slice()[3 * n..];
    rule.add_curvature(point, by_u, &mut hessian)?;

    let right = gradient(&z, |z| along_motions(p, &weights, z))?;
    let direction: Vec<Gf> = (0..3 * n).map(|_| number()).collect();
    let image = rate(&z, &direction, |z| gradient(z, |z| along_motions(p, &weights, z)))?;
    Ok(vec![
        Equality::vectors("gradient", &left, &right),
        Equality::vectors("Hessian", &(hessian * vector(&direction)), &image),
    ])
}

/// The effort times time.
struct LateEffort<'m, S: AlgebraOver<Gf>>(ControlEffort<'m, Gf, S>);

impl<S: AlgebraOver<Gf>> PointCost<S> for LateEffort<'_, S> {
    fn value(&mut self, point: CurvePoint<'_, S>) -> Result<S> {
        Ok(self.0.value(point)? * point.time)
    }

    fn derivatives(&mut self, point: CurvePoint<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        let value = self.0.derivatives(point, out)?;
        out.gradient *= point.time;
        Ok(value * point.time)
    }

    fn time_rate(&mut self, point: CurvePoint<'_, S>) -> Result<S> {
        self.0.value(point)
    }
}

/// The derivatives of a cost at a horizon, in it and in the unknown coefficients.
fn at_a_horizon<P: PointCost<Gf>>(
    p: &RandomInstance,
    example: &Discretisation,
    cost: P,
) -> Result<HorizonDerivatives<Gf>> {
    let (grid, (_, curve)) = (example.grid(), example.on(p.k));
    let mut objective = Objective::new(&grid, cost, p.dof());
    objective.set_horizon(p.k);
    objective.free_horizon(example.rates_at(p.k));
    let mut derivatives = Derivatives::new(&grid, p.dof());
    objective.derivatives(&curve, &mut derivatives)?;
    Ok(derivatives.horizons.swap_remove(0))
}

/// The derivatives of a cost in the coefficients of an example and in the horizons of its two parts.
fn in_parts<P: PointCost<Gf>>(
    p: &RandomInstance,
    example: &Discretisation,
    (horizons, cost): (Horizons<Gf>, P),
) -> Result<Derivatives<Gf>> {
    let grid = example.grid();
    let mut objective = Objective::new(&grid, cost, p.dof());
    objective.set_horizons(&horizons);
    objective.free_horizon([(); 2].map(|()| DMatrix::zeros(p.dof(), grid.count())));
    let mut derivatives = Derivatives::new(&grid, p.dof());
    objective.derivatives(&example.coefficients, &mut derivatives)?;
    Ok(derivatives)
}

/// The cost of an example as the sum of two curves of one segment each, on horizons of their own.
fn sum_of_parts<S: AlgebraOver<Gf>, P: PointCost<S>>(
    example: &Discretisation,
    curve: &DMatrix<S>,
    (horizons, reference): (&[S], Gf),
    cost: impl Fn() -> P,
) -> Result<S> {
    let mut sum = S::zero();
    for (part, horizon) in horizons.iter().enumerate() {
        let begin = match part {
            0 => S::zero(),
            _ => horizons[0] - *horizon,
        };
        // Slopes are the first function and the last but one.
        let mut own = curve.columns(3 * part, 5).into_owned();
        for slope in [0, 3] {
            let mut column = own.column_mut(slope);
            column *= *horizon / S::lift(reference);
        }
        let half = S::one() / S::from_f64(2.0);
        let grid = example.segment(part, *horizon, begin * half);
        sum += Objective::new(&grid, cost(), curve.nrows()).value(&own)?;
    }
    Ok(sum)
}

fn parts(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (example, mut number) = (Discretisation::new(p), numbers(p));
    let [other, reference] = [number() + p.k, number() + p.k + p.k];
    let horizons = || Horizons::of_parts(vec![p.k, other], reference);
    let late = LateEffort(ControlEffort::new(&p.model));
    let late = in_parts(p, &example, (horizons(), late))?.horizons;
    let slopes = gradient(&[p.k, other], |horizons| {
        let curve = example.coefficients.map(AlgebraOver::lift);
        sum_of_parts(&example, &curve, (horizons, reference), || LateEffort(ControlEffort::new(&p.model)))
    })?;

    let found = in_parts(p, &example, (horizons(), ControlEffort::new(&p.model)))?;
    let count = example.unknowns().len();
    let unknowns = [example.unknowns(), &[p.k, other]].concat();
    let by_unknowns = |unknowns: &[Gf]| vector(unknowns);
    let directions = [number(), number()];
    let direction = [example.direction.as_slice(), &directions].concat();
    let image = rate(&unknowns, &direction, |unknowns| {
        gradient(unknowns, |unknowns| {
            let curve = example.with_unknowns(&unknowns[..count]);
            sum_of_parts(&example, &curve, (&unknowns[count..], reference), || ControlEffort::new(&p.model))
        })
    })?;
    let mut own = found.hessian.to_dense() * &example.direction;
    let mut of_horizons = Vec::new();
    for (of, by) in found.horizons.iter().zip(directions) {
        own += &of.mixed * by;
        of_horizons.push(of.mixed.dot(&example.direction) + of.second * by);
    }
    let all = [own.as_slice(), &of_horizons].concat();
    let late: Vec<Gf> = late.iter().map(|of| of.first).collect();
    Ok(vec![
        Equality::vectors("slopes", &vector(&late), &slopes),
        Equality::vectors("second derivatives", &by_unknowns(&all), &image),
    ])
}

fn horizon(p: &RandomInstance) -> Result<Vec<Equality>> {
    let example = Discretisation::new(p);
    let late = LateEffort(ControlEffort::new(&p.model));
    let late = at_a_horizon(p, &example, late)?.first;
    let slope = gradient(&[p.k], |horizon| {
        let (grid, curve) = example.on(horizon[0]);
        let cost = LateEffort(ControlEffort::new(&p.model));
        Objective::new(&grid, cost, p.dof()).value(&curve)
    })?;

    let HorizonDerivatives { second, mixed, .. } = at_a_horizon(p, &example, ControlEffort::new(&p.model))?;
    // The unknowns are the changes of the coefficients, then the horizon.
    let count = mixed.len();
    let mut unknowns = vec![Gf::zero(); count];
    unknowns.push(p.k);
    let right = rate(&unknowns, &unit(count + 1, count), |unknowns| {
        gradient(unknowns, |unknowns| {
            let (grid, mut curve) = example.on(unknowns[count]);
            Discretisation::add_to_unknowns(&mut curve, &unknowns[..count]);
            let cost = ControlEffort::new(&p.model);
            Objective::new(&grid, cost, p.dof()).value(&curve)
        })
    })?;
    Ok(vec![
        Equality::numbers("slope", late, slope[0]),
        Equality::numbers("second derivative", second, right[count]),
        Equality::vectors("mixed derivatives", &mixed, &right.rows(0, count).into_owned()),
    ])
}
