//! Robots.

use crate::error::raised;
use aghf::Error;
use aghf::model::{Frame, JointKind, JointSpec, Limits, Model};
use aghf::spatial::{Inertia, Placement};
use aghf::urdf::{LoadReport, UrdfOptions, builtin_robot, load_urdf_with, parse_urdf_with};
use aghf_scenario::Losses;
use nalgebra::{Matrix3, Vector3};
use numpy::{PyArray1, ToPyArray};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A joint: name, kind, index of the parent or -1, placement in the parent (rotation by rows, then translation), axis,
/// mass with its centre and the inertia about it by rows, and the limits: lower, upper, velocity, effort.
type JointParts = (String, String, i64, [f64; 12], [f64; 3], (f64, [f64; 3], [f64; 9]), [f64; 4]);

/// The options of reading a URDF: the treatment of mimic joints, the root, the losses in JSON as in a scenario, and the
/// folders of packages.
type Options = (String, Option<String>, String, BTreeMap<String, PathBuf>);

/// Reads the options; `file` names the robot in errors.
fn urdf_options(file: &str, (mimic, root, losses, packages): Options) -> PyResult<UrdfOptions> {
    let losses: Losses =
        serde_json::from_str(&losses).map_err(|error| raised(Error::input(file, "losses", error.to_string())))?;
    Ok(UrdfOptions {
        mimic: mimic.parse().map_err(raised)?,
        root,
        losses: losses.options(),
        packages,
        ..UrdfOptions::default()
    })
}

/// The placement with a rotation by rows and a translation.
pub fn placement_of(numbers: &[f64]) -> Placement<f64> {
    let (rotation, translation) = numbers.split_at(9);
    Placement::new(Matrix3::from_row_slice(rotation), Vector3::from_column_slice(translation))
}

/// A robot. It never changes, so threads share it.
#[pyclass(name = "Model", module = "aghf", frozen)]
pub struct PyModel {
    pub model: Arc<Model>,
    /// The notes on loading the robot.
    notes: Vec<String>,
}

#[pymethods]
impl PyModel {
    /// The built-in robot of this name.
    #[staticmethod]
    fn builtin(name: &str) -> PyResult<Self> {
        let model = builtin_robot(name).map_err(raised)?;
        Ok(Self::new(model, &LoadReport::default()))
    }

    /// The robot in a URDF file.
    #[staticmethod]
    fn load_file(path: &str, options: Options) -> PyResult<Self> {
        let options = urdf_options(path, options)?;
        let (model, notes) = load_urdf_with(Path::new(path), options).map_err(raised)?;
        Ok(Self::new(model, &notes))
    }

    /// The robot in a URDF text; `name` stands for the file in errors.
    #[staticmethod]
    fn parse(text: &str, name: &str, options: Options) -> PyResult<Self> {
        let options = urdf_options(name, options)?;
        let (model, notes) = parse_urdf_with(text, name, options).map_err(raised)?;
        Ok(Self::new(model, &notes))
    }

    /// The robot with these joints, parents before children, and these frames. Placements and inertias are rows of
    /// numbers.
    #[staticmethod]
    fn from_parts(
        name: &str,
        joints: Vec<JointParts>,
        frames: Vec<(String, i64, [f64; 12])>,
        gravity: [f64; 3],
    ) -> PyResult<Self> {
        let body_of = |index: i64| usize::try_from(index).ok();
        let spec = |joint: JointParts| {
            let (name, kind, parent, origin, axis, (mass, com, inertia), limits) = joint;
            let kinds = [JointKind::Revolute, JointKind::Continuous, JointKind::Prismatic];
            let found = kinds.into_iter().find(|known| known.name() == kind);
            let Some(kind) = found else {
                let condition = format!("its kind is '{kind}'");
                return Err(Error::input(name, "kind", condition));
            };
            let [lower, upper, velocity, effort] = limits;
            Ok(JointSpec {
                name,
                kind,
                parent: body_of(parent),
                origin: placement_of(&origin),
                axis: Vector3::from(axis),
                inertia: Inertia::from_com(mass, Vector3::from(com), Matrix3::from_row_slice(&inertia)),
                limits: Limits { lower, upper, velocity, effort },
            })
        };
        let specs: aghf::Result<Vec<_>> = joints.into_iter().map(spec).collect();
        let mut model = specs
            .and_then(|specs| Model::from_joints(name, specs))
            .map_err(raised)?
            .with_gravity(Vector3::from(gravity));
        for (frame, body, placement) in frames {
            let added = model.add_frame(Frame::new(&frame, body_of(body), placement_of(&placement)));
            added.map_err(raised)?;
        }
        model.check_regular(name).map_err(raised)?;
        Ok(Self::new(model, &LoadReport::default()))
    }

    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    #[getter]
    fn dof(&self) -> usize {
        self.model.dof()
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.model.mass()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.model.joints().iter().map(|joint| joint.name()).collect()
    }

    #[getter]
    fn joint_kinds(&self) -> Vec<&str> {
        let kinds = self.model.joints().iter().map(|joint| joint.kind());
        kinds.map(JointKind::name).collect()
    }

    /// The index of the parent of each joint; -1 for the base.
    #[getter]
    fn parents<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let parents = self.model.joints().iter().map(|joint| joint.parent());
        let parents: Vec<i64> = parents.map(|p| p.map_or(-1, |p| p as i64)).collect();
        parents.to_pyarray(py)
    }

    #[getter]
    fn frame_names(&self) -> Vec<&str> {
        self.model.frames().iter().map(|frame| frame.name.as_str()).collect()
    }

    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.model.gravity().as_slice().to_pyarray(py)
    }

    /// The limits of positions, velocities and torques, infinite without a limit.
    #[getter]
    fn lower<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.limits(py, |limits| limits.lower)
    }

    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.limits(py, |limits| limits.upper)
    }

    #[getter]
    fn velocity_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.limits(py, |limits| limits.velocity)
    }

    #[getter]
    fn effort_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.limits(py, |limits| limits.effort)
    }

    fn to_urdf(&self) -> PyResult<String> {
        self.model.to_urdf().map_err(raised)
    }

    fn __repr__(&self) -> String {
        format!("Model('{}', {} joints)", self.model.name(), self.model.dof())
    }
}

impl PyModel {
    /// A robot with the notes on loading it.
    pub fn new(model: Model, notes: &LoadReport) -> Self {
        Self { model: Arc::new(model), notes: notes.iter().map(ToString::to_string).collect() }
    }

    fn limits<'py>(&self, py: Python<'py>, of: impl Fn(&Limits) -> f64) -> Bound<'py, PyArray1<f64>> {
        let joints = self.model.joints().iter();
        let limits: Vec<f64> = joints.map(|joint| of(joint.limits())).collect();
        limits.to_pyarray(py)
    }
}

/// The names of the built-in robots.
#[pyfunction]
pub fn builtin_robots() -> Vec<&'static str> {
    aghf::urdf::builtin_robots().collect()
}
