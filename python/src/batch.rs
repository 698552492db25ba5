//! Functions of states over batches of them.
//!
//! An argument has the shape `(N,)` for one state or `(batch, N)` for several, in which case all have; results have the same leading
//! dimension. Nothing is copied: rows of contiguous arrays are read where they are, and numpy takes over the vectors that were filled.

use crate::error::raised;
use aghf::Result;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

/// Numbers from Python.
pub type Numbers<'py> = PyReadonlyArrayDyn<'py, f64>;

/// An array for Python.
pub type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// An argument with its name and the number of its entries per state.
pub type Argument<'a, 'py> = (&'static str, &'a Numbers<'py>, usize);

/// The number of states from which on a batch is spread over threads.
const LEAST_PARALLEL: usize = 64;

/// The number of states that a thread takes at once.
const CHUNK: usize = 16;

/// Computes arrays of these shapes per state from arguments. `work` gets the rows of one state and room for its results, and something of
/// `scratch`, which is made once per thread. Python runs on meanwhile.
pub fn over_states<'py, T, const I: usize, const O: usize>(
    py: Python<'py>,
    arguments: [Argument<'_, 'py>; I],
    shapes: [&[usize]; O],
    scratch: impl Fn() -> T + Sync,
    work: impl Fn(&mut T, [&[f64]; I], &mut [&mut [f64]; O]) -> Result<()> + Sync,
) -> PyResult<[Array<'py>; O]> {
    let batch = batch_of(&arguments)?;
    let states = batch.unwrap_or(1);
    let mut inputs: [(&[f64], usize); I] = [(&[], 0); I];
    for (input, (name, array, width)) in inputs.iter_mut().zip(&arguments) {
        let refuse = |_| PyValueError::new_err(format!("{name}: it is not contiguous"));
        *input = (array.as_slice().map_err(refuse)?, *width);
    }
    let sizes = shapes.map(|shape| shape.iter().product::<usize>());
    let mut filled = sizes.map(|size| vec![0.0; size * states]);
    let computed = py.detach(|| {
        let mut i = 0;
        let mut rows_of = filled.each_mut().map(|all| {
            i += 1;
            all.chunks_exact_mut(sizes[i - 1].max(1))
        });
        let row = |_| {
            rows_of
                .each_mut()
                .map(|rows| rows.next().unwrap_or_default())
        };
        let mut rows: Vec<[&mut [f64]; O]> = (0..states).map(row).collect();
        let one = |scratch: &mut T, (state, row): (usize, &mut [&mut [f64]; O])| {
            let own = inputs.map(|(all, width)| &all[state * width..][..width]);
            work(scratch, own, row)
        };
        if states < LEAST_PARALLEL {
            let mut scratch = scratch();
            let mut all = rows.iter_mut().enumerate();
            return all.try_for_each(|state| one(&mut scratch, state));
        }
        let all = rows.par_iter_mut().enumerate().with_min_len(CHUNK);
        all.try_for_each_init(&scratch, one)
    });
    computed.map_err(raised)?;
    let mut arrays = Vec::with_capacity(O);
    for (values, shape) in filled.into_iter().zip(shapes) {
        let shape: Vec<usize> = batch.iter().chain(shape).copied().collect();
        arrays.push(PyArray1::from_vec(py, values).reshape(shape)?);
    }
    // There are as many as there are shapes.
    arrays
        .try_into()
        .map_err(|_| PyValueError::new_err("results were lost"))
}

/// The number of states of all arguments; `None` of one without a leading dimension.
fn batch_of(arguments: &[Argument<'_, '_>]) -> PyResult<Option<usize>> {
    let mut common: Option<Option<usize>> = None;
    for (name, array, width) in arguments {
        let batch = match array.shape() {
            [entries] if entries == width => None,
            [batch, entries] if entries == width => Some(*batch),
            shape => {
                let message = format!(
                    "{name}: its shape is {shape:?}, expected [{width}] or [batch, {width}]"
                );
                return Err(PyValueError::new_err(message));
            }
        };
        match common {
            Some(common) if common != batch => {
                let words = |batch: Option<usize>| {
                    batch.map_or("one state".to_owned(), |batch| format!("{batch} states"))
                };
                let message = format!(
                    "{name}: it has {}, the arguments before it {}",
                    words(batch),
                    words(common)
                );
                return Err(PyValueError::new_err(message));
            }
            _ => common = Some(batch),
        }
    }
    Ok(common.flatten())
}

/// Writes a matrix row by row.
pub fn by_rows(matrix: &nalgebra::DMatrix<f64>, out: &mut [f64]) {
    let columns = matrix.ncols().max(1);
    for (i, row) in out.chunks_exact_mut(columns).enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = matrix[(i, j)];
        }
    }
}
