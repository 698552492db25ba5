//! The augmented Lagrangian's terms of rows of constraints.

use aghf::constraint::{Constraints, TorqueLimits};
use aghf::flow::weak::{RowTerms, StateGrid};

/// A passive joint and one with a limit, at three points of the quadrature and three Gauss points more.
fn limits() -> Constraints<()> {
    Constraints {
        state: (),
        torque: TorqueLimits(vec![Some(0.0), Some(2.0)]),
        stage: Default::default(),
    }
}

#[test]
fn a_term_has_its_derivatives_and_the_step_takes_the_first() {
    let model = aghf::urdf::builtin_robot("pendulum_2").expect("it is built in");
    let (limits, grid) = (limits(), StateGrid::collocated(1, 4, 3, 3, 1.0));
    let mut rows = RowTerms::new(&model, &limits, &grid).expect("the same robot");
    assert_eq!((rows.count(), rows.h.len()), (3, 18));
    rows.penalties = vec![3.0, 5.0, 7.0];
    for at in 0..18 {
        rows.h[at] = (1.0 + 2.0 * at as f64).sin();
        rows.duals[at] = 0.3 + (0.7 * at as f64).cos();
    }
    for at in 0..18 {
        let (h, step) = (rows.h[at], 1e-6);
        let [value, first, second] = rows.term(at);
        let mut moved = |by: f64| {
            rows.h[at] = h + by;
            let term = rows.term(at);
            rows.h[at] = h;
            term
        };
        let [ahead, behind] = [moved(step), moved(-step)];
        assert!(((ahead[0] - behind[0]) / (2.0 * step) - first).abs() < 1e-8);
        assert!(((ahead[1] - behind[1]) / (2.0 * step) - second).abs() < 1e-8);
        let (collocated, passive) = (at >= 9, at % 3 == 0);
        let idle = collocated != passive;
        assert_eq!(
            (idle, idle),
            (second == 0.0 && value == 0.0, first == 0.0 && value == 0.0)
        );
        let (z, rho) = (rows.duals[at], rows.penalties[at % 3]);
        let expected = match (idle, passive) {
            (true, _) => 0.0,
            (false, true) => z + rho * h,
            (false, false) => (z + rho * h).max(0.0),
        };
        assert!((first - expected).abs() < 1e-12);
    }
    let asked: Vec<f64> = (0..18).map(|at| rows.term(at)[1]).collect();
    rows.update_duals();
    assert_eq!(rows.duals, asked);
}

/// Duals are densities: on another grid they are those of the times between.
#[test]
fn duals_go_to_another_grid() {
    let model = aghf::urdf::builtin_robot("pendulum_2").expect("it is built in");
    let limits = limits();
    let [coarse, fine] = [4, 7].map(|n| StateGrid::collocated(1, n, n + 1, n - 1, 1.0));
    let new = |grid| RowTerms::new(&model, &limits, grid).expect("the same robot");
    let (mut from, mut to) = (new(&coarse), new(&fine));
    from.penalties = vec![3.0, 5.0, 7.0];
    from.margins = vec![0.0, 0.1, 0.2];
    for (g, time) in coarse.times().iter().enumerate() {
        for row in 0..3 {
            from.duals[3 * g + row] = row as f64 + time;
        }
    }
    to.take_over(&from.over_time(coarse.times()), fine.times());
    assert_eq!(
        (&to.penalties, &to.margins),
        (&from.penalties, &from.margins)
    );
    for (g, time) in fine.times().iter().enumerate() {
        for row in 0..3 {
            let held = fine.is_collocated(g) == (row == 0);
            let known = from.over_time(coarse.times())[row].duals.clone();
            let (first, last) = (known[0].0, known[known.len() - 1].0);
            let expected = if held {
                row as f64 + time.clamp(first, last)
            } else {
                0.0
            };
            assert!(
                (to.duals[3 * g + row] - expected).abs() < 1e-12,
                "{g} {row}"
            );
        }
    }
}
