//! Nodes, derivatives, interpolation, quadrature and the collocated system.

use crate::common::{assert_refused, config, dual_jacobian, numbers, robot};
use aghf::curve::{Chebyshev, Curve, gauss_legendre, gauss_lobatto};
use aghf::flow::jacobian::{JacobianKind, NodeBlocks};
use aghf::flow::{Collocation, ControlForm, assemble_jacobian};
use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;
use proptest::prelude::*;

const HORIZON: f64 = 3.0;

fn chebyshev(p: usize) -> Chebyshev {
    Chebyshev::new(p, HORIZON).expect("valid")
}

/// A smooth function that is no polynomial, with its first two derivatives.
fn smooth(t: f64) -> [f64; 3] {
    let (value, inner) = ((2.0 * t).sin().exp(), 2.0 * (2.0 * t).cos());
    [
        value,
        value * inner,
        value * (inner * inner - 4.0 * (2.0 * t).sin()),
    ]
}

/// Largest errors of `D`, `D^2`, interpolation and quadrature on `smooth`, relative to the sizes there.
fn errors(p: usize) -> [f64; 4] {
    let c = chebyshev(p);
    let at =
        |order: usize| DVector::from_iterator(p + 1, c.times().iter().map(|t| smooth(*t)[order]));
    let mut weights = DVector::zeros(p + 1);
    let interpolation = (0..500).fold(0.0_f64, |worst, i| {
        let t = HORIZON * f64::from(i) / 499.0;
        c.interpolation(t, &mut weights);
        worst.max((weights.dot(&at(0)) - smooth(t)[0]).abs())
    });
    // The integral by far more nodes than any degree here needs.
    let fine = chebyshev(Chebyshev::LARGEST_DEGREE);
    let integral: f64 = fine
        .weights()
        .iter()
        .zip(fine.times())
        .map(|(w, t)| w * smooth(*t)[0])
        .sum();
    [
        (c.d() * at(0) - at(1)).amax() / at(1).amax(),
        (c.d2() * at(0) - at(2)).amax() / at(2).amax(),
        interpolation,
        (c.weights().dot(&at(0)) - integral).abs(),
    ]
}

#[test]
fn errors_fall_exponentially_with_the_degree() {
    let ladder: Vec<_> = [10, 20, 30, 40, 60].into_iter().map(errors).collect();
    println!("{ladder:?}");
    for kind in 0..4 {
        for step in ladder.windows(2).take(3) {
            assert!(
                step[1][kind] < 0.1 * step[0][kind] + 1e-11,
                "kind {kind}: {ladder:?}"
            );
        }
        // Rounding grows with p^4 in D^2 and p^2 in D.
        let rounding = [1e-11, 1e-9, 1e-13, 1e-13][kind];
        assert!(ladder[4][kind] < rounding, "kind {kind}: {ladder:?}");
    }
}

#[test]
fn nodes_are_the_papers_in_reverse() {
    let p = 7;
    let c = Chebyshev::new(p, 2.0).expect("valid");
    for (i, t) in c.times().iter().enumerate() {
        let paper = (std::f64::consts::PI * (p - i) as f64 / p as f64).cos();
        assert!((t - 1.0 - paper).abs() < 1e-15);
    }
    assert_eq!((c.times()[0], c.times()[p]), (0.0, 2.0));
}

#[test]
fn the_second_matrix_is_the_square_of_the_first() {
    for p in [2, 3, 8, 15] {
        let c = chebyshev(p);
        assert_close!(c.d2(), &(c.d() * c.d()), 1e-12);
    }
}

#[test]
fn quadrature_is_exact_for_polynomials_of_its_degree() {
    for p in 2..12 {
        let c = chebyshev(p);
        for degree in 0..=i32::try_from(p).expect("small") {
            let sum: f64 = c
                .weights()
                .iter()
                .zip(c.times())
                .map(|(w, t)| w * t.powi(degree))
                .sum();
            let exact = HORIZON.powi(degree + 1) / f64::from(degree + 1);
            assert!(
                (sum - exact).abs() < 1e-12 * exact,
                "p {p}, degree {degree}: {sum} {exact}"
            );
        }
    }
}

#[test]
fn bad_settings_are_errors() {
    for (p, horizon, element) in [
        (1, 1.0, "p:"),
        (5, 0.0, "horizon"),
        (5, f64::NAN, "horizon"),
    ] {
        let error = Chebyshev::new(p, horizon).expect_err("bad");
        assert!(error.to_string().contains(element), "{error}");
    }
    let error = Curve::new(chebyshev(4), DMatrix::zeros(2, 4)).expect_err("a column is missing");
    assert!(
        error.to_string().contains("expected 5 entries, found 4"),
        "{error}"
    );
}

/// Three parts of degree 4 on [0, 2]: `q` is a cubic on each, with the same value and slope where two meet, and `v` its slope.
fn three_parts() -> (Curve, impl Fn(usize, f64) -> [f64; 3]) {
    let third = HORIZON / 3.0;
    let cubic = move |e: usize, t: f64| {
        // Bends of its own on each part, zero with its slope at both of its ends but for a common line.
        let (bend, s) = ([1.0, -2.0, 0.5][e], t - e as f64 * third);
        let q = 0.3 + 0.7 * t + bend * (s * (third - s)).powi(2);
        let slope = 0.7 + 2.0 * bend * s * (third - s) * (third - 2.0 * s);
        let second = 2.0 * bend * (third * third - 6.0 * s * third + 6.0 * s * s);
        [q, slope, second]
    };
    let nodes = chebyshev(4);
    let mut x = DMatrix::zeros(2, 15);
    for column in 0..15 {
        let (e, node) = (column / 5, column % 5);
        let [q, v, _] = match node {
            4 if e < 2 => cubic(e + 1, third * (e + 1) as f64),
            _ => cubic(e, third * (e as f64 + nodes.times()[node] / HORIZON)),
        };
        x.column_mut(column).copy_from_slice(&[q, v]);
    }
    let curve = Curve::piecewise(HORIZON, 3, x).expect("valid");
    (curve, cubic)
}

#[test]
fn a_curve_of_parts_is_each_of_its_parts() {
    let (curve, cubic) = three_parts();
    assert_eq!((curve.segments(), curve.dof()), (3, 1));
    assert_eq!((curve.horizon(), curve.chebyshev().degree()), (HORIZON, 4));
    assert_eq!(curve.x().column(4), curve.x().column(5));
    for i in 0..=60 {
        let t = HORIZON * f64::from(i) / 60.0;
        let e = curve.segment_at(t);
        let ((x, xdot), [q, v, a]) = (curve.at(t), cubic(e, t));
        for (ours, exact) in [(x[0], q), (x[1], v), (xdot[0], v), (xdot[1], a)] {
            assert!((ours - exact).abs() < 1e-12, "{t}: {ours} {exact}");
        }
    }
    // Where two meet the state is that of both, to the last bit, and the acceleration that of the part that is asked.
    for part in 1..3 {
        let t = curve.breakpoints()[part];
        assert_eq!(curve.segment_at(t), part);
        let (before, after) = (curve.at_in(part - 1, t), curve.at_in(part, t));
        assert_close!(&before.0, &after.0, 1e-14);
        assert_eq!(curve.at(t), after);
        for (e, (_, xdot)) in [(part - 1, before), (part, after)] {
            assert!((xdot[1] - cubic(e, t)[2]).abs() < 1e-12, "{part} {e}");
        }
        assert!((cubic(part - 1, t)[2] - cubic(part, t)[2]).abs() > 0.5);
    }
    assert_eq!((curve.segment_at(0.0), curve.segment_at(HORIZON)), (0, 2));
}

#[test]
fn one_part_is_the_curve_of_one_polynomial() {
    let x = DMatrix::from_fn(2, 6, |i, j| (1.0 + (3 * i + j) as f64).sin());
    let one = Curve::new(chebyshev(5), x.clone()).expect("valid");
    let same = Curve::piecewise(HORIZON, 1, x).expect("valid");
    assert_eq!(one.at(0.37), same.at(0.37));
    assert_eq!(one.at(HORIZON), same.at(HORIZON));
}

#[test]
fn bad_parts_are_errors() {
    let x = |columns| DMatrix::from_fn(2, columns, |_, j| j as f64);
    for (segments, x, words) in [
        (0, x(5), "segments: it is 0"),
        (2, x(11), "x: expected 10 entries, found 11"),
        (2, x(4), "degree: it is 1"),
        (2, x(0), "degree: it is 0"),
        (2, x(10), "the state jumps where segment 1 begins"),
        (1, DMatrix::zeros(3, 4), "odd number of rows"),
    ] {
        let error = Curve::piecewise(HORIZON, segments, x).expect_err(words);
        assert!(error.to_string().contains(words), "{error}; want {words}");
    }
    assert_refused(Curve::piecewise(-1.0, 2, x(10)), "horizon: it is -0.5");
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn polynomials_are_reproduced(p in 2..14_usize, values in numbers(14), t in 0.0..HORIZON) {
        let c = chebyshev(p);
        let polynomial = |t: f64| values[..=p.min(13)].iter().rev().fold(0.0, |sum, c| sum * (t / HORIZON) + c);
        let mut x = DMatrix::zeros(2, c.degree() + 1);
        for (i, t) in c.times().iter().enumerate() {
            x.column_mut(i).fill(polynomial(*t));
        }
        let curve = Curve::new(c, x).expect("valid");
        let (x, xdot) = curve.at(t);
        prop_assert!((x[0] - polynomial(t)).abs() < 1e-11);
        let step = 1e-5;
        let difference = (polynomial(t + step) - polynomial(t - step)) / (2.0 * step);
        prop_assert!((xdot[1] - difference).abs() < 1e-6, "{} {difference}", xdot[1]);
    }

    /// The assembled matrix is the Jacobian of the whole collocated system, differentiated as one function.
    #[test]
    fn the_assembled_jacobian_is_that_of_the_system(
        p in 3..6_usize,
        name in prop::sample::select(vec!["pendulum_1", "pendulum_3", "kinova_gen3"]),
        values in numbers(14 * 6),
        k in prop::sample::select(vec![1.0, 1e4]),
    ) {
        let model = robot(name);
        let m = 2 * model.dof();
        let c = Chebyshev::new(p, 2.0).expect("valid");
        let (start, goal) = (&values[..m], &values[m..2 * m]);
        let unknowns: Vec<f64> = values.iter().cycle().skip(2 * m).take(m * (p - 1)).copied().collect();

        let mut collocation = Collocation::<f64, f64>::new(&c, start, goal).expect("valid");
        collocation.set(&unknowns).expect("valid");
        let size = collocation.unknowns();

        let whole = |unknowns: &[Dual64]| {
            let dual = crate::common::constants;
            let mut system = Collocation::<f64, Dual64>::new(&c, &dual(start), &dual(goal)).expect("valid");
            system.set(unknowns).expect("valid");
            let mut out = vec![Dual64::from(0.0); size];
            system.rates(&mut ControlForm::new(&model), k, &mut out).expect("valid");
            out
        };
        let truth = dual_jacobian(whole, &unknowns);
        for (name, kind) in JacobianKind::by_name() {
            let (mut assembled, mut blocks) = (DMatrix::zeros(size, size), NodeBlocks::new(model.dof()));
            let jacobian = &mut *kind.build(&model);
            assemble_jacobian(&collocation, jacobian, k, &mut blocks, &mut assembled).expect("valid");
            // Differences of numbers of the size of D^2 keep half of their digits.
            let bound = if kind == JacobianKind::Difference { 1e-5 } else { 1e-9 };
            let error = crate::common::relative_error(&assembled, &truth);
            prop_assert!(error <= bound, "{name} is off by {error:e}");
        }
    }
}

#[test]
fn gauss_legendre_is_exact_to_its_degree() {
    for m in [1, 2, 5, 16, 97] {
        let (nodes, weights) = gauss_legendre(m);
        assert!(nodes.windows(2).all(|w| w[0] < w[1]) && weights.iter().all(|w| *w > 0.0));
        for power in [0, 1, m, 2 * m - 2, 2 * m - 1] {
            let integral: f64 = nodes
                .iter()
                .zip(&weights)
                .map(|(x, w)| w * x.powi(power as i32))
                .sum();
            let exact = if power % 2 == 0 {
                2.0 / (power as f64 + 1.0)
            } else {
                0.0
            };
            assert!(
                (integral - exact).abs() < 1e-14 * m as f64,
                "{m} {power}: {integral} {exact}"
            );
        }
    }
}

/// With both ends among the nodes, two degrees less.
#[test]
fn gauss_lobatto_is_exact_to_its_degree() {
    for m in [2, 3, 5, 16, 97] {
        let (nodes, weights) = gauss_lobatto(m);
        assert_eq!((nodes[0], nodes[m - 1]), (-1.0, 1.0));
        assert!(nodes.windows(2).all(|w| w[0] < w[1]) && weights.iter().all(|w| *w > 0.0));
        for power in [0, 1, m.min(2 * m - 3), 2 * m - 4, 2 * m - 3] {
            let terms = nodes.iter().zip(&weights);
            let integral: f64 = terms.map(|(x, w)| w * x.powi(power as i32)).sum();
            let even = f64::from(u8::from(power % 2 == 0));
            let exact = even * 2.0 / (power as f64 + 1.0);
            assert!(
                (integral - exact).abs() < 1e-14 * m as f64,
                "{m} {power}: {integral} {exact}"
            );
        }
    }
}

/// The sum of the Chebyshev polynomials by their recurrence is the curve, also between the nodes.
#[test]
fn the_coefficients_are_those_of_the_curve() {
    let (curve, _) = three_parts();
    for segment in 0..3 {
        let coefficients = curve.coefficients(segment);
        assert_eq!(coefficients.shape(), (2, 5));
        let (begin, end) = (
            curve.breakpoints()[segment],
            curve.breakpoints()[segment + 1],
        );
        for i in 0..=20 {
            let share = f64::from(i) / 20.0;
            let s = 2.0 * share - 1.0;
            let mut polynomials = vec![1.0, s];
            for k in 2..5 {
                polynomials.push(2.0 * s * polynomials[k - 1] - polynomials[k - 2]);
            }
            let sum = &coefficients * DVector::from_vec(polynomials);
            let (x, _) = curve.at_in(segment, begin + share * (end - begin));
            assert_close!(&sum, &x, 1e-14);
        }
    }
}
