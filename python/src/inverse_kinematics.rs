//! Inverse kinematics.

use crate::batch::{Array, Numbers, States};
use crate::dynamics::frame_of;
use crate::model::{PyModel, placement_of};
use aghf::constraint::FrameRows;
use aghf::error::Error;
use aghf::model::Frame;
use aghf::plan::InverseKinematics;
use nalgebra::Matrix3;
use pyo3::prelude::*;

/// The largest error of an entry of $R^T R$ for a rotation, which numbers of single precision keep.
const ORTHONORMAL: f64 = 1e-6;

/// Joint positions within the limits that take a frame to placements, each a rotation by rows and a translation, by
/// searches from at most this number of first guesses; NaN where none is found.
#[pyfunction]
pub fn inverse_kinematics<'py>(
    py: Python<'py>,
    model: &PyModel,
    placement: Numbers<'py>,
    near: Numbers<'py>,
    frame: &str,
    guesses: usize,
) -> PyResult<[Array<'py>; 1]> {
    let model = &model.model;
    let (n, frame) = (model.dof(), frame_of(model, frame)?);
    let states = States::read(["placement", "near"], [&placement, &near], [12, n])?;
    let limits = model.joints().iter().map(|joint| joint.limits());
    let bounds: Vec<_> = limits.map(|limits| [limits.lower, limits.upper]).collect();
    let search = |(): &mut (), group: std::ops::Range<usize>, [found]: [&mut [f64]; 1]| {
        let [numbers, near] = states.row(group.start);
        let goal = placement_of(numbers);
        let square = goal.rotation.transpose() * goal.rotation - Matrix3::identity();
        if !(square.amax() <= ORTHONORMAL && goal.rotation.determinant() > 0.0) {
            let condition = format!("the rotation of number {} is none", group.start);
            return Err(Error::input(model.name(), "placement", condition));
        }
        let numbers = [("placement", numbers), ("near", near)];
        if let Some((what, _)) = numbers.iter().find(|(_, all)| all.iter().any(|x| !x.is_finite())) {
            let condition = format!("an entry of number {} is not finite", group.start);
            return Err(Error::input(model.name(), *what, condition));
        }
        let rows = FrameRows::new(frame, Frame::new("goal", None, goal));
        let rows = rows.at_origin().oriented();
        let mut search = InverseKinematics::new(model, &rows, bounds.clone())?;
        found.fill(f64::NAN);
        for guess in search.guesses(near, 0).take(guesses) {
            let end = search.solve(&guess)?;
            if end.violation <= InverseKinematics::<FrameRows>::TOLERANCE {
                found.copy_from_slice(&search.nearer(&end.q, near));
                break;
            }
        }
        Ok(())
    };
    states.evaluate(py, [vec![n]], 1, || (), search)
}
