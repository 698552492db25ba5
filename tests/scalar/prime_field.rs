//! The field: its axioms, its exact image of `f64`, and formal derivatives over it.

use crate::common::config;
use aghf::dynamics::{Data, rnea};
use aghf::flow::{AghfLagrangian, ControlForm, LagrangianFlow, RightHandSide};
use aghf::model::random_tree;
use aghf::scalar::{Jet, PrimeField, Scalar, Tanh};
use aghf::verify::field::{Equality, Identity, RandomInstance, prove_identities};
use num_traits::{One, Zero};
use proptest::prelude::*;

type F = PrimeField;

fn elements() -> impl Strategy<Value = F> {
    prop_oneof![
        1 => prop::sample::select(vec![0, 1, 2, F::ORDER - 1, F::ORDER - 2, 1 << 60]).prop_map(F::new),
        6 => any::<u64>().prop_map(F::new),
    ]
}

proptest! {
    #![proptest_config(config(256))]

    #[test]
    fn it_is_a_field(a in elements(), b in elements(), c in elements()) {
        prop_assert_eq!(a + b, b + a);
        prop_assert_eq!(a * b, b * a);
        prop_assert_eq!((a + b) + c, a + (b + c));
        prop_assert_eq!((a * b) * c, a * (b * c));
        prop_assert_eq!(a * (b + c), a * b + a * c);
        prop_assert_eq!(a - b, a + -b);
        prop_assert_eq!(a + -a, F::zero());
        if !b.is_zero() {
            prop_assert_eq!(b * b.inverse(), F::one());
            prop_assert_eq!((a / b) * b, a);
        }
        prop_assert!(a.residue() < F::ORDER);
    }

    /// Sums and products are those of the integers modulo the prime.
    #[test]
    fn arithmetic_is_that_of_the_integers(a in any::<u64>(), b in any::<u64>()) {
        let order = u128::from(F::ORDER);
        let residue = |x: u128| u64::try_from(x % order).expect("below the prime");
        let (a, b) = (u128::from(a), u128::from(b));
        let (fa, fb) = (F::new(residue(a)), F::new(residue(b)));
        prop_assert_eq!((fa + fb).residue(), residue(a + b));
        prop_assert_eq!((fa * fb).residue(), residue((a % order) * (b % order)));
        prop_assert_eq!((fa - fb).residue(), residue(a % order + order - b % order));
    }

    /// Exact where `f64` is: sums and products of small dyadic rationals.
    #[test]
    fn the_image_of_f64_is_exact(a in -(1_i32 << 20)..1 << 20, b in -(1_i32 << 20)..1 << 20, e in -40_i32..40) {
        let (x, y) = (f64::from(a) * 2.0_f64.powi(e), f64::from(b) * 2.0_f64.powi(-e / 2));
        let image = <F as Scalar>::from_f64;
        prop_assert_eq!(image(x) * image(y), image(x * y));
        prop_assert_eq!(image(f64::from(a)) + image(f64::from(b)), image(f64::from(a) + f64::from(b)));
        prop_assert_eq!(image(-x), -image(x));
        prop_assert_eq!(image(0.5) + image(0.5), F::one());
        prop_assert_eq!(image(f64::MIN_POSITIVE * 0.5) * image(2.0), image(f64::MIN_POSITIVE));
    }

    #[test]
    fn points_are_on_the_circle_and_derivatives_formal(t in elements()) {
        let (sin, cos) = t.sin_cos();
        prop_assert_eq!(sin * sin + cos * cos, F::one());
        let jet = Jet::new(t, [F::new(3)]);
        let (jet_sin, jet_cos) = Scalar::sin_cos(jet);
        prop_assert_eq!((jet_sin.re, jet_sin.eps[0]), (sin, cos * F::new(3)));
        prop_assert_eq!((jet_cos.re, jet_cos.eps[0]), (cos, -sin * F::new(3)));
        let tanh = Tanh::tanh(jet);
        prop_assert_eq!(tanh.eps[0], (F::one() - tanh.re * tanh.re) * F::new(3));
    }

    /// The root is formal and zero only at zero; half of the elements are negative, as the negative integers are.
    #[test]
    fn roots_are_formal_and_signs_those_of_integers(a in elements(), b in elements(), n in 1..1_000_000_u64) {
        prop_assert_eq!(Scalar::sqrt(a).is_zero(), a.is_zero());
        let root = Scalar::sqrt(Jet::new(a, [b]));
        if !a.is_zero() {
            prop_assert_eq!(root.eps[0] * (root.re + root.re), b);
        }
        prop_assert_eq!((-F::new(n)).if_negative(a, b), a);
        prop_assert_eq!(F::new(n).if_negative(a, b), b);
        prop_assert_eq!(F::zero().if_negative(a, b), b);
        let chosen = Jet::new(-F::new(n), [a]).if_negative(Jet::new(a, [b]), Jet::new(b, [a]));
        prop_assert_eq!(chosen, Jet::new(a, [b]));
    }

    /// The quotient and product rules, over a number with two tangents.
    #[test]
    fn jets_obey_the_rules(a in elements(), b in elements(), da in elements(), db in elements()) {
        let (x, y) = (Jet::new(a, [da, F::one()]), Jet::new(b, [db, F::zero()]));
        prop_assert_eq!((x * y).eps, [da * b + a * db, b]);
        if !b.is_zero() {
            prop_assert_eq!((x / y) * y, x);
            prop_assert_eq!((x / y).eps[0], (da * b - a * db) / (b * b));
        }
        prop_assert_eq!((x - y) + y, x);
        prop_assert_eq!(-(-x), x);
    }
}

/// A model loaded with `f64` constants runs over the field with the same code.
#[test]
fn the_dynamics_run_over_the_field() {
    let model = random_tree(5, 8).expect("five joints").cast::<F>();
    let numbers = |seed: u64| (0..5).map(|i| F::new(seed + 7 * i)).collect::<Vec<F>>();
    let mut tau = vec![F::zero(); 5];
    rnea(&model, &mut Data::new(&model), &numbers(1), &numbers(2), &numbers(3), &mut tau).expect("lengths agree");
    assert!(tau.iter().all(|t| !t.is_zero()));
}

/// Both sides of a user-defined identity: the flow of the paper's Lagrangian by its definition, and the control form
/// with `k` multiplied by a number.
fn definition_and_control_form(p: &RandomInstance, factor: F) -> aghf::Result<Vec<Equality>> {
    let mut definition = nalgebra::DVector::from_element(2 * p.dof(), F::zero());
    let mut control_form = definition.clone();
    LagrangianFlow::new(&p.model, AghfLagrangian).omega(p.node(), p.k, definition.as_mut_slice())?;
    ControlForm::new(&p.model).omega(p.node(), p.k * factor, control_form.as_mut_slice())?;
    Ok(vec![Equality::vectors("Omega", &definition, &control_form)])
}

#[test]
fn the_definition_of_the_flow_is_the_control_form_over_the_field() {
    let identity = |claims| Identity {
        label: "definition",
        statement: "G^-1 (d/dt dL/dxdot - dL/dx) is the control form",
        convention: "",
        claims,
    };
    let identities = [
        identity(|p| definition_and_control_form(p, F::one())),
        identity(|p| definition_and_control_form(p, F::new(2))),
    ];
    let verdicts = prove_identities(&identities, 3, 5).expect("lengths agree");
    assert_eq!(verdicts[0].failure, None);
    assert!(verdicts[0].entries >= 3 * 10);
    assert!(verdicts[1].failure.is_some(), "a wrong penalty shows");
}
