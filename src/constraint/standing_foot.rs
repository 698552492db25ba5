//! A foot that stands: bounds of the force of the ground on it.

use super::{Quantity, RowLabel};
use crate::dynamics::{Data, RneaWeightedHessian, RootWrenchDerivatives, root_wrench, root_wrench_second_order};
use crate::error::{Error, Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Force, Motion, Placement, cross};
use nalgebra::{DMatrix, DVector, Vector3};

/// A flat foot, fixed to the base, that the ground holds by pressure and friction alone. With the
/// [wrench of the root](root_wrench()) in the axes of the sole, the force `f` and the moment `m` about the middle of
/// the sole, divided by the weight of the robot, the rows are
///
/// $$ -f_z, \quad -m_y - l f_z, \quad m_y - l f_z, \quad m_x - b f_z, \quad -m_x - b f_z, \quad
///    \pm m_z - \gamma f_z, \quad \frac{f_x^2 + f_y^2 - \mu^2 f_z^2}{2 \mu} , $$
///
/// none of which may be positive: the ground pushes, the centre of pressure $(-m_y, m_x) / f_z$ is on a sole of the
/// length `2 l` and the width `2 b`, the foot does not turn, and it does not slip. All are polynomials of the wrench.
/// At $f_z = 1$ their excess is that of the weight, of the centre of pressure in m, of $m_z / f_z$ in m and of the
/// ratio of friction. Derivation: `proofs/constraints.md`.
#[derive(Clone, Debug, PartialEq)]
pub struct StandingFoot<C: Scalar = f64> {
    /// The name of the foot, for labels.
    pub name: String,
    /// The placement of the sole in the base frame: its middle, `x` along its length, `y` to the left and `z` up.
    pub sole: Placement<C>,
    /// Half of the length `l`, m.
    pub half_length: C,
    /// Half of the width `b`, m.
    pub half_width: C,
    /// The coefficient of friction $\mu$.
    pub friction: C,
    /// The largest ratio $\gamma$ of the moment about the normal to the normal force, m; `None` for no bound.
    pub torsion: Option<C>,
    /// The weight of the robot, N, by which forces are divided.
    pub weight: C,
}

/// The force of the ground on a standing foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootContact {
    /// The force in the axes of the sole, N; its last component, the normal force, is negative if the ground would have
    /// to pull.
    pub force: [f64; 3],
    /// The coordinates of the centre of pressure along the length and the width of the sole, m.
    pub centre_of_pressure: [f64; 2],
    /// The ratio of the force in the plane of the sole to the normal force.
    pub friction: f64,
    /// The ratio of the moment about the normal at the middle of the sole to the normal force, m.
    pub torsion: f64,
    /// The largest of the rows: positive if the foot does not hold.
    pub excess: f64,
}

/// The largest number of rows.
const MAX_ROWS: usize = 8;

/// The weighted derivatives of the rows in $z = [q; v; a]$, with scratch space.
#[derive(Clone, Debug)]
pub struct FootDerivatives<S: Scalar = f64> {
    wrench: RootWrenchDerivatives<S>,
    second: RneaWeightedHessian<S>,
    product: DMatrix<S>,
    /// $\sum_j \sigma_j \nabla g_j$, `3 N` entries.
    pub gradient: DVector<S>,
    /// $\sum_j \lambda_j \nabla^2 g_j + c_j \nabla g_j \nabla g_j^T$, `3 N` by `3 N`.
    pub hessian: DMatrix<S>,
}

impl<S: Scalar> FootDerivatives<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            wrench: RootWrenchDerivatives::new(n),
            second: RneaWeightedHessian::new(n),
            product: DMatrix::zeros(6, 3 * n),
            gradient: DVector::zeros(3 * n),
            hessian: DMatrix::zeros(3 * n, 3 * n),
        }
    }
}

/// The weights of the rows in their derivatives, one entry per row.
#[derive(Clone, Copy, Debug)]
pub struct FootWeights<'a, S> {
    /// The weights $\sigma$ of the gradients.
    pub slopes: &'a [S],
    /// The weights $\lambda$ of the second derivatives.
    pub multipliers: &'a [S],
    /// The weights `c` of the products of gradients.
    pub curvatures: &'a [S],
}

impl<C: Scalar> StandingFoot<C> {
    /// The number of rows: those of the normal force, of the four edges, of the two sides of the torsion, if it is
    /// bounded, and of the friction.
    #[must_use]
    pub fn dim(&self) -> usize {
        match self.torsion {
            Some(_) => MAX_ROWS,
            None => MAX_ROWS - 2,
        }
    }

    /// The turn about and the motion along each axis of the sole, by their products with a wrench: the moment about the
    /// middle of the sole and the force in its axes.
    fn axes(&self) -> [[Motion<C>; 3]; 2] {
        let axis = |i| self.sole.rotation.column(i).into_owned();
        let turn = |i| Motion::new(axis(i), cross(&self.sole.translation, &axis(i)));
        let slide = |i| Motion::new(Vector3::zeros(), axis(i));
        [[0, 1, 2].map(turn), [0, 1, 2].map(slide)]
    }

    /// The rows before the friction, which are linear, by their products with a wrench.
    fn linear(&self) -> impl Iterator<Item = Motion<C>> {
        let [turn, slide] = self.axes();
        let share = C::one() / self.weight;
        let up = slide[2];
        let ratios = [(turn[1], Some(self.half_length)), (-turn[0], Some(self.half_width)), (turn[2], self.torsion)];
        let ratios = ratios.into_iter().filter_map(|(m, most)| Some((m, most?)));
        let sides = ratios.flat_map(move |(m, most)| [-m - up * most, m - up * most]);
        std::iter::once(-up).chain(sides).map(move |row| row * share)
    }

    /// The axes of the force and the coefficients of the squares of its components in the row of the friction.
    fn friction(&self) -> [(Motion<C>, C); 3] {
        let [_, [x, y, z]] = self.axes();
        let twice = self.friction + self.friction;
        let share = C::one() / (twice * self.weight * self.weight);
        [(x, share), (y, share), (z, -self.friction * self.friction * share)]
    }

    /// Computes the rows for a wrench of the root into `g`, [`dim`](Self::dim) entries.
    ///
    /// # Errors
    /// `g` has another number of entries.
    pub fn rows<S: AlgebraOver<C>>(&self, wrench: &Force<S>, g: &mut [S]) -> Result<()> {
        check_length("g", self.dim(), g.len())?;
        for (g, row) in g.iter_mut().zip(self.linear()) {
            *g = component(&row, wrench);
        }
        let squares = self.friction().map(|(axis, c)| {
            let force = component(&axis, wrench);
            (force * force).scale(c)
        });
        g[self.dim() - 1] = squares[0] + squares[1] + squares[2];
        Ok(())
    }

    /// Computes the rows at $z = [q; v; a]$ into `g`, [`dim`](Self::dim) entries.
    ///
    /// # Errors
    /// A slice does not have `N` entries, or `g` not one per row, or `data` was made for another number of joints.
    pub fn value<S: AlgebraOver<C>>(
        &self,
        model: &Model<C>,
        data: &mut Data<S>,
        [q, v, a]: [&[S]; 3],
        g: &mut [S],
    ) -> Result<()> {
        self.rows(&root_wrench(model, data, q, v, a)?, g)
    }

    /// The gradients of the rows in the wrench.
    fn slopes<S: AlgebraOver<C>>(&self, wrench: &Force<S>) -> [[S; 6]; MAX_ROWS] {
        let mut slopes = [[S::zero(); 6]; MAX_ROWS];
        for (to, row) in slopes.iter_mut().zip(self.linear()) {
            *to = entries(&row).map(S::lift);
        }
        let of_friction = &mut slopes[self.dim() - 1];
        for (axis, c) in self.friction() {
            let twice = component(&axis, wrench).scale(c + c);
            for (to, axis) in of_friction.iter_mut().zip(entries(&axis)) {
                *to += twice.scale(axis);
            }
        }
        slopes
    }

    /// Computes the weighted derivatives of the rows at $z = [q; v; a]$. With the Jacobian `J` of the wrench and the
    /// gradients $r_j$ and the Hessians $R_j$ of the rows in it,
    ///
    /// $$ \sum_j \sigma_j J^T r_j , \qquad J^T \left( \sum_j \lambda_j R_j + c_j r_j r_j^T \right) J +
    ///    \nabla^2 (m \cdot f), \quad m = \sum_j \lambda_j r_j . $$
    ///
    /// # Errors
    /// A slice does not have `N` entries, or the weights not one per row, or `data` or `out` was made for another
    /// number of joints.
    ///
    /// # Cost
    /// O(N d), with d the depth of the tree, and O(N^2) for the products.
    pub fn weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        model: &Model<C>,
        data: &mut Data<S>,
        z: [&[S]; 3],
        weights: FootWeights<'_, S>,
        out: &mut FootDerivatives<S>,
    ) -> Result<()> {
        for weights in [weights.slopes, weights.multipliers, weights.curvatures] {
            check_length("weights", self.dim(), weights.len())?;
        }
        let mut slopes = [[S::zero(); 6]; MAX_ROWS];
        let weigh = |wrench: &Force<S>| {
            slopes = self.slopes(wrench);
            motion(&sum(&slopes, weights.multipliers))
        };
        let (wrench, second) = (&mut out.wrench, &mut out.second);
        root_wrench_second_order(model, data, z, weigh, wrench, second)?;
        let mut inner = [[S::zero(); 6]; 6];
        for (slope, c) in slopes.iter().zip(weights.curvatures) {
            add_square(slope, *c, &mut inner);
        }
        let of_friction = weights.multipliers[self.dim() - 1];
        for (axis, c) in self.friction() {
            add_square(&entries(&axis).map(S::lift), of_friction.scale(c + c), &mut inner);
        }
        out.multiply(&sum(&slopes, weights.slopes), &inner);
        Ok(())
    }

    /// The name of a row and its unit.
    #[must_use]
    pub fn label(&self, row: usize) -> RowLabel {
        let edge =
            (["front edge", "rear edge", "left edge", "right edge"].get(row.wrapping_sub(1)), row + 1 == self.dim());
        let (what, unit) = match (row, edge) {
            (0, _) => ("normal force", "of the weight"),
            (_, (Some(edge), _)) => (*edge, "m"),
            (_, (_, true)) => ("friction", ""),
            _ => ("torsion", "m"),
        };
        RowLabel::new(format!("{what} of foot '{}'", self.name), unit, Quantity::Foot)
    }
}

impl StandingFoot {
    /// The contact for a wrench of the root.
    #[must_use]
    pub fn contact(&self, wrench: &Force<f64>) -> FootContact {
        let [moment, force] = self.axes().map(|axes| axes.map(|axis| axis.dot(wrench)));
        let normal = force[2];
        let squares = self.friction().map(|(axis, c)| c * axis.dot(wrench).powi(2));
        let linear = self.linear().map(|row| row.dot(wrench));
        FootContact {
            force,
            centre_of_pressure: [-moment[1] / normal, moment[0] / normal],
            friction: force[0].hypot(force[1]) / normal,
            torsion: moment[2] / normal,
            excess: linear.fold(squares.iter().sum(), f64::max),
        }
    }

    /// The value of each row at a bad violation: the whole bound.
    pub(crate) fn scales(&self) -> Vec<f64> {
        let [l, b] = [self.half_length, self.half_width];
        let torsion = self.torsion.into_iter().flat_map(|most| [most, most]);
        let linear = [1.0, l, l, b, b].into_iter().chain(torsion);
        linear.chain([self.friction]).collect()
    }

    /// Checks that all sizes are positive and finite.
    ///
    /// # Errors
    /// One is not; the error names it.
    pub fn check(&self) -> Result<()> {
        let sizes = [
            ("half of the length", Some(self.half_length)),
            ("half of the width", Some(self.half_width)),
            ("friction", Some(self.friction)),
            ("torsion", self.torsion),
            ("weight of the robot", Some(self.weight)),
        ];
        for (what, size) in sizes {
            if let Some(size) = size.filter(|size| !(size.is_finite() && *size > 0.0)) {
                let condition = format!("it is {size} and must be a positive number");
                return Err(Error::input(format!("foot '{}'", self.name), what, condition));
            }
        }
        Ok(())
    }
}

impl<S: Scalar> FootDerivatives<S> {
    /// Computes $J^T s$ and $J^T M J + \nabla^2 (m \cdot f)$.
    fn multiply(&mut self, s: &[S; 6], m: &[[S; 6]; 6]) {
        let jacobian = self.wrench.jacobian.as_slice();
        let n = self.gradient.len() / 3;
        let dot = |a: &[S], b: &[S]| a.iter().zip(b).fold(S::zero(), |sum, (a, b)| sum + *a * *b);
        let products = self.product.as_mut_slice().chunks_exact_mut(6);
        for (j, (column, product)) in jacobian.chunks_exact(6).zip(products).enumerate() {
            self.gradient[j] = dot(column, s);
            for (to, row) in product.iter_mut().zip(m) {
                *to = dot(row, column);
            }
        }
        let products = self.product.as_slice().chunks_exact(6);
        for (j, product) in products.enumerate() {
            for (i, column) in jacobian.chunks_exact(6).take(j + 1).enumerate() {
                let entry = dot(column, product);
                self.hessian[(i, j)] = entry;
                self.hessian[(j, i)] = entry;
            }
        }
        let RneaWeightedHessian { qq, qv, vv, qa } = &self.second;
        for (x, y, block) in [(0, 0, qq), (1, 1, vv), (0, 1, qv), (0, 2, qa)] {
            let mut to = self.hessian.view_mut((x * n, y * n), (n, n));
            to += block;
            if x < y {
                let mut to = self.hessian.view_mut((y * n, x * n), (n, n));
                to += block.transpose();
            }
        }
    }
}

/// The product of a motion and a wrench.
fn component<C: Scalar, S: AlgebraOver<C>>(motion: &Motion<C>, wrench: &Force<S>) -> S {
    let wrench = wrench.angular.iter().chain(&wrench.linear);
    let products = wrench.zip(entries(motion)).map(|(f, m)| f.scale(m));
    products.fold(S::zero(), |sum, product| sum + product)
}

fn entries<S: Scalar>(Motion { angular, linear }: &Motion<S>) -> [S; 6] {
    [angular.x, angular.y, angular.z, linear.x, linear.y, linear.z]
}

fn motion<S: Scalar>(x: &[S; 6]) -> Motion<S> {
    Motion::new(Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]))
}

/// The weighted sum of the gradients of the rows.
fn sum<S: Scalar>(slopes: &[[S; 6]; MAX_ROWS], weights: &[S]) -> [S; 6] {
    let mut sum = [S::zero(); 6];
    for (slope, weight) in slopes.iter().zip(weights) {
        for (to, slope) in sum.iter_mut().zip(slope) {
            *to += *slope * *weight;
        }
    }
    sum
}

/// Adds $c r r^T$.
fn add_square<S: Scalar>(r: &[S; 6], c: S, to: &mut [[S; 6]; 6]) {
    for (row, a) in to.iter_mut().zip(r) {
        for (to, b) in row.iter_mut().zip(r) {
            *to += c * *a * *b;
        }
    }
}
