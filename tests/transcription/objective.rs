//! The transcribed objective: its derivatives.

use crate::common::{slider, tree};
use aghf::cost::{ControlEffort, Point, PointCost, PointDerivatives, Points, PointsDerivatives};
use aghf::curve::{Basis, Continuity};
use aghf::error::Result;
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Jet, Scalar};
use aghf::transcription::{Derivatives, Grid, Objective};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub fn random(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

/// The effort with squared jerks.
pub fn effort_and_jerk<S: AlgebraOver<f64>>(model: &Model) -> ControlEffort<'_, f64, S> {
    let weights: Vec<S> = (0..model.dof()).map(|i| S::lift(0.3 + i as f64)).collect();
    let cost = ControlEffort::new(model).with_higher(&[&weights]);
    cost.expect("a weight for each joint")
}

/// The objective over numbers that move twice.
fn second_order(model: &Model, basis: &Basis, coefficients: &DMatrix<f64>, moving: [usize; 2]) -> Jet<Jet<f64, 1>, 1> {
    type Twice = Jet<Jet<f64, 1>, 1>;
    let grid = Grid::new(basis, 7, 1.3).map(<Twice as AlgebraOver<f64>>::lift);
    let mut lifted = coefficients.map(<Twice as AlgebraOver<f64>>::lift);
    let (n, free) = (model.dof(), basis.free());
    let entry = |unknown: usize| (unknown % n, free[unknown / n]);
    lifted[entry(moving[0])].re.eps[0] += 1.0;
    lifted[entry(moving[1])].eps[0].re += 1.0;
    Objective::new(&grid, effort_and_jerk::<Twice>(model), model.dof()).value(&lifted).expect("sizes agree")
}

/// Continuous velocities, or accelerations as well, with rest at the start and a given or a free final state.
pub fn ends(acceleration: bool, free_end: bool) -> Continuity {
    Continuity {
        acceleration,
        fixed_accelerations: [acceleration, false],
        free_final_velocity: free_end,
        free_final_position: free_end,
        corners: false,
        free_start: false,
    }
}

/// Gradient and Hessian of one and of several segments, with and without a free final state.
#[test]
fn derivatives_are_those_of_duals() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for (n, seed, segments, degree, continuity) in [
        (3, 1, 1, 6, ends(false, false)),
        (4, 2, 1, 5, ends(false, true)),
        (2, 5, 3, 4, ends(false, true)),
        (2, 5, 3, 6, ends(true, false)),
        (2, 5, 2, 7, ends(true, true)),
    ] {
        let model = tree(n, seed);
        let basis = Basis::new(segments, degree, continuity);
        let grid = Grid::new(&basis, 7, 1.3);
        let coefficients = random(&mut rng, n, basis.count());
        let mut objective = Objective::new(&grid, effort_and_jerk(&model), n);
        let mut derivatives = Derivatives::new(&grid, n);
        let value = objective.derivatives(&coefficients, &mut derivatives).expect("sizes agree");
        let again = objective.value(&coefficients).expect("sizes agree");
        assert!((value - again).abs() <= 1e-13 * value);
        let hessian = derivatives.hessian.to_dense();
        let unknowns = hessian.nrows();
        assert_eq!(unknowns, basis.free().len() * n);
        let (mut by_duals, mut slopes) = (DMatrix::zeros(unknowns, unknowns), vec![0.0; unknowns]);
        for i in 0..unknowns {
            for j in 0..=i {
                let dual = second_order(&model, &basis, &coefficients, [i, j]);
                by_duals[(i, j)] = dual.eps[0].eps[0];
                by_duals[(j, i)] = by_duals[(i, j)];
                slopes[i] = dual.re.eps[0];
            }
        }
        // Sums of some hundred products in another order.
        assert_close!(&derivatives.gradient, &slopes, 1e-12);
        assert_close!(&hessian, &by_duals, 1e-12);
    }
}

/// The metric is the Hessian less what the second derivatives of inverse dynamics contribute: that of a linear problem.
#[test]
fn on_a_linear_robot_metric_and_hessian_are_one() {
    let model = slider(2.0);
    let basis = Basis::new(2, 7, Continuity::default());
    let grid = Grid::new(&basis, 8, 0.7);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut derivatives = Derivatives::new(&grid, 1);
    Objective::new(&grid, ControlEffort::new(&model), 1)
        .derivatives(&random(&mut rng, 1, basis.count()), &mut derivatives)
        .expect("sizes agree");
    let (hessian, metric) = (derivatives.hessian.to_dense(), derivatives.metric.to_dense());
    assert_close!(&hessian, &metric, 1e-14);
    // Second derivatives of bubbles are orthonormal in normalised time: 2 m^2 T^-3 on the diagonal, zero beside it.
    let bubbles = hessian.view((0, 0), (4, 4)).into_owned();
    let expected = DMatrix::identity(4, 4) * (2.0 * 4.0 / 0.7_f64.powi(3));
    assert_close!(&bubbles, &expected, 1e-12);
}

/// The cost $q^2 + \dddot q^4$ of each joint.
pub struct OfJerk;

impl<S: Scalar> PointCost<S> for OfJerk {
    fn value(&mut self, _: Point<'_, S>) -> Result<S> {
        unreachable!("all points of a segment are evaluated at once")
    }

    fn derivatives(&mut self, _: Point<'_, S>, _: &mut PointDerivatives<S>) -> Result<S> {
        unreachable!("all points of a segment are evaluated at once")
    }

    fn order(&self) -> usize {
        3
    }

    fn values(&mut self, points: Points<'_, S>, costs: &mut [S]) -> Result<()> {
        let [jerks] = points.higher else { unreachable!("the cost needs one order") };
        for (g, cost) in costs.iter_mut().enumerate() {
            let q = points.point(g).q.iter().enumerate();
            *cost = q.fold(S::zero(), |sum, (i, q)| {
                let j = jerks[(i, g)];
                sum + *q * *q + j * j * j * j
            });
        }
        Ok(())
    }

    fn all_derivatives(&mut self, points: Points<'_, S>, out: &mut PointsDerivatives<S>) -> Result<()> {
        let [jerks] = points.higher else { unreachable!("the cost needs one order") };
        self.values(points, &mut out.costs)?;
        let [two, four, twelve] = [2.0, 4.0, 12.0].map(S::from_f64);
        let n = jerks.nrows();
        for g in 0..points.count() {
            let q = points.point(g).q;
            let hessian = DMatrix::from_fn(3 * n, 3 * n, |i, j| if i == j && i < n { two } else { S::zero() });
            out.hessians.set(g, &hessian);
            for x in 0..3 {
                let slopes = DVector::from_fn(n, |i, _| if x == 0 { two * q[i] } else { S::zero() });
                out.gradients.set_column(3 * g + x, &slopes);
            }
        }
        out.higher = vec![[jerks.map(|j| four * j * j * j), jerks.map(|j| twelve * j * j)]];
        Ok(())
    }
}

/// The derivatives of a cost in the jerk, those in a free horizon included.
#[test]
fn derivatives_in_the_jerk_are_those_of_duals() {
    type Twice = Jet<Jet<f64, 1>, 1>;
    let lift = <Twice as AlgebraOver<f64>>::lift;
    let (n, horizon) = (2, 0.8);
    for (segments, degree, continuity) in [(1, 6, ends(false, false)), (2, 7, ends(true, false))] {
        let basis = Basis::new(segments, degree, continuity);
        let grid = Grid::new(&basis, 9, 1.0);
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let coefficients = random(&mut rng, n, basis.count());
        let mut rates = [(); 2].map(|()| random(&mut rng, n, basis.count()));
        for function in basis.free() {
            for rates in &mut rates {
                rates.column_mut(function).fill(0.0);
            }
        }
        let mut objective = Objective::new(&grid, OfJerk, n);
        objective.free_horizon(rates.clone());
        objective.set_horizon(horizon);
        let mut derivatives = Derivatives::new(&grid, n);
        objective.derivatives(&coefficients, &mut derivatives).expect("sizes agree");
        let (free, lifted_grid) = (basis.free(), grid.map(lift));
        let unknowns = free.len() * n;
        let second_order = |moving: [usize; 2]| {
            let (mut lifted, mut time) = (coefficients.map(lift), lift(horizon));
            for (part, unknown) in moving.into_iter().enumerate() {
                let mut one = lift(0.0);
                match part {
                    0 => one.re.eps[0] = 1.0,
                    _ => one.eps[0].re = 1.0,
                }
                if unknown == unknowns {
                    time += one;
                } else {
                    lifted[(unknown % n, free[unknown / n])] += one;
                }
            }
            let late = time - lift(horizon);
            let [first, second] = &rates;
            lifted += first.zip_map(second, |first, second| late * (lift(first) + late * lift(0.5 * second)));
            let mut objective = Objective::new(&lifted_grid, OfJerk, n);
            objective.set_horizon(time);
            objective.value(&lifted).expect("sizes agree")
        };
        let hessian = derivatives.hessian.to_dense();
        for i in 0..unknowns {
            let slope = second_order([i, i]).re.eps[0];
            assert_close!(&[derivatives.gradient[i]], &[slope], 1e-11);
            for j in 0..=i {
                let second = second_order([i, j]).eps[0].eps[0];
                let scale = hessian[(i, i)].abs().max(hessian[(j, j)].abs());
                assert!((hessian[(i, j)] - second).abs() <= 1e-11 * scale);
            }
            let mixed = second_order([i, unknowns]).eps[0].eps[0];
            let found = derivatives.horizons[0].mixed[i];
            assert!((found - mixed).abs() <= 1e-10 * mixed.abs().max(1.0));
        }
        let own = second_order([unknowns, unknowns]);
        let found = [derivatives.horizons[0].first, derivatives.horizons[0].second];
        assert_close!(&found, &[own.re.eps[0], own.eps[0].eps[0]], 1e-11);
    }
}
