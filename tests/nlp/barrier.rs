//! Rules of the barrier parameter.

use crate::dense::{Dense, accurate};
use aghf::cost::HyperDual64;
use aghf::nlp::{BarrierState, BarrierUpdate, Monotone, Options, Status};
use std::sync::{Arc, Mutex};

/// The nearest point of a disc and a half-plane to $(2, 1)$, with an objective that is never zero.
fn nearest(x: &[HyperDual64]) -> (HyperDual64, Vec<HyperDual64>) {
    let away = (x[0] - 2.0) * (x[0] - 2.0) + (x[1] - 1.0) * (x[1] - 1.0);
    let disc = x[0] * x[0] + x[1] * x[1] - 1.0;
    (away + 1.0, vec![disc, x[1] - 0.2])
}

fn program() -> Dense {
    Dense { measure: 0.7, ..Dense::new(nearest, &[-0.5, -0.5], 0, 2) }
}

/// A share of the complementarity after every step, or never another parameter, and a record of all that it was shown.
#[derive(Debug, Default)]
struct Adaptive {
    never: bool,
    seen: Mutex<Vec<BarrierState>>,
}

impl BarrierUpdate for Adaptive {
    fn is_solved(&self, state: &BarrierState) -> bool {
        self.seen.lock().expect("no panic").push(*state);
        !self.never
    }

    fn next(&self, state: &BarrierState) -> f64 {
        0.2 * state.complementarity
    }
}

/// A rule that returns one value, whatever it is shown.
#[derive(Debug)]
struct Always(f64);

impl BarrierUpdate for Always {
    fn is_solved(&self, _: &BarrierState) -> bool {
        true
    }

    fn next(&self, _: &BarrierState) -> f64 {
        self.0
    }
}

fn by(rule: impl BarrierUpdate + 'static) -> Options {
    Options { barrier: Arc::new(rule), ..accurate() }
}

/// Every rule leads to the same point, which is known: $x_2 = 0.2$ on the circle.
#[test]
fn any_rule_leads_to_the_minimum() {
    let slow = Monotone { factor: 0.5, ..Monotone::default() };
    let rules = [accurate(), by(slow), by(Adaptive::default()), by(Always(0.0)), by(Always(f64::NAN))];
    for options in rules {
        let end = program().solve(&options);
        assert_eq!(end.status, Status::Converged, "{:?}", options.barrier);
        let x = [0.96_f64.sqrt(), 0.2];
        assert_close!(end.x.as_slice(), x.iter(), 1e-7);
    }
}

/// All values are relative to the objective and summed with the weights of the rows, the measure included.
#[test]
fn rules_see_relative_sums() {
    let rule = Arc::new(Adaptive::default());
    let options = Options { barrier: rule.clone(), ..accurate() };
    let end = program().solve(&options);
    let seen = rule.seen.lock().expect("no panic");
    for state in &*seen {
        assert!(state.alpha > 0.0 && state.alpha <= 1.0, "{state:?}");
        assert!(state.decrease.is_finite() && state.mu > 0.0, "{state:?}");
    }
    let last = seen.last().expect("there were steps");
    let iterate = &end.iterate;
    let working = iterate.working.iter();
    let products = working.map(|of| of.row.weight * of.slack * of.multiplier);
    let own = 0.7 * products.sum::<f64>() / end.progress.objective;
    assert!(own <= 1.1 * options.last_barrier && own >= 0.5 * options.last_barrier, "{own:e}");
    // Near the end the iterates are on the central path.
    assert!((last.complementarity / last.mu - 1.0).abs() < 0.1, "{last:?}");
}

/// Iterations are counted while none decreases the barrier function by more than the barrier parameter. At the first
/// one there is nothing to compare with; far from the minimum each decreases it by more, at the minimum none does.
#[test]
fn iterations_without_a_decrease_are_counted() {
    let rule = Arc::new(Adaptive { never: true, ..Adaptive::default() });
    let options = Options { first_barrier: 1e-2, iterations: 30, barrier: rule.clone(), ..accurate() };
    assert_eq!(program().solve(&options).status, Status::Iterations);
    let seen = rule.seen.lock().expect("no panic");
    let stalled: Vec<usize> = seen.iter().map(|state| state.stalled).collect();
    assert_eq!(stalled[..3], [0, 0, 0], "{stalled:?}");
    assert!(stalled.windows(2).all(|two| two[1] == 0 || two[1] == two[0] + 1), "{stalled:?}");
    let last: Vec<usize> = stalled[20..].iter().map(|count| count - stalled[20]).collect();
    assert_eq!(last, Vec::from_iter(0..10), "{stalled:?}");
}

/// A problem whose predicted decrease remains large counts as solved after some iterations without one, unless there
/// are equalities.
#[test]
fn a_stalled_barrier_problem_is_solved() {
    let at = |stalled, has_equalities| BarrierState {
        mu: 0.1,
        complementarity: 0.1,
        decrease: 10.0,
        alpha: 1e-3,
        has_equalities,
        stalled,
    };
    let rule = Monotone::default();
    let counts = [0, rule.stalled - 1, rule.stalled];
    let [without, with] = [false, true].map(|has| counts.map(|stalled| rule.is_solved(&at(stalled, has))));
    assert_eq!(without, [false, false, true]);
    assert_eq!(with, [false; 3]);
}

/// $(x^2 - 1)^2 + 1$, and a row far away.
fn well(x: &[HyperDual64]) -> (HyperDual64, Vec<HyperDual64>) {
    let well = x[0] * x[0] - 1.0;
    (well * well + 1.0, vec![x[0] - 1e3])
}

/// With another barrier parameter the count begins anew: a smaller one makes the barrier function of the row far away
/// larger.
#[test]
fn a_new_barrier_problem_has_not_stalled() {
    let rule = Arc::new(Adaptive::default());
    let options = Options { barrier: rule.clone(), ..accurate() };
    Dense::new(well, &[1.01], 0, 1).solve(&options);
    let seen = rule.seen.lock().expect("no panic");
    let reduced = seen.windows(2).filter(|two| two[1].mu < 0.9 * two[0].mu);
    let stalled: Vec<_> = reduced.map(|two| two[1].stalled).collect();
    assert!(stalled.len() > 3 && stalled.iter().all(|count| *count == 0), "{stalled:?}");
}

/// Where the objective has negative curvature, the predicted decrease is that of the longest step down the slope, of
/// length 1, however short the step is for the multiple of the norm.
#[test]
fn short_steps_do_not_show_a_minimum() {
    let rule = Arc::new(Adaptive::default());
    let options = Options { first_regularisation: 1e3, barrier: rule.clone(), ..accurate() };
    let end = Dense::new(well, &[0.2], 0, 1).solve(&options);
    assert_eq!(end.status, Status::Converged);
    let first = rule.seen.lock().expect("no panic")[0];
    let objective = |x: f64| (x * x - 1.0).powi(2) + 1.0;
    let slope = 4.0 * 0.2 * (1.0 - 0.2 * 0.2);
    let curvature = 12.0 * 0.2 * 0.2 - 4.0;
    let step = slope / (options.first_regularisation * objective(0.2) + curvature);
    let objective = objective(0.2 + first.alpha * step);
    assert_close!(&[first.decrease], &[slope / objective], 1e-2);
}
