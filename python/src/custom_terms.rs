//! Running costs and constraints written in Python.

use aghf::constraint::{Constraint, PlacedState, Quantity, RowLabel, RowSet, WeightedDerivatives, Weights};
use aghf::cost::{RunningCost, StageDerivatives, StageInput};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, LANES, Scalar, Wide};
use aghf::{Error, Result};
use nalgebra::{DMatrix, DVector};
use numpy::{PyArray1, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::any::Any;
use std::sync::{Arc, Mutex, PoisonError};

/// The first exception raised by a Python function, which an error of the library cannot carry.
#[derive(Clone, Debug, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// The exception, if there is one.
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Keeps the exception of a result and returns an error in its place.
    pub fn keep<T>(&self, result: PyResult<T>, what: &str) -> Result<T> {
        result.map_err(|error| {
            let stand_in = Error::input("Python", what, error.to_string());
            let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert(error);
            stand_in
        })
    }
}

/// An array returned by Python, which must have this shape.
pub fn array<'py>(of: &Bound<'py, PyAny>, name: &str, shape: &[usize]) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let array: PyReadonlyArrayDyn<'py, f64> = of.extract()?;
    if array.shape() != shape {
        let found = array.shape();
        let message = format!("{name}: its shape is {found:?}, expected {shape:?}");
        return Err(PyValueError::new_err(message));
    }
    Ok(array)
}

/// A running cost: an object with `value(t, q, v, a, u)` and `derivatives(t, q, v, a, u)`, which returns gradient and
/// Hessian in `[q; v; a; u]`.
pub struct PyRunningCost {
    pub object: Py<PyAny>,
    pub raised: Raised,
}

impl PyRunningCost {
    fn call<'py>(&self, py: Python<'py>, method: &str, at: &StageInput<'_, f64>) -> PyResult<Bound<'py, PyAny>> {
        let [q, v, a, u] = [at.q, at.v, at.a, at.u].map(|x| PyArray1::from_slice(py, x));
        self.object.bind(py).call_method1(method, (at.t, q, v, a, u))
    }

    fn value_of(&self, at: &StageInput<'_, f64>) -> PyResult<f64> {
        Python::attach(|py| self.call(py, "value", at)?.extract())
    }

    fn derivatives_of(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> PyResult<()> {
        Python::attach(|py| {
            let m = 4 * at.q.len();
            let found = self.call(py, "derivatives", at)?;
            let (gradient, hessian): (Bound<'_, PyAny>, Bound<'_, PyAny>) = found.extract()?;
            let gradient = array(&gradient, "gradient", &[m])?;
            let hessian = array(&hessian, "hessian", &[m, m])?;
            for (to, x) in out.gradient.iter_mut().zip(gradient.as_array()) {
                *to = *x;
            }
            // The order of the indices does not matter: the Hessian is symmetric.
            for (to, x) in out.hessian.iter_mut().zip(hessian.as_array()) {
                *to = *x;
            }
            Ok(())
        })
    }
}

impl RunningCost for PyRunningCost {
    fn value(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        self.raised.keep(self.value_of(at), "running_cost.value")
    }

    fn derivatives(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> Result<f64> {
        let found = self.derivatives_of(at, out);
        self.raised.keep(found, "running_cost.derivatives")?;
        self.value(at)
    }
}

/// A constraint: an object with `value(q, v)`, which returns the rows, and `derivatives(q, v)`, which returns the
/// Jacobian and the Hessian of each row in `[q; v]`.
#[derive(Clone, Debug)]
pub struct PyConstraint {
    object: Arc<Py<PyAny>>,
    rows: usize,
    scales: Vec<f64>,
    names: Vec<String>,
    raised: Raised,
}

impl PyConstraint {
    /// A constraint with its number of rows; `scales` and `names` are optional attributes.
    pub fn new(object: &Bound<'_, PyAny>, raised: Raised) -> PyResult<Self> {
        let rows = object.getattr("rows")?.extract()?;
        let scales = match object.getattr_opt("scales")? {
            Some(scales) => {
                let scales = array(&scales, "scales", &[rows])?;
                scales.as_array().iter().copied().collect()
            }
            None => vec![1.0; rows],
        };
        let names: Vec<String> = match object.getattr_opt("names")? {
            Some(names) => names.extract()?,
            None => Vec::new(),
        };
        if !names.is_empty() && names.len() != rows {
            let message = format!("names: it has {} entries, expected {rows}", names.len());
            return Err(PyValueError::new_err(message));
        }
        Ok(Self { object: Arc::new(object.clone().unbind()), rows, scales, names, raised })
    }

    fn call<'py>(&self, py: Python<'py>, method: &str, x: &[f64]) -> PyResult<Bound<'py, PyAny>> {
        let (q, v) = x.split_at(x.len() / 2);
        let [q, v] = [q, v].map(|x| PyArray1::from_slice(py, x));
        self.object.bind(py).call_method1(method, (q, v))
    }

    fn value_of(&self, x: &[f64]) -> PyResult<Vec<f64>> {
        Python::attach(|py| {
            let g = array(&self.call(py, "value", x)?, "value", &[self.rows])?;
            Ok(g.as_array().iter().copied().collect())
        })
    }

    /// The gradient with weights `w`, and the Hessian with these weights and the weights `c` of the products of
    /// gradients.
    fn contraction(&self, x: &[f64], w: &[f64], c: Option<&[f64]>) -> PyResult<(DVector<f64>, DMatrix<f64>)> {
        Python::attach(|py| {
            let m = x.len();
            let found = self.call(py, "derivatives", x)?;
            let found = found.cast::<PyTuple>()?;
            let jacobian = array(&found.get_item(0)?, "jacobian", &[self.rows, m])?;
            let hessians = array(&found.get_item(1)?, "hessians", &[self.rows, m, m])?;
            let (jacobian, hessians) = (jacobian.as_array(), hessians.as_array());
            let mut gradient = DVector::zeros(m);
            let mut hessian = DMatrix::zeros(m, m);
            for (row, w) in w.iter().enumerate() {
                let by_x = DVector::from_fn(m, |i, _| jacobian[[row, i]]);
                gradient.axpy(*w, &by_x, 1.0);
                if let Some(c) = c {
                    hessian.ger(c[row], &by_x, &by_x, 1.0);
                    hessian += DMatrix::from_fn(m, m, |i, j| w * hessians[[row, i, j]]);
                }
            }
            Ok((gradient, hessian))
        })
    }

    /// The error for a scalar type that Python cannot evaluate.
    fn refused<S>() -> Error {
        let condition = "a constraint in Python is evaluated over float64 alone: methods that differentiate its \
            values by dual numbers cannot take it";
        Error::input("Python", std::any::type_name::<S>(), condition)
    }
}

/// The number of lanes of a supported scalar.
fn lanes_of<S: Scalar>() -> Result<usize> {
    let zero = S::zero();
    let zero = &zero as &dyn Any;
    if zero.is::<f64>() {
        Ok(1)
    } else if zero.is::<Wide>() {
        Ok(LANES)
    } else {
        Err(PyConstraint::refused::<S>())
    }
}

/// One lane of numbers.
fn lane<S: Scalar>(all: &[S], lane: usize) -> Vec<f64> {
    let one = |x: &S| {
        let x = x as &dyn Any;
        let alone = x.downcast_ref::<f64>().copied();
        alone.or_else(|| x.downcast_ref::<Wide>().map(|wide| wide.0[lane]))
    };
    all.iter().filter_map(one).collect()
}

/// Writes one lane of numbers.
fn put<'s, S: Scalar>(to: impl IntoIterator<Item = &'s mut S>, lane: usize, from: &[f64]) {
    for (to, x) in to.into_iter().zip(from) {
        let to = to as &mut dyn Any;
        if let Some(to) = to.downcast_mut::<f64>() {
            *to = *x;
        } else if let Some(to) = to.downcast_mut::<Wide>() {
            to.0[lane] = *x;
        }
    }
}

impl Constraint for PyConstraint {
    fn dim(&self) -> usize {
        self.rows
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> Result<()> {
        for i in 0..lanes_of::<S>()? {
            let found = self.value_of(&lane(at.x, i));
            put(&mut *g, i, &self.raised.keep(found, "constraint.value")?);
        }
        Ok(())
    }

    fn row_set(&self, row: usize) -> RowSet {
        RowSet::at_most_zero().scaled(self.scales.get(row).copied().unwrap_or(1.0))
    }

    fn label(&self, row: usize, _: &Model) -> RowLabel {
        match self.names.get(row) {
            Some(name) => RowLabel::new(name.clone(), "", Quantity::Other),
            None => RowLabel::numbered(row),
        }
    }

    fn add_weighted_derivatives<S: AlgebraOver<f64>>(
        &self,
        at: &PlacedState<'_, f64, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let Weights { first_order: w, gauss_newton: c } = weights;
        let none = |weights: &[S]| weights.iter().all(Scalar::vanishes);
        if none(w) && c.is_none_or(none) {
            return Ok(());
        }
        let m = at.x.len();
        let (mut gradient, mut hessian) = (DVector::zeros(m), DMatrix::zeros(m, m));
        for i in 0..lanes_of::<S>()? {
            let c = c.map(|c| lane(c, i));
            let found = self.contraction(&lane(at.x, i), &lane(w, i), c.as_deref());
            let found = self.raised.keep(found, "constraint.derivatives")?;
            put(gradient.iter_mut(), i, found.0.as_slice());
            put(hessian.iter_mut(), i, found.1.as_slice());
        }
        out.add_dense(&gradient, &hessian)
    }
}
