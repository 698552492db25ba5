//! The primal-dual equations, condensed to the unknowns.

use super::{Options, Progress, Saddle};
use crate::linalg::{BlockTridiagonal, Scratch, assign};
use nalgebra::{DMatrix, DVector};

/// The number of inverse iterations, after which the direction mixes few eigenvectors.
const INVERSE_ITERATIONS: usize = 30;

/// The rounding of the terms of multipliers, relative to the gradient, above which equalities count as dependent: their
/// multipliers are then large numbers that cancel. It is 1e-5 as for the error of the equations in WB (3.10).
const INACCURATE: f64 = 1e-5;

/// The largest multiple of the first shift.
const LARGEST_SHIFT: f64 = 1e13;

/// A symmetric matrix of a block-tridiagonal part with a border of a few rows and columns.
#[derive(Clone, Debug)]
pub struct Bordered {
    pub matrix: BlockTridiagonal<f64>,
    /// The columns of the border.
    pub border: DMatrix<f64>,
    /// The corner, as many rows and columns as the border has columns; of its factor the lower triangle.
    pub corner: DMatrix<f64>,
}

/// The gradient and the condensed matrix of the equations, with the norm in which steps are measured.
pub struct Kkt {
    pub gradient: DVector<f64>,
    pub hessian: Bordered,
    /// The equalities, if they are those of the [saddle-point equations](super::Nlp::has_filter).
    pub equalities: Saddle,
    pub(super) norm: Bordered,
    factor: Bordered,
    memory: Memory,
    /// The last multiple of the norm that was added to an indefinite matrix.
    regularisation: f64,
    /// The smallest multiple to be tried.
    floor: f64,
}

/// Memory of factorisations and products.
#[derive(Default)]
struct Memory {
    scratch: Scratch,
    /// The border before a factorisation, and one of its columns.
    border: DMatrix<f64>,
    column: DVector<f64>,
    /// A product, and the last step.
    product: DVector<f64>,
    step: DVector<f64>,
}

impl Memory {
    /// Memory for a matrix.
    pub fn new(matrix: &Bordered) -> Self {
        Self {
            column: DVector::zeros(matrix.border.nrows()),
            product: DVector::zeros(matrix.order()),
            ..Self::default()
        }
    }
}

/// A Newton step.
pub struct Step {
    pub x: DVector<f64>,
    /// The product of gradient and step.
    pub slope: f64,
    /// The changes of the multipliers of the equalities.
    pub multipliers: DVector<f64>,
}

impl Bordered {
    /// A matrix with this number of rows and columns of zeros in its border.
    pub fn with_border(matrix: BlockTridiagonal<f64>, columns: usize) -> Self {
        Self { border: DMatrix::zeros(matrix.order(), columns), matrix, corner: DMatrix::zeros(columns, columns) }
    }

    /// The number of rows.
    pub fn order(&self) -> usize {
        self.border.nrows() + self.border.ncols()
    }

    /// Sets the matrix to `a + factor b`.
    pub(crate) fn set_sum(&mut self, a: &Self, factor: f64, b: &Self) {
        self.matrix.set_sum(&a.matrix, factor, &b.matrix);
        let sum = |to: &mut f64, a: f64, b: f64| *to = a + b * factor;
        self.border.zip_zip_apply(&a.border, &b.border, sum);
        self.corner.zip_zip_apply(&a.corner, &b.corner, sum);
    }

    /// Replaces the matrix by its factor; the border becomes the solution for it, and the corner the Cholesky factor of
    /// the Schur complement. Returns false if the matrix is not positive definite.
    fn factorise(&mut self, memory: &mut Memory) -> bool {
        if !self.matrix.factorise_in(&mut memory.scratch) {
            return false;
        }
        if self.border.ncols() == 0 {
            return true;
        }
        assign(&mut memory.border, &self.border);
        for (known, mut column) in memory.border.column_iter().zip(self.border.column_iter_mut()) {
            memory.column.copy_from(&known);
            self.matrix.solve(&mut memory.column);
            column.copy_from(&memory.column);
        }
        self.corner.gemm_tr(-1.0, &memory.border, &self.border, 1.0);
        cholesky(&mut self.corner)
    }

    /// Replaces `b` by the solution; requires [`factorise`](Self::factorise).
    pub(crate) fn solve(&self, b: &mut DVector<f64>) {
        let n = self.border.nrows();
        if self.border.ncols() == 0 {
            self.matrix.solve(b);
            return;
        }
        let (head, mut tail) = b.rows_range_pair_mut(..n, n..);
        tail.gemv_tr(-1.0, &self.border, &head, 1.0);
        // A pivot of a factor is not zero.
        self.corner.solve_lower_triangular_mut(&mut tail);
        self.corner.tr_solve_lower_triangular_mut(&mut tail);
        self.matrix.solve(b);
        let (mut head, tail) = b.rows_range_pair_mut(..n, n..);
        head.gemv(-1.0, &self.border, &tail, 1.0);
    }

    /// The product with a vector.
    pub fn product(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut y = DVector::zeros(x.len());
        self.product_into(x, &mut y);
        y
    }

    /// Computes the product with a vector into `y`.
    fn product_into(&self, x: &DVector<f64>, y: &mut DVector<f64>) {
        let (n, own) = (self.border.nrows(), self.border.ncols());
        y.fill(0.0);
        self.matrix.add_product(x, y);
        if own > 0 {
            let (head, tail) = (x.rows(0, n), x.rows(n, own));
            y.rows_mut(0, n).gemv(1.0, &self.border, &tail, 1.0);
            let mut below = y.rows_mut(n, own);
            below.gemv_tr(1.0, &self.border, &head, 0.0);
            below.gemv(1.0, &self.corner, &tail, 1.0);
        }
    }
}

impl Kkt {
    /// Zeros, with the norm of steps. `None` if the norm is not positive definite.
    pub fn new(norm: Bordered) -> Option<Self> {
        let mut kkt = Self::with_norm(norm);
        kkt.factor.factorise(&mut kkt.memory).then_some(kkt)
    }

    /// Zeros, with a norm that need not be positive definite.
    pub(crate) fn with_norm(norm: Bordered) -> Self {
        Self {
            gradient: DVector::zeros(norm.order()),
            hessian: norm.clone(),
            equalities: Saddle::default(),
            factor: norm.clone(),
            memory: Memory::new(&norm),
            norm,
            regularisation: 0.0,
            floor: 0.0,
        }
    }

    /// Begins anew after `change` of the corner of the norm, which remains positive definite.
    pub(crate) fn restart(&mut self, change: impl FnOnce(&mut DMatrix<f64>)) {
        change(&mut self.norm.corner);
        (self.regularisation, self.floor) = (0.0, 0.0);
    }

    /// Adapts the smallest multiple of the norm to the fraction of the last step that was taken, as the radius of a
    /// trust region would be: short fractions show that the quadratic model does not hold that far.
    pub fn adapt(&mut self, alpha: f64, used: f64, options: &Options) {
        let [_, more, less] = options.regularisation_factors;
        self.floor = if alpha < options.short_fraction {
            more * used.max(options.smallest_regularisation)
        } else if alpha > options.long_fraction {
            less * self.floor
        } else {
            self.floor
        };
        if self.floor < options.smallest_regularisation {
            self.floor = 0.0;
        }
    }

    /// Factorises the matrix with a multiple of the norm; returns false if it has not the inertia of a minimum.
    fn factorise(&mut self, multiple: f64, scale: f64) -> bool {
        self.factor.set_sum(&self.hessian, multiple, &self.norm);
        if self.equalities.is_empty() {
            self.factor.factorise(&mut self.memory)
        } else {
            self.equalities.factorise(&self.factor, scale)
        }
    }

    /// A direction of length 1 along the equalities with negative curvature of the condensed matrix; `None` at a
    /// minimum.
    pub fn negative_curvature(&mut self, scale: f64) -> Option<DVector<f64>> {
        if self.factorise(0.0, scale) {
            return None;
        }
        let (curvature, direction) = self.smallest_curvature(scale, 0.0);
        (curvature < 0.0).then_some(direction)
    }

    /// The smallest curvature of the condensed matrix along the equalities relative to the norm, with its direction, by
    /// inverse iteration, shifted beyond it by a multiple of the norm: `first` or more. It ends when the distance from
    /// the shift changes by less than this part.
    pub(crate) fn smallest_curvature(&mut self, first: f64, settled: f64) -> (f64, DVector<f64>) {
        let mut shift = 0.0;
        while !self.factorise(shift, first) && shift < LARGEST_SHIFT * first {
            shift = (4.0 * shift).max(first);
        }
        let mut x = DVector::from_fn(self.gradient.len(), |i, _| (1.0 + i as f64).sin());
        let (mut curvature, mut none) = (f64::INFINITY, DVector::zeros(self.equalities.values.len()));
        for _ in 0..INVERSE_ITERATIONS {
            self.norm.product_into(&x, &mut self.memory.product);
            x.copy_from(&self.memory.product);
            none.fill(0.0);
            self.solve(&mut x, &mut none);
            x /= self.length(&x);
            let now = x.dot(&self.hessian.product(&x));
            let before = std::mem::replace(&mut curvature, now);
            if (before - now).abs() < settled * (now + shift).abs() {
                break;
            }
        }
        (curvature, x)
    }

    /// The length of the gradient in the dual norm.
    pub fn dual_length(&mut self) -> f64 {
        self.factor.set_sum(&self.norm, 0.0, &self.norm);
        if !self.factor.factorise(&mut self.memory) {
            return f64::INFINITY;
        }
        let x = &mut self.memory.product;
        x.copy_from(&self.gradient);
        self.factor.solve(x);
        self.gradient.dot(x).sqrt()
    }

    /// The length of a step.
    pub fn length(&mut self, step: &DVector<f64>) -> f64 {
        self.norm.product_into(step, &mut self.memory.product);
        step.dot(&self.memory.product).sqrt()
    }

    /// The Newton step with the smallest tried multiple of the norm for which the matrix is positive definite (WB,
    /// algorithm IC); `None` if there is none. It should be [returned](Self::reuse), so that the next step needs no new
    /// memory.
    pub fn step(&mut self, scale: f64, progress: &mut Progress, options: &Options) -> Option<Step> {
        let [first, later, less] = options.regularisation_factors;
        let known = self.regularisation;
        let mut multiple = self.floor;
        progress.factorisations = 0;
        let mut x = std::mem::take(&mut self.memory.step);
        let multipliers = loop {
            progress.factorisations += 1;
            if self.factorise(multiple * scale, scale)
                && let Some(multipliers) = self.newton(scale, &mut x)
            {
                break multipliers;
            }
            multiple = if multiple > 0.0 && multiple == self.floor {
                (later * multiple).max(less * known)
            } else if multiple == 0.0 && known == 0.0 {
                options.first_regularisation
            } else if multiple == 0.0 {
                (less * known).max(f64::EPSILON)
            } else if known == 0.0 {
                first * multiple
            } else {
                later * multiple
            };
            if multiple.is_nan() || multiple > options.largest_regularisation {
                return None;
            }
        };
        if multiple > 0.0 {
            self.regularisation = multiple;
        }
        progress.regularisation = multiple;
        let slope = self.gradient.dot(&x);
        progress.step = self.length(&x);
        // The energy of the step, which may be negative across equalities.
        let energy = multipliers.dot(&self.equalities.values) - slope;
        let energy = if self.equalities.is_empty() { energy } else { energy.abs() };
        progress.stationarity = (energy / scale).sqrt();
        Some(Step { x, slope, multipliers })
    }

    /// Computes the Newton step by the last factor into `x`, and the changes of the multipliers; `None` if the inertia
    /// is not that of a minimum after all, as rounding hid that equalities are dependent.
    fn newton(&mut self, scale: f64, x: &mut DVector<f64>) -> Option<DVector<f64>> {
        loop {
            assign(x, &self.gradient);
            x.neg_mut();
            let mut multipliers = -&self.equalities.values;
            self.solve(x, &mut multipliers);
            if self.equalities.is_empty() {
                return Some(multipliers);
            }
            self.refine(x, &mut multipliers);
            let size = self.gradient.amax().max(self.factor.product(x).amax());
            let is_accurate = self.equalities.rounding(&multipliers) <= INACCURATE * size;
            if is_accurate || self.equalities.is_relaxed() {
                return Some(multipliers);
            }
            if !self.equalities.relax(&self.factor, scale) {
                return None;
            }
        }
    }

    /// One step of iterative refinement of the solution with equalities, whose factor leaves the matrix as it is.
    fn refine(&self, x: &mut DVector<f64>, multipliers: &mut DVector<f64>) {
        let [mut b, mut e] = [-&self.gradient, -&self.equalities.values];
        b -= self.factor.product(x);
        self.equalities.subtract([x, multipliers], &mut b, &mut e);
        self.equalities.solve(&mut b, &mut e);
        *x += b;
        *multipliers += e;
    }

    /// Replaces `b` and `e` by the solution for the matrices of the last step; see [`Saddle::solve`].
    pub(super) fn solve(&self, b: &mut DVector<f64>, e: &mut DVector<f64>) {
        if self.equalities.is_empty() {
            self.factor.solve(b);
        } else {
            self.equalities.solve(b, e);
        }
    }

    /// Keeps the memory of a step.
    pub fn reuse(&mut self, step: Step) {
        self.memory.step = step.x;
    }
}

/// Replaces the lower triangle of a small matrix by its Cholesky factor; returns true if it is positive definite.
fn cholesky(a: &mut DMatrix<f64>) -> bool {
    for j in 0..a.nrows() {
        for k in 0..j {
            let factor = a[(j, k)];
            for i in j..a.nrows() {
                a[(i, j)] -= factor * a[(i, k)];
            }
        }
        let pivot = a[(j, j)].sqrt();
        // False for NaN.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return false;
        }
        a[(j, j)] = pivot;
        for i in j + 1..a.nrows() {
            a[(i, j)] /= pivot;
        }
    }
    true
}
