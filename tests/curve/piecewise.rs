//! Curves of several polynomials.

use super::chebyshev::{HORIZON, chebyshev};
use crate::common::assert_refused;
use aghf::curve::{Chebyshev, Curve};
use nalgebra::{DMatrix, DVector};

/// Three parts of degree 4 on [0, 2]: `q` is a cubic on each, with the same value and slope where two meet, and `v` its
/// slope.
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
    assert_eq!((curve.horizon(), curve.degree()), (HORIZON, 4));
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

/// The sum of the Chebyshev polynomials by their recurrence is the curve, also between the nodes.
#[test]
fn the_coefficients_are_those_of_the_curve() {
    let (curve, _) = three_parts();
    for segment in 0..3 {
        let coefficients = curve.coefficients(segment);
        assert_eq!(coefficients.shape(), (2, 5));
        let (begin, end) = (curve.breakpoints()[segment], curve.breakpoints()[segment + 1]);
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

/// Parts of different lengths have segments of their own: state and rate are those of each polynomial in its own time.
#[test]
fn parts_have_lengths_of_their_own() {
    // x = [t, t^2 / 2; 1, t] in the first part, and on with the velocity of its end in the second one.
    let lengths = [0.5, 2.0];
    let nodes = |length: f64| Chebyshev::new(3, length).expect("valid").times().to_vec();
    let mut x = DMatrix::zeros(2, 16);
    for (segment, begin) in [0.0, 0.25, 0.5, 1.5].into_iter().enumerate() {
        let length = lengths[segment / 2] / 2.0;
        for (node, time) in nodes(length).into_iter().enumerate() {
            let t: f64 = begin + time;
            x.set_column(4 * segment + node, &nalgebra::vector![t * t / 2.0, t]);
        }
    }
    let curve = Curve::in_parts(&lengths, 4, x.clone()).expect("it is continuous");
    assert_eq!((curve.parts(), curve.segments(), curve.degree()), (2, 4, 3));
    assert_eq!(curve.breakpoints(), [0.0, 0.25, 0.5, 1.5, 2.5]);
    assert_eq!([0, 1].map(|part| curve.horizon_of(part)), [1.0, 4.0]);
    assert_eq!([1, 2].map(|e| curve.chebyshev(e).horizon()), [0.25, 1.0]);
    for time in [0.0, 0.1, 0.25, 0.4, 0.5, 1.1, 2.0, 2.5] {
        let (state, rate) = curve.at(time);
        assert_close!(&state, &[time * time / 2.0, time], 1e-14);
        assert_close!(&rate, &[time, 1.0], 1e-12);
    }
    let slower = curve.stretched(5.0).expect("positive");
    assert_eq!(slower.breakpoints(), [0.0, 0.5, 1.0, 3.0, 5.0]);
    let (state, rate) = slower.at(2.0);
    assert_close!(&state, &[0.5, 0.5], 1e-14);
    assert_close!(&rate, &[0.5, 0.25], 1e-12);
    for (lengths, segments) in [(&[][..], 4), (&[1.0, 1.0, 1.0], 4), (&[1.0, 1.0], 0), (&[1.0, -1.0], 4)] {
        assert!(Curve::in_parts(lengths, segments, x.clone()).is_err());
    }
}
