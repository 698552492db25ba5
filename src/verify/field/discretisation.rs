//! A discretised curve with random numbers.

use super::{Gf, RandomInstance};
use crate::scalar::AlgebraOver;
use crate::transcription::Grid;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// Random numbers for an instance.
pub(super) fn numbers(p: &RandomInstance) -> impl FnMut() -> Gf {
    let mut rng = ChaCha8Rng::seed_from_u64(p.k.residue());
    move || Gf::new(rng.random_range(0..Gf::ORDER))
}

/// Two segments of degree 4 with two points each: functions, weights and coefficients are random.
pub(super) struct Discretisation {
    times: Vec<Gf>,
    weights: Vec<Gf>,
    /// Values of the functions of a segment and their first two derivatives, three columns per point.
    table: DMatrix<Gf>,
    /// `N` rows, one column per function.
    pub coefficients: DMatrix<Gf>,
    /// The first two derivatives of the coefficients in the horizon, at a horizon of zero.
    pub rates: [DMatrix<Gf>; 2],
    /// A direction for the unknown coefficients.
    pub direction: DVector<Gf>,
}

impl Discretisation {
    const SEGMENTS: usize = 2;
    const POINTS: usize = 2;
    const COUNT: usize = 8;
    /// The unknown functions: the last but one is among them, as with a free final velocity.
    const FREE: Range<usize> = 2..Self::COUNT - 1;

    pub fn new(p: &RandomInstance) -> Self {
        let (mut number, n) = (numbers(p), p.dof());
        let mut matrix = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| number());
        let direction = matrix(Self::FREE.len() * n, 1);
        Self {
            direction: direction.column(0).into_owned(),
            times: matrix(Self::SEGMENTS * Self::POINTS, 1).data.into(),
            weights: matrix(Self::POINTS, 1).data.into(),
            table: matrix(5, 3 * Self::POINTS),
            coefficients: matrix(n, Self::COUNT),
            rates: [matrix(n, Self::COUNT), matrix(n, Self::COUNT)],
        }
    }

    /// The grid on a horizon of one second.
    pub fn grid(&self) -> Grid<Gf> {
        self.on(num_traits::One::one()).0
    }

    /// The grid on a horizon, and coefficients that are quadratic in it.
    pub fn on<S: AlgebraOver<Gf>>(&self, horizon: S) -> (Grid<S>, DMatrix<S>) {
        let rate = S::one() / horizon;
        let powers = [S::one(), rate, rate * rate];
        let (functions, columns) = self.table.shape();
        let table = DMatrix::from_fn(functions, columns, |f, column| powers[column % 3].scale(self.table[(f, column)]));
        let scaled = |x: &[Gf]| x.iter().map(|x| horizon.scale(*x)).collect();
        let (times, weights) = (scaled(&self.times), scaled(&self.weights));
        let grid = Grid::from_table(Self::SEGMENTS, 2, Self::FREE.collect(), times, weights, table);
        let half = horizon * horizon / S::from_f64(2.0);
        let [first, second] = &self.rates;
        let quadratic = |c: Gf, first: Gf, second: Gf| S::lift(c) + horizon.scale(first) + half.scale(second);
        (grid, self.coefficients.zip_zip_map(first, second, quadratic))
    }

    /// The first two derivatives of the coefficients at a horizon.
    pub fn rates_at(&self, horizon: Gf) -> [DMatrix<Gf>; 2] {
        let [first, second] = &self.rates;
        [first + second * horizon, second.clone()]
    }

    /// The grid of one segment alone on a horizon, whose normalised time zero is at a time.
    pub fn segment<S: AlgebraOver<Gf>>(&self, e: usize, horizon: S, begin: S) -> Grid<S> {
        let (of_all, _) = self.on(horizon);
        let own = e * Self::POINTS..(e + 1) * Self::POINTS;
        let times = of_all.times[own].iter().map(|time| begin + *time);
        let functions = of_all.table.nrows();
        Grid::from_table(1, 2, (0..functions).collect(), times.collect(), of_all.weights.clone(), of_all.table.clone())
    }

    /// Adds numbers to the unknown coefficients.
    pub fn add_to_unknowns<S: AlgebraOver<Gf>>(coefficients: &mut DMatrix<S>, numbers: &[S]) {
        let first = Self::FREE.start * coefficients.nrows();
        let unknowns = &mut coefficients.as_mut_slice()[first..][..numbers.len()];
        for (unknown, number) in unknowns.iter_mut().zip(numbers) {
            *unknown += *number;
        }
    }

    /// The unknown coefficients.
    pub fn unknowns(&self) -> &[Gf] {
        let n = self.coefficients.nrows();
        &self.coefficients.as_slice()[Self::FREE.start * n..Self::FREE.end * n]
    }

    /// The coefficients with other values of the unknowns.
    pub fn with_unknowns<S: AlgebraOver<Gf>>(&self, unknowns: &[S]) -> DMatrix<S> {
        let first = Self::FREE.start * self.coefficients.nrows();
        let mut coefficients = self.coefficients.map(S::lift);
        coefficients.as_mut_slice()[first..first + unknowns.len()].copy_from_slice(unknowns);
        coefficients
    }
}
