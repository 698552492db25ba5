//! A motion that is followed and replanned.

use crate::batch::{Array, Numbers, numbers};
use crate::error::raised;
use crate::motion::evaluate;
use crate::signals::until_signalled;
use crate::solve::{json, read_scenario};
use aghf::Error;
use aghf::direct::{Command, Outcome, Safety};
use aghf::motion::Interrupt;
use aghf_scenario::{Obstacle, ScenarioTracker, ScenarioTrackerOptions};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// A tracker with its scenario.
#[pyclass(name = "Tracker", module = "aghf")]
pub struct PyTracker(ScenarioTracker);

/// True at the end; $q, v, a, \tau, u$ and the gain; the violated row with its amount, unit and time; true if the robot
/// has left its plan; the deviation; iterations; whether the plan is a new one, was cut off, has converged.
type Found<'py> = (bool, [Array<'py>; 6], Option<(String, f64, &'static str, f64)>, bool, f64, usize, [bool; 3]);

/// The arrays of a command.
fn arrays<'py>(py: Python<'py>, command: &Command) -> PyResult<[Array<'py>; 6]> {
    let Command { q, v, a, tau, gain, u } = command;
    let n = q.len();
    let array = |x: &[f64], shape| PyArray1::from_slice(py, x).reshape(shape);
    // The gain is stored column by column.
    let gain = gain.transpose();
    Ok([
        array(q, vec![n])?,
        array(v, vec![n])?,
        array(a, vec![n])?,
        array(tau, vec![n])?,
        array(u, vec![n])?,
        array(gain.as_slice(), vec![n, 2 * n])?,
    ])
}

#[pymethods]
impl PyTracker {
    /// Searches the first plan; the scenario is named, or has a text in JSON.
    #[new]
    fn new(py: Python<'_>, named: (String, Option<String>), options: &str) -> PyResult<Self> {
        let scenario = read_scenario(&named.0, named.1.as_deref())?;
        let options: ScenarioTrackerOptions = json("options", options)?;
        let interrupt = Interrupt::default();
        let stop = interrupt.clone();
        let search = || ScenarioTracker::new(scenario, &options, interrupt);
        let found = until_signalled(py, search, || stop.raise())?;
        found.map(Self).map_err(raised)
    }

    /// Takes a step.
    fn step<'py>(&mut self, py: Python<'py>, q: Numbers<'py>, v: Numbers<'py>, now: f64) -> PyResult<Found<'py>> {
        let state = [self.numbers("q", &q)?, self.numbers("v", &v)?].concat();
        let step = py.detach(|| self.0.step(&state, now)).map_err(raised)?;
        let command = arrays(py, step.command)?;
        let finished = step.outcome == Outcome::Finished;
        let (safety, deviation, iterations) = (step.safety, step.deviation, step.iterations);
        let flags = [step.replaced, step.cut_off, step.converged];
        let violation = match safety {
            Safety::Violated { row, by, after } => {
                let label = self.0.label(row);
                Some((label.name, self.0.excess(row, by), label.unit, after))
            }
            Safety::Kept | Safety::Left => None,
        };
        let left = safety == Safety::Left;
        Ok((finished, command, violation, left, deviation, iterations, flags))
    }

    /// Changes the goal.
    fn set_goal(&mut self, q: Numbers<'_>, horizon: f64) -> PyResult<()> {
        let q = self.numbers("q", &q)?.to_vec();
        self.0.set_goal(&q, horizon).map_err(raised)
    }

    /// The number of seconds that are left of the plan.
    fn left(&self) -> PyResult<f64> {
        Ok(self.0.rest().map_err(raised)?.horizon())
    }

    /// The rest of the plan at times from now, as `Solution.evaluate` has it.
    fn evaluate<'py>(&self, py: Python<'py>, t: Numbers<'py>) -> PyResult<[Array<'py>; 4]> {
        let rest = self.0.rest().map_err(raised)?;
        evaluate(py, (&self.0.scenario().model, &rest), &t)
    }

    /// Changes the deadline, s.
    fn set_deadline(&mut self, seconds: Option<f64>) -> PyResult<()> {
        self.0.set_deadline(seconds).map_err(raised)
    }

    /// Replaces the obstacles, a list in JSON.
    fn set_obstacles(&mut self, obstacles: &str) -> PyResult<()> {
        let obstacles: Vec<Obstacle> = json("obstacles", obstacles)?;
        self.0.set_obstacles(&obstacles).map_err(raised)
    }
}

impl PyTracker {
    /// The numbers of an argument, one per joint.
    fn numbers<'n>(&self, name: &'static str, given: &'n Numbers<'_>) -> PyResult<&'n [f64]> {
        let numbers = numbers(name, given)?;
        let (expected, found) = (self.0.scenario().model.dof(), numbers.len());
        if found == expected { Ok(numbers) } else { Err(raised(Error::Length { what: name, expected, found })) }
    }
}
