//! The right-hand side of the flow and its Jacobian.

use crate::batch::{Array, FunctionOfStates, Number, Numbers, States, by_rows, over_states};
use crate::error::raised;
use crate::model::PyModel;
use aghf::Result;
use aghf::flow::jacobian::{ControlFormJacobian, JacobianKind, Jacobians, NodeBlocks, NodeJacobian};
use aghf::flow::{ControlForm, Node, RightHandSide};
use aghf::model::Model;
use pyo3::prelude::*;

/// The names of the arguments.
const NAMES: [&str; 3] = ["x", "xdot", "xddot"];

/// Omega with the penalty of (11).
struct Omega {
    k: f64,
}

impl FunctionOfStates<3, 1> for Omega {
    type Scratch<'m, S: Number> = ControlForm<'m, f64, S>;

    const NAMES: [&'static str; 3] = NAMES;

    fn widths(&self, n: usize) -> [usize; 3] {
        [2 * n; 3]
    }

    fn shapes(&self, n: usize) -> [Vec<usize>; 1] {
        [vec![2 * n]]
    }

    fn scratch<'m, S: Number>(&self, model: &'m Model) -> Self::Scratch<'m, S> {
        ControlForm::new(model)
    }

    fn evaluate<S: Number>(
        &self,
        _: &Model,
        form: &mut Self::Scratch<'_, S>,
        [x, xdot, xddot]: [&[S]; 3],
        [out]: &mut [&mut [S]; 1],
    ) -> Result<()> {
        let t = S::zero();
        form.omega(Node { t, x, xdot, xddot }, self.k, out)
    }
}

/// Its Jacobian in control form.
struct InControlForm {
    k: f64,
}

impl FunctionOfStates<3, 3> for InControlForm {
    type Scratch<'m, S: Number> = (ControlFormJacobian<'m, f64, S>, NodeBlocks<S>);

    const NAMES: [&'static str; 3] = NAMES;

    fn widths(&self, n: usize) -> [usize; 3] {
        [2 * n; 3]
    }

    fn shapes(&self, n: usize) -> [Vec<usize>; 3] {
        shapes_of_blocks(n)
    }

    fn scratch<'m, S: Number>(&self, model: &'m Model) -> Self::Scratch<'m, S> {
        (ControlFormJacobian::new(model), NodeBlocks::new(model.dof()))
    }

    fn evaluate<S: Number>(
        &self,
        _: &Model,
        (jacobian, blocks): &mut Self::Scratch<'_, S>,
        [x, xdot, xddot]: [&[S]; 3],
        out: &mut [&mut [S]; 3],
    ) -> Result<()> {
        let t = S::zero();
        jacobian.evaluate(Node { t, x, xdot, xddot }, self.k, blocks)?;
        by_rows(blocks.all(), out);
        Ok(())
    }
}

/// The shapes of the blocks of a Jacobian.
fn shapes_of_blocks(n: usize) -> [Vec<usize>; 3] {
    [(); 3].map(|()| vec![2 * n; 2])
}

/// Omega at nodes.
#[pyfunction]
fn omega<'py>(
    py: Python<'py>,
    model: &PyModel,
    x: Numbers<'py>,
    xdot: Numbers<'py>,
    xddot: Numbers<'py>,
    k: f64,
) -> PyResult<[Array<'py>; 1]> {
    over_states(py, &model.model, &Omega { k }, [&x, &xdot, &xddot])
}

/// The derivatives of Omega in x, xdot and xddot by the implementation of this name.
#[pyfunction]
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
    let (model, arguments) = (&*model.model, [&x, &xdot, &xddot]);
    if kind == JacobianKind::ControlForm {
        return over_states(py, model, &InControlForm { k }, arguments);
    }
    // The other methods evaluate one node at a time.
    let n = model.dof();
    let states = States::read(NAMES, arguments, [2 * n; 3])?;
    let scratch = || (kind.build(model), NodeBlocks::new(n));
    states.evaluate(py, shapes_of_blocks(n), 1, scratch, |(form, blocks), group, mut out| {
        let (t, [x, xdot, xddot]) = (0.0, states.row(group.start));
        form.evaluate(Node { t, x, xdot, xddot }, k, blocks)?;
        by_rows(blocks.all(), &mut out);
        Ok(())
    })
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
