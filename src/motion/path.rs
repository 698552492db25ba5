//! A curve in a basis.

use super::Problem;
use crate::curve::{Basis, Chebyshev, Continuity, Curve, Fit, Functions, Local};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The relative sizes of the random bends of successive starts.
const SIZES: [f64; 4] = [1.0, 0.5, 1.5, 1.0];

/// A curve in a basis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    pub basis: Basis,
    /// The coefficients, `N` by [`Basis::count`].
    pub coefficients: DMatrix<f64>,
}

/// Memory of values of paths.
#[derive(Clone, Debug, Default)]
pub(crate) struct PathMemory {
    functions: Functions,
    fit: Fit,
    local: Local,
}

impl PathMemory {
    /// The configuration and its first two derivatives at a normalised time.
    pub fn evaluate(&mut self, path: &Path, time: f64) -> &Local {
        let n = path.coefficients.nrows();
        if self.local[0].len() != n {
            self.local = [(); 3].map(|()| DVector::zeros(n));
        }
        let Self { functions, local, .. } = self;
        path.basis.evaluate_in(&path.coefficients, time, functions, local);
        local
    }
}

impl Path {
    /// The polynomial of least degree between the boundary states of the problem; continuous accelerations are zero at
    /// its ends unless they are given.
    pub fn line(problem: &Problem<'_>, basis: Basis) -> Self {
        let ends = Continuity {
            free_final_velocity: false,
            free_final_position: false,
            free_start: false,
            ..basis.continuity()
        };
        let least = Basis::new(1, ends.smallest_degree() - 1, ends);
        let coefficients = DMatrix::zeros(problem.model().dof(), least.count());
        let least = Self { basis: least, coefficients };
        least.between_ends_of(problem).in_basis(basis)
    }

    /// The same curve, or its best approximation, in another basis.
    pub fn in_basis(&self, basis: Basis) -> Self {
        let dof = self.coefficients.nrows();
        let coefficients = basis.fit(dof, |time| self.basis.evaluate(&self.coefficients, time));
        Self { basis, coefficients }
    }

    /// Computes the coefficients of the rest of a path on one segment after this share of it, from 0 to less than 1, as
    /// a path of its own: the same polynomial in other coefficients.
    pub fn after_in(&self, share: f64, memory: &mut PathMemory, coefficients: &mut DMatrix<f64>) {
        let left = 1.0 - share;
        let PathMemory { functions, fit, .. } = memory;
        let rest = |time: f64, local: &mut Local| {
            let time = share + left * time;
            let own = &self.coefficients;
            self.basis.evaluate_in(own, time, functions, local);
            local[1] *= left;
            local[2] *= left * left;
        };
        self.basis.fit_in(rest, fit, coefficients);
    }

    /// The states along a curve, `2 N` coefficients per function, or their best approximation in a basis whose slopes
    /// may jump.
    pub fn of_states(curve: &Curve, basis: Basis) -> Self {
        let (rows, horizon) = (curve.x().nrows(), curve.horizon());
        let coefficients = basis.fit(rows, |time| {
            let (x, xdot) = curve.at(time * horizon);
            [x, xdot * horizon, DVector::zeros(rows)]
        });
        Self { basis, coefficients }
    }

    /// The curve with these states.
    pub fn curve_of_states(&self, horizon: f64) -> Result<Curve> {
        let (basis, p) = (&self.basis, self.basis.degree());
        let nodes = Chebyshev::new(p, 1.0)?;
        let mut x = DMatrix::zeros(self.coefficients.nrows(), basis.segments() * (p + 1));
        for e in 0..basis.segments() {
            for (node, time) in nodes.times().iter().enumerate() {
                let state = match node {
                    0 => self.coefficients.column(basis.value(e)).into_owned(),
                    _ if node == p => self.coefficients.column(basis.value(e + 1)).into_owned(),
                    _ => {
                        let time = (e as f64 + time) / basis.segments() as f64;
                        let [state, ..] = basis.evaluate(&self.coefficients, time);
                        state
                    }
                };
                x.set_column(e * (p + 1) + node, &state);
            }
        }
        Curve::piecewise(horizon, basis.segments(), x)
    }

    /// The start with this number: the curve itself for zero, otherwise the curve with random bends of varying size.
    pub fn start(&self, amplitude: f64, seed: u64, number: u64) -> Self {
        if number == 0 {
            return self.clone();
        }
        let size = SIZES[number as usize % SIZES.len()];
        let size = amplitude * size;
        let mut rng = ChaCha8Rng::seed_from_u64(number);
        rng.set_stream(seed);
        self.bent(size, &mut rng)
    }

    /// Adds bends: each joint is moved by random multiples of the bubbles, up to `size` for the longest one.
    fn bent(&self, size: f64, rng: &mut ChaCha8Rng) -> Self {
        let mut bent = self.clone();
        let times = (0..=64).map(|i| i as f64 / 32.0 - 1.0);
        let tables: Vec<_> = times.map(|s| self.basis.local(s)).collect();
        let first = self.basis.continuity().order();
        for k in first..=self.basis.degree() - first {
            let heights = tables.iter().map(|table| table[(0, k)].abs());
            let height = heights.fold(0.0, f64::max);
            for j in 0..bent.coefficients.nrows() {
                let share: f64 = rng.random_range(-1.0..1.0);
                bent.coefficients[(j, k)] += size * share / ((k + 1 - first) as f64 * height);
            }
        }
        bent
    }

    /// The first two derivatives of the coefficients in a horizon `T`: those of given velocities `v` are $T v$, and
    /// those of given accelerations $T^2 a$.
    pub fn rates(&self, problem: &Problem<'_>, horizon: f64) -> [DMatrix<f64>; 2] {
        let (n, count) = self.coefficients.shape();
        let mut rates = [(); 2].map(|()| DMatrix::zeros(n, count));
        self.rates_in(problem, horizon, &mut rates);
        rates
    }

    /// Computes [`rates`](Self::rates), which are zero elsewhere.
    pub fn rates_in(&self, problem: &Problem<'_>, horizon: f64, [first, second]: &mut [DMatrix<f64>; 2]) {
        let n = self.coefficients.nrows();
        let ends = [problem.start(), problem.goal()];
        for (column, end) in self.basis.fixed_slopes() {
            first.column_mut(column).copy_from_slice(&ends[end][n..]);
        }
        for (column, end) in self.basis.fixed_accelerations() {
            let Some(a) = &problem.accelerations()[end] else { continue };
            for (i, a) in a.iter().enumerate() {
                (first[(i, column)], second[(i, column)]) = (2.0 * horizon * a, 2.0 * a);
            }
        }
    }

    /// The same shape between the boundary states of a problem, on the horizon of the problem. A free final position is
    /// kept.
    pub fn between_ends_of(mut self, problem: &Problem<'_>) -> Self {
        self.set_ends(problem);
        self
    }

    /// Moves the ends to the boundary states of a problem, on the horizon of the problem, except those that are free.
    pub fn set_ends(&mut self, problem: &Problem<'_>) {
        let n = self.coefficients.nrows();
        let ends = [problem.start(), problem.goal()];
        for (column, end) in self.basis.fixed_slopes() {
            let mut slope = self.coefficients.column_mut(column);
            slope.copy_from_slice(&ends[end][n..]);
            slope *= problem.horizon();
        }
        let last = self.basis.segments();
        let Continuity { free_final_position, free_start, .. } = self.basis.continuity();
        let ends = [(0, problem.start(), free_start), (last, problem.goal(), free_final_position)];
        for (end, state, _) in ends.into_iter().filter(|(.., free)| !free) {
            let mut q = self.coefficients.column_mut(self.basis.value(end));
            q.copy_from_slice(&state[..n]);
        }
        for (column, end) in self.basis.fixed_accelerations() {
            let mut second = self.coefficients.column_mut(column);
            match &problem.accelerations()[end] {
                Some(a) => second.copy_from_slice(a),
                None => second.fill(0.0),
            }
            second *= problem.horizon().powi(2);
        }
    }
}

/// The states $[q; v]$ at the Chebyshev nodes of all segments of a path, `2 N` by `p + 1` per segment, from
/// configuration and velocity at normalised times.
pub(crate) fn states_at_nodes(path: &Path, state: impl Fn(f64) -> [DVector<f64>; 2]) -> Result<DMatrix<f64>> {
    let (n, segments, p) = (path.coefficients.nrows(), path.basis.segments(), path.basis.degree());
    let chebyshev = Chebyshev::new(p, 1.0)?;
    let mut x = DMatrix::zeros(2 * n, segments * (p + 1));
    for e in 0..segments {
        for (node, time) in chebyshev.times().iter().enumerate() {
            // The same number, and so the same state, for both segments at a shared breakpoint.
            let [q, v] = state((e as f64 + time) / segments as f64);
            let column = e * (p + 1) + node;
            x.view_mut((0, column), (n, 1)).copy_from(&q);
            x.view_mut((n, column), (n, 1)).copy_from(&v);
        }
    }
    Ok(x)
}

/// Converts the path to polynomials through Chebyshev nodes, with $v = \dot q$.
pub(crate) fn curve_of(problem: &Problem<'_>, path: &Path) -> Result<Curve> {
    let (n, horizon) = (problem.model().dof(), problem.horizon());
    let segments = path.basis.segments();
    let mut x = states_at_nodes(path, |time| {
        let [q, slope, _] = path.basis.evaluate(&path.coefficients, time);
        [q, slope / horizon]
    })?;
    let last = x.ncols() - 1;
    let Continuity { free_final_position, free_final_velocity, free_start, .. } = path.basis.continuity();
    if !free_start {
        x.column_mut(0).copy_from_slice(problem.start());
    }
    for (free, own) in [(free_final_position, 0..n), (free_final_velocity, n..2 * n)] {
        if !free {
            let mut given = x.view_mut((own.start, last), (n, 1));
            given.copy_from_slice(&problem.goal()[own]);
        }
    }
    Curve::piecewise(horizon, segments, x)
}

/// The configuration of a curve in a basis.
pub(crate) fn path_of(curve: &Curve, basis: Basis) -> Path {
    let (n, parts) = (curve.dof(), curve.parts());
    let second: Vec<_> =
        (0..curve.segments()).map(|e| curve.segment(e) * curve.chebyshev(e).d2().transpose()).collect();
    let mut weights = DVector::zeros(curve.degree() + 1);
    let coefficients = basis.fit(n, |time| {
        let part = ((time * parts as f64) as usize).min(parts - 1);
        let horizon = curve.horizon_of(part);
        let begin = curve.breakpoints()[part * curve.segments() / parts];
        let time = begin + horizon * (time - part as f64 / parts as f64);
        let segment = curve.segment_at(time);
        let (x, xdot) = curve.at_in(segment, time);
        let chebyshev = curve.chebyshev(segment);
        chebyshev.interpolation(time - curve.breakpoints()[segment], &mut weights);
        let a = second[segment].rows(0, n) * &weights;
        let of_q = |x: &DVector<f64>, scale: f64| x.rows(0, n) * scale;
        [of_q(&x, 1.0), of_q(&xdot, horizon), a * horizon * horizon]
    });
    Path { basis, coefficients }
}
