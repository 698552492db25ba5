//! The relaxation: the derivatives of its objective, and what it has to do with the flow.

use super::reference::{JJ, Reference, effort, jacobian, rate, stack, unit, variation};
use super::{Equality, F, Identity, Point};
use crate::error::Result;
use crate::flow::{ControlForm, RightHandSide};
use crate::linalg::Ldlt;
use crate::relax::{
    ControlEffort, Derivatives, Grid, Objective, Point as CurvePoint, PointCost, PointDerivatives,
};
use crate::scalar::{AlgebraOver, Jet};
use nalgebra::{DMatrix, DVector};
use num_traits::{One, Zero};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let identity = |label, statement, convention, claims| Identity {
        label,
        statement,
        convention,
        claims,
    };
    let objective = "J is a sum over quadrature points; any functions, weights and coefficients";
    let curve =
        "at a point with xdot_P1 = x_P2 and xddot_P1 = xdot_P2, for the variation (phi, phi')";
    vec![
        identity(
            "relaxation gradient",
            "the gradient of J is that by duals",
            objective,
            objective_gradient,
        ),
        identity(
            "relaxation Hessian",
            "the Hessian of J is that by duals of the gradient by duals",
            objective,
            objective_hessian,
        ),
        identity(
            "relaxation and flow",
            "the variation of |u|^2 is d/dt (p . dx) - dx^T G Omega",
            curve,
            flow_of_the_objective,
        ),
        identity(
            "relaxation Euler step",
            "an implicit Euler step, linearised, is a damped step of Newton",
            "step size h, metric D, damping 1 / h",
            euler_step,
        ),
    ]
}

/// A discretised objective: two segments of degree 4 with two points each, all numbers random.
struct Example {
    grid: Grid<F>,
    coefficients: DMatrix<F>,
    direction: DVector<F>,
    free: std::ops::Range<usize>,
}

impl Example {
    fn new(p: &Point) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(p.k.residue());
        let mut number = || F::new(rng.random_range(0..F::ORDER));
        let (segments, points, functions, count) = (2, 2, 5, 8);
        // The last function but one is free, as with a free final velocity.
        let free = 2..count - 1;
        let times = (0..segments * points).map(|_| number()).collect();
        let weights = (0..points).map(|_| number()).collect();
        let table = DMatrix::from_fn(functions, 3 * points, |_, _| number());
        let coefficients = DMatrix::from_fn(p.dof(), count, |_, _| number());
        Self {
            direction: DVector::from_fn(free.len() * p.dof(), |_, _| number()),
            grid: Grid::from_table(segments, free.clone(), times, weights, table),
            coefficients,
            free,
        }
    }

    fn unknowns(&self) -> &[F] {
        let n = self.coefficients.nrows();
        &self.coefficients.as_slice()[self.free.start * n..self.free.end * n]
    }

    /// The objective with other unknowns, over any scalar.
    fn value<S: AlgebraOver<F>>(&self, p: &Point, unknowns: &[S]) -> Result<S> {
        let first = self.free.start * p.dof();
        let mut coefficients = self.coefficients.map(S::lift);
        coefficients.as_mut_slice()[first..first + unknowns.len()].copy_from_slice(unknowns);
        let grid = self.grid.map(S::lift);
        Objective::new(&grid, ControlEffort::new(&p.model), p.dof()).value(&coefficients)
    }

    fn derivatives(&self, p: &Point) -> Result<(F, Derivatives<F>)> {
        let mut derivatives = Derivatives::new(&self.grid, p.dof());
        let cost = ControlEffort::new(&p.model);
        let value = Objective::new(&self.grid, cost, p.dof())
            .derivatives(&self.coefficients, &mut derivatives)?;
        Ok((value, derivatives))
    }
}

fn objective_gradient(p: &Point) -> Result<Vec<Equality>> {
    let example = Example::new(p);
    let (value, derivatives) = example.derivatives(p)?;
    let by_duals = jacobian(example.unknowns(), |c| Ok(vec![example.value(p, c)?]))?;
    Ok(vec![
        Equality::numbers("J", value, example.value(p, example.unknowns())?),
        Equality::vectors(
            "gradient",
            &derivatives.gradient,
            &by_duals.row(0).transpose(),
        ),
    ])
}

/// A matrix that is wrong maps a random direction to the right vector with the probability of the bound only.
fn objective_hessian(p: &Point) -> Result<Vec<Equality>> {
    let example = Example::new(p);
    let (_, derivatives) = example.derivatives(p)?;
    let unknowns = example.unknowns();
    let mut right = DVector::zeros(unknowns.len());
    for i in 0..unknowns.len() {
        let rates = rate(unknowns, example.direction.as_slice(), |c| {
            let e: Vec<_> = unit(c.len(), i);
            let moved: Vec<JJ> = c.iter().zip(&e).map(|(c, e)| Jet::new(*c, [*e])).collect();
            Ok(vec![example.value(p, &moved)?.eps[0]])
        })?;
        right[i] = rates[0];
    }
    let left = derivatives.hessian.to_dense() * &example.direction;
    Ok(vec![Equality::vectors("Hessian", &left, &right)])
}

/// The same point on the manifold $v = \dot q$.
fn on_the_manifold(p: &Point) -> Point {
    let n = p.dof();
    let (v, a) = (p.x.rows(n, n), p.xdot.rows(n, n));
    Point {
        model: p.model.clone(),
        weightless: p.weightless.clone(),
        xdot: stack(&v.into_owned(), &a.into_owned()),
        xddot: stack(&a.into_owned(), &p.xddot.rows(n, n).into_owned()),
        x: p.x.clone(),
        w: p.w.clone(),
        ..*p
    }
}

fn flow_of_the_objective(p: &Point) -> Result<Vec<Equality>> {
    let (p, n) = (&on_the_manifold(p), p.dof());
    let moves = [
        &p.w,
        &(&p.w * p.extra[0]),
        &(&p.w * p.extra[1] + &p.w.map(|w| w * w)),
    ];
    let state = [p.x.rows(0, n), p.x.rows(n, n), p.xdot.rows(n, n)];

    let mut cost = ControlEffort::new(&p.model);
    let mut derivatives = PointDerivatives::new(n);
    let [q, v, a] = state.each_ref().map(|part| part.as_slice());
    let point = CurvePoint {
        index: 0,
        time: F::zero(),
        q,
        v,
        a,
    };
    cost.derivatives(point, &mut derivatives)?;
    let left = (0..3).fold(F::zero(), |sum, i| {
        sum + derivatives.gradient.rows(i * n, n).dot(moves[i])
    });

    let by_lagrangian = variation(p, |x: &[JJ], xdot: &[JJ]| effort(p, x, xdot))?;
    let (dx, dxdot) = (stack(moves[0], moves[1]), stack(moves[1], moves[2]));
    let mut omega = DVector::zeros(2 * n);
    ControlForm::new(&p.model).omega(p.node(), p.k, omega.as_mut_slice())?;
    let flow = Reference::at(p)?.metric() * omega;
    let momentum = by_lagrangian.by_xdot.dot(&dxdot) + by_lagrangian.momentum_rate.dot(&dx);
    Ok(vec![Equality::numbers(
        "variation",
        left,
        momentum - dx.dot(&flow),
    )])
}

fn euler_step(p: &Point) -> Result<Vec<Equality>> {
    let example = Example::new(p);
    let (_, derivatives) = example.derivatives(p)?;
    let Derivatives {
        gradient,
        hessian,
        metric,
    } = derivatives;
    let (hessian, metric, h) = (hessian.to_dense(), metric.to_dense(), p.k);
    let solve = |matrix: DMatrix<F>, mut b: DVector<F>| {
        let mut ldlt = Ldlt::new(b.len());
        ldlt.factorise(&matrix);
        ldlt.solve(b.as_mut_slice());
        b
    };
    // c' = -D^-1 g(c) implicitly: D (c1 - c0) + h g(c1) = 0, with g(c1) to first order.
    let euler = solve(&metric + &hessian * h, -&gradient * h);
    let newton = solve(hessian + metric * (F::one() / h), -gradient);
    Ok(vec![Equality::vectors("step", &euler, &newton)])
}
