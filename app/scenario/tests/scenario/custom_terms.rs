//! Constraints and running costs that no key names.

use aghf::Result;
use aghf::constraint::{Constraint, PlacedState, WeightedDerivatives, Weights};
use aghf::cost::WeightedSquares;
use aghf::scalar::AlgebraOver;
use aghf::verify::duals::{CheckOptions, check_constraint};
use aghf_scenario::{DirectOptions, FlowOptions, RestOptions, Scenario, Solve, SolveOptions, SolveReport};
use nalgebra::{DMatrix, DVector};
use std::path::Path;
use std::sync::Arc;

const SWING: &str = r#"{"robot": "pendulum_2", "horizon_s": 2.0, "q_start": [0, 0], "v_start": [0, 0],
    "q_goal": [1.0, 1.5], "v_goal": [0, 0]}"#;

fn swing() -> Scenario {
    Scenario::parse(SWING, "swing.json", Path::new("")).expect("it is good")
}

fn solved(scenario: &Scenario) -> SolveReport {
    let options = DirectOptions { starts: Some(1), ..DirectOptions::default() };
    Solve::new(scenario).options(options.clone()).run().expect("it is good")
}

/// $q_1 (q_2 + v_1) \le$ a bound, with derivatives by hand that are there whole.
#[derive(Clone, Debug)]
struct Product {
    bound: f64,
}

impl Constraint for Product {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> Result<()> {
        g[0] = at.x[0] * (at.x[1] + at.x[2]) - S::lift(self.bound);
        Ok(())
    }

    fn add_weighted_derivatives<S: AlgebraOver<f64>>(
        &self,
        at: &PlacedState<'_, f64, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let (q1, other, zero) = (at.x[0], at.x[1] + at.x[2], S::zero());
        let by_x = DVector::from_vec(vec![other, q1, q1, zero]);
        let (w, c) = (weights.first_order[0], weights.gauss_newton.map_or(zero, |c| c[0]));
        let mut hessian = DMatrix::from_fn(4, 4, |i, j| c * by_x[i] * by_x[j]);
        for (i, j) in [(0, 1), (1, 0), (0, 2), (2, 0)] {
            hessian[(i, j)] += w;
        }
        out.add_dense(&(by_x * w), &hessian)
    }
}

#[test]
fn derivatives_that_are_there_whole_agree_with_dual_numbers() {
    let scenario = swing();
    let options = CheckOptions::default();
    let product = Product { bound: 0.3 };
    let findings = check_constraint(&scenario.model, "product", &product, &options).expect("same robot");
    assert_eq!(findings.len(), 2);
    for finding in findings {
        assert!(finding.passes(), "{}: {:e}", finding.quantity, finding.error);
    }
}

#[test]
fn a_constraint_of_ones_own_is_kept_and_judged() {
    let mut scenario = swing();
    let largest = |report: &SolveReport| {
        let at = |i| {
            let (x, _) = report.curve.at(0.001 * f64::from(i));
            x[0] * (x[1] + x[2])
        };
        (0..=2000).map(at).fold(f64::MIN, f64::max)
    };
    let free = largest(&solved(&scenario));
    assert!(free > 1.6, "the goal alone has 1.5, this {free}");
    assert!(scenario.is_free());
    scenario.add_constraint(Product { bound: 1.55 });
    assert!(!scenario.is_free());
    let kept = solved(&scenario);
    assert!(kept.summary.success, "{:?}", kept.summary.failure);
    assert!(largest(&kept) < 1.55 + 1e-5);
    // At the goal it is 1.5.
    scenario.add_constraint(Product { bound: 1.4 });
    let refused = Solve::new(&scenario).run().expect_err("no motion can");
    let message = "swing: q_goal: it violates row 0 of the constraint by 1.000e-1";
    assert_eq!(refused.to_string(), message);
}

#[test]
fn a_running_cost_of_ones_own_takes_the_place_of_the_scenarios() {
    let weights = |n| WeightedSquares::new(n, vec![1.0; n], vec![3.0; n], vec![0.0; n]);
    let mut by_key = swing();
    by_key.file.objective = serde_json::from_str(r#"{"units": "si", "velocity": 3.0}"#).expect("it is good");
    let mut own = swing();
    own.set_running_cost(Arc::new(weights(2).expect("in range")));
    let [expected, found] = [&by_key, &own].map(|scenario| {
        let cost = serde_json::to_value(solved(scenario).summary).expect("it is JSON")["cost"].clone();
        cost.as_f64().expect("it has a cost of its own")
    });
    assert!((found - expected).abs() < 1e-9 * expected, "{found} and {expected}");
    let [expected, found] = [&by_key, &own].map(|scenario| {
        let duals = SolveOptions::Duals(RestOptions::default());
        let report = Solve::new(scenario).options(duals).run().expect("valid");
        assert!(report.summary.success, "{:?}", report.summary.failure);
        report.summary.control_effort
    });
    assert!((found - expected).abs() < 1e-6 * expected, "{found} and {expected}");
    let by_flow = FlowOptions::default();
    let refused = Solve::new(&own).options(by_flow.clone()).run().expect_err("all but the published flow can");
    assert!(refused.to_string().contains("running cost of one's own"), "{refused}");
}
