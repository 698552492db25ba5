//! Smooth programs written in Python.

use crate::custom_terms::{Raised, array};
use crate::error::raised;
use aghf::Result;
use aghf::nlp::{Options, SmoothDerivatives, SmoothProgram, solve_smooth};
use nalgebra::DVector;
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An object with `objective(x)`, `gradient(x)`, `constraints(x)`, `jacobian(x)` and `hessian(x, y)`, the Hessian of
/// the Lagrangian.
struct PyProgram<'py> {
    object: Bound<'py, PyAny>,
    bounds: Vec<[f64; 2]>,
    row_bounds: Vec<[f64; 2]>,
    raised: Raised,
}

impl<'py> PyProgram<'py> {
    fn fill(&self, found: &Bound<'py, PyAny>, name: &str, shape: &[usize], to: &mut [f64]) -> PyResult<()> {
        let found = array(found, name, shape)?;
        // In the order of columns, which is that of nalgebra.
        for (to, from) in to.iter_mut().zip(found.as_array().t().iter()) {
            *to = *from;
        }
        Ok(())
    }

    fn values(&self, x: &DVector<f64>, g: &mut DVector<f64>) -> PyResult<f64> {
        let at = PyArray1::from_slice(self.object.py(), x.as_slice());
        if !g.is_empty() {
            let rows = self.object.call_method1("constraints", (&at,))?;
            self.fill(&rows, "constraints", &[g.len()], g.as_mut_slice())?;
        }
        self.object.call_method1("objective", (&at,))?.extract()
    }

    fn all_derivatives(&self, x: &DVector<f64>, y: &DVector<f64>, out: &mut SmoothDerivatives) -> PyResult<()> {
        let (n, m) = (x.len(), y.len());
        let [at, y] = [x, y].map(|vector| PyArray1::from_slice(self.object.py(), vector.as_slice()));
        let gradient = self.object.call_method1("gradient", (&at,))?;
        self.fill(&gradient, "gradient", &[n], out.gradient.as_mut_slice())?;
        if m > 0 {
            let jacobian = self.object.call_method1("jacobian", (&at,))?;
            self.fill(&jacobian, "jacobian", &[m, n], out.jacobian.as_mut_slice())?;
        }
        let hessian = self.object.call_method1("hessian", (&at, &y))?;
        self.fill(&hessian, "hessian", &[n, n], out.hessian.as_mut_slice())
    }
}

impl SmoothProgram for PyProgram<'_> {
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.bounds.clone()
    }

    fn row_bounds(&self) -> Vec<[f64; 2]> {
        self.row_bounds.clone()
    }

    fn value(&mut self, x: &DVector<f64>, g: &mut DVector<f64>) -> Result<f64> {
        let found = self.values(x, g);
        self.raised.keep(found, "the objective or the constraints")
    }

    fn derivatives(&mut self, x: &DVector<f64>, y: &DVector<f64>, out: &mut SmoothDerivatives) -> Result<()> {
        let found = self.all_derivatives(x, y, out);
        self.raised.keep(found, "the derivatives")
    }
}

fn pairs(bounds: &PyReadonlyArray2<'_, f64>) -> Vec<[f64; 2]> {
    bounds.as_array().rows().into_iter().map(|row| [row[0], row[1]]).collect()
}

/// Solves a smooth program, see `aghf.solve_nlp`.
#[pyfunction]
#[pyo3(signature = (problem, x, bounds, row_bounds, iterations, tolerance))]
pub fn solve_nlp<'py>(
    problem: Bound<'py, PyAny>,
    x: PyReadonlyArray1<'py, f64>,
    bounds: PyReadonlyArray2<'py, f64>,
    row_bounds: PyReadonlyArray2<'py, f64>,
    iterations: usize,
    tolerance: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let py = problem.py();
    let (bounds, row_bounds) = (pairs(&bounds), pairs(&row_bounds));
    let mut program = PyProgram { object: problem, bounds, row_bounds, raised: Raised::default() };
    let options = Options { iterations, tolerance, ..Options::default() };
    let x = DVector::from_iterator(x.as_array().len(), x.as_array().iter().copied());
    let found = solve_smooth(&mut program, &x, &options);
    if let Some(error) = program.raised.take() {
        return Err(error);
    }
    let found = found.map_err(raised)?;
    let out = PyDict::new(py);
    for (key, vector) in
        [("x", &found.x), ("multipliers", &found.multipliers), ("bound_multipliers", &found.bound_multipliers)]
    {
        out.set_item(key, PyArray1::from_slice(py, vector.as_slice()))?;
    }
    out.set_item("objective", found.objective)?;
    out.set_item("status", format!("{:?}", found.status))?;
    out.set_item("iterations", found.iterations)?;
    for (key, value) in [
        ("stationarity", found.error.stationarity),
        ("feasibility", found.error.feasibility),
        ("complementarity", found.error.complementarity),
    ] {
        out.set_item(key, value)?;
    }
    Ok(out)
}
