//! Pieces of a motion contain it and its derivatives.

use crate::common::{config, robot};
use crate::scalar::double::Double;
use aghf::certify::{Motion, ORDER, Part, Piece, Polynomial};
use aghf::curve::Curve;
use aghf::dynamics::{Data, rnea};
use aghf::scalar::{One, Scalar, TaylorModel, Zero};
use nalgebra::DMatrix;
use proptest::prelude::*;

/// Chebyshev coefficients of the derivative in `x`.
fn derivative(c: &[Double]) -> Vec<Double> {
    let n = c.len() - 1;
    let mut found = vec![Double::zero(); n + 2];
    for j in (1..=n).rev() {
        found[j - 1] = found[j + 1] + c[j] * Double::from(2.0 * j as f64);
    }
    found[0] /= Double::from(2.0);
    found
}

/// The value at `x` by the recursion of the polynomials.
fn value(c: &[Double], x: Double) -> Double {
    let (mut before, mut now, mut sum) = (x, Double::one(), Double::zero());
    for c in c {
        sum += *c * now;
        (before, now) = (now, (x + x) * now - before);
    }
    sum
}

/// The value of a polynomial at `s`, and its radius.
fn enclosure(of: &Polynomial, s: f64) -> (Double, f64) {
    let s = Double::from(s);
    let terms = of.coefficients.iter().rev();
    (terms.fold(Double::zero(), |sum, c| sum * s + Double::from(*c)), of.radius)
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn pieces_contain_the_motion(c in prop::collection::vec(-1.0..1.0_f64, 2..20), horizon in 0.3..5.0_f64,
        level in 0..6_i32, place in 0.0..1.0_f64, s in -1.0..1.0_f64) {
        // As those of a smooth motion the coefficients decrease.
        let c: Vec<f64> = c.iter().enumerate().map(|(k, c)| c * 0.6_f64.powi(k as i32)).collect();
        let motion = Motion::new(horizon, &[vec![vec![0.5; c.len()]], vec![c.clone()]]).expect("it is one");
        // A half width of any kind: powers of it are rounded.
        let half = 0.9 * 0.5_f64.powi(level);
        let count = (1.0 / half) as usize;
        let middle = -1.0 + half * (2 * ((place * count as f64) as usize).min(count - 1) + 1) as f64;
        let piece = motion.piece(Part { segment: 1, middle, half });
        let x = Double::from(middle) + Double::from(half) * Double::from(s);
        let rate = Double::from(4.0) / Double::from(horizon);
        let mut exact: Vec<Double> = c.iter().map(|c| Double::from(*c)).collect();
        for (order, found) in [&piece.q, &piece.v, &piece.a, &piece.jerk].into_iter().enumerate() {
            let (found, radius) = enclosure(&found[0], s);
            let wanted = (0..order).fold(value(&exact, x), |sum, _| sum * rate);
            let off = (found - wanted).rounded().abs();
            prop_assert!(off <= radius, "derivative {order}: {off} of {radius}");
            prop_assert!(half > 0.3 || radius < 1e-9 * 20.0_f64.powi(order as i32), "{radius}");
            exact = derivative(&exact);
        }
    }
}

/// A smooth motion of a robot on three segments.
fn curve(joints: usize) -> Curve {
    let (segments, degree, horizon) = (3, 12, 2.0);
    let nodes = degree + 1;
    let x = DMatrix::from_fn(2 * joints, segments * nodes, |row, k| {
        let (e, i) = (k / nodes, k % nodes);
        let within = 0.5 * (1.0 - (std::f64::consts::PI * i as f64 / degree as f64).cos());
        let t = horizon / 3.0 * (e as f64 + within);
        let speed = 1.0 + 0.3 * (row % joints) as f64;
        if row < joints { (speed * t).sin() } else { speed * (speed * t).cos() }
    });
    Curve::piecewise(horizon, segments, x).expect("it is continuous")
}

#[test]
fn torques_are_enclosed_and_close() {
    let model = robot("kinova_gen3");
    let n = model.dof();
    let curve = curve(n);
    let motion = Motion::of_curve(&curve).expect("one part");
    assert_eq!((motion.segments(), motion.degree(), motion.horizon()), (3, 12, 2.0));
    let mut data = Data::<TaylorModel<ORDER>>::new(&model);
    let half = |part: Part, side: usize| part.split(part.middle)[side];
    let part = half(half(half(Part::whole(1), 1), 0), 1);
    let piece: Piece = motion.piece(part);
    let torques = piece.torques(&model, &mut data).expect("lengths agree");
    let widest = torques.iter().map(TaylorModel::radius).fold(0.0, f64::max);
    assert!(widest < 1e-5, "{widest}");
    for s in [-1.0, -0.2, 0.9] {
        let at = |all: &[Polynomial]| -> Vec<Double> { all.iter().map(|p| enclosure(p, s).0).collect() };
        let (mut exact, data) = (vec![Double::zero(); n], &mut Data::new(&model));
        rnea(&model, data, &at(&piece.q), &at(&piece.v), &at(&piece.a), &mut exact).expect("lengths agree");
        for (torque, exact) in torques.iter().zip(&exact) {
            let c = torque.coefficients().iter().rev();
            let middle = c.fold(Double::zero(), |sum, c| sum * Double::from(s) + Double::from(*c));
            assert!((middle - *exact).rounded().abs() <= torque.radius());
        }
        // The curve itself, as others evaluate it.
        let (x, _) = curve.at_in(1, motion.time(part, s));
        for (i, q) in piece.q.iter().enumerate() {
            assert!((enclosure(q, s).0.rounded() - x[i]).abs() < 1e-12);
        }
    }
}

#[test]
fn halves_meet_and_ends_are_accurate() {
    let part = Part { segment: 2, middle: 0.25, half: 0.25 };
    let [left, right] = part.split(part.middle);
    assert_eq!((left.ends(), right.ends()), ([0.0, 0.25], [0.25, 0.5]));
    // Any place is rounded so that middles and halves stand for both ends exactly, down to short parts.
    let mut short = Part::whole(2).split(0.1 + 0.2)[1];
    while short.half > 1e-7 {
        let parts = short.split(short.middle);
        assert_eq!(parts[0].ends()[1], parts[1].ends()[0]);
        assert_eq!([parts[0].ends()[0], parts[1].ends()[1]], short.ends());
        short = parts[1];
    }
    let motion = Motion::of_curve(&curve(2)).expect("one part");
    let end = motion.piece(Part::about(2, 1.0));
    let middle = end.v[1].middle();
    assert!((middle.coefficients()[0] - 1.3 * 2.6_f64.cos()).abs() < 1e-9 && middle.radius() < 1e-11);
    let q = Double::from(end.q[0].coefficients[0]) - Double::from(2.0).sin_cos().0;
    assert!(q.rounded().abs() < 1e-9);
}

#[test]
fn coefficients_that_are_no_motion_are_refused() {
    let row = vec![1.0, 0.5];
    for (coefficients, condition) in [
        (vec![], "there is no segment"),
        (vec![vec![row.clone()], vec![vec![1.0]]], "the same number"),
        (vec![vec![vec![]]], "the same number"),
        (vec![vec![vec![f64::NAN, 1.0]]], "finite numbers"),
    ] {
        let error = Motion::new(1.0, &coefficients).expect_err("it is none");
        assert!(error.to_string().contains(condition), "{error}");
    }
    assert!(Motion::new(0.0, &[vec![row]]).is_err());
}

/// A certificate is of one part: its intervals are shares of equal segments.
#[test]
fn a_curve_in_parts_is_refused() {
    let x = DMatrix::from_fn(2, 6, |i, j| if i == 0 { [0.0, 0.5, 1.0, 1.0, 1.5, 2.0][j] } else { 1.0 });
    let curve = Curve::in_parts(&[1.0, 2.0], 2, x).expect("it is continuous");
    let error = Motion::of_curve(&curve).expect_err("two parts").to_string();
    assert!(error.contains("it has 2 parts"), "{error}");
}
