//! The integral of a running cost along a curve of a basis, with its derivatives in the coefficients.

use super::grid::put_block;
use super::horizon::Moved;
use super::horizons::{place_in, rates_of_slopes};
use super::place::{points, rate, scale};
use super::segment::Segment;
use super::{Grid, HorizonDerivatives, Horizons, Shared};
use crate::cost::{PackedHessian, PointCost, PointsDerivatives};
use crate::error::{Result, check_length};
use crate::linalg::BlockTridiagonal;
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// The sum $\sum_g w_g\\, l(q, \dot q, \ddot q)$ over the points of a [`Grid`], a function of the coefficients `N` by
/// `count`.
///
/// With the function $\phi_m^x$ number `m` (`x` = 0) and its derivatives at a point, and the `N` by `N` blocks $W^{xy}$
/// of the Hessian of `l` there,
///
/// $$ \frac{\partial}{\partial c_m} = \sum_g w_g \sum_x \phi_m^x \frac{\partial l}{\partial z^x}, \qquad
///    \frac{\partial^2}{\partial c_m \partial c_n} = \sum_g w_g \sum_{x, y} \phi_m^x \phi_n^y\\, W^{xy}. $$
///
/// The products of functions are tabulated, so that all blocks of the Hessian of a segment with `p` functions and `M`
/// points are two matrix products, see [`PackedHessian`]: about $p^2 / 2$ by $9 M$ times $9 M$ by $N^2 / 2$.
pub struct Objective<'g, S: Scalar, P> {
    grid: Shared<'g, Grid<S>>,
    cost: P,
    dof: usize,
    /// The factors from the time of the grid to time, and if they are unknown the first two derivatives of the
    /// coefficients in them.
    pub(super) horizons: Horizons<S>,
    pub(super) rates: Option<[DMatrix<S>; 2]>,
    times: Vec<S>,
    /// $q, v, a$ at the points of a segment, one column each.
    pub(super) states: DMatrix<S>,
    /// The derivatives of the higher orders of the cost at the points of a segment.
    higher: Vec<DMatrix<S>>,
    costs: Vec<S>,
    /// Allocated when derivatives are first requested.
    workspace: Option<Workspace<S>>,
}

/// Scratch space of derivatives.
struct Workspace<S: Scalar> {
    at_points: PointsDerivatives<S>,
    sums: [DMatrix<S>; 2],
    gradient: DMatrix<S>,
    /// The derivatives in a free horizon, at the points and in each higher order.
    moved: Vec<Moved<S>>,
    /// The second derivatives in each higher order by pairs of functions.
    squares: Vec<DMatrix<S>>,
}

/// The derivatives of an objective in the unknown coefficients, function by function.
#[derive(Clone, Debug)]
pub struct Derivatives<S: Scalar> {
    /// The gradient.
    pub gradient: DVector<S>,
    /// The Hessian.
    pub hessian: BlockTridiagonal<S>,
    /// The Gauss-Newton metric.
    pub metric: BlockTridiagonal<S>,
    /// The derivatives in the horizon, or in that of each part: the first, the second, and the mixed ones with the
    /// coefficients. Mixed ones in two parts are zero.
    pub horizons: Vec<HorizonDerivatives<S>>,
}

impl<S: Scalar> Derivatives<S> {
    /// Zeros for the unknowns of a grid and a robot with `dof` joints.
    #[must_use]
    pub fn new(grid: &Grid<S>, dof: usize) -> Self {
        let sizes: Vec<_> = (0..grid.segments).map(|e| grid.block(e).len() * dof).collect();
        let matrix = BlockTridiagonal::new(&sizes, grid.shared * dof);
        Self {
            gradient: DVector::zeros(grid.free.len() * dof),
            hessian: matrix.clone(),
            metric: matrix,
            horizons: vec![HorizonDerivatives::zeros(grid.free.len() * dof)],
        }
    }
}

impl<'g, S: Scalar, P: PointCost<S>> Objective<'g, S, P> {
    /// The integral of `cost` on `grid` for a robot with `dof` joints.
    #[must_use]
    pub fn new(grid: impl Into<Shared<'g, Grid<S>>>, cost: P, dof: usize) -> Self {
        let grid = grid.into();
        let points = grid.points();
        Self {
            higher: vec![DMatrix::zeros(dof, points); cost.order() - 2],
            cost,
            dof,
            horizons: Horizons::one(S::one()),
            rates: None,
            times: grid.times.clone(),
            states: DMatrix::zeros(dof, 3 * points),
            costs: vec![S::zero(); points],
            workspace: None,
            grid,
        }
    }

    /// Sets the factor `T` from the time of the grid to time: with $\tau$ the time of the grid, the integral is
    /// $T \sum_g w_g\\, l(q, q' / T, q'' / T^2)$.
    pub fn set_horizon(&mut self, horizon: S) {
        self.set_horizons(&Horizons::one(horizon));
    }

    /// Sets the horizons of all parts.
    pub fn set_horizons(&mut self, horizons: &Horizons<S>) {
        self.horizons.assign(horizons);
        let (points, segments) = (self.grid.points(), self.grid.segments);
        let times = self.times.iter_mut().zip(&self.grid.times);
        for (g, (time, normalised)) in times.enumerate() {
            let part = horizons.part(g / points, segments);
            *time = horizons.time(part, *normalised);
        }
    }

    /// Makes the horizon an unknown, in which the coefficients have these first two derivatives, `N` by the number of
    /// functions each; or those of parts, in which the slopes change by themselves.
    pub fn free_horizon(&mut self, rates: [DMatrix<S>; 2]) {
        self.rates = Some(rates);
    }

    /// Changes the derivatives of the coefficients in a [free horizon](Self::free_horizon), if it is one.
    pub(crate) fn set_rates(&mut self, rates: &[DMatrix<S>; 2]) {
        for (own, rates) in self.rates.iter_mut().flatten().zip(rates) {
            own.copy_from(rates);
        }
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &Grid<S> {
        &self.grid
    }

    /// The running cost.
    pub fn cost_mut(&mut self) -> &mut P {
        &mut self.cost
    }

    /// The running cost.
    pub fn cost(&self) -> &P {
        &self.cost
    }

    /// The number of joints `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Computes the integral.
    ///
    /// # Errors
    /// `coefficients` is not `N` by the number of functions of the grid.
    pub fn value(&mut self, coefficients: &DMatrix<S>) -> Result<S> {
        self.check(coefficients)?;
        let [mut sum, mut whole] = [S::zero(); 2];
        for e in 0..self.grid.segments {
            self.place(coefficients, e);
            let phase = self.phase(e);
            let here = points(&self.grid, &self.times, (&self.states, &self.higher), e, phase);
            self.cost.values(here, &mut self.costs)?;
            for (weight, cost) in self.grid.weights.iter().zip(&self.costs) {
                sum += *weight * *cost;
            }
            self.end_segment(e, &mut sum, &mut whole);
        }
        Ok(whole)
    }

    /// Computes the integral, and its derivatives into `out`.
    ///
    /// # Errors
    /// `coefficients` is not `N` by the number of functions of the grid.
    pub fn derivatives(&mut self, coefficients: &DMatrix<S>, out: &mut Derivatives<S>) -> Result<S> {
        self.integrate(coefficients, true, out)
    }

    /// Computes the derivatives as [`derivatives`](Self::derivatives) does, without the metric.
    ///
    /// # Errors
    /// `coefficients` is not `N` by the number of functions of the grid.
    pub fn gradient_and_hessian(&mut self, coefficients: &DMatrix<S>, out: &mut Derivatives<S>) -> Result<S> {
        self.integrate(coefficients, false, out)
    }

    fn integrate(&mut self, coefficients: &DMatrix<S>, with_metric: bool, out: &mut Derivatives<S>) -> Result<S> {
        self.check(coefficients)?;
        let (shared, dof) = (self.grid.clone(), self.dof);
        let grid = &*shared;
        self.begin(coefficients, out);
        let [mut sum, mut whole] = [S::zero(); 2];
        for e in 0..grid.segments {
            self.place(coefficients, e);
            let phase = self.phase(e);
            let curve = points(grid, &self.times, (&self.states, &self.higher), e, phase);
            let segment = Segment::new(grid, &self.horizons, e, curve);
            let Workspace { at_points, sums, gradient, moved, squares } =
                self.workspace.get_or_insert_with(|| Workspace::new(grid, dof, curve.higher.len()));
            at_points.with_metrics = with_metric;
            at_points.clear_higher(curve.higher.len(), dof, grid.points());
            self.cost.all_derivatives(curve, at_points)?;
            for (weight, cost) in grid.weights.iter().zip(&at_points.costs) {
                sum += *weight * *cost;
            }
            if let Some([rates, _]) = &self.rates {
                segment.in_horizon(rates, at_points, moved, gradient, out);
                segment.in_time(&mut self.cost, out)?;
            }
            segment.weigh(at_points, squares);
            segment.gradient(self.rates.as_ref().map(|[_, second]| second), at_points, gradient, out);
            let (horizon, factor) = (segment.horizon, segment.factor);
            at_points.hessians.integrate(grid.products(), horizon, sums, |pair, block| {
                for squares in &*squares {
                    for i in 0..dof {
                        block[(i, i)] += squares[(i, pair)];
                    }
                }
                put_block(grid, (block, factor), e, pair, &mut out.hessian);
            });
            if with_metric {
                at_points.metrics.integrate(grid.products(), horizon, sums, |pair, block| {
                    put_block(grid, (block, factor), e, pair, &mut out.metric);
                });
            }
            self.end_segment(e, &mut sum, &mut whole);
        }
        Ok(whole)
    }

    /// Begins derivatives: with zeros, and in parts with the rates of the slopes.
    fn begin(&mut self, coefficients: &DMatrix<S>, out: &mut Derivatives<S>) {
        out.gradient.fill(S::zero());
        let (unknowns, parts) = (out.gradient.len(), self.horizons.parts().len());
        out.horizons.resize_with(parts, || HorizonDerivatives::zeros(unknowns));
        for of in &mut out.horizons {
            (of.first, of.second) = (S::zero(), S::zero());
            of.mixed.fill(S::zero());
        }
        if let (Some([rates, _]), Some(reference)) = (&mut self.rates, self.horizons.reference()) {
            rates_of_slopes(coefficients, &self.grid, reference, rates);
        }
    }

    /// Adds the sum over the segments of a part, times its horizon, to the whole after the last one.
    fn end_segment(&self, e: usize, sum: &mut S, whole: &mut S) {
        let [part, next] = [e, e + 1].map(|e| self.horizons.part(e, self.grid.segments));
        if next != part {
            *whole += self.horizons.parts()[part] * std::mem::replace(sum, S::zero());
        }
    }

    /// Computes the Gram matrix of the velocities: the square of the norm is $\tfrac{T}{\pi^2} \int |\delta v|^2 dt$,
    /// which for the longest wave that vanishes at both ends is the mean square of $\delta q$.
    #[must_use]
    pub fn gram(&self) -> BlockTridiagonal<S> {
        let (n, grid) = (self.dof, &*self.grid);
        let segments = S::from_f64(grid.segments as f64 / std::f64::consts::PI.powi(2));
        let scale = grid.weights.iter().fold(S::zero(), |sum, w| sum + *w) * segments;
        let mut gram = Derivatives::new(grid, n).hessian;
        let identity = DMatrix::identity(n, n);
        let velocity = |m, g| grid.table[(m, 3 * g + 1)];
        let squares = grid.pairs.iter().map(|&(a, b)| {
            let at_points = grid.weights.iter().enumerate();
            at_points.fold(S::zero(), |sum, (g, w)| sum + *w * velocity(a, g) * velocity(b, g))
        });
        let squares: Vec<S> = squares.collect();
        for e in 0..grid.segments {
            for (pair, square) in squares.iter().enumerate() {
                let mut block = &identity * (*square * scale);
                put_block(grid, (&mut block, None), e, pair, &mut gram);
            }
        }
        gram
    }

    /// The phase of segment `e`.
    fn phase(&self, e: usize) -> usize {
        e * self.cost.phases() / self.grid.segments
    }

    /// Computes the curve at the points of segment `e`.
    pub(super) fn place(&mut self, coefficients: &DMatrix<S>, e: usize) {
        let (grid, first) = (&self.grid, self.grid.first(e));
        let part = self.horizons.part(e, grid.segments);
        let horizon = self.horizons.parts()[part];
        let factor = (grid.shared, self.horizons.stretch(part));
        place_in(coefficients, first, &grid.table, factor, &mut self.states);
        scale(&mut self.states, horizon);
        for ((k, rates), of) in self.higher.iter_mut().enumerate().zip(&grid.higher) {
            place_in(coefficients, first, &of.table, factor, rates);
            *rates *= rate(horizon, 3 + k);
        }
    }

    fn check(&self, coefficients: &DMatrix<S>) -> Result<()> {
        check_length("coefficients", self.dof, coefficients.nrows())?;
        check_length("coefficients", self.grid.count(), coefficients.ncols())
    }
}

impl<S: Scalar> Workspace<S> {
    fn new(grid: &Grid<S>, dof: usize, higher: usize) -> Self {
        Self {
            at_points: PointsDerivatives::new(dof, grid.points()),
            sums: PackedHessian::sums(dof, grid.pairs.len()),
            gradient: DMatrix::zeros(dof, grid.table.nrows()),
            moved: (0..=higher).map(|_| Moved::default()).collect(),
            squares: vec![DMatrix::zeros(dof, grid.pairs.len()); higher],
        }
    }
}
