//! The primal-dual equations, condensed to the unknowns.

use super::{Options, Progress};
use crate::linalg::BlockTridiagonal;
use nalgebra::{Cholesky, DMatrix, DVector};

/// The number of inverse iterations, after which the direction mixes few eigenvectors.
const INVERSE_ITERATIONS: usize = 30;

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
    norm: Bordered,
    factor: Bordered,
    /// The last multiple of the norm that was added to an indefinite matrix.
    regularisation: f64,
    /// The smallest multiple to be tried.
    floor: f64,
}

/// A Newton step.
pub struct Step {
    pub x: DVector<f64>,
    /// The product of gradient and step.
    pub slope: f64,
}

impl Bordered {
    /// A matrix without a border.
    pub fn without_border(matrix: BlockTridiagonal<f64>) -> Self {
        let (border, corner) = (DMatrix::zeros(matrix.order(), 0), DMatrix::zeros(0, 0));
        Self {
            matrix,
            border,
            corner,
        }
    }

    /// The number of rows.
    pub fn order(&self) -> usize {
        self.border.nrows() + self.border.ncols()
    }

    /// Sets the matrix to `a + factor b`.
    fn set_sum(&mut self, a: &Self, factor: f64, b: &Self) {
        self.matrix.set_sum(&a.matrix, factor, &b.matrix);
        self.border = &a.border + &b.border * factor;
        self.corner = &a.corner + &b.corner * factor;
    }

    /// Replaces the matrix by its factor; the border becomes the solution for it, and the corner the Cholesky factor of
    /// the Schur complement. Returns false if the matrix is not positive definite.
    fn factorise(&mut self) -> bool {
        if !self.matrix.factorise() {
            return false;
        }
        if self.border.ncols() == 0 {
            return true;
        }
        let known = self.border.clone();
        for mut column in self.border.column_iter_mut() {
            let mut solution = column.clone_owned();
            self.matrix.solve(&mut solution);
            column.copy_from(&solution);
        }
        let complement = &self.corner - known.tr_mul(&self.border);
        let factor =
            Cholesky::new(complement).filter(|of| of.l_dirty().iter().all(|x| x.is_finite()));
        factor.map(|factor| self.corner = factor.unpack()).is_some()
    }

    /// Replaces `b` by the solution; requires [`factorise`](Self::factorise).
    fn solve(&self, b: &mut DVector<f64>) {
        let (n, own) = (self.border.nrows(), self.border.ncols());
        if own == 0 {
            self.matrix.solve(b);
            return;
        }
        let mut head = b.rows(0, n).into_owned();
        let mut tail = b.rows(n, own) - self.border.tr_mul(&head);
        // A pivot of a factor is not zero.
        self.corner.solve_lower_triangular_mut(&mut tail);
        self.corner.tr_solve_lower_triangular_mut(&mut tail);
        self.matrix.solve(&mut head);
        head.gemv(-1.0, &self.border, &tail, 1.0);
        b.rows_mut(0, n).copy_from(&head);
        b.rows_mut(n, own).copy_from(&tail);
    }

    /// The product with a vector.
    pub fn product(&self, x: &DVector<f64>) -> DVector<f64> {
        let (n, own) = (self.border.nrows(), self.border.ncols());
        if own == 0 {
            return self.matrix.product(x);
        }
        let (head, tail) = (x.rows(0, n).into_owned(), x.rows(n, own));
        let mut y = self.matrix.product(&head).insert_rows(n, own, 0.0);
        y.rows_mut(0, n).gemv(1.0, &self.border, &tail, 1.0);
        y.rows_mut(n, own)
            .copy_from(&(self.border.tr_mul(&head) + &self.corner * tail));
        y
    }
}

impl Kkt {
    /// Zeros, with the norm of steps. `None` if the norm is not positive definite.
    pub fn new(norm: Bordered) -> Option<Self> {
        let mut norm_factor = norm.clone();
        if !norm_factor.factorise() {
            return None;
        }
        Some(Self {
            gradient: DVector::zeros(norm.order()),
            hessian: norm.clone(),
            factor: norm.clone(),
            norm,
            regularisation: 0.0,
            floor: 0.0,
        })
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

    /// A direction of length 1 along which the condensed matrix has negative curvature; `None` at a minimum. By inverse
    /// iteration, shifted beyond the smallest eigenvalue.
    pub fn negative_curvature(&mut self, scale: f64) -> Option<DVector<f64>> {
        self.factor.set_sum(&self.hessian, 0.0, &self.norm);
        if self.factor.factorise() {
            return None;
        }
        let mut shift = scale;
        loop {
            self.factor.set_sum(&self.hessian, shift, &self.norm);
            if self.factor.factorise() {
                break;
            }
            shift *= 4.0;
            if !shift.is_finite() {
                return None;
            }
        }
        let mut x = DVector::from_fn(self.gradient.len(), |i, _| (1.0 + i as f64).sin());
        for _ in 0..INVERSE_ITERATIONS {
            let mut y = self.norm.product(&x);
            self.factor.solve(&mut y);
            x = &y / self.length(&y);
        }
        (x.dot(&self.hessian.product(&x)) < 0.0).then_some(x)
    }

    /// The length of the gradient in the dual norm.
    pub fn dual_length(&mut self) -> f64 {
        self.factor.set_sum(&self.norm, 0.0, &self.norm);
        if !self.factor.factorise() {
            return f64::INFINITY;
        }
        let mut x = self.gradient.clone();
        self.factor.solve(&mut x);
        self.gradient.dot(&x).sqrt()
    }

    /// The length of a step.
    pub fn length(&self, step: &DVector<f64>) -> f64 {
        step.dot(&self.norm.product(step)).sqrt()
    }

    /// The Newton step with the smallest tried multiple of the norm for which the matrix is positive definite (WB,
    /// algorithm IC); `None` if there is none.
    pub fn step(&mut self, scale: f64, progress: &mut Progress, options: &Options) -> Option<Step> {
        let [first, later, less] = options.regularisation_factors;
        let known = self.regularisation;
        let mut multiple = self.floor;
        progress.factorisations = 0;
        loop {
            progress.factorisations += 1;
            self.factor
                .set_sum(&self.hessian, multiple * scale, &self.norm);
            if self.factor.factorise() {
                break;
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
        }
        if multiple > 0.0 {
            self.regularisation = multiple;
        }
        progress.regularisation = multiple;
        let mut x = -&self.gradient;
        self.factor.solve(&mut x);
        let slope = self.gradient.dot(&x);
        progress.step = self.length(&x);
        progress.stationarity = (-slope / scale).sqrt();
        Some(Step { x, slope })
    }
}
