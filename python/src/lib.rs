//! The Python module `aghf._aghf`: the functions of `aghf` on numpy arrays. The package `aghf` adds names and
//! documentation.

mod batch;
mod custom_terms;
mod dynamics;
mod error;
mod experiments;
mod flow;
mod inverse_kinematics;
mod model;
mod motion;
mod nlp;
mod signals;
mod solve;
mod tracker;

use pyo3::prelude::*;

#[pymodule]
fn _aghf(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    error::add_to(module)?;
    module.add_class::<model::PyModel>()?;
    module.add_class::<solve::PySolution>()?;
    module.add_class::<tracker::PyTracker>()?;
    module.add_function(wrap_pyfunction!(model::builtin_robots, module)?)?;
    dynamics::add_to(module)?;
    module.add_function(wrap_pyfunction!(inverse_kinematics::inverse_kinematics, module)?)?;
    module.add_function(wrap_pyfunction!(motion::clearance, module)?)?;
    module.add_function(wrap_pyfunction!(motion::judge, module)?)?;
    flow::add_to(module)?;
    module.add_function(wrap_pyfunction!(nlp::solve_nlp, module)?)?;
    solve::add_to(module)?;
    experiments::add_to(module)
}
