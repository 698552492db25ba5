//! Enclosures contain the functions, computed in twice the precision of `f64`.

use crate::common::{any_model, config, numbers};
use crate::scalar::double::Double;
use aghf::dynamics::{Data, rnea};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Ball, Scalar, TaylorModel, Zero};
use proptest::prelude::*;

/// The value of a polynomial at `s`.
fn value(c: &[f64], s: f64) -> Double {
    let s = Double::from(s);
    c.iter().rev().fold(Double::zero(), |sum, c| sum * s + Double::from(*c))
}

/// The distance of a value from the polynomial of a model at `s`, less the radius: at most zero.
fn beyond<const N: usize>(model: &TaylorModel<N>, at: Double, s: f64) -> f64 {
    (at - value(model.coefficients(), s)).rounded().abs() - model.radius()
}

/// Polynomials of degree three, with coefficients beyond degree zero of at most `size`.
fn polynomials(count: usize, size: f64) -> impl Strategy<Value = Vec<Vec<f64>>> {
    let one = (-2.0..2.0_f64, prop::collection::vec(-size..size, 3));
    let one = one.prop_map(|(first, rest)| [vec![first], rest].concat());
    prop::collection::vec(one, count)
}

/// All operations of a scalar on two numbers, the first of which is near its constant.
fn operations<S: AlgebraOver<f64>>(x: S, y: S) -> Vec<S> {
    let (sin, cos) = x.sin_cos();
    let positive = y * y + S::from_f64(3.0);
    let ratio = x / positive;
    let switched = (y - S::from_f64(0.25)).if_negative(x, positive);
    vec![x + y, x - y, x * y, -x, x.scale(0.3), sin, cos, positive.sqrt(), ratio, switched]
}

fn contains<const N: usize>(of: &[Vec<f64>]) -> Result<(), TestCaseError> {
    let model = |i: usize| TaylorModel::<N>::new(&of[i], 0.0);
    let models = operations(model(0), model(1));
    for s in [-1.0, -0.4, 0.0, 0.7, 1.0] {
        let exact = operations(value(&of[0], s), value(&of[1], s));
        for (k, (model, exact)) in models.iter().zip(exact).enumerate() {
            let beyond = beyond(model, exact, s);
            prop_assert!(beyond <= 0.0, "operation {k} at {s}: {beyond}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(256))]

    #[test]
    fn operations_contain_the_values(wide in polynomials(2, 0.3), narrow in polynomials(2, 1e-9)) {
        for of in [&wide, &narrow] {
            contains::<1>(of)?;
            contains::<3>(of)?;
            contains::<9>(of)?;
        }
    }

    /// Random trees with drives on polynomial motions.
    #[test]
    fn torques_contain_those_of_twice_the_precision((model, motion) in model_and_motion(0.005)) {
        let model = model.with_random_drives(7);
        let torques = inverse_dynamics(&model, &motion, |c| TaylorModel::<9>::new(c, 0.0));
        for s in [-1.0, -0.3, 0.6, 1.0] {
            let exact = inverse_dynamics(&model, &motion, |c| value(c, s));
            for (i, (torque, exact)) in torques.iter().zip(exact).enumerate() {
                let beyond = beyond(torque, exact, s);
                prop_assert!(beyond <= 0.0, "joint {i} at {s}: {beyond}");
            }
        }
    }

    /// At an instant only rounding is left.
    #[test]
    fn torques_at_an_instant_contain_those_of_twice_the_precision((model, motion) in model_and_motion(0.0)) {
        let torques = inverse_dynamics(&model, &motion, |c| Ball::new(c, 0.0));
        let exact = inverse_dynamics(&model, &motion, |c| value(c, 0.0));
        for (i, (torque, exact)) in torques.iter().zip(exact).enumerate() {
            let beyond = beyond(torque, exact, 0.0);
            prop_assert!(beyond <= 0.0 && torque.radius() < 1e-9, "joint {i}: {beyond}, {}", torque.radius());
        }
    }
}

/// A model and polynomials of degree three, the positions, velocities and accelerations of its joints.
fn model_and_motion(size: f64) -> impl Strategy<Value = (Model, Vec<Vec<f64>>)> {
    any_model().prop_flat_map(move |model| {
        let n = model.dof();
        (Just(model), prop::collection::vec(numbers(4), 3 * n)).prop_map(move |(model, mut motion)| {
            for c in &mut motion {
                c[1..].iter_mut().for_each(|c| *c *= size);
            }
            (model, motion)
        })
    })
}

fn inverse_dynamics<S: AlgebraOver<f64>>(model: &Model, motion: &[Vec<f64>], of: impl Fn(&[f64]) -> S) -> Vec<S> {
    let n = model.dof();
    let all: Vec<S> = motion.iter().map(|c| of(c)).collect();
    let mut torques = vec![S::zero(); n];
    let data = &mut Data::new(model);
    rnea(model, data, &all[..n], &all[n..2 * n], &all[2 * n..], &mut torques).expect("lengths agree");
    torques
}

/// Nothing is known beyond a zero of a divisor, and it does not pass for a bound.
#[test]
fn what_is_not_known_proves_nothing() {
    let x = TaylorModel::<3>::new(&[0.1, 1.0], 0.0);
    let one = TaylorModel::constant(1.0);
    for unknown in [one / x, x.sqrt(), (one / x) * TaylorModel::constant(0.0), x.if_negative(one / x, one)] {
        let is_known = unknown.radius() < f64::MAX;
        assert!(!is_known, "{unknown:?}");
    }
    let (sin, cos) = TaylorModel::<3>::new(&[0.1, 4.0], 0.0).sin_cos();
    for bounded in [sin, cos] {
        assert!(bounded.magnitude() >= 1.0);
    }
}
