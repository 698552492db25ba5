//! Solving scenarios.

use crate::batch::{Array, Numbers};
use crate::custom_terms::{PyConstraint, PyRunningCost, Raised};
use crate::error::raised;
use crate::model::PyModel;
use crate::motion::evaluate;
use crate::signals::{LOOK, until_signalled};
use aghf::motion::Interrupt;
use aghf_cli::export::{joint_trajectory, save_mcap};
use aghf_cli::output::{OutputFolder, REPORT_FILES, Sampling, refuse_existing, write_report};
use aghf_cli::report::{Motion, page, tradeoff_page};
use aghf_scenario::{
    LoadOptions, Record, Scenario, Solve, SolveOptions, SolveReport, Solved, Trace, Tradeoff, Verdict,
};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Deserialize;
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};

/// The result of a solve.
#[pyclass(name = "Solution", module = "aghf", frozen)]
pub struct PySolution {
    scenario: Scenario,
    report: SolveReport,
}

/// Solves a scenario by its name and its JSON text; a built-in scenario or a file has no text. The search ends with the
/// best motion so far once `should_stop` returns true.
#[pyfunction]
fn solve<'py>(
    py: Python<'py>,
    named: (String, Option<String>),
    options: &str,
    running_cost: Option<Py<PyAny>>,
    constraints: Vec<Bound<'py, PyAny>>,
    callbacks: [Option<Bound<'py, PyAny>>; 2],
    start: Option<PyRef<'py, PySolution>>,
) -> PyResult<PySolution> {
    let ((name, text), [on_iteration, should_stop]) = (named, callbacks);
    let (mut scenario, options) = read(&name, text.as_deref(), options)?;
    let start = start.map(|start| start.solved());
    let raised_first = Raised::default();
    if let Some(object) = running_cost {
        let raised = raised_first.clone();
        scenario.set_running_cost(Arc::new(PyRunningCost { object, raised }));
    }
    for constraint in &constraints {
        scenario.add_constraint(PyConstraint::new(constraint, raised_first.clone())?);
    }
    let interrupt = Interrupt::default();
    let (sender, records) = channel();
    let records = Mutex::new(records);
    let (of, stop, start) = (&scenario, interrupt.clone(), start.as_ref());
    let report = std::thread::scope(|scope| {
        let search = scope.spawn(move || {
            let mut solve = Solve::new(of).options(options).interrupt(stop);
            if let Some(start) = start {
                solve = solve.start(start);
            }
            // The receiver is gone once the search has to stop.
            let solve = solve.observe(move |record| {
                let _ = sender.send(*record);
            });
            solve.run()
        });
        let mut failed = None;
        loop {
            let hear = || {
                let records = records.lock().unwrap_or_else(PoisonError::into_inner);
                records.recv_timeout(LOOK)
            };
            let heard = match py.detach(hear) {
                Ok(record) if failed.is_none() => match &on_iteration {
                    Some(callback) => call_back(py, callback, &record),
                    None => Ok(()),
                },
                Ok(_) | Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let Some(should_stop) = &should_stop
                && should_stop.call0()?.is_truthy()?
            {
                interrupt.raise();
            }
            if let Err(error) = heard.and_then(|()| py.check_signals()) {
                interrupt.raise();
                // Ctrl-C ends the search with the best motion so far.
                if !error.is_instance_of::<PyKeyboardInterrupt>(py) {
                    failed = Some(error);
                }
            }
        }
        let report = py.detach(|| search.join());
        match failed {
            Some(error) => Err(error),
            None => Ok(report),
        }
    })?;
    let report = report.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    let report = report.map_err(|error| raised_first.take().unwrap_or_else(|| raised(error)))?;
    Ok(PySolution { scenario, report })
}

/// The scenario and the options of a solve.
fn read(name: &str, text: Option<&str>, options: &str) -> PyResult<(Scenario, SolveOptions)> {
    let scenario = read_scenario(name, text)?;
    Ok((scenario, read_options(options)?))
}

/// The options in a text in JSON.
fn read_options(text: &str) -> PyResult<SolveOptions> {
    let keys: serde_json::Value = json("options", text)?;
    // The errors name the options already.
    SolveOptions::deserialize(keys).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// An argument that comes as a text in JSON.
pub fn json<T: serde::de::DeserializeOwned>(what: &str, text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| PyValueError::new_err(format!("{what}: {error}")))
}

/// The scenario with this name or this text in JSON.
pub fn read_scenario(name: &str, text: Option<&str>) -> PyResult<Scenario> {
    let scenario = match text {
        Some(text) => Scenario::parse(text, name, Path::new("")),
        None => Scenario::load(name),
    };
    scenario.map_err(raised)
}

/// Calls a function with a record as keyword arguments.
fn call_back(py: Python<'_>, callback: &Bound<'_, PyAny>, record: &Record) -> PyResult<()> {
    let values = PyDict::new(py);
    match record {
        Record::Flow(flow) => {
            values.set_item("s", flow.s)?;
            values.set_item("action", flow.action_at_nodes)?;
        }
        Record::Rest(rest) => {
            values.set_item("s", rest.s)?;
            values.set_item("degree", rest.degree)?;
            values.set_item("action", rest.action)?;
            values.set_item("gradient_norm", rest.gradient_norm)?;
        }
        Record::Direct(iteration) => {
            values.set_item("start", iteration.start)?;
            values.set_item("horizon", iteration.horizon)?;
            values.set_item("degree", iteration.degree)?;
            values.set_item("cost", iteration.cost)?;
            values.set_item("gradient_norm", iteration.gradient_norm)?;
        }
    }
    callback.call1((values,)).map(drop)
}

/// Finds motions from the least duration to the least effort, in this order.
#[pyfunction]
fn tradeoff(py: Python<'_>, name: &str, text: Option<&str>, options: &str, points: usize) -> PyResult<Vec<PySolution>> {
    let (scenario, options) = read(name, text, options)?;
    let SolveOptions::Direct(options) = options else {
        let condition = "method: only 'direct' has a trade-off";
        return Err(PyValueError::new_err(condition));
    };
    let interrupt = Interrupt::default();
    let (of, stop) = (&scenario, interrupt.clone());
    let search = move || {
        let search = Tradeoff::new(of).points(points).options(options);
        search.interrupt(stop).run()
    };
    let found = until_signalled(py, search, || interrupt.raise())?;
    let found = found.map_err(raised)?.into_iter();
    Ok(found.map(|(scenario, report)| PySolution { scenario, report }).collect())
}

/// The self-contained HTML page of a trade-off.
#[pyfunction]
fn tradeoff_html(solutions: Vec<PyRef<'_, PySolution>>) -> PyResult<String> {
    let found = solutions.iter();
    let found = found.map(|own| (own.scenario.clone(), own.report.clone()));
    tradeoff_page(&found.collect::<Vec<_>>()).map_err(raised)
}

impl PySolution {
    /// The solve from which another one can start.
    fn solved(&self) -> Solved {
        Solved {
            scenario: self.scenario.clone(),
            curve: self.report.curve.clone(),
            summary: self.report.summary.clone(),
        }
    }
}

#[pymethods]
impl PySolution {
    /// The solve with this summary in JSON, without the progress of its search.
    #[staticmethod]
    fn from_summary(text: &str) -> PyResult<Self> {
        let solved = Solved::parse(text, "summary", &LoadOptions::default()).map_err(raised)?;
        let report = SolveReport {
            completed: matches!(solved.summary.verdict, Verdict::Optimal | Verdict::AtSMax),
            summary: solved.summary,
            curve: solved.curve,
            history: Vec::new(),
            stopped: None,
            trace: Trace::default(),
        };
        let scenario = solved.scenario;
        Ok(Self { scenario, report })
    }

    #[getter]
    fn verdict(&self) -> String {
        self.report.summary.verdict.to_string()
    }

    #[getter]
    fn success(&self) -> bool {
        self.report.summary.success
    }

    #[getter]
    fn horizon(&self) -> f64 {
        self.report.curve.horizon()
    }

    #[getter]
    fn model(&self) -> PyModel {
        PyModel::new(self.scenario.model.clone(), &self.scenario.load_notes)
    }

    /// The summary in JSON.
    fn summary_json(&self) -> PyResult<String> {
        let text = serde_json::to_string(&self.report.summary);
        text.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The scenario in JSON.
    fn scenario_json(&self) -> PyResult<String> {
        let text = serde_json::to_string(&self.scenario.file);
        text.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Positions, velocities, accelerations and torques at times, each with the shape `(times, N)`.
    fn evaluate<'py>(&self, py: Python<'py>, t: Numbers<'py>) -> PyResult<[Array<'py>; 4]> {
        evaluate(py, (&self.scenario.model, &self.report.curve), &t)
    }

    /// The self-contained HTML page of the motion.
    fn report_html(&self) -> PyResult<String> {
        page(&[Motion::of_report(&self.scenario, &self.report)]).map_err(raised)
    }

    /// The motion as a `trajectory_msgs/JointTrajectory` in JSON.
    fn joint_trajectory_json(&self, rate: Option<f64>) -> PyResult<String> {
        let (scenario, curve) = (&self.scenario, &self.report.curve);
        let message = joint_trajectory(scenario, curve, rate.map(Sampling::Rate), None);
        let text = serde_json::to_string(&message.map_err(raised)?);
        text.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Writes the motion to an MCAP file.
    fn save_mcap(&self, path: &str, rate: Option<f64>, replace: bool) -> PyResult<()> {
        let path = Path::new(path);
        refuse_existing(path, replace).map_err(raised)?;
        let (scenario, curve) = (&self.scenario, &self.report.curve);
        save_mcap(scenario, curve, rate.map(Sampling::Rate), None, path).map_err(raised)
    }

    /// Writes the files of the solve into a folder; returns their paths.
    fn save(&self, folder: &str, replace: bool) -> PyResult<Vec<String>> {
        let folder = OutputFolder::open(Path::new(folder), &REPORT_FILES, replace);
        let (folder, page) = (folder.map_err(raised)?, self.report_html()?);
        let files = write_report(&self.scenario, &self.report, Some(&page), &folder, None);
        let files = files.map_err(raised)?;
        Ok(files.iter().map(|file| file.display().to_string()).collect())
    }
}

/// Adds the functions to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(solve, module)?)?;
    module.add_function(wrap_pyfunction!(tradeoff, module)?)?;
    module.add_function(wrap_pyfunction!(tradeoff_html, module)?)
}
