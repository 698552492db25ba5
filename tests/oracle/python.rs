//! The bridge to Pinocchio: an interpreter in this process, with the packages of the virtual environment that
//! `tests/run` creates.

use nalgebra::DMatrix;
use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::sync::OnceLockExt;
use pyo3::types::{PyDict, PyTuple};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Results by name; vectors are columns.
pub type Quantities = BTreeMap<String, DMatrix<f64>>;

/// A robot read by Pinocchio.
pub struct Oracle(Py<PyAny>);

impl Oracle {
    /// Loads the text of a URDF file in Pinocchio; the error is Python's message.
    pub fn load(urdf: &str) -> Result<Self, String> {
        Python::attach(|py| {
            let robot = namespace(py).get_item("Robot").expect("it is a dictionary");
            let robot = robot.expect("it is defined").call1((urdf,));
            robot.map(|r| Self(r.unbind())).map_err(|e| e.to_string())
        })
    }

    /// `joints`, `parents` and `links`, in Pinocchio's order.
    pub fn names(&self) -> BTreeMap<String, Vec<String>> {
        Python::attach(|py| {
            let names = self.0.call_method0(py, "names").expect("it is defined");
            names.extract(py).expect("lists of names")
        })
    }

    /// The number of joints, and of those whose subtree has no inertia.
    pub fn summary(&self) -> String {
        Python::attach(|py| {
            let summary = self.0.call_method0(py, "summary").expect("it is defined");
            summary.extract(py).expect("a text")
        })
    }

    /// Calls a method of the robot with vectors.
    pub fn call(&self, method: &str, vectors: &[&[f64]]) -> Quantities {
        Python::attach(|py| {
            let arguments = vectors.iter().map(|x| PyArray1::from_slice(py, x));
            let arguments = PyTuple::new(py, arguments).expect("a tuple");
            let result = self.0.bind(py).call_method1(method, arguments);
            quantities(&or_panic(py, result))
        })
    }

    /// Calls a function of the definition at a node.
    pub fn define(&self, function: &str, z: &[f64], k: f64) -> Quantities {
        Python::attach(|py| {
            let function = namespace(py).get_item(function).expect("a dictionary");
            let arguments = [PyArray1::from_slice(py, z), PyArray1::from_slice(py, &[k])];
            let [z, k] = arguments;
            let result = function.expect("it is defined").call1((&self.0, z, k));
            quantities(&or_panic(py, result))
        })
    }
}

/// The virtual environment.
pub fn venv() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/oracle/venv")
}

/// A data folder in the packages of the virtual environment that are built with CMake.
pub fn share(folder: &str) -> PathBuf {
    let version = Python::attach(|py| (py.version_info().major, py.version_info().minor));
    let packages = format!("lib/python{}.{}/site-packages", version.0, version.1);
    venv().join(packages).join("cmeel.prefix/share").join(folder)
}

fn or_panic<'py>(py: Python<'py>, result: PyResult<Bound<'py, PyAny>>) -> Bound<'py, PyAny> {
    result.unwrap_or_else(|error| {
        error.print(py);
        panic!("{error}")
    })
}

/// A dictionary of arrays.
fn quantities(dictionary: &Bound<'_, PyAny>) -> Quantities {
    let arrays: BTreeMap<String, PyReadonlyArrayDyn<'_, f64>> =
        dictionary.extract().expect("arrays of numbers by name");
    let matrix = |array: PyReadonlyArrayDyn<'_, f64>| {
        let array = array.as_array();
        let columns = array.shape().get(1).copied().unwrap_or(1);
        DMatrix::from_row_iterator(array.shape()[0], columns, array.iter().copied())
    };
    arrays.into_iter().map(|(k, v)| (k, matrix(v))).collect()
}

/// The names defined by the Python files here. A plain `OnceLock` could deadlock: during an import Python may let
/// another thread run, which would then wait for the first while that waits for Python.
fn namespace(py: Python<'_>) -> &Bound<'_, PyDict> {
    static NAMESPACE: OnceLock<Py<PyDict>> = OnceLock::new();
    let made = NAMESPACE.get_or_init_py_attached(py, || {
        open_venv(py);
        let names = PyDict::new(py);
        for source in [include_str!("ground_truth.py"), include_str!("definition.py")] {
            let source = CString::new(source).expect("no zero in it");
            if let Err(error) = py.run(&source, Some(&names), None) {
                panic!("{error}: run `tests/run`, which installs what is needed");
            }
        }
        names.unbind()
    });
    made.bind(py)
}

/// Adds the packages of the virtual environment, after checking that it is complete, has the pinned versions, and
/// belongs to the interpreter whose library was loaded.
fn open_venv(py: Python<'_>) {
    let prepared = std::fs::read_to_string(venv().join("prepared")).unwrap_or_default();
    let version = py.eval(
        c"' '.join([__import__('os').path.realpath(__import__('sys').base_prefix), \
            *__import__('sys').version.split()])",
        None,
        None,
    );
    let interpreter = version.expect("it has a version").to_string();
    let wanted = format!("{interpreter}\n{}", include_str!("requirements.txt"));
    assert!(
        prepared.trim_end() == wanted.trim_end(),
        "target/oracle/venv is not there, not whole, of other pins or of another Python than this one \
        ({interpreter}): run \
         `tests/run`, which makes it anew"
    );
    let info = py.version_info();
    let packages = format!("lib/python{}.{}/site-packages", info.major, info.minor);
    py.import("site")
        .and_then(|site| site.call_method1("addsitedir", (venv().join(packages),)))
        .expect("it is a folder");
}
