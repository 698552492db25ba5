//! The analytic Lagrangian at a point.

use super::{analytic, written};
use crate::cost::{PointCost, Points, PointsDerivatives};
use crate::error::Result;
use crate::flow::Lagrangian;
use crate::scalar::{AlgebraOver, Tanh};
use crate::verify::duals::Written;
use crate::verify::field::discretisation::numbers;
use crate::verify::field::{Equality, Gf, RandomInstance};
use crate::verify::reference::{gradient, rate, vector};
use nalgebra::{DMatrix, DVector};
use num_traits::Zero;

/// Uses five points, which do not fill the lanes.
pub(super) fn analytic_lagrangian(p: &RandomInstance) -> Result<Vec<Equality>> {
    const POINTS: usize = 5;
    let (mut number, n) = (numbers(p), p.dof());
    let states = DMatrix::from_fn(2 * n, 3 * POINTS, |_, _| number());
    let multipliers = DMatrix::from_fn(n, POINTS, |_, _| number());
    let direction = DVector::from_fn(4 * n, |_, _| number());
    let points = Points { first: 0, phase: 0, times: &[Gf::zero(); POINTS], states: &states, higher: &[] };
    let mut ours = analytic(p, &multipliers)?;
    let mut values = vec![Gf::zero(); POINTS];
    let mut all = PointsDerivatives::new(2 * n, POINTS);
    ours.values(points, &mut values)?;
    ours.all_derivatives(points, &mut all)?;

    let mut equalities = Vec::new();
    for g in 0..POINTS {
        let y = &states.as_slice()[6 * n * g..][..4 * n];
        let definition = Definition { p, written: written(p, &multipliers, g) };
        let along = [direction.as_slice(), &vec![Gf::zero(); 2 * n]].concat();
        let with_rest = |of: &DVector<Gf>| vector(&[of.as_slice(), &vec![Gf::zero(); 2 * n]].concat());
        let value = definition.value(y)?;
        let slopes = gradient(y, |y| definition.value(y))?;
        let second = rate(y, direction.as_slice(), |y| gradient(y, |y| definition.value(y)))?;
        let gradient = vector(&all.gradients.as_slice()[6 * n * g..][..6 * n]);
        equalities.extend([
            Equality::numbers("value", values[g], value),
            Equality::numbers("value beside derivatives", all.costs[g], value),
            Equality::vectors("gradient", &gradient, &with_rest(&slopes)),
            Equality::vectors("Hessian", &(all.hessians.get(g) * vector(&along)), &with_rest(&second)),
        ]);
    }
    Ok(equalities)
}

/// The Lagrangian by its definition, at $[x; \dot x]$.
struct Definition<'a> {
    p: &'a RandomInstance,
    written: Written<Gf>,
}

impl Definition<'_> {
    fn value<S: AlgebraOver<Gf> + Tanh>(&self, y: &[S]) -> Result<S> {
        let (x, xdot) = y.split_at(y.len() / 2);
        let p = self.p;
        self.written.value(&p.model, S::lift(p.t), x, xdot, p.k)
    }
}
