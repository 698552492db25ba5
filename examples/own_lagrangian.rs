//! A Lagrangian of one's own, run by the flow: a potential that draws the joints to a rest position joins the paper's Lagrangian.
//! Prints how near to rest the motion stays, and at what effort, for several weights of the potential.

use aghf::flow::{ActuationMetric, AghfLagrangian, Flow, FlowSettings, Lagrangian, effort_of};
use aghf::model::Model;
use aghf::motion::{Problem, sample};
use aghf::scalar::{AlgebraOver, Tanh};
use aghf::urdf::builtin_robot;
use std::error::Error;

/// The paper's Lagrangian and $w |q - q_0|^2$.
struct Drawn {
    weight: f64,
    rest: Vec<f64>,
}

impl Lagrangian for Drawn {
    fn value<S: AlgebraOver<f64> + Tanh>(&self, model: &Model, t: S, x: &[S], xdot: &[S], k: f64) -> aghf::Result<S> {
        let effort = AghfLagrangian.value(model, t, x, xdot, k)?;
        let away = x.iter().zip(&self.rest).map(|(q, rest)| *q - S::lift(*rest));
        Ok(away.fold(effort, |sum, away| sum + (away * away).scale(self.weight)))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let model = builtin_robot("pendulum_2")?;
    let problem = Problem::new(&model, vec![-1.0, 0.5, 0.0, 0.0], vec![1.0, 0.5, 0.0, 0.0], 2.0)?;
    let settings = FlowSettings::new(9, 1e4, 10.0);
    println!("weight  mean distance from rest, rad  effort, N^2 m^2 s");
    for weight in [0.0, 1e2, 1e3] {
        let rest = vec![0.0; model.dof()];
        let drawn = &Drawn { weight, rest };
        let flow = Flow::new(&problem, settings.clone()).lagrangian(drawn, ActuationMetric::default());
        let found = flow.run()?;
        assert_eq!(found.failure, None);
        let samples = sample(&model, &found.curve, 100)?;
        let distances = samples.iter().map(|s| s.q[0].hypot(s.q[1]));
        let mean = distances.sum::<f64>() / samples.len() as f64;
        let effort = effort_of(&model, &found.curve, settings.k)?.control_effort;
        println!("{weight:6}  {mean:28.3}  {effort:17.1}");
    }
    Ok(())
}
