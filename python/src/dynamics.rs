//! Rigid-body dynamics and their derivatives.

use crate::batch::{Array, FunctionOfStates, Number, Numbers, by_rows, function_of_states, over_states};
use crate::model::PyModel;
use aghf::Result;
use aghf::dynamics as library;
use aghf::dynamics::{
    Data, ForwardDynamicsDerivatives, ForwardDynamicsSecondDerivatives, InverseDynamicsDerivatives,
    InverseDynamicsSecondDerivatives, RneaVjp, RneaWeightedHessian, frame_placement,
};
use aghf::linalg::Tensor3;
use aghf::model::{Frame, Model};
use aghf::names::instead;
use aghf::scalar::Scalar;
use aghf::spatial::Placement;
use nalgebra::DMatrix;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

function_of_states! {
    /// The torques or forces of accelerations.
    fn rnea as Rnea(model, n; q: n, v: n, a: n) -> [[n]]
    data: Data<S> = Data::new(model);
    results => library::rnea(model, data, q, v, a, results[0])
}

function_of_states! {
    /// The accelerations of torques or forces.
    fn aba as Aba(model, n; q: n, v: n, tau: n) -> [[n]]
    data: Data<S> = Data::new(model);
    results => library::aba(model, data, q, v, tau, results[0])
}

function_of_states! {
    /// Mass matrices.
    fn crba as Crba(model, n; q: n) -> [[n, n]]
    scratch: (Data<S>, DMatrix<S>) = (Data::new(model), DMatrix::zeros(n, n));
    results => {
        let (data, h) = scratch;
        library::crba(model, data, q, h)?;
        by_rows([h], results);
        Ok(())
    }
}

function_of_states! {
    /// Mass matrices and their rates along velocities.
    fn mass_matrix_and_rate as MassMatrixAndRate(model, n; q: n, v: n) -> [[n, n], [n, n]]
    scratch: (Data<S>, [DMatrix<S>; 2]) = (Data::new(model), [(); 2].map(|()| DMatrix::zeros(n, n)));
    results => {
        let (data, [h, hdot]) = scratch;
        library::mass_matrix_and_rate(model, data, q, v, h, hdot)?;
        by_rows([h, hdot], results);
        Ok(())
    }
}

function_of_states! {
    /// Kinetic and potential energies.
    fn energy as Energy(model, n; q: n, v: n) -> [[0; 0], [0; 0]]
    data: Data<S> = Data::new(model);
    results => {
        results[0][0] = library::kinetic_energy(model, data, q, v)?;
        results[1][0] = library::potential_energy(model, data, q)?;
        Ok(())
    }
}

function_of_states! {
    /// Inverse dynamics with its first derivatives: tau, dtau/dq, dtau/dv, dtau/da.
    fn rnea_derivatives as RneaDerivatives(model, n; q: n, v: n, a: n) -> [[n], [n, n], [n, n], [n, n]]
    scratch: (Data<S>, InverseDynamicsDerivatives<S>) = (Data::new(model), InverseDynamicsDerivatives::new(n));
    results => {
        let (data, id) = scratch;
        library::rnea_derivatives(model, data, q, v, a, id)?;
        results[0].copy_from_slice(id.tau.as_slice());
        by_rows([&id.dq, &id.dv, &id.h], &mut results[1..]);
        Ok(())
    }
}

function_of_states! {
    /// Forward dynamics with its first derivatives: a, da/dq, da/dv, da/dtau.
    fn aba_derivatives as AbaDerivatives(model, n; q: n, v: n, tau: n) -> [[n], [n, n], [n, n], [n, n]]
    scratch: (Data<S>, ForwardDynamicsDerivatives<S>) = (Data::new(model), ForwardDynamicsDerivatives::new(n));
    results => {
        let (data, fd) = scratch;
        library::aba_derivatives(model, data, q, v, tau, fd)?;
        results[0].copy_from_slice(fd.a.as_slice());
        by_rows([&fd.dq, &fd.dv, &fd.h_inverse], &mut results[1..]);
        Ok(())
    }
}

/// The scratch of the second derivatives of the inverse dynamics.
type SecondScratch<S> = (Data<S>, InverseDynamicsSecondDerivatives<S>);

function_of_states! {
    /// The second derivatives of the inverse dynamics in qq, vv, qv and aq.
    fn rnea_second_derivatives as RneaSecondDerivatives(model, n; q: n, v: n, a: n) -> [[n; 3], [n; 3], [n; 3], [n; 3]]
    scratch: SecondScratch<S> = (Data::new(model), InverseDynamicsSecondDerivatives::new(n));
    results => {
        let (data, id) = scratch;
        library::rnea_second_derivatives(model, data, q, v, a, id)?;
        by_planes([id.dqdq(), id.dvdv(), id.dqdv(), id.dadq()], model.dof(), results);
        Ok(())
    }
}

function_of_states! {
    /// The second derivatives of the forward dynamics in qq, vv and qv.
    fn aba_second_derivatives as AbaSecondDerivatives(model, n; q: n, v: n, tau: n) -> [[n; 3], [n; 3], [n; 3]]
    scratch: (SecondScratch<S>, ForwardDynamicsDerivatives<S>, ForwardDynamicsSecondDerivatives<S>) = (
        (Data::new(model), InverseDynamicsSecondDerivatives::new(n)),
        ForwardDynamicsDerivatives::new(n),
        ForwardDynamicsSecondDerivatives::new(n),
    );
    results => {
        let ((data, id), fd, second) = scratch;
        library::aba_derivatives(model, data, q, v, tau, fd)?;
        library::rnea_second_derivatives(model, data, q, v, fd.a.as_slice(), id)?;
        library::aba_second_derivatives(fd, id, second)?;
        by_planes([&second.dqdq, &second.dvdv, &second.dqdv], model.dof(), results);
        Ok(())
    }
}

/// Writes each tensor of order `n` into its result, with the last index fastest.
fn by_planes<S: Scalar, const K: usize>(tensors: [&Tensor3<S>; K], n: usize, results: &mut [&mut [S]; K]) {
    for (tensor, result) in tensors.into_iter().zip(results) {
        for (at, entry) in result.iter_mut().enumerate() {
            *entry = tensor[(at / (n * n), at / n % n, at % n)];
        }
    }
}

function_of_states! {
    /// The products of a vector with the first derivatives of the inverse dynamics in q, v and a.
    fn rnea_vjp as Vjp(model, n; q: n, v: n, a: n, w: n) -> [[n], [n], [n]]
    scratch: (Data<S>, RneaVjp<S>) = (Data::new(model), RneaVjp::new(n));
    results => {
        let (data, vjp) = scratch;
        library::rnea_vjp(model, data, q, v, a, w, vjp)?;
        for (own, out) in [&vjp.q, &vjp.v, &vjp.a].into_iter().zip(results) {
            out.copy_from_slice(own.as_slice());
        }
        Ok(())
    }
}

function_of_states! {
    /// The second derivatives of the product of a vector with the inverse dynamics in qq, qv, vv and qa.
    fn rnea_weighted_hessian as WeightedHessian(model, n; q: n, v: n, a: n, w: n) -> [[n, n], [n, n], [n, n], [n, n]]
    scratch: (Data<S>, RneaWeightedHessian<S>) = (Data::new(model), RneaWeightedHessian::new(n));
    results => {
        let (data, hessian) = scratch;
        library::rnea_weighted_hessian(model, data, q, v, a, w, hessian)?;
        by_rows([&hessian.qq, &hessian.qv, &hessian.vv, &hessian.qa], results);
        Ok(())
    }
}

/// Writes a placement as a homogeneous 4 by 4 matrix.
fn homogeneous<S: Scalar>(placement: &Placement<S>, out: &mut [S]) {
    for i in 0..3 {
        for j in 0..3 {
            out[4 * i + j] = placement.rotation[(i, j)];
        }
        out[4 * i + 3] = placement.translation[i];
    }
    out[12..15].fill(S::zero());
    out[15] = S::one();
}

function_of_states! {
    /// The placements of all bodies in the base, homogeneous.
    fn forward_kinematics as ForwardKinematics(model, n; q: n) -> [[n, 4, 4]]
    placed: Vec<Placement<S>> = vec![Placement::identity(); n];
    results => {
        library::forward_kinematics(model, q, placed)?;
        for (placement, out) in placed.iter().zip(results[0].chunks_exact_mut(16)) {
            homogeneous(placement, out);
        }
        Ok(())
    }
}

/// The frame of this name.
pub fn frame_of<'m>(model: &'m Model, name: &str) -> PyResult<&'m Frame<f64>> {
    let found = model.frames().iter().find(|frame| frame.name == name);
    found.ok_or_else(|| {
        let names = instead(name, model.frames().iter().map(|frame| frame.name.as_str()));
        let message = format!("{}: it has no frame '{name}'{names}", model.name());
        PyKeyError::new_err(message)
    })
}

/// The placement of a frame.
struct PlacementOf<'m>(&'m Frame<f64>);

impl FunctionOfStates<1, 1> for PlacementOf<'_> {
    type Scratch<'m, S: Number> = Vec<Placement<S>>;

    const NAMES: [&'static str; 1] = ["q"];

    fn widths(&self, n: usize) -> [usize; 1] {
        [n]
    }

    fn shapes(&self, _: usize) -> [Vec<usize>; 1] {
        [vec![4, 4]]
    }

    fn scratch<S: Number>(&self, model: &Model) -> Vec<Placement<S>> {
        vec![Placement::identity(); model.dof()]
    }

    fn evaluate<S: Number>(
        &self,
        model: &Model,
        placed: &mut Vec<Placement<S>>,
        [q]: [&[S]; 1],
        [out]: &mut [&mut [S]; 1],
    ) -> Result<()> {
        library::forward_kinematics(model, q, placed)?;
        homogeneous(&frame_placement(self.0, placed)?, out);
        Ok(())
    }
}

/// The Jacobian of a frame.
struct JacobianOf<'m>(&'m Frame<f64>);

impl FunctionOfStates<1, 1> for JacobianOf<'_> {
    type Scratch<'m, S: Number> = (Data<S>, DMatrix<S>);

    const NAMES: [&'static str; 1] = ["q"];

    fn widths(&self, n: usize) -> [usize; 1] {
        [n]
    }

    fn shapes(&self, n: usize) -> [Vec<usize>; 1] {
        [vec![6, n]]
    }

    fn scratch<S: Number>(&self, model: &Model) -> (Data<S>, DMatrix<S>) {
        (Data::new(model), DMatrix::zeros(6, model.dof()))
    }

    fn evaluate<S: Number>(
        &self,
        model: &Model,
        (data, jacobian): &mut (Data<S>, DMatrix<S>),
        [q]: [&[S]; 1],
        out: &mut [&mut [S]; 1],
    ) -> Result<()> {
        library::frame_jacobian(model, data, q, self.0, jacobian)?;
        by_rows([jacobian], out);
        Ok(())
    }
}

/// The placement of a frame in the base, homogeneous.
#[pyfunction]
fn frame_placements<'py>(py: Python<'py>, model: &PyModel, q: Numbers<'py>, frame: &str) -> PyResult<[Array<'py>; 1]> {
    let model = &model.model;
    over_states(py, model, &PlacementOf(frame_of(model, frame)?), [&q])
}

/// The Jacobian of a frame.
#[pyfunction]
fn frame_jacobian<'py>(py: Python<'py>, model: &PyModel, q: Numbers<'py>, frame: &str) -> PyResult<[Array<'py>; 1]> {
    let model = &model.model;
    over_states(py, model, &JacobianOf(frame_of(model, frame)?), [&q])
}

/// Adds the functions to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(rnea, module)?)?;
    module.add_function(wrap_pyfunction!(aba, module)?)?;
    module.add_function(wrap_pyfunction!(crba, module)?)?;
    module.add_function(wrap_pyfunction!(mass_matrix_and_rate, module)?)?;
    module.add_function(wrap_pyfunction!(energy, module)?)?;
    module.add_function(wrap_pyfunction!(rnea_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(aba_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(rnea_second_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(aba_second_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(rnea_vjp, module)?)?;
    module.add_function(wrap_pyfunction!(rnea_weighted_hessian, module)?)?;
    module.add_function(wrap_pyfunction!(forward_kinematics, module)?)?;
    module.add_function(wrap_pyfunction!(frame_placements, module)?)?;
    module.add_function(wrap_pyfunction!(frame_jacobian, module)?)
}
