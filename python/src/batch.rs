//! Functions of states, evaluated over batches.
//!
//! An argument has the shape `(N,)` for one state or `(batch, N)` for several, the same for all arguments; results have
//! the same leading dimension. Only values that enter SIMD lanes are copied: rows of contiguous arrays are read in
//! place, and numpy takes ownership of the result vectors.

use crate::error::raised;
use aghf::Result;
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, LANES, Scalar, Tanh, Wide};
use nalgebra::DMatrix;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::ops::Range;

/// Numbers from Python.
pub type Numbers<'py> = PyReadonlyArrayDyn<'py, f64>;

/// The numbers of an argument.
pub fn numbers<'n>(name: &str, given: &'n Numbers<'_>) -> PyResult<&'n [f64]> {
    let refuse = |_| PyValueError::new_err(format!("{name}: it is not contiguous"));
    given.as_slice().map_err(refuse)
}

/// An array for Python.
pub type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// The smallest batch that is spread over threads.
const MIN_PARALLEL: usize = 64;

/// The smallest number of states that a thread takes at once.
const CHUNK: usize = 16;

/// The scalars of the dynamics and of the flow.
pub trait Number: AlgebraOver<f64> + Tanh {}
impl<S: AlgebraOver<f64> + Tanh> Number for S {}

/// A function of states of a robot, with `I` arguments and `O` results, over any scalar.
pub trait FunctionOfStates<const I: usize, const O: usize>: Sync {
    /// The scratch space, one per thread.
    type Scratch<'m, S: Number>;

    /// The names of the arguments.
    const NAMES: [&'static str; I];

    /// The number of entries of each argument, for a robot with `n` joints.
    fn widths(&self, n: usize) -> [usize; I];

    /// The shape of each result.
    fn shapes(&self, n: usize) -> [Vec<usize>; O];

    /// Allocates the scratch space.
    fn scratch<'m, S: Number>(&self, model: &'m Model) -> Self::Scratch<'m, S>;

    /// Fills the results, each row by row.
    fn evaluate<S: Number>(
        &self,
        model: &Model,
        scratch: &mut Self::Scratch<'_, S>,
        arguments: [&[S]; I],
        results: &mut [&mut [S]; O],
    ) -> Result<()>;
}

/// Evaluates a function at one state or at all states of a batch in SIMD lanes, with the GIL released.
pub fn over_states<'py, F: FunctionOfStates<I, O>, const I: usize, const O: usize>(
    py: Python<'py>,
    model: &Model,
    function: &F,
    arguments: [&Numbers<'py>; I],
) -> PyResult<[Array<'py>; O]> {
    let n = model.dof();
    let (widths, shapes) = (function.widths(n), function.shapes(n));
    let states = States::read(F::NAMES, arguments, widths)?;
    if states.count() == 1 {
        let scratch = || function.scratch(model);
        return states.evaluate(py, shapes, 1, scratch, |scratch, group, mut rows| {
            function.evaluate(model, scratch, states.row(group.start), &mut rows)
        });
    }
    let zeros = |size| vec![Wide::splat(0.0); size];
    let sizes = shapes.each_ref().map(|shape| size_of(shape));
    let scratch = || (function.scratch(model), widths.map(zeros), sizes.map(zeros));
    states.evaluate(py, shapes, LANES, scratch, |(scratch, inputs, outputs), group, rows| {
        for lane in 0..LANES {
            // Unused lanes repeat the last state.
            let own = states.row((group.start + lane).min(group.end - 1));
            for (to, from) in inputs.iter_mut().zip(own) {
                to.iter_mut().zip(from).for_each(|(to, x)| to.0[lane] = *x);
            }
        }
        let arguments = inputs.each_ref().map(Vec::as_slice);
        let mut results = outputs.each_mut().map(Vec::as_mut_slice);
        function.evaluate(model, scratch, arguments, &mut results)?;
        for (rows, from) in rows.into_iter().zip(outputs) {
            for (lane, row) in rows.chunks_exact_mut(from.len().max(1)).enumerate() {
                row.iter_mut().zip(&*from).for_each(|(to, x)| *to = x.0[lane]);
            }
        }
        Ok(())
    })
}

/// The arguments of a function at one state or several.
pub struct States<'a, const I: usize> {
    arguments: [&'a [f64]; I],
    widths: [usize; I],
    /// `None` without a leading dimension.
    batch: Option<usize>,
}

impl<'a, const I: usize> States<'a, I> {
    /// Checks the shapes of arguments with these numbers of entries per state.
    pub fn read(names: [&str; I], arguments: [&'a Numbers<'_>; I], widths: [usize; I]) -> PyResult<Self> {
        let batch = batch_of(&names, &arguments, &widths)?;
        let mut read: [&[f64]; I] = [&[]; I];
        for (read, (name, array)) in read.iter_mut().zip(names.iter().zip(arguments)) {
            *read = numbers(name, array)?;
        }
        Ok(Self { arguments: read, widths, batch })
    }

    /// The number of states.
    pub fn count(&self) -> usize {
        self.batch.unwrap_or(1)
    }

    /// The arguments at a state.
    pub fn row(&self, state: usize) -> [&'a [f64]; I] {
        std::array::from_fn(|i| &self.arguments[i][state * self.widths[i]..][..self.widths[i]])
    }

    /// Fills arrays of these shapes per state. `work` gets a group of at most `size` states, slices for all of their
    /// results, and a value of `scratch`, which is made once per thread.
    pub fn evaluate<'py, T, const O: usize>(
        &self,
        py: Python<'py>,
        shapes: [Vec<usize>; O],
        size: usize,
        scratch: impl Fn() -> T + Sync,
        work: impl Fn(&mut T, Range<usize>, [&mut [f64]; O]) -> Result<()> + Sync,
    ) -> PyResult<[Array<'py>; O]> {
        let states = self.count();
        let sizes = shapes.each_ref().map(|shape| size_of(shape));
        let mut filled = sizes.map(|size| vec![0.0; size * states]);
        let computed = py.detach(|| {
            let groups = groups(&mut filled, sizes.map(|entries| size * entries), states.div_ceil(size));
            let one = |scratch: &mut T, (group, rows): (usize, [&mut [f64]; O])| {
                let first = group * size;
                work(scratch, first..states.min(first + size), rows)
            };
            if states < MIN_PARALLEL {
                let mut scratch = scratch();
                let mut all = groups.into_iter().enumerate();
                return all.try_for_each(|group| one(&mut scratch, group));
            }
            let all = groups.into_par_iter().enumerate();
            let chunk = CHUNK.div_ceil(size);
            all.with_min_len(chunk).try_for_each_init(&scratch, one)
        });
        computed.map_err(raised)?;
        let mut arrays = Vec::with_capacity(O);
        for (values, shape) in filled.into_iter().zip(shapes) {
            let shape: Vec<usize> = self.batch.into_iter().chain(shape).collect();
            arrays.push(PyArray1::from_vec(py, values).reshape(shape)?);
        }
        // There is one array per shape.
        arrays.try_into().map_err(|_| PyValueError::new_err("results were lost"))
    }
}

/// The number of entries of an array.
fn size_of(shape: &[usize]) -> usize {
    shape.iter().product()
}

/// The slices of each array, of these sizes, that belong to each group.
fn groups<const O: usize>(filled: &mut [Vec<f64>; O], sizes: [usize; O], count: usize) -> Vec<[&mut [f64]; O]> {
    let mut i = 0;
    let mut chunks = filled.each_mut().map(|all| {
        i += 1;
        all.chunks_mut(sizes[i - 1].max(1))
    });
    let next = |_| chunks.each_mut().map(|chunks| chunks.next().unwrap_or_default());
    (0..count).map(next).collect()
}

/// The number of states, which all arguments share; `None` for one without a leading dimension.
fn batch_of(names: &[&str], arguments: &[&Numbers<'_>], widths: &[usize]) -> PyResult<Option<usize>> {
    let mut common: Option<Option<usize>> = None;
    for ((name, array), width) in names.iter().zip(arguments).zip(widths) {
        let batch = match array.shape() {
            [entries] if entries == width => None,
            [batch, entries] if entries == width => Some(*batch),
            shape => {
                let message = format!("{name}: its shape is {shape:?}, expected [{width}] or [batch, {width}]");
                return Err(PyValueError::new_err(message));
            }
        };
        match common {
            Some(common) if common != batch => {
                let words =
                    |batch: Option<usize>| batch.map_or("one state".to_owned(), |batch| format!("{batch} states"));
                let message = format!("{name}: it has {}, the arguments before it {}", words(batch), words(common));
                return Err(PyValueError::new_err(message));
            }
            _ => common = Some(batch),
        }
    }
    Ok(common.flatten())
}

/// Writes each matrix row by row into its result.
pub fn by_rows<S: Scalar, const K: usize>(matrices: [&DMatrix<S>; K], results: &mut [&mut [S]]) {
    for (matrix, result) in matrices.into_iter().zip(results) {
        let columns = matrix.ncols().max(1);
        for (i, row) in result.chunks_exact_mut(columns).enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = matrix[(i, j)];
            }
        }
    }
}

/// Declares a function of states and its Python function, which returns a list of the results:
/// `fn name(model, n; argument: width, ...) -> [shape, ...]`, its scratch over the scalar `S`, and what it computes.
macro_rules! function_of_states {
    (
        $(#[$doc:meta])*
        fn $name:ident as $type:ident($model:ident, $n:ident; $($argument:ident: $width:expr),+) -> [$($shape:expr),+]
        $scratch:ident: $scratch_type:ty = $new:expr;
        $results:ident => $body:expr
    ) => {
        struct $type;

        impl $crate::batch::FunctionOfStates<
            { [$(stringify!($argument)),+].len() },
            { [$(stringify!($shape)),+].len() },
        > for $type {
            type Scratch<'m, S: $crate::batch::Number> = $scratch_type;

            const NAMES: [&'static str; [$(stringify!($argument)),+].len()] = [$(stringify!($argument)),+];

            fn widths(&self, $n: usize) -> [usize; [$(stringify!($argument)),+].len()] {
                [$($width),+]
            }

            fn shapes(&self, $n: usize) -> [Vec<usize>; [$(stringify!($shape)),+].len()] {
                let _ = $n;
                [$($shape.to_vec()),+]
            }

            fn scratch<S: $crate::batch::Number>(&self, $model: &Model) -> $scratch_type {
                let $n = $model.dof();
                let _ = $n;
                $new
            }

            fn evaluate<S: $crate::batch::Number>(
                &self,
                $model: &Model,
                $scratch: &mut $scratch_type,
                [$($argument),+]: [&[S]; [$(stringify!($argument)),+].len()],
                $results: &mut [&mut [S]; [$(stringify!($shape)),+].len()],
            ) -> Result<()> {
                $body
            }
        }

        $(#[$doc])*
        #[pyfunction]
        fn $name<'py>(
            py: Python<'py>,
            model: &PyModel,
            $($argument: Numbers<'py>),+
        ) -> PyResult<[Array<'py>; [$(stringify!($shape)),+].len()]> {
            over_states(py, &model.model, &$type, [$(&$argument),+])
        }
    };
}
pub(crate) use function_of_states;
