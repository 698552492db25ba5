//! Slacks, elastic variables and multipliers: the condensed equations against the complete ones.

use crate::common::config;
use aghf::nlp::{Barrier, Equality, Iterate, Options, Row, RowState};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

const ROW: Row = Row::new(0, 1.0);
const EQUALITY: Row = Row::equality(0, 1.0);

/// A row with a slack, an elastic variable and a multiplier at this fraction between its bounds.
fn one(row: Row, barrier: Barrier, [slack, elastic, fraction]: [f64; 3]) -> Iterate {
    let mut iterate = Iterate::new(barrier, Vec::new());
    iterate.set_working(&[row], &[0.0]);
    let state = RowState { row, slack, elastic, multiplier: 0.0, penalty: barrier.nu };
    let multiplier = state.least() + fraction * (barrier.nu - state.least());
    iterate.working[0] = RowState { multiplier, ..state };
    iterate
}

/// An inequality or an equality.
fn kinds() -> impl Strategy<Value = Row> {
    prop_oneof![Just(ROW), Just(EQUALITY)]
}

/// Numbers of all orders of magnitude between these powers of ten.
fn size(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|power| 10.0_f64.powf(power))
}

/// Barriers of all orders of magnitude within these powers of ten of the parameter and of the penalty.
fn barriers(mu: [f64; 2], nu: [f64; 2]) -> impl Strategy<Value = Barrier> {
    let both = (size(mu[0], mu[1]), size(nu[0], nu[1]));
    both.prop_map(|(mu, nu)| Barrier { mu, nu })
}

/// Slack, elastic variable and fraction of a row that is not at the limits of rounding.
fn regular() -> impl Strategy<Value = [f64; 3]> {
    (size(-3.0, 0.0), size(-3.0, 0.0), 0.01..0.99).prop_map(|(s, t, z)| [s, t, z])
}

proptest! {
    #![proptest_config(config(128))]

    /// Slack and elastic variable satisfy $h + s = t$ and $\mu / s + \mu / t = \nu$, or $2 \nu$ for an equality, the
    /// conditions of the least barrier function for a row, without loss of digits.
    #[test]
    fn a_split_is_the_minimum(
        row in kinds(), barrier in barriers([-12.0, 1.0], [-2.0, 9.0]), sign: bool,
        h in prop_oneof![Just(0.0), size(-12.0, 9.0)],
    ) {
        let h = if sign { h } else { -h };
        let [s, t] = barrier.split(&row, h, barrier.nu);
        prop_assert!(s > 0.0 && t > 0.0, "{s} {t}");
        prop_assert!((h + s - t).abs() <= 1e-14 * (h.abs() + s + t), "{h} {s} {t}");
        let sum = barrier.mu / s + barrier.mu / t;
        let penalties = if row.is_equality { 2.0 * barrier.nu } else { barrier.nu };
        prop_assert!((sum - penalties).abs() <= 1e-13 * penalties, "{sum}");
    }

    /// The step of a row solves the three linearised conditions $s (z - \underline z) = \mu$, $t (\nu - z) = \mu$ and
    /// $h + s = t$, and the condensed terms predict the multiplier at its end.
    #[test]
    fn condensed_and_complete_equations_agree(
        row in kinds(), barrier in barriers([-4.0, 0.0], [-1.0, 2.0]), at in regular(), h in -1.0..1.0_f64,
        change in -1.0..1.0_f64,
    ) {
        let iterate = one(row, barrier, at);
        let ([s, t, _], mu, z) = (at, barrier.mu, iterate.working[0].multiplier);
        let [below, above] = iterate.working[0].distances();
        let matrix = Matrix3::new(below, 0.0, s, 0.0, above, -t, 1.0, -1.0, 0.0);
        let right = Vector3::new(mu - s * below, mu - t * above, t - s - h - change);
        let exact = matrix.lu().solve(&right).expect("the matrix is regular");
        let step = iterate.step(&iterate.working[0], h, change);
        assert_close!(&[step.slack, step.elastic, step.multiplier], exact.as_slice(), 1e-9);
        let term = iterate.term(&iterate.working[0], h);
        prop_assert!(term.curvature > 0.0);
        prop_assert_eq!(term.multiplier, z);
        assert_close!(&[term.slope + term.curvature * change], &[z + step.multiplier], 1e-9);
    }

    /// The slope of the barrier function along a step is that of the condensed equations less the curvature of slack
    /// and elastic variable.
    #[test]
    fn slope_along_a_step(
        row in kinds(), barrier in barriers([-4.0, 0.0], [-1.0, 2.0]), at in regular(), change in -1.0..1.0_f64,
    ) {
        let iterate = one(row, barrier, at);
        let ([s, t, _], Barrier { mu, nu }, h) = (at, barrier, at[1] - at[0]);
        let step = iterate.step(&iterate.working[0], h, change);
        let of_slack = if row.is_equality { nu } else { 0.0 };
        let exact = nu * step.elastic + of_slack * step.slack - mu * (step.slack / s + step.elastic / t);
        let [own, condensed] = iterate.bend(&iterate.working[0], &step, change);
        let term = iterate.term(&iterate.working[0], h);
        let value = nu * t + of_slack * s - mu * (s.ln() + t.ln());
        assert_close!(&[term.cost, iterate.barrier_terms(|_| 1.0)], &[value; 2], 1e-12);
        let found = term.slope * change + condensed - own;
        let size = 1.0 + own + nu * (step.slack.abs() + step.elastic.abs());
        prop_assert!((found - exact).abs() <= 1e-9 * size, "{found} {exact}");
    }

    /// Whatever the step, slack, elastic variable and multiplier keep a fraction of their distances from zero, and the
    /// multiplier from the penalty; a step within these is taken as it is.
    #[test]
    fn a_step_stays_inside(
        row in kinds(), s in size(-9.0, 3.0), t in size(-9.0, 3.0), z in 1e-6..1.0 - 1e-6, h in -1e3..1e3_f64,
        change in -1e3..1e3_f64, fraction in 0.0..1.0_f64,
    ) {
        let (barrier, tau) = (Barrier { mu: 1e-3, nu: 7.0 }, 0.9);
        let from = one(row, barrier, [s, t, z]);
        let step = from.step(&from.working[0], h, change);
        let to = from.working[0].take(&step, fraction, tau);
        let (z, [below, above], least) = (from.working[0].multiplier, from.working[0].distances(), 1.0 - tau);
        let expected = [
            (s + fraction * step.slack).max(least * s),
            (t + fraction * step.elastic).max(least * t),
            (z + fraction * step.multiplier).clamp(z - tau * below, z + tau * above),
        ];
        for (found, expected) in [to.slack, to.elastic, to.multiplier].iter().zip(expected) {
            prop_assert!((found - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{found} {expected}");
        }
    }

    /// The multiplier that the condensed equations predict without a step is that of a Newton step of slack, elastic
    /// variable and multiplier alone, within its range.
    #[test]
    fn updated_multipliers_are_those_of_the_condensed_equations(
        row in kinds(), barrier in barriers([-4.0, 0.0], [-1.0, 2.0]), at in regular(),
    ) {
        let mut iterate = one(row, barrier, at);
        let (h, state) = (at[1] - at[0], iterate.working[0]);
        let step = iterate.step(&state, h, 0.0);
        iterate.update_multipliers(&[h], 1e10);
        let expected = (state.multiplier + step.multiplier).clamp(state.least(), barrier.nu);
        let range = (barrier.mu / state.slack + barrier.mu / state.elastic) / 1e10;
        prop_assert!((iterate.working[0].multiplier - expected).abs() <= 1e-9 * barrier.nu + range);
        prop_assert_eq!(iterate.working[0].slack, state.slack);
    }

    /// A multiplier, however wrong, ends between its bounds, so that the condensed terms are numbers.
    #[test]
    fn a_safeguarded_multiplier_is_in_its_range(
        row in kinds(), barrier in barriers([-12.0, 1.0], [-2.0, 9.0]), s in size(-12.0, 9.0), t in size(-12.0, 9.0),
        z in 0.0..1.0,
    ) {
        let mut iterate = one(row, barrier, [s, t, z]);
        iterate.safeguard_all(1e10);
        let distances = iterate.working[0].distances();
        prop_assert!(distances.iter().all(|distance| *distance > 0.0), "{distances:?}");
        let term = iterate.term(&iterate.working[0], t - s);
        prop_assert!(term.slope.is_finite() && term.curvature > 0.0, "{term:?}");
    }
}

/// A known multiplier moves a row away from its bound to the slack that belongs to it, up to a largest one; a zero is
/// not a known multiplier.
#[test]
fn known_multipliers_have_their_slacks() {
    let barrier = Barrier { mu: 1e-3, nu: 1.0 };
    for (known, expected) in [(0.5, 2e-3), (1e-3, 0.02)] {
        let mut iterate = one(ROW, barrier, [1e-6, 1e-6, 0.9]);
        iterate.set_multipliers(&[known], &[0.0], &Options::default());
        assert_close!(&[iterate.working[0].slack, iterate.working[0].elastic], &[expected; 2], 1e-15);
        assert_close!(&[iterate.working[0].multiplier], &[known], 1e-14);
    }
    let mut iterate = one(ROW, barrier, [1e-6, 1e-6, 0.9]);
    iterate.set_multipliers(&[0.0], &[0.0], &Options::default());
    assert_eq!((iterate.working[0].slack, iterate.working[0].multiplier), (1e-6, 0.9));
}

/// The penalty of a row is the given multiple of its known multiplier if that is larger than the penalty of all rows.
#[test]
fn known_multipliers_have_their_penalties() {
    let barrier = Barrier { mu: 1e-3, nu: 1.0 };
    for (known, penalty) in [(0.4, 1.0), (3.0, 6.0)] {
        let mut iterate = one(ROW, barrier, [1e-6, 1e-6, 0.9]);
        iterate.set_multipliers(&[known], &[0.0], &Options::default());
        assert_eq!(iterate.working[0].penalty, penalty);
    }
}

/// Of rows at their penalties only those that are violated get larger ones, up to the largest; later penalties of all
/// rows are lower bounds.
#[test]
fn penalties_of_violated_rows_grow() {
    let (barrier, options) = (Barrier { mu: 1e-6, nu: 2.0 }, Options::default());
    let mut iterate = Iterate::new(barrier, Vec::new());
    let rows = [0, 1, 2].map(|at| Row::new(at, 1.0));
    let h = [0.1, -0.1, 1e-4];
    iterate.set_working(&rows, &h);
    for (state, fraction) in iterate.working.iter_mut().zip([0.95, 0.95, 0.5]) {
        state.multiplier = fraction * barrier.nu;
    }
    let penalties = |of: &Iterate| [0, 1, 2].map(|k: usize| of.working[k].penalty);
    assert!(iterate.raise_penalties(&h, &options, 1e9));
    let factor = options.row_penalty_factor;
    assert_eq!(penalties(&iterate), [factor * 2.0, 2.0, 2.0]);
    assert!(!iterate.raise_penalties(&h, &options, 1e9));
    iterate.set_barrier(Barrier { mu: 1e-6, nu: 5.0 }, options.multiplier_range);
    assert_eq!(penalties(&iterate), [factor * 2.0, 5.0, 5.0]);
    iterate.working[0].multiplier = 0.95 * factor * 2.0;
    assert!(iterate.raise_penalties(&h, &options, 30.0));
    assert_eq!(penalties(&iterate)[0], 30.0);
    iterate.working[0].multiplier = 29.0;
    assert!(!iterate.raise_penalties(&h, &options, 30.0));
}

/// A row that leaves the working set and returns begins anew, at the minimum of its barrier function.
#[test]
fn a_returning_row_begins_anew() {
    let barrier = Barrier { mu: 1e-3, nu: 1.0 };
    let mut iterate = one(ROW, barrier, [5.0, 6.0, 0.9]);
    iterate.set_working(&[], &[0.3]);
    assert!(iterate.working.is_empty());
    iterate.set_working(&[ROW], &[-0.3]);
    assert_eq!([iterate.working[0].slack, iterate.working[0].elastic], barrier.split(&ROW, -0.3, barrier.nu));
    assert_close!(&[iterate.working[0].multiplier], &[barrier.mu / iterate.working[0].slack], 1e-15);
}

/// A row whose multiplier is at the penalty asks for a larger one only if its violation is not accepted.
#[test]
fn rows_at_the_penalty() {
    let barrier = Barrier { mu: 1e-6, nu: 2.0 };
    let at = |fraction| one(ROW, barrier, [1e-3, 1e-3, fraction]);
    assert!(at(0.95).is_at_penalty(&[1e-3], 1e-6));
    assert!(!at(0.85).is_at_penalty(&[1e-3], 1e-6));
    assert!(!at(0.95).is_at_penalty(&[1e-7], 1e-6));
    assert!(!at(0.95).is_at_penalty(&[-1.0], 1e-6));
}

/// An iterate with one curved row.
fn curved() -> Iterate {
    let mut iterate = Iterate::new(Barrier { mu: 1e-6, nu: 2.0 }, Vec::new());
    iterate.set_working(&[Row { is_curved: true, ..ROW }], &[-1.0]);
    iterate
}

/// The weight of the second derivatives of curved rows falls to none with steps that need a multiple of the norm, and
/// returns; other rows have all of theirs.
#[test]
fn the_weight_of_second_derivatives() {
    let mut iterate = curved();
    assert_eq!(iterate.curvature_weight, 1.0);
    for (is_regularised, weight) in [
        (true, 0.25),
        (true, 0.0625),
        (true, 0.0),
        (true, 0.0),
        (false, 0.1),
        (false, 0.4),
        (true, 0.1),
        (true, 0.0),
        (false, 0.1),
        (false, 0.4),
        (false, 1.0),
        (false, 1.0),
    ] {
        iterate.adapt_curvature_weight(is_regularised, &Options::default());
        assert_eq!(iterate.curvature_weight, weight);
        let state = iterate.working[0];
        assert_eq!(iterate.term(&state, -1.0).multiplier, weight * state.multiplier);
        let other = RowState { row: ROW, ..state };
        assert_eq!(iterate.term(&other, -1.0).multiplier, state.multiplier);
    }
    iterate.set_working(&[ROW], &[-1.0]);
    iterate.adapt_curvature_weight(true, &Options::default());
    assert_eq!(iterate.curvature_weight, 1.0);
}

/// All second derivatives are tried again where some steps without them needed a multiple of the norm too, counted anew
/// after each step without one.
#[test]
fn all_second_derivatives_are_tried_again() {
    let options = Options { max_steps_without_curvature: 2, ..Options::default() };
    let mut iterate = curved();
    iterate.curvature_weight = 0.0;
    for (is_regularised, weight) in [(true, 0.0), (false, 0.1), (true, 0.0), (true, 0.0), (true, 1.0), (true, 0.25)] {
        iterate.adapt_curvature_weight(is_regularised, &options);
        assert_eq!(iterate.curvature_weight, weight);
    }
}

/// The known multiplier of an equality, of either sign, raises its penalty, and its slacks are those of its value.
#[test]
fn known_multipliers_of_equalities() {
    let barrier = Barrier { mu: 1e-6, nu: 1.0 };
    for known in [-3.0, 0.2] {
        let mut iterate = Iterate::new(barrier, Vec::new());
        iterate.set_working(&[EQUALITY], &[0.1]);
        iterate.set_multipliers(&[known], &[0.1], &Options::default());
        let RowState { slack, elastic, multiplier, penalty, .. } = iterate.working[0];
        assert_eq!(penalty, f64::max(1.0, 2.0 * known.abs()));
        assert_close!(&[multiplier], &[known], 1e-14);
        assert_eq!([slack, elastic], barrier.split(&EQUALITY, 0.1, penalty));
    }
}

/// A hard row has the slack of its value and no elastic variable, whatever the step; a violated one has a slack all the
/// same, and the whole step removes the rest of its equation.
#[test]
fn a_hard_row_is_not_elastic() {
    let barrier = Barrier { mu: 1e-3, nu: 1.0 };
    let mut iterate = Iterate::new(barrier, Vec::new());
    iterate.set_working(&[Row { is_hard: true, ..ROW }], &[-0.2]);
    let state = iterate.working[0];
    assert_eq!([state.slack, state.elastic, state.multiplier], [0.2, 0.0, 5e-3]);
    let step = iterate.step(&state, -0.2, 0.1);
    assert_close!(&[step.slack, step.elastic, step.multiplier], &[-0.1, 0.0, 2.5e-3], 1e-15);
    let mut after = state.take(&step, 1.0, 0.9);
    after.meet(-0.1);
    assert_close!(&[after.slack, after.elastic, after.multiplier], &[0.1, 0.0, 7.5e-3], 1e-15);
    assert_close!(&[iterate.barrier_terms(|_| 1.0)], &[-1e-3 * f64::ln(0.2)], 1e-15);
    let state = barrier.central(Row { is_hard: true, ..ROW }, 0.5, 1.0);
    assert_close!(&[state.slack, state.elastic, state.multiplier], &[0.01, 0.51, 0.1], 1e-15);
    let step = iterate.step(&state, 0.5, -0.8);
    let mut after = state.take(&step, 1.0, 0.9);
    after.meet(-0.3);
    assert_close!(&[after.slack, after.elastic], &[0.3, 0.0], 1e-15);
}

/// Penalties grow after a step that hardly decreases a violation, of rows whose multipliers have nearly reached them.
#[test]
fn penalties_steer() {
    let (barrier, options) = (Barrier { mu: 1e-6, nu: 2.0 }, Options::default());
    for (h, fraction, raised) in [(0.95, 0.99, true), (0.8, 0.99, false), (0.95, 0.6, false), (-0.95, 0.99, true)] {
        let mut iterate = one(EQUALITY, barrier, [1e-3, 1e-3, fraction]);
        assert_eq!(iterate.steer(&[1.0], &[h], &options, 1e9), raised, "{h} {fraction}");
        assert_eq!(iterate.working[0].penalty, if raised { 20.0 } else { 2.0 });
    }
}

/// The terms of an equality are those of the Lagrangian, which the barrier function does not have; another working set
/// of inequalities does not change its multiplier.
#[test]
fn equalities_have_the_terms_of_the_lagrangian() {
    let h = 0.25;
    let mut iterate = Iterate::new(Barrier { mu: 1e-3, nu: 1.0 }, vec![Equality::new(Row::new(1, 0.5))]);
    iterate.set_multipliers(&[0.0, -3.0], &[0.0, h], &Options::default());
    let term = iterate.equalities[0].term(h);
    assert_eq!([term.cost, term.slope, term.multiplier, term.curvature], [-0.75, -3.0, -3.0, 0.0]);
    assert_eq!(iterate.lagrangian_terms(&[0.0, h], 2.0), -0.75);
    assert_eq!(iterate.barrier_terms(|_| 1.0), 0.0);
    iterate.set_working(&[ROW], &[-0.3, h]);
    assert_eq!(iterate.equalities[0].multiplier, -3.0);
}
