//! The analytic Lagrangian and its metric at a point.

use super::{analytic, written};
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::flow::weak::{LagrangianDerivatives, PointLagrangian, StatePoints};
use crate::flow::{ActuationMetric, ActuationWeights, Lagrangian, Metric};
use crate::scalar::{AlgebraOver, Tanh};
use crate::verify::duals::Written;
use crate::verify::field::discretisation::numbers;
use crate::verify::field::{Equality, Gf, Jet1, RandomInstance};
use crate::verify::reference::{gradient, jacobian, rate, vector};
use nalgebra::{DMatrix, DVector};
use num_traits::{One, Zero};

/// Uses five points, which do not fill the lanes; the Lagrangian is disabled at one of them.
pub(super) fn analytic_lagrangian(p: &RandomInstance) -> Result<Vec<Equality>> {
    const POINTS: usize = 5;
    const SILENT: usize = 3;
    let (mut number, n) = (numbers(p), p.dof());
    let states = DMatrix::from_fn(4 * n, POINTS, |_, _| number());
    let duals = DMatrix::from_fn(n, POINTS, |_, _| number());
    let direction = DVector::from_fn(4 * n, |_, _| number());
    let times = [Gf::zero(); POINTS];
    let at = StatePoints {
        first: 0,
        times: &times,
        states: &states,
    };
    let mut ours = analytic(p, &duals);
    ours.silent = (0..POINTS).map(|g| g == SILENT).collect();
    let mut values = vec![Gf::zero(); POINTS];
    let [mut all, mut convex] = [(); 2].map(|()| LagrangianDerivatives::new(n, POINTS));
    convex.convex = true;
    ours.values(at, &mut values)?;
    ours.derivatives(at, &mut all)?;
    ours.derivatives(at, &mut convex)?;
    let mut metrics = DMatrix::zeros(4 * n * n, POINTS);
    ours.metrics(at, &mut metrics)?;

    let paper = ActuationMetric {
        weights: ActuationWeights::diagonal(p.w.as_slice().to_vec())?,
    };
    let mut equalities = Vec::new();
    for g in 0..POINTS {
        let y = states.column(g).into_owned();
        let y = [
            &y.as_slice()[..2 * n],
            &y.as_slice()[3 * n..],
            &y.as_slice()[2 * n..3 * n],
        ];
        let y = y.concat();
        let along = direction.as_slice();
        let share = if g == SILENT { Gf::zero() } else { Gf::one() };
        let definition = Definition {
            p,
            written: written(p, &duals, g),
        };
        let value = definition.value(&y)? * share;
        let slopes = gradient(&y, |y| definition.value(y))? * share;
        let second = rate(&y, along, |y| gradient(y, |y| definition.value(y)))? * share;
        let model_of_newton = definition.gauss_newton(&y, along)? * share;
        let metric = paper.matrix(&p.model, times[g], &y[..2 * n], p.k)?;
        equalities.extend([
            Equality::numbers("value", values[g], value),
            Equality::numbers("value beside derivatives", all.values[g], value),
            Equality::vectors("gradient", &gradient_at(&all, g), &slopes),
            Equality::vectors("Hessian", &along_hessian(&all, g, &direction), &second),
            Equality::vectors(
                "Gauss and Newton",
                &along_hessian(&convex, g, &direction),
                &model_of_newton,
            ),
            Equality::vectors(
                "metric",
                &metrics.column(g).into_owned(),
                &vector(metric.as_slice()),
            ),
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

    /// The second derivatives along a direction with the control replaced by its tangent at `y`.
    fn gauss_newton(&self, y: &[Gf], along: &[Gf]) -> Result<DVector<Gf>> {
        let (p, n) = (self.p, self.p.dof());
        let control = |y: &[Jet1]| -> Result<DVector<Jet1>> {
            let mut u = DVector::zeros(n);
            let (q, v, a) = (&y[..n], &y[n..2 * n], &y[3 * n..]);
            rnea(
                &p.model,
                &mut Data::new(&p.model),
                q,
                v,
                a,
                u.as_mut_slice(),
            )?;
            Ok(u)
        };
        let by_y = jacobian(y, control)?;
        let moved = (&by_y * vector(along)).component_mul(&self.written.weights[0]);
        let two = Gf::one() + Gf::one();
        // Everything else is quadratic, so its Hessian is constant.
        let [_, velocity, acceleration] = &self.written.weights;
        let rest = Written {
            weights: [DVector::zeros(n), velocity.clone(), acceleration.clone()],
            dual: self.written.dual.clone(),
        };
        let rest = Definition { p, written: rest };
        let rest = rate(y, along, |y| gradient(y, |y| rest.value(y)))?;
        Ok(by_y.transpose() * moved * two + rest)
    }
}

/// $[L_x; L_{\dot x}]$ at point `g`.
fn gradient_at(all: &LagrangianDerivatives<Gf>, g: usize) -> DVector<Gf> {
    let count = all.values.len();
    let [x, rate] = [g, count + g].map(|column| all.gradients.column(column).into_owned());
    vector(&[x.as_slice(), rate.as_slice()].concat())
}

/// The second derivatives at point `g` along a direction.
fn along_hessian(
    all: &LagrangianDerivatives<Gf>,
    g: usize,
    direction: &DVector<Gf>,
) -> DVector<Gf> {
    let (count, size) = (all.values.len(), all.gradients.nrows());
    let mut sum = DVector::zeros(2 * size);
    for kind in 0..4 {
        let block = all.hessians.column(kind * count + g);
        let block = DMatrix::from_column_slice(size, size, block.as_slice());
        let mut rows = sum.rows_mut(kind / 2 * size, size);
        rows += block * direction.rows(kind % 2 * size, size);
    }
    sum
}
