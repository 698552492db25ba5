//! The right-hand side of the flow and its Jacobian.

use crate::batch::{Array, Numbers, by_rows, over_states};
use crate::error::raised;
use crate::model::PyModel;
use aghf::flow::jacobian::{JacobianKind, Jacobians, NodeBlocks};
use aghf::flow::{ControlForm, Node, RightHandSide};
use pyo3::prelude::*;

/// Omega at nodes.
#[pyfunction]
fn omega<'py>(
    py: Python<'py>,
    model: &PyModel,
    x: Numbers<'py>,
    xdot: Numbers<'py>,
    xddot: Numbers<'py>,
    k: f64,
) -> PyResult<Array<'py>> {
    let (model, n) = (&*model.model, 2 * model.model.dof());
    let arguments = [("x", &x, n), ("xdot", &xdot, n), ("xddot", &xddot, n)];
    let scratch = || ControlForm::new(model);
    let [found] = over_states(
        py,
        arguments,
        [&[n]],
        scratch,
        |form, [x, xdot, xddot], [out]| {
            let t = 0.0;
            form.omega(Node { t, x, xdot, xddot }, k, out)
        },
    )?;
    Ok(found)
}

/// The derivatives of Omega in x, xdot and xddot by the implementation of this name.
#[pyfunction]
#[pyo3(signature = (model, x, xdot, xddot, k, jacobian = "control-form"))]
fn omega_jacobian<'py>(
    py: Python<'py>,
    model: &PyModel,
    x: Numbers<'py>,
    xdot: Numbers<'py>,
    xddot: Numbers<'py>,
    k: f64,
    jacobian: &str,
) -> PyResult<[Array<'py>; 3]> {
    let kind: JacobianKind = jacobian.parse().map_err(raised)?;
    let (model, n) = (&*model.model, 2 * model.model.dof());
    let arguments = [("x", &x, n), ("xdot", &xdot, n), ("xddot", &xddot, n)];
    let scratch = || (kind.build(model), NodeBlocks::new(model.dof()));
    over_states(
        py,
        arguments,
        [&[n, n]; 3],
        scratch,
        |(form, blocks), [x, xdot, xddot], out| {
            let t = 0.0;
            form.evaluate(Node { t, x, xdot, xddot }, k, blocks)?;
            let all = [&blocks.dx, &blocks.dxdot, &blocks.dxddot];
            for (block, out) in all.into_iter().zip(out) {
                by_rows(block, out);
            }
            Ok(())
        },
    )
}

/// The names of the implementations of the Jacobian.
#[pyfunction]
fn jacobians() -> Vec<String> {
    Jacobians::built_in().names().map(str::to_owned).collect()
}

/// Adds the functions to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(omega, module)?)?;
    module.add_function(wrap_pyfunction!(omega_jacobian, module)?)?;
    module.add_function(wrap_pyfunction!(jacobians, module)?)
}
