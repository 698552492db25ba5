//! Numbers: derivatives of the functions, and constants that are not promoted.

use crate::common::{config, wave};
use aghf::dynamics::{Data, rnea};
use aghf::model::random_tree;
use aghf::scalar::{AlgebraOver, Jet, Lanes, Scalar, Tanh};
use nalgebra::SVector;
use num_dual::{Derivative, Dual, Dual2_64, Dual64, DualSVec64, HyperDual64};
use proptest::prelude::*;

/// `sin x cos x + tanh x` written generically, with its first two derivatives by hand.
fn mixed<S: Tanh>(x: S) -> S {
    let (sin, cos) = Scalar::sin_cos(x);
    sin * cos + Tanh::tanh(x)
}

fn mixed_by_hand(x: f64) -> [f64; 3] {
    let t = x.tanh();
    let sech2 = 1.0 - t * t;
    [x.sin() * x.cos() + t, (2.0 * x).cos() + sech2, -2.0 * (2.0 * x).sin() - 2.0 * t * sech2]
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn functions_and_their_derivatives(x in -3.0..3.0_f64) {
        let [value, first, second] = mixed_by_hand(x);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{a} {b}");
        near(mixed(x), value);
        near(mixed(Dual64::new(x, 1.0)).eps, first);
        let vector = mixed(DualSVec64::<3>::new(x, Derivative::some(SVector::from([1.0, 0.0, -2.0]))));
        let eps = vector.eps.0.expect("it depends on x");
        near(eps[0], first);
        near(eps[1], 0.0);
        near(eps[2], -2.0 * first);
        near(mixed(Dual2_64::new(x, 1.0, 0.0)).v2, second);
        near(mixed(HyperDual64::new(x, 1.0, 1.0, 0.0)).eps1eps2, second);
        let nested = mixed(Dual::new(Dual64::new(x, 1.0), Dual64::new(1.0, 0.0)));
        near(nested.eps.eps, second);
        prop_assert!((f64::from(mixed(x as f32)) - value).abs() < 1e-5);
        near(mixed(Lanes([x, 0.0, 1.0, -x])).0[3], -mixed(x));
        prop_assert_eq!(mixed(Lanes([x, 0.0, -x])).0[2], -mixed(x));
    }

    #[test]
    fn scaling_is_multiplying_by_the_promoted_constant(x in -3.0..3.0_f64, c in -3.0..3.0_f64) {
        fn same<S: AlgebraOver<f64>>(x: S, c: f64) {
            assert_eq!(x.scale(c), x * S::lift(c));
            assert_eq!(S::lift(c), <S as Scalar>::from_f64(c));
        }
        same(x, c);
        same(x as f32, c);
        same(Lanes([x; 4]), c);
        // `==` compares only the real part of a dual number, so the other parts are compared one by one.
        let dual = HyperDual64::new(x, 2.0, 3.0, 4.0);
        let (scaled, promoted) = (AlgebraOver::scale(dual, c), dual * HyperDual64::from(c));
        prop_assert_eq!(
            (scaled.re, scaled.eps1, scaled.eps2, scaled.eps1eps2),
            (promoted.re, promoted.eps1, promoted.eps2, promoted.eps1eps2)
        );
    }
}

/// `sqrt x` for positive `x` and `x sin x` for the others, with its first two derivatives by hand.
fn chosen<S: Scalar>(x: S) -> S {
    x.if_negative(x * x.sin_cos().0, Scalar::sqrt(x))
}

fn chosen_by_hand(x: f64) -> [f64; 3] {
    let (sin, cos) = x.sin_cos();
    if x < 0.0 {
        [x * sin, sin + x * cos, 2.0 * cos - x * sin]
    } else {
        [x.sqrt(), 0.5 / x.sqrt(), -0.25 / (x * x.sqrt())]
    }
}

/// Roots and selections are differentiated over every type of number; the unselected value, here the root of a negative
/// number, has no effect.
#[test]
fn roots_and_choices() {
    for x in [-2.5, -0.3, 0.2, 1.7, 9.0] {
        let [value, first, second] = chosen_by_hand(x);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "at {x}: {a} {b}");
        near(chosen(x), value);
        assert!((f64::from(chosen(x as f32)) - value).abs() < 1e-6);
        near(chosen(Dual64::new(x, 3.0)).eps, 3.0 * first);
        near(chosen(Dual2_64::new(x, 1.0, 0.0)).v2, second);
        near(chosen(HyperDual64::new(x, 1.0, 1.0, 0.0)).eps1eps2, second);
        let nested = chosen(Jet::new(Jet::new(x, [1.0]), [Jet::constant(1.0), Jet::constant(0.0)]));
        near(nested.re.re, value);
        near(nested.eps[0].re, first);
        near(nested.eps[0].eps[0], second);
        near(nested.eps[1].eps[0], 0.0);
        let lanes = chosen(Jet::new(Lanes([x, -x, x, 1.0]), [Lanes([1.0, 1.0, 2.0, 0.0])]));
        let [_, other, _] = chosen_by_hand(-x);
        for (lane, slope) in [first, other, 2.0 * first, 0.0].into_iter().enumerate() {
            near(lanes.eps[0].0[lane], slope);
        }
    }
    let choose = |x: f64| x.if_negative(1.0, 2.0);
    assert_eq!([-1e-300, -0.0, 0.0, 1e-300, f64::NAN].map(choose), [1.0, 2.0, 2.0, 2.0, 2.0]);
}

/// Only numbers without derivatives are known to vanish: `num-dual` does not report derivatives.
#[test]
fn what_vanishes() {
    assert!(0.0_f64.vanishes() && (-0.0_f32).vanishes() && !1e-300_f64.vanishes());
    assert!(!Dual64::from(0.0).vanishes());
    assert!(Lanes([0.0; 4]).vanishes() && !Lanes([0.0, 0.0, 1.0, 0.0]).vanishes());
    assert!(Jet::new(0.0, [0.0; 2]).vanishes() && !Jet::new(0.0, [0.0, 1.0]).vanishes());
    assert!(!Jet::new(1.0, [0.0]).vanishes());
}

/// Far from zero the hyperbolic tangent is one, and its derivatives are finite.
#[test]
fn tanh_saturates() {
    for x in [19.9, 20.1, 800.0, f64::MAX] {
        for x in [x, -x] {
            assert_eq!(Tanh::tanh(x), x.signum());
            let first = Tanh::tanh(Dual64::new(x, 3.0));
            assert!(first.re == x.signum() && first.eps.abs() < 1e-15, "{first}");
            let second = Tanh::tanh(HyperDual64::new(x, 1.0, 1.0, 0.0));
            assert!(second.eps1eps2.abs() < 1e-15, "{second}");
        }
    }
}

#[test]
fn dynamics_run_in_single_precision() {
    let model = random_tree(8, 5).expect("eight joints");
    let run = |[q, v, a]: [&[f64]; 3]| {
        let short = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<_>>();
        let (mut double, mut single) = (vec![0.0; 8], vec![0.0_f32; 8]);
        rnea(&model, &mut Data::new(&model), q, v, a, &mut double).expect("lengths agree");
        let [q, v, a] = [q, v, a].map(short);
        rnea(&model, &mut Data::new(&model), &q, &v, &a, &mut single).expect("lengths agree");
        let single: Vec<f64> = single.into_iter().map(f64::from).collect();
        assert_close!(&single, &double, 1e-5);
    };
    run([&wave(8, 0.3), &wave(8, 0.7), &wave(8, 1.1)]);
}
