//! Rigid-body dynamics and their derivatives.

use crate::batch::{Array, Numbers, by_rows, over_states};
use crate::model::PyModel;
use aghf::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, InverseDynamicsSecondDerivatives,
    RneaVjp, RneaWeightedHessian, aba as aba_of, aba_derivatives as aba_derivatives_of,
    crba as crba_of, forward_kinematics as forward_kinematics_of,
    frame_jacobian as frame_jacobian_of, frame_placement, mass_matrix_and_rate as h_and_hdot_of,
    rnea as rnea_of, rnea_derivatives as rnea_derivatives_of,
    rnea_second_derivatives as rnea_second_derivatives_of, rnea_vjp as rnea_vjp_of,
    rnea_weighted_hessian as rnea_weighted_hessian_of,
};
use aghf::linalg::Tensor3;
use aghf::model::{Frame, Model};
use aghf::spatial::Placement;
use nalgebra::DMatrix;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

/// The torques or forces of accelerations.
#[pyfunction]
fn rnea<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    v: Numbers<'py>,
    a: Numbers<'py>,
) -> PyResult<Array<'py>> {
    let (model, n) = (&*model.model, model.model.dof());
    let arguments = [("q", &q, n), ("v", &v, n), ("a", &a, n)];
    let work = |data: &mut Data, [q, v, a]: [&[f64]; 3], [tau]: &mut [&mut [f64]; 1]| {
        rnea_of(model, data, q, v, a, tau)
    };
    let [tau] = over_states(py, arguments, [&[n]], || Data::new(model), work)?;
    Ok(tau)
}

/// The accelerations of torques or forces.
#[pyfunction]
fn aba<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    v: Numbers<'py>,
    tau: Numbers<'py>,
) -> PyResult<Array<'py>> {
    let (model, n) = (&*model.model, model.model.dof());
    let arguments = [("q", &q, n), ("v", &v, n), ("tau", &tau, n)];
    let work = |data: &mut Data, [q, v, tau]: [&[f64]; 3], [a]: &mut [&mut [f64]; 1]| {
        aba_of(model, data, q, v, tau, a)
    };
    let [a] = over_states(py, arguments, [&[n]], || Data::new(model), work)?;
    Ok(a)
}

/// Mass matrices.
#[pyfunction]
fn crba<'py>(py: Python<'py>, model: &PyModel, q: Numbers<'py>) -> PyResult<Array<'py>> {
    let (model, n) = (&*model.model, model.model.dof());
    let scratch = || (Data::new(model), DMatrix::zeros(n, n));
    let [h] = over_states(
        py,
        [("q", &q, n)],
        [&[n, n]],
        scratch,
        |(data, h), [q], [out]| {
            crba_of(model, data, q, h)?;
            by_rows(h, out);
            Ok(())
        },
    )?;
    Ok(h)
}

/// Mass matrices and their rates along velocities.
#[pyfunction]
fn mass_matrix_and_rate<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    v: Numbers<'py>,
) -> PyResult<[Array<'py>; 2]> {
    let (model, n) = (&*model.model, model.model.dof());
    let scratch = || (Data::new(model), DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let arguments = [("q", &q, n), ("v", &v, n)];
    let shapes: [&[usize]; 2] = [&[n, n], &[n, n]];
    over_states(
        py,
        arguments,
        shapes,
        scratch,
        |(data, h, hdot), [q, v], out| {
            h_and_hdot_of(model, data, q, v, h, hdot)?;
            by_rows(h, out[0]);
            by_rows(hdot, out[1]);
            Ok(())
        },
    )
}

/// Inverse dynamics with its first derivatives: tau, dtau/dq, dtau/dv, dtau/da.
#[pyfunction]
fn rnea_derivatives<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    v: Numbers<'py>,
    a: Numbers<'py>,
) -> PyResult<[Array<'py>; 4]> {
    let (model, n) = (&*model.model, model.model.dof());
    let arguments = [("q", &q, n), ("v", &v, n), ("a", &a, n)];
    let shapes: [&[usize]; 4] = [&[n], &[n, n], &[n, n], &[n, n]];
    let scratch = || (Data::new(model), InverseDynamicsDerivatives::new(n));
    over_states(
        py,
        arguments,
        shapes,
        scratch,
        |(data, id), [q, v, a], out| {
            rnea_derivatives_of(model, data, q, v, a, id)?;
            out[0].copy_from_slice(id.tau.as_slice());
            for (matrix, out) in [&id.dq, &id.dv, &id.h].into_iter().zip(&mut out[1..]) {
                by_rows(matrix, out);
            }
            Ok(())
        },
    )
}

/// Forward dynamics with its first derivatives: a, da/dq, da/dv, da/dtau.
#[pyfunction]
fn aba_derivatives<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    v: Numbers<'py>,
    tau: Numbers<'py>,
) -> PyResult<[Array<'py>; 4]> {
    let (model, n) = (&*model.model, model.model.dof());
    let arguments = [("q", &q, n), ("v", &v, n), ("tau", &tau, n)];
    let shapes: [&[usize]; 4] = [&[n], &[n, n], &[n, n], &[n, n]];
    let scratch = || (Data::new(model), ForwardDynamicsDerivatives::new(n));
    over_states(
        py,
        arguments,
        shapes,
        scratch,
        |(data, fd), [q, v, tau], out| {
            aba_derivatives_of(model, data, q, v, tau, fd)?;
            out[0].copy_from_slice(fd.a.as_slice());
            for (matrix, out) in [&fd.dq, &fd.dv, &fd.h_inverse]
                .into_iter()
                .zip(&mut out[1..])
            {
                by_rows(matrix, out);
            }
            Ok(())
        },
    )
}

/// The second derivatives of the inverse dynamics in qq, vv, qv and aq.
#[pyfunction]
fn rnea_second_derivatives<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    v: Numbers<'py>,
    a: Numbers<'py>,
) -> PyResult<[Array<'py>; 4]> {
    let (model, n) = (&*model.model, model.model.dof());
    let arguments = [("q", &q, n), ("v", &v, n), ("a", &a, n)];
    let scratch = || (Data::new(model), InverseDynamicsSecondDerivatives::new(n));
    over_states(
        py,
        arguments,
        [&[n, n, n]; 4],
        scratch,
        |(data, id), [q, v, a], out| {
            rnea_second_derivatives_of(model, data, q, v, a, id)?;
            let tensors = [&id.dqdq, &id.dvdv, &id.dqdv, &id.dadq];
            for (tensor, out) in tensors.into_iter().zip(out) {
                by_planes(tensor, n, out);
            }
            Ok(())
        },
    )
}

/// Writes a tensor with its last index fastest.
fn by_planes(tensor: &Tensor3<f64>, n: usize, out: &mut [f64]) {
    for (at, entry) in out.iter_mut().enumerate() {
        let (i, j, k) = (at / (n * n), at / n % n, at % n);
        *entry = tensor[(i, j, k)];
    }
}

/// The products of a vector with the first derivatives of the inverse dynamics in q, v and a.
#[pyfunction]
fn rnea_vjp<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    v: Numbers<'py>,
    a: Numbers<'py>,
    w: Numbers<'py>,
) -> PyResult<[Array<'py>; 3]> {
    let (model, n) = (&*model.model, model.model.dof());
    let arguments = [("q", &q, n), ("v", &v, n), ("a", &a, n), ("w", &w, n)];
    let scratch = || (Data::new(model), RneaVjp::new(n));
    over_states(
        py,
        arguments,
        [&[n]; 3],
        scratch,
        |(data, vjp), [q, v, a, w], out| {
            rnea_vjp_of(model, data, q, v, a, w, vjp)?;
            for (own, out) in [&vjp.q, &vjp.v, &vjp.a].into_iter().zip(out) {
                out.copy_from_slice(own.as_slice());
            }
            Ok(())
        },
    )
}

/// The second derivatives of the product of a vector with the inverse dynamics in qq, qv, vv and qa.
#[pyfunction]
fn rnea_weighted_hessian<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    v: Numbers<'py>,
    a: Numbers<'py>,
    w: Numbers<'py>,
) -> PyResult<[Array<'py>; 4]> {
    let (model, n) = (&*model.model, model.model.dof());
    let arguments = [("q", &q, n), ("v", &v, n), ("a", &a, n), ("w", &w, n)];
    let scratch = || (Data::new(model), RneaWeightedHessian::new(n));
    over_states(
        py,
        arguments,
        [&[n, n]; 4],
        scratch,
        |(data, hessian), [q, v, a, w], out| {
            rnea_weighted_hessian_of(model, data, q, v, a, w, hessian)?;
            let blocks = [&hessian.qq, &hessian.qv, &hessian.vv, &hessian.qa];
            for (block, out) in blocks.into_iter().zip(out) {
                by_rows(block, out);
            }
            Ok(())
        },
    )
}

/// Writes a placement as a homogeneous matrix of four by four.
fn homogeneous(placement: &Placement<f64>, out: &mut [f64]) {
    for i in 0..3 {
        for j in 0..3 {
            out[4 * i + j] = placement.rotation[(i, j)];
        }
        out[4 * i + 3] = placement.translation[i];
    }
    out[15] = 1.0;
}

/// The placements of all bodies in the base, homogeneous.
#[pyfunction]
fn forward_kinematics<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
) -> PyResult<Array<'py>> {
    let (model, n) = (&*model.model, model.model.dof());
    let scratch = || vec![Placement::identity(); n];
    let [placed] = over_states(
        py,
        [("q", &q, n)],
        [&[n, 4, 4]],
        scratch,
        |placed, [q], [out]| {
            forward_kinematics_of(model, q, placed)?;
            for (placement, out) in placed.iter().zip(out.chunks_exact_mut(16)) {
                homogeneous(placement, out);
            }
            Ok(())
        },
    )?;
    Ok(placed)
}

/// The frame of this name.
fn frame_of<'m>(model: &'m Model, name: &str) -> PyResult<&'m Frame<f64>> {
    let found = model.frames().iter().find(|frame| frame.name == name);
    found.ok_or_else(|| {
        let message = format!("{}: it has no frame '{name}'", model.name());
        PyKeyError::new_err(message)
    })
}

/// The placement of a frame in the base, homogeneous.
#[pyfunction]
fn frame_placements<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    frame: &str,
) -> PyResult<Array<'py>> {
    let (model, n) = (&*model.model, model.model.dof());
    let frame = frame_of(model, frame)?;
    let scratch = || vec![Placement::identity(); n];
    let [placed] = over_states(
        py,
        [("q", &q, n)],
        [&[4, 4]],
        scratch,
        |placed, [q], [out]| {
            forward_kinematics_of(model, q, placed)?;
            homogeneous(&frame_placement(frame, placed)?, out);
            Ok(())
        },
    )?;
    Ok(placed)
}

/// The Jacobian of a frame.
#[pyfunction]
fn frame_jacobian<'py>(
    py: Python<'py>,
    model: &PyModel,
    q: Numbers<'py>,
    frame: &str,
) -> PyResult<Array<'py>> {
    let (model, n) = (&*model.model, model.model.dof());
    let frame = frame_of(model, frame)?;
    let scratch = || (Data::new(model), DMatrix::zeros(6, n));
    let arguments = [("q", &q, n)];
    let [found] = over_states(
        py,
        arguments,
        [&[6, n]],
        scratch,
        |(data, own), [q], [out]| {
            frame_jacobian_of(model, data, q, frame, own)?;
            by_rows(own, out);
            Ok(())
        },
    )?;
    Ok(found)
}

/// Adds the functions to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(rnea, module)?)?;
    module.add_function(wrap_pyfunction!(aba, module)?)?;
    module.add_function(wrap_pyfunction!(crba, module)?)?;
    module.add_function(wrap_pyfunction!(mass_matrix_and_rate, module)?)?;
    module.add_function(wrap_pyfunction!(rnea_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(aba_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(rnea_second_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(rnea_vjp, module)?)?;
    module.add_function(wrap_pyfunction!(rnea_weighted_hessian, module)?)?;
    module.add_function(wrap_pyfunction!(forward_kinematics, module)?)?;
    module.add_function(wrap_pyfunction!(frame_placements, module)?)?;
    module.add_function(wrap_pyfunction!(frame_jacobian, module)?)
}
