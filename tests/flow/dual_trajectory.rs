//! Dual trajectories, and the costs of the control that they define.

use crate::common::assert_refused;
use aghf::curve::Chebyshev;
use aghf::flow::{ControlCost, ControlDual, DualTrajectory};
use aghf::scalar::{AlgebraOver, Tanh};
use nalgebra::DMatrix;

/// The analytic derivatives of a dual of the control equal those by dual numbers of its value.
#[test]
fn a_dual_of_the_control_is_linear_in_it() {
    struct ValueAlone<'a>(&'a ControlDual);
    impl ControlCost for ValueAlone<'_> {
        fn value<S: AlgebraOver<f64> + Tanh>(&self, t: S, joint: usize, u: S) -> S {
            self.0.value(t, joint, u)
        }
    }
    let coefficients = DMatrix::from_fn(2, 5, |i, j| (1.0 + i as f64 + 0.6 * j as f64).cos());
    let dual = ControlDual(DualTrajectory::new(2.0, coefficients).expect("it has columns"));
    // The third joint has no component.
    for joint in 0..3 {
        let alone = ValueAlone(&dual);
        let (t, u) = (0.7, -1.3);
        assert_close!(&dual.derivatives(t, joint, u), &alone.derivatives(t, joint, u), 1e-14);
        assert_close!(&dual.rates(t, joint, u), &alone.rates(t, joint, u), 1e-14);
        assert_eq!(dual.rates(t, joint, u)[0] == 0.0, joint == 2);
        let both = (&dual, &alone);
        let doubled = dual.rates(t, joint, u).map(|r| 2.0 * r);
        assert_close!(&both.rates(t, joint, u), &doubled, 1e-14);
        assert_close!(&[both.value(t, joint, u)], &[2.0 * dual.value(t, joint, u)], 1e-14);
    }
}

#[test]
fn a_dual_trajectory_goes_through_its_values() {
    for p in [2, 7, 30] {
        let chebyshev = Chebyshev::new(p, 2.5).expect("a degree");
        let values = |shift: f64| {
            let times = chebyshev.times();
            DMatrix::from_fn(3, p + 1, |i, j| (times[j] * (i as f64 + 1.0) + shift).sin())
        };
        let (first, second) = (values(0.0), values(1.0));
        let mut lambda = DualTrajectory::through(&chebyshev, &first).expect("one per node");
        assert_eq!(lambda.components(), 3);
        let at_nodes = |lambda: &DualTrajectory, part: usize| {
            let times = chebyshev.times();
            DMatrix::from_fn(3, p + 1, |i, j| lambda.value_and_rate(i, times[j])[part])
        };
        assert_close!(&at_nodes(&lambda, 0), &first, 1e-14);
        let rates = &first * chebyshev.d().transpose();
        assert_close!(&at_nodes(&lambda, 1), &rates, 1e-12);
        lambda.ascend(0.3, &chebyshev, &second).expect("same horizon");
        assert_close!(&at_nodes(&lambda, 0), &(first + second * 0.3), 1e-14);
        assert_close!(&[lambda.value(3, 1.0)], &[0.0], 0.0);
    }
    // The step may have another degree.
    let (few, many) = [3, 9].map(|p| Chebyshev::new(p, 2.5).expect("a degree")).into();
    let constant = |count: usize, c: f64| DMatrix::from_element(1, count, c);
    for (own, other) in [(&few, &many), (&many, &few)] {
        let count = |c: &Chebyshev| c.degree() + 1;
        let mut lambda = DualTrajectory::through(own, &constant(count(own), 1.0)).expect("one per node");
        lambda.ascend(2.0, other, &constant(count(other), 3.0)).expect("same horizon");
        assert_close!(&[lambda.value(0, 0.4)], &[7.0], 1e-14);
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let empty = DualTrajectory::new(1.0, DMatrix::zeros(2, 0));
    assert_refused(empty, "there are none, at least one column is needed");
    let still = DualTrajectory::new(0.0, DMatrix::zeros(2, 1));
    assert_refused(still, "horizon: it is zero and must be a positive time");
    let chebyshev = Chebyshev::new(4, 2.0).expect("a degree");
    let too_few = DualTrajectory::through(&chebyshev, &DMatrix::zeros(2, 4));
    assert_refused(too_few, "values: expected 5 entries, found 4");
    let mut lambda = DualTrajectory::new(1.0, DMatrix::zeros(2, 1)).expect("a column");
    let other_horizon = lambda.ascend(1.0, &chebyshev, &DMatrix::zeros(2, 5));
    assert_refused(other_horizon, "horizon: it is 1, that of the step 2");
    let one_row = lambda.ascend(1.0, &chebyshev, &DMatrix::zeros(1, 5));
    assert_refused(one_row, "c: expected 2 entries, found 1");
}
