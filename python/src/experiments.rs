//! Checks of derivatives, and sweeps.

use crate::error::raised;
use crate::model::PyModel;
use crate::signals::until_signalled;
use aghf::verify::{CheckOptions, check_all};
use aghf_cli::sweep::{Row, Sweep, run};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Compares every analytic derivative with dual numbers at random states; the findings in JSON.
#[pyfunction]
fn check(py: Python<'_>, model: &PyModel, samples: usize, seed: u64) -> PyResult<String> {
    let options = CheckOptions { samples, seed, ..CheckOptions::default() };
    let findings = py.detach(|| check_all(&model.model, &options));
    in_json(&findings.map_err(raised)?)
}

/// Solves all sets of a sweep side by side on all cores, or `threads`; the rows in JSON, in the order of the sets.
#[pyfunction]
fn sweep(py: Python<'_>, name: &str, threads: Option<usize>) -> PyResult<String> {
    let sweep = Sweep::load(name).map_err(raised)?;
    let rows: Mutex<Vec<Row>> = Mutex::default();
    let stopped = AtomicBool::new(false);
    let search = || {
        run(&sweep, &sweep.sets, threads, &|row| {
            let mut rows = rows.lock().unwrap_or_else(PoisonError::into_inner);
            rows.push(row);
            if stopped.load(Ordering::Relaxed) {
                Err(aghf::Error::input(&sweep.name, "sweep", "it was stopped"))
            } else {
                Ok(())
            }
        })
    };
    let ended = until_signalled(py, search, || stopped.store(true, Ordering::Relaxed))?;
    ended.map_err(raised)?;
    let mut rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    rows.sort_by_key(|row| row.set);
    in_json(&rows)
}

fn in_json(of: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(of).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Adds the functions to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(check, module)?)?;
    module.add_function(wrap_pyfunction!(sweep, module)?)
}
