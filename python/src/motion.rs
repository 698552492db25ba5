//! Motions at times, their judgement, and the clearance of configurations.

use crate::batch::{Array, Numbers, States, numbers};
use crate::error::raised;
use crate::solve::read_scenario;
use aghf::curve::Curve;
use aghf::dynamics::{Data, rnea};
use aghf::error::Result;
use aghf::model::Model;
use aghf_scenario::judge::{Tolerances, Trajectory, judge as judged};
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

/// Positions, velocities, accelerations and torques of a motion at times, each with the shape `(times, N)`.
pub fn evaluate<'py>(py: Python<'py>, (model, curve): (&Model, &Curve), t: &Numbers<'py>) -> PyResult<[Array<'py>; 4]> {
    let n = model.dof();
    let times = numbers("t", t)?;
    let horizon = curve.horizon();
    let outside = |t: &&f64| !(0.0..=horizon).contains(*t);
    if let Some(time) = times.iter().find(outside) {
        let message = format!("t: it has {time}, the motion is from 0 to {horizon} s");
        return Err(PyValueError::new_err(message));
    }
    let mut all = [const { Vec::new() }; 4].map(|mut all: Vec<f64>| {
        all.reserve(n * times.len());
        all
    });
    let data = &mut Data::new(model);
    let mut tau = vec![0.0; n];
    for time in times {
        let (x, xdot) = curve.at(*time);
        let (q, v) = x.as_slice().split_at(n);
        let a = &xdot.as_slice()[n..];
        rnea(model, data, q, v, a, &mut tau).map_err(raised)?;
        for (all, own) in all.iter_mut().zip([q, v, a, &tau]) {
            all.extend_from_slice(own);
        }
    }
    let shape = [t.shape(), &[n]].concat();
    let mut arrays = Vec::with_capacity(4);
    for values in all {
        arrays.push(PyArray1::from_vec(py, values).reshape(shape.clone())?);
    }
    arrays.try_into().map_err(|_| PyValueError::new_err("results were lost"))
}

/// Judges a motion of a scenario by its samples: the times, and at these the positions and, if they are given, the
/// velocities, accelerations and torques, each `(times, N)`. Returns the judgement in JSON.
#[pyfunction]
pub fn judge(
    py: Python<'_>,
    named: (String, Option<String>),
    times: Numbers<'_>,
    tables: [Option<Numbers<'_>>; 4],
    tolerances: [f64; 2],
) -> PyResult<String> {
    let scenario = read_scenario(&named.0, named.1.as_deref())?;
    let (n, times) = (scenario.model.dof(), numbers("t", &times)?.to_vec());
    let mut rows = [const { None }; 4];
    for ((rows, table), name) in rows.iter_mut().zip(&tables).zip(["q", "v", "a", "tau"]) {
        let Some(table) = table else { continue };
        if table.shape() != [times.len(), n] {
            let (shape, count) = (table.shape(), times.len());
            let message = format!("{name}: its shape is {shape:?}, ({count}, {n}) is needed");
            return Err(PyValueError::new_err(message));
        }
        let all = numbers(name, table)?.chunks_exact(n);
        *rows = Some(all.map(<[f64]>::to_vec).collect());
    }
    let [tolerance, overlap_m] = tolerances;
    let found = py.detach(|| {
        let trajectory = Trajectory::new(times, rows)?;
        judged(&scenario, &trajectory, Tolerances { tolerance, overlap_m })
    });
    let text = serde_json::to_string(&found.map_err(raised)?);
    text.map_err(|error| PyValueError::new_err(error.to_string()))
}

/// The distance of the closest pair of a link and an obstacle or another link, m, and its names, at each of the
/// configurations of a scenario, `(N,)` or `(batch, N)`; infinity and `None` if no pairs keep clear.
#[pyfunction]
pub fn clearance(
    py: Python<'_>,
    named: (String, Option<String>),
    q: Numbers<'_>,
) -> PyResult<Vec<(f64, Option<[String; 2]>)>> {
    let scenario = read_scenario(&named.0, named.1.as_deref())?;
    let n = scenario.model.dof();
    let states = States::read(["q"], [&q], [n])?;
    let all = numbers("q", &q)?;
    if let Some(at) = all.iter().position(|x| !x.is_finite()) {
        return Err(PyValueError::new_err(format!("q: entry {} of number {} is not finite", at % n, at / n)));
    }
    let closest = |state: usize| {
        let nearest = scenario.nearest(states.row(state).into_iter())?;
        Ok(nearest.map_or((f64::INFINITY, None), |(_, names, distance)| (distance, Some(names))))
    };
    py.detach(|| (0..states.count()).into_par_iter().map(closest).collect::<Result<_>>()).map_err(raised)
}
