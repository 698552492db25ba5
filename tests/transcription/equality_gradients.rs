//! The gradients of equalities at the collocated points.

use super::objective::{ends, random};
use aghf::cost::{Point, PointCost, PointDerivatives};
use aghf::curve::Basis;
use aghf::error::Result;
use aghf::transcription::{Derivatives, Grid, Horizons, Objective};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// $\sum_i v_i \sin q_i + a_i^2 + 2$ and its derivatives.
fn equality(q: &[f64], v: &[f64], a: &[f64]) -> (f64, DMatrix<f64>) {
    let n = q.len();
    let sum: f64 = (0..n).map(|i| v[i] * q[i].sin() + a[i] * a[i]).sum();
    let slopes = DMatrix::from_fn(n, 3, |i, x| [v[i] * q[i].cos(), q[i].sin(), 2.0 * a[i]][x]);
    (sum + 2.0, slopes)
}

/// A cost that is the equality at one point and zero elsewhere, with its value there.
struct Alone {
    point: usize,
    value: f64,
}

impl PointCost<f64> for Alone {
    fn value(&mut self, point: Point<'_, f64>) -> Result<f64> {
        self.derivatives(point, &mut PointDerivatives::new(point.q.len()))
    }

    fn derivatives(&mut self, point: Point<'_, f64>, out: &mut PointDerivatives<f64>) -> Result<f64> {
        out.gradient.fill(0.0);
        out.hessian.fill(0.0);
        if point.index != self.point {
            return Ok(0.0);
        }
        let (value, slopes) = equality(point.q, point.v, point.a);
        out.gradient.copy_from_slice(slopes.as_slice());
        self.value = value;
        Ok(value)
    }
}

/// Value, gradient, derivative in the horizon of part `part`, and weight of the equality at a point.
fn alone(
    objective: &mut Objective<'_, f64, Alone>,
    point: usize,
    (coefficients, part): (&DMatrix<f64>, usize),
    horizon: f64,
    out: &mut Derivatives<f64>,
) -> (f64, Vec<f64>, f64) {
    objective.cost_mut().point = point;
    let sum = objective.derivatives(coefficients, out).expect("sizes agree");
    let value = objective.cost().value;
    let weight = sum / value;
    let gradient = out.gradient.iter().map(|slope| slope / weight).collect();
    (weight / horizon, gradient, (out.horizons[part].first - sum / horizon) / weight)
}

/// The gradients are those of a cost that is the equality at one point, divided by the weight of that: with a given
/// horizon, one that moves coefficients, and parts with slopes of their own.
#[test]
fn gradients_are_those_of_a_cost_at_one_point() {
    let (n, basis) = (2, Basis::new(4, 6, ends(false, true)));
    let grid = Grid::collocated(&basis, [7, 3], 1.0);
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let coefficients = random(&mut rng, n, basis.count());
    let none = DMatrix::zeros(n, basis.count());
    for (horizons, rates) in [
        (Horizons::one(1.3), None),
        (Horizons::one(1.3), Some(random(&mut rng, n, basis.count()))),
        (Horizons::of_parts(vec![0.8, 1.7], 1.2), Some(none.clone())),
    ] {
        let mut objective = Objective::new(&grid, Alone { point: 0, value: 0.0 }, n);
        objective.set_horizons(&horizons);
        let is_free = rates.is_some();
        if let Some(rates) = rates {
            objective.free_horizon([rates, none.clone()]);
        }
        let mut out = Derivatives::new(&grid, n);
        let parts = horizons.parts().len();
        let part = |segment: usize| segment * parts / 4;
        let mut expected = Vec::new();
        for point in 0..40 {
            let segment = point / 10;
            let horizon = horizons.parts()[part(segment)];
            let of = (&coefficients, part(segment));
            let (weight, gradient, late) = alone(&mut objective, point, of, horizon, &mut out);
            // The collocated points have a small share of the quadrature.
            if weight < 1e-3 {
                expected.push((segment, gradient, late));
            }
        }
        let at_points = |_: &mut Alone, states: &DMatrix<f64>| {
            let mut slopes = DMatrix::zeros(n, states.ncols());
            for g in 0..states.ncols() / 3 {
                let [q, v, a] = [0, 1, 2].map(|x| states.column(3 * g + x).as_slice().to_vec());
                slopes.columns_mut(3 * g, 3).copy_from(&equality(&q, &v, &a).1);
            }
            Ok(vec![slopes])
        };
        let mut found = Vec::new();
        let mut each = |segment: usize, gradient: &nalgebra::DVector<f64>, late: f64| {
            found.push((segment, gradient.as_slice().to_vec(), late));
        };
        objective.equality_gradients(&coefficients, at_points, &mut each).expect("no function fails");
        assert_eq!((found.len(), expected.len()), (12, 12));
        for ((segment, gradient, late), (known, slopes, by_horizon)) in found.iter().zip(&expected) {
            assert_eq!(segment, known);
            assert_close!(gradient, slopes, 1e-9);
            if is_free {
                assert_close!(&[*late], &[*by_horizon], 1e-8);
            }
        }
    }
}
