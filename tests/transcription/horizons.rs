//! Parts of a motion with lengths of their own: derivatives of an objective in these.

use super::objective::{OfJerk, effort_and_jerk, ends, random};
use crate::common::tree;
use aghf::cost::PointCost;
use aghf::curve::Basis;
use aghf::scalar::{AlgebraOver, Jet};
use aghf::transcription::{Derivatives, Grid, Horizons, Objective};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

type Twice = Jet<Jet<f64, 1>, 1>;

const REFERENCE: f64 = 1.2;
const PARTS: [f64; 2] = [0.8, 1.7];

fn lift(x: f64) -> Twice {
    <Twice as AlgebraOver<f64>>::lift(x)
}

/// Two parts of two segments each.
fn basis() -> Basis {
    Basis::new(4, 6, ends(false, true))
}

/// Compares all derivatives of a cost with those by duals of its value.
fn compare<P: PointCost<f64>, D: PointCost<Twice>>(n: usize, cost: P, by_duals: impl Fn() -> D) {
    let (basis, free) = (basis(), basis().free());
    let grid = Grid::new(&basis, 8, 1.0);
    let coefficients = random(&mut ChaCha8Rng::seed_from_u64(11), n, basis.count());
    let mut objective = Objective::new(&grid, cost, n);
    objective.set_horizons(&Horizons::of_parts(PARTS.to_vec(), REFERENCE));
    objective.free_horizon([(); 2].map(|()| DMatrix::zeros(n, basis.count())));
    let mut found = Derivatives::new(&grid, n);
    objective.derivatives(&coefficients, &mut found).expect("sizes agree");
    let (unknowns, lifted_grid) = (free.len() * n, grid.map(lift));
    let second_order = |moving: [usize; 2]| {
        let (mut lifted, mut parts) = (coefficients.map(lift), PARTS.map(lift));
        for (order, unknown) in moving.into_iter().enumerate() {
            let moved = match unknown.checked_sub(unknowns) {
                Some(part) => &mut parts[part],
                None => &mut lifted[(unknown % n, free[unknown / n])],
            };
            match order {
                0 => moved.re.eps[0] += 1.0,
                _ => moved.eps[0].re += 1.0,
            }
        }
        let mut objective = Objective::new(&lifted_grid, by_duals(), n);
        objective.set_horizons(&Horizons::of_parts(parts.to_vec(), lift(REFERENCE)));
        objective.value(&lifted).expect("sizes agree")
    };
    let hessian = found.hessian.to_dense();
    for i in 0..unknowns {
        let close = |found: f64, dual: f64| {
            let scale = hessian[(i, i)].abs().max(1.0);
            assert!((found - dual).abs() <= 1e-10 * scale, "{i}: {found}, {dual}");
        };
        close(found.gradient[i], second_order([i, i]).re.eps[0]);
        for j in 0..=i {
            close(hessian[(i, j)], second_order([i, j]).eps[0].eps[0]);
        }
        for (part, of) in found.horizons.iter().enumerate() {
            let mixed = second_order([i, unknowns + part]);
            close(of.mixed[i], mixed.eps[0].eps[0]);
        }
    }
    for (part, of) in found.horizons.iter().enumerate() {
        let own = second_order([unknowns + part; 2]);
        assert_close!(&[of.first, of.second], &[own.re.eps[0], own.eps[0].eps[0]], 1e-10);
    }
    let both = second_order([unknowns, unknowns + 1]);
    assert_eq!(both.eps[0].eps[0], 0.0);
}

#[test]
fn derivatives_in_parts_are_those_of_duals() {
    let model = tree(2, 5);
    compare(2, effort_and_jerk(&model), || effort_and_jerk::<Twice>(&model));
    compare(2, OfJerk, || OfJerk);
}

/// Parts that last as long as the reference are one horizon, and a part takes its share of time.
#[test]
fn parts_of_one_length_are_one_horizon() {
    let (model, basis) = (tree(3, 2), basis());
    let grid = Grid::new(&basis, 8, 1.0);
    let coefficients = random(&mut ChaCha8Rng::seed_from_u64(12), 3, basis.count());
    let value = |horizons: Horizons<f64>| {
        let mut objective = Objective::new(&grid, effort_and_jerk(&model), 3);
        objective.set_horizons(&horizons);
        objective.value(&coefficients).expect("sizes agree")
    };
    let one = value(Horizons::one(REFERENCE));
    let parts = value(Horizons::of_parts(vec![REFERENCE; 2], REFERENCE));
    assert!((one - parts).abs() <= 1e-14 * one);
    let horizons = Horizons::of_parts(PARTS.to_vec(), REFERENCE);
    assert!((horizons.whole() - 1.25_f64).abs() <= 1e-15);
    assert!(value(horizons) != one);
}
