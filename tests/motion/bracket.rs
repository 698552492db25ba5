//! Maxima between three values. The file is compiled here, because its type is not public.

#[allow(dead_code, unreachable_pub)]
#[path = "../../src/motion/bracket.rs"]
mod source;

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
        let (time, height) = refined(
            |t| (t - top).cos() + 0.2 * (t - top).powi(3),
            [0.0, 1.0, 2.0],
        );
        assert!((time - top).abs() < 1e-2, "{time} {top}");
        assert!((height - 1.0).abs() < 1e-4, "{height}");
    }
}

/// The distance from a corner that is passed in a tenth of an interval, where the first parabola is far off.
#[test]
fn a_corner() {
    for top in [0.6, 1.2, 1.4] {
        let f = |t: f64| -((t - top).powi(2) + 0.01_f64).sqrt();
        let first = Bracket {
            times: [0.0, 1.0, 2.0],
            values: [0.0, 1.0, 2.0].map(f),
        };
        let (_, height) = refined(f, first.times);
        let (before, after) = (first.vertex().1 + 0.1, height + 0.1);
        assert!(
            after.abs() < 0.02 && after.abs() < 0.2 * before.abs(),
            "{before} {after}"
        );
    }
}

/// A row that is exact near its bound alone may have a step below it. The parabola through the values next to it may be
/// above all of them, the maximum is not.
#[test]
fn a_step() {
    let f = |t: f64| {
        if (1.1..1.3).contains(&t) {
            -0.02
        } else {
            -0.04
        }
    };
    let times = [1.0, 1.28, 1.31];
    let bracket = Bracket {
        times,
        values: times.map(f),
    };
    assert!(bracket.vertex().1 > 0.0 && !bracket.is_settled());
    assert_eq!(bracket.maximum(), (1.28, -0.02));
    for middle in [1.11, 1.2, 1.29] {
        let times = [0.0, middle, 2.0];
        let values = times.map(f);
        let mut bracket = Bracket { times, values };
        for _ in 0..Bracket::MOST_REFINEMENTS {
            bracket.narrow(bracket.next(), f(bracket.next()));
        }
        let (time, height) = bracket.maximum();
        assert!((-0.02..-0.0195).contains(&height), "{height} at {time}");
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
    let of = |values| Bracket {
        times: [0.0, 1.0, 2.0],
        values,
    };
    assert!(!of([-1.1, -1.0, -1.1]).may_exceed(0.0));
    assert!(of([-2.0, -1.0, -1.5]).may_exceed(0.0));
    assert!(!of([1.0, 0.0, -1.0]).is_valid() && !of([f64::NEG_INFINITY, 0.0, -1.0]).is_valid());
}
