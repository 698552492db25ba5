//! The direct method with a user-defined running cost and a free horizon.

use super::discretisation::{Discretisation, numbers};
use super::{Equality, Gf, Identity, RandomInstance};
use crate::cost::{
    ChainRule, ControlEffort, Point as CurvePoint, PointCost, PointDerivatives, StageDerivatives,
};
use crate::error::Result;
use crate::scalar::AlgebraOver;
use crate::transcription::{Derivatives, HorizonDerivatives, Objective};
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
    let point = CurvePoint {
        index: 0,
        phase: 0,
        time: Gf::zero(),
        q: &z[..n],
        v: &z[n..2 * n],
        a: &z[2 * n..],
    };
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
    let image = rate(&z, &direction, |z| {
        gradient(z, |z| along_motions(p, &weights, z))
    })?;
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

    fn derivatives(
        &mut self,
        point: CurvePoint<'_, S>,
        out: &mut PointDerivatives<S>,
    ) -> Result<S> {
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
    objective.free_horizon(example.rates.clone());
    let mut derivatives = Derivatives::new(&grid, p.dof());
    objective.derivatives(&curve, &mut derivatives)?;
    Ok(derivatives.horizon)
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

    let HorizonDerivatives { second, mixed, .. } =
        at_a_horizon(p, &example, ControlEffort::new(&p.model))?;
    // The unknowns are what is added to the coefficients, then the horizon.
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
        Equality::vectors(
            "mixed derivatives",
            &mixed,
            &right.rows(0, count).into_owned(),
        ),
    ])
}
