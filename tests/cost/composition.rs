//! Sums of running costs: their derivatives, and their minima.

use crate::common::direct::{degree, solved};
use crate::common::{assert_right, robot};
use aghf::cost::{
    AutodiffCost, ControlEffort, CostThroughDynamics, HyperDual64, RunningCost, StageDerivatives, StageInput, Weighted,
    WeightedSquares,
};
use aghf::direct::{Direct, DirectSettings, DirectSolution};
use aghf::model::{Model, random_tree};
use aghf::motion::Problem;
use aghf::verify::duals::{CheckOptions, check_running_cost};
use std::sync::Arc;

/// Squared power, by a closure.
fn power(at: &StageInput<'_, HyperDual64>) -> HyperDual64 {
    let both = at.u.iter().zip(at.v);
    both.map(|(u, v)| (*u * *v) * (*u * *v)).sum()
}

/// A term that depends on time.
fn late(at: &StageInput<'_, HyperDual64>) -> HyperDual64 {
    at.q.iter().map(|q| *q * *q * at.t).sum()
}

/// The same as [`late`] by hand: it writes its entries, as a term may that finds zeros.
#[derive(Clone)]
struct Late;

impl RunningCost for Late {
    fn value(&self, at: &StageInput<'_, f64>) -> aghf::Result<f64> {
        Ok(at.q.iter().map(|q| q * q * at.t).sum())
    }

    fn derivatives(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> aghf::Result<f64> {
        for (i, q) in at.q.iter().enumerate() {
            out.gradient[i] = 2.0 * q * at.t;
            out.hessian[(i, i)] = 2.0 * at.t;
        }
        self.value(at)
    }

    fn time_rate(&self, at: &StageInput<'_, f64>) -> aghf::Result<f64> {
        Ok(at.q.iter().map(|q| q * q).sum())
    }
}

/// Squares of `u`, `v` and `a` with these weights.
fn squares(at: &StageInput<'_, HyperDual64>, weights: [f64; 3]) -> HyperDual64 {
    let all = [at.u, at.v, at.a].into_iter().zip(weights);
    all.flat_map(|(x, w)| x.iter().map(move |x| *x * *x * w)).sum()
}

fn uniform(n: usize, [u, v, a]: [f64; 3]) -> WeightedSquares {
    WeightedSquares::new(n, vec![u; n], vec![v; n], vec![a; n]).expect("good")
}

fn check(model: &Model, sum: &impl RunningCost, truth: impl Fn(&StageInput<'_, HyperDual64>) -> HyperDual64) {
    let options = CheckOptions { samples: 3, ..CheckOptions::default() };
    assert_right(model, check_running_cost(model, "sum", sum, truth, &options));
}

#[test]
fn sums_have_the_derivatives_of_duals() {
    let model = random_tree(3, 7).expect("a tree");
    let (effort, slow) = (WeightedSquares::effort(3), uniform(3, [0.2, 0.3, 0.4]));
    let by_duals = AutodiffCost::new(power);
    let weighted = Weighted::new(-0.5, &by_duals);
    check(&model, &(&effort, weighted), |at| squares(at, [1.0, 0.0, 0.0]) - power(at) * 0.5);
    check(&model, &(&effort, weighted, Late), |at| squares(at, [1.0, 0.0, 0.0]) - power(at) * 0.5 + late(at));
    check(&model, &(Late, &effort, weighted, &slow), |at| squares(at, [1.2, 0.3, 0.4]) - power(at) * 0.5 + late(at));
    check(&model, &(Late, Late, &effort, weighted, &slow), |at| {
        squares(at, [1.2, 0.3, 0.4]) - power(at) * 0.5 + late(at) * 2.0
    });
    let six = (Weighted::new(3.0, Late), &slow, &effort, Late, weighted, &slow);
    check(&model, &six, |at| squares(at, [1.4, 0.6, 0.8]) - power(at) * 0.5 + late(at) * 4.0);
    check(&model, &vec![slow.clone(), effort.clone(), slow.clone()], |at| squares(at, [1.4, 0.6, 0.8]));
    check(&model, &[slow.clone(), effort], |at| squares(at, [1.2, 0.3, 0.4]));
    let different: Vec<Arc<dyn RunningCost>> = vec![Arc::new(Late), Arc::new(slow), Arc::new(by_duals)];
    check(&model, &different, |at| late(at) + squares(at, [0.2, 0.3, 0.4]) + power(at));
    let nested = Weighted::new(2.0, (different, Weighted::new(2.0, Late)));
    check(&model, &nested, |at| late(at) * 6.0 + squares(at, [0.4, 0.6, 0.8]) + power(at) * 2.0);
    let none: Vec<WeightedSquares> = Vec::new();
    check(&model, &none, |_| HyperDual64::from(0.0));
}

/// The requirement of a free horizon: the rate in time is the sum of the rates of the terms, with their weights.
#[test]
fn rates_in_time_are_summed() {
    let (q, zeros) = ([0.5, -2.0], [0.0; 2]);
    let at = StageInput { t: 0.7, q: &q, v: &zeros, a: &zeros, u: &zeros };
    let late = AutodiffCost::new(late);
    let rate = |cost: &dyn RunningCost| cost.time_rate(&at).expect("same robot");
    let alone = 4.25;
    assert_eq!(rate(&Late), alone);
    assert_eq!(rate(&(Late, &late)), 2.0 * alone);
    assert_eq!(rate(&vec![Weighted::new(0.5, Late); 3]), 1.5 * alone);
    assert_eq!(rate(&Arc::new([Late])), alone);
}

/// The cost of a sum is that of one cost with the sums of the weights, and so is what comes of it.
#[test]
fn a_sum_has_the_minimum_of_its_total() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.5, 0.5, 0.0, 0.0], 2.0).expect("valid");
    let settings = degree(9);
    let weighted = uniform(2, [1.0, 0.5, 0.1]);
    let fast = ControlEffort::weighted(&model, &weighted).expect("same robot");
    let truth = of_cost(&problem, &settings, fast);
    let of = |sum: &(dyn RunningCost + Sync)| of_cost(&problem, &settings, CostThroughDynamics::of(&model, sum));
    let terms = || (WeightedSquares::effort(2), uniform(2, [0.0, 0.5, 0.0]));
    let last = Weighted::new(0.1, uniform(2, [0.0, 0.0, 1.0]));
    let (effort, velocity) = terms();
    let tuple = of(&(effort, velocity, last.clone()));
    let (effort, velocity) = terms();
    let list: Vec<Arc<dyn RunningCost + Send + Sync>> = vec![Arc::new(effort), Arc::new(velocity), Arc::new(last)];
    let list = of(&list);
    assert!(truth.converged && tuple.converged);
    assert!((tuple.cost - truth.cost).abs() < 1e-9 * truth.cost);
    assert_close!(tuple.curve.x(), truth.curve.x(), 1e-6);
    assert_eq!(list.curve.x(), tuple.curve.x());
    let effort = solved(&problem, &settings);
    assert!(tuple.cost > effort.cost);
}

fn of_cost(problem: &Problem<'_>, settings: &DirectSettings, cost: impl aghf::cost::CostWithControl) -> DirectSolution {
    let direct = Direct::new(problem).cost(cost);
    let solution = direct.settings(settings.clone()).solve();
    solution.unwrap_or_else(|e| panic!("{e}"))
}
