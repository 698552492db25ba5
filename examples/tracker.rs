//! A motion that is followed and replanned at 500 Hz, while its goal moves away at about 0.1 m/s: the robot of the
//! model is simulated, and each step takes one iteration. Prints when the goal stops and when the motion ends.

use aghf::constraint::{Bounds, Constraints, TorqueLimits};
use aghf::cost::ControlEffort;
use aghf::direct::{DirectSettings, Outcome, Tracker, TrackerOptions};
use aghf::dynamics::{Data, aba};
use aghf::motion::Problem;
use aghf::urdf::builtin_robot;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = &builtin_robot("kinova_gen3")?;
    let (start, mut goal) = ([0.0, 0.6, 0.0, 1.6, 0.0, 0.8, 0.0], [1.0, 0.9, 0.0, 1.2, 0.0, 0.8, 0.0]);
    let state = |q: [f64; 7]| [q, [0.0; 7]].concat();
    let problem = Problem::new(model, state(start), state(goal), 1.5)?;
    let limits = (Bounds::positions(model), Bounds::velocities(model));
    let kept = Constraints { state: limits, torque: TorqueLimits::of(model), stage: Default::default() };
    let settings = DirectSettings { degree: 12, ..DirectSettings::constrained() };
    let options = TrackerOptions { settings, ..TrackerOptions::default() };
    let mut tracker = Tracker::new(&problem, kept, ControlEffort::new(model), options)?;

    let (mut x, mut data, period) = (state(start), Data::new(model), 0.002);
    for k in 0..2000 {
        let now = period * f64::from(k);
        if k % 50 == 0 && now < 1.0 {
            goal[0] += 0.02;
            tracker.set_goal(&goal, (1.5 - now).max(0.8))?;
        }
        let step = tracker.step(&x, now)?;
        if k % 100 == 0 || step.outcome == Outcome::Finished {
            println!("{now:.2} s {:?} {:?} {:.1e} rad from the plan", step.outcome, step.safety, step.deviation);
        }
        if step.outcome == Outcome::Finished {
            break;
        }
        let mut a = [0.0; 7];
        aba(model, &mut data, &x[..7], &x[7..], &step.command.u, &mut a)?;
        for i in 0..7 {
            x[i] += period * (x[7 + i] + 0.5 * period * a[i]);
            x[7 + i] += period * a[i];
        }
    }
    let error = x.iter().zip(&goal).map(|(x, goal)| (x - goal).abs()).fold(0.0, f64::max);
    println!("{error:.1e} rad from the goal");
    Ok(())
}
