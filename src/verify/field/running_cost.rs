//! The relaxation with a running cost of one's own and a free horizon.

use super::reference::{JJ, jacobian, rate, unit, vector};
use super::{Equality, F, Identity, Point};
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::relax::{
    ChainRule, ControlEffort, Grid, Objective, Point as CurvePoint, PointCost, PointDerivatives,
    StageDerivatives, horizon_slope,
};
use crate::scalar::{AlgebraOver, Jet};
use nalgebra::{DMatrix, DVector};
use num_traits::{One, Zero};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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
            label: "relaxation horizon",
            statement: "the derivative of J in T is that by duals",
            convention: "l = t |u|^2; any functions, weights and coefficients that are affine in T",
            claims: horizon,
        },
    ]
}

/// Random numbers that go with a point.
fn numbers(p: &Point) -> impl FnMut() -> F {
    let mut rng = ChaCha8Rng::seed_from_u64(p.k.residue());
    move || F::new(rng.random_range(0..F::ORDER))
}

/// A cubic that couples every entry of `y` with others.
fn cubic<S: AlgebraOver<F>>(weights: &[F], y: &[S]) -> S {
    let count = y.len();
    (0..count).fold(S::zero(), |sum, i| {
        let (next, far) = (y[(i + 1) % count], y[(i + count / 2 + 1) % count]);
        sum + y[i].scale(weights[i]) * (S::one() + next + y[i] * far)
    })
}

/// The same with the control for the last entries.
fn along_motions<S: AlgebraOver<F>>(p: &Point, weights: &[F], z: &[S]) -> Result<S> {
    let n = p.dof();
    let mut y = [z, &vec![S::zero(); n]].concat();
    let (z, u) = y.split_at_mut(3 * n);
    let (q, rest) = z.split_at(n);
    let (v, a) = rest.split_at(n);
    rnea(&p.model, &mut Data::new(&p.model), q, v, a, u)?;
    Ok(cubic(weights, &y))
}

/// Numbers that move along entry `i`.
fn moved<S: AlgebraOver<F>>(x: &[S], i: usize) -> Vec<Jet<S, 1>> {
    let along: Vec<S> = unit(x.len(), i);
    let both = x.iter().zip(along);
    both.map(|(x, e)| Jet::new(*x, [e])).collect()
}

fn chain_rule(p: &Point) -> Result<Vec<Equality>> {
    let (n, mut number) = (p.dof(), numbers(p));
    let weights: Vec<F> = (0..4 * n).map(|_| number()).collect();
    let z = [p.x.as_slice(), &p.xdot.as_slice()[n..]].concat();
    let point = CurvePoint {
        index: 0,
        time: F::zero(),
        q: &z[..n],
        v: &z[n..2 * n],
        a: &z[2 * n..],
    };
    let mut rule = ChainRule::new(&p.model);
    let y = [&z, rule.linearise(point)?].concat();
    let mut by_y = StageDerivatives::new(n);
    let gradient = jacobian(&y, |y| Ok(vec![cubic(&weights, y)]))?;
    by_y.gradient.copy_from(&gradient.row(0).transpose());
    for i in 0..4 * n {
        let row = jacobian(&y, |y| Ok(vec![cubic(&weights, &moved(y, i)).eps[0]]))?;
        by_y.hessian.row_mut(i).copy_from(&row);
    }
    let (mut left, mut hessian) = (DVector::zeros(3 * n), DMatrix::zeros(3 * n, 3 * n));
    rule.gradient(&by_y.gradient, &mut left);
    rule.pull_back(&by_y.hessian, &mut hessian);
    let by_u = &by_y.gradient.as_slice()[3 * n..];
    rule.add_curvature(point, by_u, &mut hessian)?;

    let right = jacobian(&z, |z| Ok(vec![along_motions(p, &weights, z)?]))?;
    let direction: Vec<F> = (0..3 * n).map(|_| number()).collect();
    let mut image = DVector::zeros(3 * n);
    for i in 0..3 * n {
        let rates = rate(&z, &direction, |z| {
            let moved: Vec<JJ> = moved(z, i);
            Ok(vec![along_motions(p, &weights, &moved)?.eps[0]])
        })?;
        image[i] = rates[0];
    }
    Ok(vec![
        Equality::vectors("gradient", &left, &right.row(0).transpose()),
        Equality::vectors("Hessian", &(hessian * vector(&direction)), &image),
    ])
}

/// The effort times time.
struct LateEffort<'m, S: AlgebraOver<F>>(ControlEffort<'m, F, S>);

impl<S: AlgebraOver<F>> PointCost<S> for LateEffort<'_, S> {
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

/// Two segments of degree 4 with two points each, on a horizon that may move.
struct Example {
    times: Vec<F>,
    weights: Vec<F>,
    table: DMatrix<F>,
    coefficients: DMatrix<F>,
    rates: DMatrix<F>,
}

impl Example {
    const COUNT: usize = 8;

    fn new(p: &Point) -> Self {
        let (mut number, n) = (numbers(p), p.dof());
        let mut matrix = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| number());
        Self {
            times: matrix(4, 1).as_slice().to_vec(),
            weights: matrix(2, 1).as_slice().to_vec(),
            table: matrix(5, 6),
            coefficients: matrix(n, Self::COUNT),
            rates: matrix(n, Self::COUNT),
        }
    }

    /// The functions in time, and the coefficients.
    fn on<S: AlgebraOver<F>>(&self, horizon: S) -> (Grid<S>, DMatrix<S>) {
        let rate = S::one() / horizon;
        let powers = [S::one(), rate, rate * rate];
        let shape = self.table.shape();
        let table = DMatrix::from_fn(shape.0, shape.1, |f, column| {
            powers[column % 3].scale(self.table[(f, column)])
        });
        let scaled = |x: &[F]| x.iter().map(|x| horizon.scale(*x)).collect();
        let free = 2..Self::COUNT - 2;
        let grid = Grid::from_table(2, free, scaled(&self.times), scaled(&self.weights), table);
        let moved = |c: F, rate: F| S::lift(c) + horizon.scale(rate);
        (grid, self.coefficients.zip_map(&self.rates, moved))
    }
}

fn horizon(p: &Point) -> Result<Vec<Equality>> {
    let (example, horizon) = (Example::new(p), p.k);
    let (grid, curve) = example.on(horizon);
    let mut cost = LateEffort(ControlEffort::new(&p.model));
    let left = horizon_slope(&grid, &mut cost, &curve, &example.rates, horizon)?;
    let right = rate(&[horizon], &[F::one()], |horizon| {
        let (grid, curve) = example.on(horizon[0]);
        let cost = LateEffort(ControlEffort::new(&p.model));
        Ok(vec![Objective::new(&grid, cost, p.dof()).value(&curve)?])
    })?;
    Ok(vec![Equality::numbers("slope", left, right[0])])
}
