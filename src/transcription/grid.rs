//! The functions of a basis at the points of a quadrature.

use super::Scan;
use super::horizons::slopes;
use crate::constraint::MAX_ORDER;
use crate::cost::products;
use crate::curve::{Basis, gauss_legendre, gauss_lobatto};
use crate::linalg::{BlockTridiagonal, multiply};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DMatrixViewMut, DVector};
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A basis on a horizon, tabulated at Gauss-Legendre points, as many on each segment.
///
/// The segments are alike, so one table serves all.
#[derive(Clone, Debug)]
pub struct Grid<S: Scalar> {
    /// The number of segments.
    pub(crate) segments: usize,
    /// The number of functions per breakpoint.
    pub(super) shared: usize,
    /// The functions with unknown coefficients, ascending.
    pub(crate) free: Vec<usize>,
    /// The unknown of each function, if it has one.
    pub(crate) unknown: Vec<Option<usize>>,
    /// Times of the points, s, segment by segment.
    pub(crate) times: Vec<S>,
    /// Weights of the points of a segment.
    pub(crate) weights: Vec<S>,
    /// True for each point of a segment at which equalities, and no other rows, are enforced.
    pub(crate) collocated: Vec<bool>,
    /// Value, first and second derivative in time at each point of a segment: one row per function of a segment, three
    /// columns per point.
    pub(crate) table: DMatrix<S>,
    /// Its transpose.
    pub(crate) transposed: DMatrix<S>,
    /// The derivatives of higher orders, from three to [`MAX_ORDER`]; none of arbitrary functions.
    pub(crate) higher: Vec<Higher<S>>,
    /// Pairs of functions of a segment, the first not before the second, in the order of the rows of `products`.
    pub(crate) pairs: Vec<(usize, usize)>,
    /// Weighted products of functions; only derivatives need them.
    products: OnceLock<[DMatrix<S>; 2]>,
}

/// The derivatives of the functions of a segment of one order.
#[derive(Clone, Debug)]
pub(crate) struct Higher<S: Scalar> {
    /// The derivatives at each point, one row per function, and their transpose.
    pub table: DMatrix<S>,
    pub transposed: DMatrix<S>,
    /// Their products of each pair of functions, one row per point; only costs in them need these.
    products: OnceLock<DMatrix<S>>,
}

impl<S: Scalar> Higher<S> {
    fn new(table: DMatrix<S>) -> Self {
        Self { transposed: table.transpose(), table, products: OnceLock::new() }
    }

    /// Multiplies the first derivatives in those of this order by their weights, and sums the second ones over the
    /// points with the products of each pair of functions into `squares`, `N` by pairs.
    pub fn weigh(
        &self,
        grid: &Grid<S>,
        (horizon, rate): (S, S),
        [first, second]: &mut [DMatrix<S>; 2],
        squares: &mut DMatrix<S>,
    ) {
        for (g, weight) in grid.weights.iter().enumerate() {
            let mut column = first.column_mut(g);
            column *= *weight * horizon * rate;
            let mut column = second.column_mut(g);
            column *= *weight * horizon * rate * rate;
        }
        let products = self.products.get_or_init(|| {
            DMatrix::from_fn(grid.points(), grid.pairs.len(), |g, pair| {
                let (a, b) = grid.pairs[pair];
                self.table[(a, g)] * self.table[(b, g)]
            })
        });
        multiply(second, products, squares);
    }
}

/// Tables that several searches share.
#[derive(Default)]
pub(crate) struct Grids {
    grids: Mutex<Vec<Made<Grid<f64>>>>,
    with_ends: Mutex<Vec<Made<Grid<f64>>>>,
    collocated: Mutex<Vec<Made<Grid<f64>, [usize; 2]>>>,
    scans: Mutex<Vec<Made<Scan>>>,
}

/// A table and its arguments.
type Made<T, C = usize> = (Basis, C, Arc<T>);

/// A point of one segment in `[-1, 1]`.
struct Node {
    at: f64,
    weight: f64,
    collocated: bool,
}

impl Grids {
    /// The shared [`Grid::new`] in normalised time.
    pub fn get(&self, basis: &Basis, points: usize) -> Arc<Grid<f64>> {
        get(&self.grids, basis, points, |basis, points| Grid::new(basis, points, 1.0))
    }

    /// The shared [`Grid::with_ends`] in normalised time.
    pub fn with_ends(&self, basis: &Basis, points: usize) -> Arc<Grid<f64>> {
        get(&self.with_ends, basis, points, |basis, points| Grid::with_ends(basis, points, 1.0))
    }

    /// The shared [`Grid::collocated`] in normalised time.
    pub fn collocated(&self, basis: &Basis, points: [usize; 2]) -> Arc<Grid<f64>> {
        get(&self.collocated, basis, points, |basis, points| Grid::collocated(basis, points, 1.0))
    }

    /// The shared [`Scan::new`].
    pub fn scan(&self, basis: &Basis, intervals: usize) -> Arc<Scan> {
        get(&self.scans, basis, intervals, Scan::new)
    }
}

/// The stored table, or otherwise a `new` one.
fn get<T, C: Copy + PartialEq>(
    made: &Mutex<Vec<Made<T, C>>>,
    basis: &Basis,
    count: C,
    new: impl Fn(&Basis, C) -> T,
) -> Arc<T> {
    let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
    let known = made.iter().find(|(b, c, _)| (b, *c) == (basis, count));
    if let Some((.., table)) = known {
        return table.clone();
    }
    let table = Arc::new(new(basis, count));
    made.push((basis.clone(), count, table.clone()));
    table
}

impl Grid<f64> {
    /// The share of the collocated points in the quadrature, small because they are few.
    pub(crate) const COLLOCATED: f64 = 1e-3;

    /// Tabulates `basis` on `[0, horizon]` with `points` Gauss-Legendre points per segment.
    #[must_use]
    pub fn new(basis: &Basis, points: usize, horizon: f64) -> Self {
        Self::of_rule(basis, gauss_legendre(points), horizon)
    }

    /// Tabulates at Gauss-Lobatto points instead, which include the ends of each segment: velocities often have a
    /// maximum between two segments, where the control jumps.
    #[must_use]
    pub fn with_ends(basis: &Basis, points: usize, horizon: f64) -> Self {
        Self::of_rule(basis, gauss_lobatto(points), horizon)
    }

    fn of_rule(basis: &Basis, (nodes, weights): (Vec<f64>, Vec<f64>), horizon: f64) -> Self {
        let nodes = nodes.into_iter().zip(weights);
        let nodes = nodes.map(|(at, weight)| Node { at, weight, collocated: false });
        Self::at(basis, nodes.collect(), horizon)
    }

    /// Adds `degree - 1` Gauss-Legendre points per segment, at which equalities are enforced: the collocation of a
    /// second-order equation, whose residual between the points is orthogonal to all polynomials of lower degree
    /// (`proofs/weak_form.md`). They have the share `COLLOCATED` in the quadrature.
    #[must_use]
    pub fn collocated(basis: &Basis, [points, held]: [usize; 2], horizon: f64) -> Self {
        let rule = |count, part, collocated| {
            let (nodes, weights) = gauss_legendre(count);
            let nodes = nodes.into_iter().zip(weights);
            nodes.map(move |(at, weight)| Node { at, weight: part * weight, collocated })
        };
        let part = Self::COLLOCATED;
        let all = rule(points, 1.0 - part, false).chain(rule(held, part, true));
        let mut nodes: Vec<Node> = all.collect();
        nodes.sort_by(|a, b| a.at.total_cmp(&b.at));
        Self::at(basis, nodes, horizon)
    }

    /// Tabulates at these points of each segment.
    fn at(basis: &Basis, nodes: Vec<Node>, horizon: f64) -> Self {
        let mut table = DMatrix::zeros(basis.degree() + 1, 3 * nodes.len());
        let mut higher = vec![DMatrix::zeros(basis.degree() + 1, nodes.len()); MAX_ORDER - 2];
        for (g, node) in nodes.iter().enumerate() {
            let local = basis.local(node.at);
            for (order, table) in (3..).zip(&mut higher) {
                table.set_column(g, &(local.row(order as usize).transpose() / horizon.powi(order)));
            }
            for d in 0..3 {
                let scaled = local.row(d).transpose() / horizon.powi(d as i32);
                table.set_column(3 * g + d, &scaled);
            }
        }
        let segments = 0..basis.segments();
        let times = segments.flat_map(|e| nodes.iter().map(move |s| horizon * basis.time(e, s.at)));
        let length = basis.half() * horizon;
        let weights = nodes.iter().map(|node| node.weight * length).collect();
        Self {
            collocated: nodes.iter().map(|node| node.collocated).collect(),
            higher: higher.into_iter().map(Higher::new).collect(),
            ..Self::from_table(
                basis.segments(),
                basis.continuity().order(),
                basis.free(),
                times.collect(),
                weights,
                table,
            )
        }
    }
}

impl<S: Scalar> Grid<S> {
    /// A grid of arbitrary functions: the identities of the assembly hold for any.
    pub(crate) fn from_table(
        segments: usize,
        shared: usize,
        free: Vec<usize>,
        times: Vec<S>,
        weights: Vec<S>,
        table: DMatrix<S>,
    ) -> Self {
        let functions = table.nrows();
        // On a single segment the fixed functions have no part in the Hessian.
        let needed = match segments {
            1 => free.clone(),
            _ => (0..functions).collect(),
        };
        let pairs = needed.iter().enumerate();
        let pairs = pairs.flat_map(|(i, b)| needed[i..].iter().map(move |a| (*a, *b)));
        let pairs = pairs.collect();
        let mut unknown = vec![None; segments * (functions - shared) + shared];
        for (index, function) in free.iter().enumerate() {
            unknown[*function] = Some(index);
        }
        Self {
            segments,
            shared,
            free,
            unknown,
            times,
            collocated: vec![false; weights.len()],
            weights,
            transposed: table.transpose(),
            higher: Vec::new(),
            table,
            pairs,
            products: OnceLock::new(),
        }
    }

    /// The same grid over another scalar.
    #[must_use]
    pub fn map<T: Scalar>(&self, f: impl Fn(S) -> T) -> Grid<T> {
        let all = |x: &[S]| x.iter().map(|x| f(*x)).collect();
        let (times, weights) = (all(&self.times), all(&self.weights));
        let table = self.table.map(&f);
        Grid {
            collocated: self.collocated.clone(),
            higher: self.higher.iter().map(|of| Higher::new(of.table.map(&f))).collect(),
            ..Grid::from_table(self.segments, self.shared, self.free.clone(), times, weights, table)
        }
    }

    /// Weighted products of the functions of each pair, for [`PackedHessian`](crate::cost::PackedHessian).
    pub(crate) fn products(&self) -> &[DMatrix<S>; 2] {
        let new = || products(&self.table, &self.weights, &self.pairs);
        self.products.get_or_init(new)
    }

    /// The number of points per segment.
    #[must_use]
    pub fn points(&self) -> usize {
        self.weights.len()
    }

    /// The number of functions, those of the boundary conditions included.
    #[must_use]
    pub fn count(&self) -> usize {
        self.first(self.segments) + self.shared
    }

    /// The first function of segment `e`.
    pub(crate) fn first(&self, e: usize) -> usize {
        e * (self.table.nrows() - self.shared)
    }

    /// The unknowns that segment `e` owns alone or shares with the next: a block of the Hessian.
    pub(crate) fn block(&self, e: usize) -> Range<usize> {
        let before = |function| self.free.partition_point(|free| *free < function);
        let first = match e {
            0 => 0,
            _ => self.first(e) + self.shared,
        };
        before(first)..before(self.first(e + 1) + self.shared)
    }

    /// The `n` by `n` block of a pair of functions of segment `e`, the first not before the second; `None` if the
    /// coefficient of one is fixed.
    pub(crate) fn block_mut<'m>(
        &self,
        e: usize,
        (a, b): (usize, usize),
        n: usize,
        out: &'m mut BlockTridiagonal<S>,
    ) -> Option<DMatrixViewMut<'m, S>> {
        let first = self.first(e);
        let (row, column) = (self.unknown[first + a]?, self.unknown[first + b]?);
        // The first functions of a segment are the last ones of the block before.
        let (own, shared) = (self.block(e).start, self.shared);
        let (target, row, column) = match (e > 0 && a < shared, e > 0 && b < shared) {
            (false, false) => (&mut out.diagonal[e], row - own, column - own),
            (false, true) => (&mut out.coupling[e - 1], row - own, column + shared - own),
            (true, _) => {
                let start = self.block(e - 1).start;
                (&mut out.diagonal[e - 1], row - start, column - start)
            }
        };
        Some(target.view_mut((row * n, column * n), (n, n)))
    }
}

/// Adds the gradient in the functions of segment `e`, one column each, to the full gradient.
pub(super) fn add_gradient<S: Scalar>(grid: &Grid<S>, gradient: &DMatrix<S>, e: usize, out: &mut DVector<S>) {
    let (n, first) = (gradient.nrows(), grid.first(e));
    for (m, column) in gradient.column_iter().enumerate() {
        if let Some(unknown) = grid.unknown[first + m] {
            let mut target = out.rows_mut(unknown * n, n);
            target += column;
        }
    }
}

/// Writes the block of a pair of functions of segment `e`, in a part with this factor of slopes, added to the
/// contribution of the previous segment, which must have been written before.
pub(super) fn put_block<S: Scalar>(
    grid: &Grid<S>,
    (block, factor): (&mut DMatrix<S>, Option<S>),
    e: usize,
    pair: usize,
    out: &mut BlockTridiagonal<S>,
) {
    let (a, b) = grid.pairs[pair];
    if let Some(factor) = factor {
        let slopes = slopes(grid.table.nrows(), grid.shared);
        for _ in [a, b].iter().filter(|of| slopes.contains(of)) {
            *block *= factor;
        }
    }
    if let Some(mut target) = grid.block_mut(e, (a, b), block.nrows(), out) {
        if e > 0 && a < grid.shared {
            target += &*block;
        } else {
            target.copy_from(&*block);
        }
    }
}
