//! The derivatives of the dynamics by the checker: first and second ones, weighted ones and tensors, against dual
//! numbers.

use crate::common::{assert_right, config, model_and_node, robots, state, wave};
use aghf::verify::duals::{State, check_dynamics_at};
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn they_match_duals((model, parts) in model_and_node()) {
        assert_right(&model, check_dynamics_at(&model, &[state(parts)], &[]));
    }
}

/// Every robot at rest in its zero position, straight, and moving.
#[test]
fn all_robots_at_the_states_that_hide_terms() {
    for model in robots() {
        let n = model.dof();
        let (zero, wave) = (vec![0.0; n], |f: f64| wave(n, f));
        let states: Vec<State> = [
            [zero.clone(), zero.clone(), zero.clone()],
            [zero.clone(), wave(0.9), zero.clone()],
            [wave(0.4), zero.clone(), zero.clone()],
            [wave(0.4), zero.clone(), wave(1.1)],
            [wave(0.7), wave(1.3), wave(2.1)],
        ]
        .into_iter()
        .map(|[q, v, a]| state([[q, v.clone()].concat(), [v, a].concat(), vec![0.0; 2 * n]]))
        .collect();
        assert_right(&model, check_dynamics_at(&model, &states, &[]));
    }
}
