//! Maxima between three values. The file is compiled here, because its type is not public.

#[allow(dead_code, unreachable_pub)]
#[path = "../../src/curve/bracket.rs"]
mod source;

use crate::common::slider;
use aghf::constraint::{Bound, Bounds, Constraint, Constraints, PlacedState, Side, TorqueLimits};
use aghf::curve::{Chebyshev, Curve};
use aghf::motion::{Violation, violations};
use aghf::scalar::AlgebraOver;
use nalgebra::DMatrix;
use source::Bracket;

fn refined(f: impl Fn(f64) -> f64, times: [f64; 3]) -> (f64, f64) {
    let values = times.map(&f);
    let mut bracket = Bracket { times, values };
    assert!(bracket.is_valid());
    for _ in 0..Bracket::REFINEMENTS {
        let time = bracket.next();
        assert!(bracket.times[0] < time && time < bracket.times[2]);
        bracket.narrow(time, f(time));
        assert!(bracket.is_valid(), "{bracket:?}");
    }
    bracket.vertex()
}

/// A smooth maximum is found to the accuracy of the second parabola, wherever it is between the times.
#[test]
fn a_smooth_maximum() {
    for top in [0.55, 0.9, 1.0, 1.3, 1.4] {
        let (time, height) = refined(|t| (t - top).cos() + 0.2 * (t - top).powi(3), [0.0, 1.0, 2.0]);
        assert!((time - top).abs() < 1e-2, "{time} {top}");
        assert!((height - 1.0).abs() < 1e-4, "{height}");
    }
}

/// The distance from a corner that is passed in a tenth of an interval, where the first parabola is far off.
#[test]
fn a_corner() {
    for top in [0.6, 1.2, 1.4] {
        let f = |t: f64| -((t - top).powi(2) + 0.01_f64).sqrt();
        let first = Bracket { times: [0.0, 1.0, 2.0], values: [0.0, 1.0, 2.0].map(f) };
        let (_, height) = refined(f, first.times);
        let (before, after) = (first.vertex().1 + 0.1, height + 0.1);
        assert!(after.abs() < 0.02 && after.abs() < 0.2 * before.abs(), "{before} {after}");
    }
}

/// A row that is exact near its bound alone may have a step below it. The parabola through the values next to it may be
/// above all of them, the maximum is not.
#[test]
fn a_step() {
    let f = |t: f64| {
        if (1.1..1.3).contains(&t) { -0.02 } else { -0.04 }
    };
    let times = [1.0, 1.28, 1.31];
    let bracket = Bracket { times, values: times.map(f) };
    assert!(bracket.vertex().1 > 0.0 && !bracket.is_settled());
    assert_eq!(bracket.maximum(), (1.28, -0.02));
    for middle in [1.11, 1.2, 1.29] {
        let times = [0.0, middle, 2.0];
        let values = times.map(f);
        let mut bracket = Bracket { times, values };
        for _ in 0..Bracket::MAX_REFINEMENTS {
            bracket.narrow(bracket.next(), f(bracket.next()));
        }
        let (time, height) = bracket.maximum();
        assert!((-0.02..-0.0195).contains(&height), "{height} at {time}");
    }
}

/// Of a row that is hardly within its bound between two steps no parabola is a violation.
#[test]
fn a_step_to_a_bound() {
    for k in 0..200 {
        let (from, to) = (1.1 - 4e-3 * f64::from(k), 1.3 + 1e-3 * f64::from(k));
        let f = |t: f64| {
            if (from..to).contains(&t) { -1e-6 } else { -0.08 }
        };
        let times = [from - 0.1, 0.5 * (from + to), to + 0.3];
        let values = times.map(f);
        let mut bracket = Bracket { times, values };
        for _ in 0..Bracket::MAX_REFINEMENTS {
            if bracket.is_settled() {
                break;
            }
            bracket.narrow(bracket.next(), f(bracket.next()));
        }
        let (time, height) = bracket.maximum();
        assert!((-1e-6..=0.0).contains(&height), "{height} at {time}");
    }
}

/// A maximum between an end and its neighbour is seen from the end, one beyond it is not.
#[test]
fn a_maximum_at_an_end() {
    let of = |top: f64| {
        let times = [0.0, 1.0, 2.0];
        let values = times.map(|t| -(t - top).powi(2));
        Bracket { times, values }
    };
    assert_eq!(of(1.75).at_end(2), (1.75, 0.0));
    assert_eq!(of(0.25).at_end(0), (0.25, 0.0));
    assert_eq!(of(2.5).at_end(2), (2.0, -0.25));
    assert_eq!(of(-1.0).at_end(0), (0.0, -1.0));
}

/// A row far below its bound is not refined, one whose neighbours fall steeply is.
#[test]
fn maxima_that_may_exceed_a_bound() {
    let of = |values| Bracket { times: [0.0, 1.0, 2.0], values };
    assert!(!of([-1.1, -1.0, -1.1]).may_exceed(0.0));
    assert!(of([-2.0, -1.0, -1.5]).may_exceed(0.0));
    assert!(!of([1.0, 0.0, -1.0]).is_valid() && !of([f64::NEG_INFINITY, 0.0, -1.0]).is_valid());
}

/// A smooth row, and with `steps` one that is constant between steps. Only its violation at 1.6 is one.
struct Rows {
    steps: bool,
}

impl Constraint for Rows {
    fn dim(&self) -> usize {
        1 + usize::from(self.steps)
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> aghf::Result<()> {
        let (q, number) = (at.x[0], S::from_f64);
        g[0] = number(1e-3) - (q - number(0.93)) * (q - number(0.93)) * (number(1.0) + q);
        for (from, value) in [(0.0, -0.08), (0.5, -0.0005), (0.7, -0.003), (0.9, -0.08), (1.5, 0.004), (1.7, -0.08)] {
            if self.steps {
                g[1] = (q - number(from)).if_negative(g[1], number(value));
            }
        }
        Ok(())
    }
}

/// In a report a row is refined by itself, and a violation at a regular time is kept although a parabola elsewhere is
/// higher before it is refined.
#[test]
fn a_row_with_steps_in_a_report() {
    let chebyshev = Chebyshev::new(4, 2.0).expect("a good degree");
    let times = chebyshev.times().to_vec();
    let x = DMatrix::from_fn(2, 5, |i, k| if i == 0 { times[k] } else { 1.0 });
    let curve = Curve::new(chebyshev, x).expect("sizes agree");
    let of = |steps| {
        let all = Constraints { state: Rows { steps }, torque: TorqueLimits(Vec::new()), stage: Default::default() };
        violations(&slider(1.0), &curve, &all, 10).expect("same robot")
    };
    let found = of(true);
    assert_eq!(of(false), found[..1]);
    assert!((found[0].by - 1e-3).abs() < 1e-6, "{found:?}");
    let Violation { by, at_s, .. } = found[1];
    // A violation beside a step is overestimated by two hundredths of the step at most.
    let most = 0.004 + 0.02 * (0.004 + 0.08);
    assert!((0.004..most).contains(&by), "{found:?}");
    assert!((at_s - 1.6).abs() < 0.05, "{found:?}");
}

/// Of two bumps of nearly the same height either may be the highest one, and neither may be between the times alone.
#[test]
fn each_of_two_bumps_is_refined() {
    for step in -20..=20 {
        let tilt = 1e-3 * f64::from(step);
        let q = |t: f64| tilt * t - ((t - 0.93).powi(2) - 0.36).powi(2);
        let chebyshev = Chebyshev::new(4, 2.0).expect("a good degree");
        let times = chebyshev.times().to_vec();
        let x = DMatrix::from_fn(2, 5, |i, k| if i == 0 { q(times[k]) } else { 0.0 });
        let curve = Curve::new(chebyshev, x).expect("sizes agree");
        let highest = (0..=200_000).map(|k| q(1e-5 * f64::from(k)));
        let highest = highest.fold(f64::NEG_INFINITY, f64::max);
        let bound = Bound { entry: 0, side: Side::Upper, value: highest - 1e-3 };
        let all =
            Constraints { state: Bounds(vec![bound]), torque: TorqueLimits(Vec::new()), stage: Default::default() };
        let found = violations(&slider(1.0), &curve, &all, 10).expect("same robot");
        assert!((found[0].by - 1e-3).abs() < 1e-5, "{found:?}");
    }
}
