//! Errors as Python exceptions.

use aghf::Error;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;

pyo3::create_exception!(
    aghf,
    InputError,
    PyValueError,
    "Bad input, with the attributes `file`, `element` and `condition`."
);

/// The Python exception for an error.
pub fn raised(error: Error) -> PyErr {
    let message = error.to_string();
    match error {
        Error::Input { file, element, condition } => Python::attach(|py| {
            let raised = InputError::new_err(message);
            let value = raised.value(py);
            let parts = [("file", file), ("element", element), ("condition", condition)];
            for (name, part) in parts {
                if let Err(error) = value.setattr(name, part) {
                    return error;
                }
            }
            raised
        }),
        Error::Length { .. } => PyValueError::new_err(message),
        Error::Io { .. } => PyOSError::new_err(message),
    }
}

/// Adds the exceptions to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("InputError", module.py().get_type::<InputError>())
}
