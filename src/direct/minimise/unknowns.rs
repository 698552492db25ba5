//! The unknowns of a program, and the candidates that they belong to.

use super::ends::PeriodicEnds;
use super::free::Free;
use super::{Candidate, Context};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::curve::Basis;
use crate::motion::Problem;
use crate::transcription::{Grid, Horizons, place};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The least mean square of slopes in the norm of the times of waypoints, rad^2: that of a motion by a milliradian.
const LEAST_SQUARE_SLOPE: f64 = 1e-6;

/// The unknowns: the free coefficients of a curve in a basis; then those of the border, the horizon if it is free, or
/// those of its parts, and the times of waypoints that have none; then the ends of a periodic motion.
pub(super) struct Unknowns {
    pub grid: Arc<Grid<f64>>,
    pub basis: Basis,
    /// The coefficients, those of the boundary conditions included, and their first two derivatives in the horizon.
    pub coefficients: DMatrix<f64>,
    pub rates: [DMatrix<f64>; 2],
    pub horizons: Horizons<f64>,
    pub free: Free,
    /// The normalised times of the waypoints, and the indices of those whose times are unknown.
    pub times: Vec<f64>,
    pub moving: Vec<usize>,
    /// The ends of a periodic motion.
    pub period: Option<PeriodicEnds>,
}

/// The functions with free coefficients: slope and value at the start of a periodic motion, those whose coefficients
/// are the first unknowns, and slope and value at the end, which follow from those at the start.
fn parts(free: &[usize], is_periodic: bool) -> [&[usize]; 3] {
    let ends = 2 * usize::from(is_periodic);
    let (start, rest) = free.split_at(ends);
    let (between, end) = rest.split_at(rest.len() - ends);
    [start, between, end]
}

impl Unknowns {
    /// The unknowns of a candidate without times of waypoints and periodic ends.
    pub fn new<K: Constraint, P: CostWithControl>(
        context: Context<'_, '_, K, P>,
        candidate: &Candidate,
        grid: Arc<Grid<f64>>,
    ) -> Self {
        let path = &candidate.path;
        Self {
            grid,
            basis: path.basis.clone(),
            coefficients: path.coefficients.clone(),
            rates: path.rates(context.problem, candidate.horizons.whole()),
            horizons: candidate.horizons.clone(),
            free: Free::new(context.free_horizon, &context.settings.parts, context.settings.search.reserve),
            times: candidate.times.clone(),
            moving: Vec::new(),
            period: None,
        }
    }

    /// Takes over another candidate in the same basis.
    pub fn restart(&mut self, problem: &Problem<'_>, candidate: &Candidate) {
        self.coefficients.copy_from(&candidate.path.coefficients);
        candidate.path.rates_in(problem, candidate.horizons.whole(), &mut self.rates);
        self.horizons.assign(&candidate.horizons);
    }

    /// The number of unknown coefficients before the unknowns of the border.
    pub fn own(&self) -> usize {
        self.grid.free.len() * self.coefficients.nrows() - 2 * self.ends()
    }

    /// The number of unknowns of the border: the horizon if it is free, or those of parts, then the unknown times of
    /// waypoints.
    pub fn border(&self) -> usize {
        self.free.parts.len() + self.moving.len()
    }

    /// The number of unknowns of the ends of a periodic motion.
    fn ends(&self) -> usize {
        self.period.as_ref().map_or(0, PeriodicEnds::count)
    }

    /// The index of an unknown time in the border, if it is one.
    pub fn unknown_time(&self, waypoint: usize) -> Option<usize> {
        let at = self.moving.iter().position(|k| *k == waypoint)?;
        Some(self.free.parts.len() + at)
    }

    /// The unknowns of a curve in the basis.
    pub fn vector(&self, of: &Candidate) -> DVector<f64> {
        let mut x = DVector::zeros(self.own() + self.border() + self.ends());
        self.vector_in(of, &mut x);
        x
    }

    /// Computes [`vector`](Self::vector) into `x`.
    pub fn vector_in(&self, of: &Candidate, x: &mut DVector<f64>) {
        let [ends, own, _] = parts(&self.grid.free, self.period.is_some());
        let coefficients = &of.path.coefficients;
        let column = |function: &usize| coefficients.column(*function).into_iter().copied();
        let parts = self.free.parts.iter();
        let horizons = parts.map(|(part, _)| of.horizons.parts()[*part]);
        let times = self.moving.iter().map(|k| of.times[*k]);
        let values = own.iter().flat_map(column);
        let values = values.chain(horizons).chain(times);
        let values = values.chain(ends.iter().flat_map(column));
        for (x, value) in x.iter_mut().zip(values) {
            *x = value;
        }
    }

    /// Sets coefficients, horizons and times.
    pub fn set(&mut self, x: &DVector<f64>) {
        let (n, own, border) = (self.coefficients.nrows(), self.own(), self.border());
        let [start, between, end] = parts(&self.grid.free, self.period.is_some());
        let mut set = |functions: &[usize], values: &[f64]| {
            for (function, values) in functions.iter().zip(values.chunks_exact(n)) {
                let mut column = self.coefficients.column_mut(*function);
                column.copy_from_slice(values);
            }
        };
        set(between, &x.as_slice()[..own]);
        if let Some(PeriodicEnds { period, .. }) = &self.period {
            let of_start = &x.as_slice()[x.len() - start.len() * n..];
            set(start, of_start);
            for (function, values) in end.iter().zip(of_start.chunks_exact(n)) {
                set(&[*function], &period.end_of(values));
            }
        }
        for (k, (part, _)) in self.free.parts.iter().enumerate() {
            self.horizons.set(*part, x[own + k]);
        }
        if self.free.is_whole(&self.horizons) {
            let (horizon, [first, second]) = (self.horizons.whole(), &mut self.rates);
            for (column, _) in self.basis.fixed_accelerations() {
                let mut rate = first.column_mut(column);
                rate.copy_from(&second.column(column));
                rate *= horizon;
            }
            let slopes = self.basis.fixed_slopes().map(|(column, _)| (column, horizon));
            let accelerations = self.basis.fixed_accelerations().map(|(column, _)| (column, 0.5 * horizon));
            for (column, factor) in slopes.chain(accelerations) {
                let mut given = self.coefficients.column_mut(column);
                given.copy_from(&first.column(column));
                given *= factor;
            }
        }
        let first = own + border - self.moving.len();
        for (i, k) in self.moving.iter().enumerate() {
            self.times[*k] = x[first + i];
        }
    }

    /// Sets path, horizons and times of waypoints of a candidate.
    pub fn put(&self, candidate: &mut Candidate) {
        candidate.path.coefficients.copy_from(&self.coefficients);
        candidate.horizons.assign(&self.horizons);
        candidate.times.clone_from(&self.times);
    }

    /// The horizon of a part for the unknowns `x`.
    pub fn horizon_at(&self, x: &DVector<f64>, part: usize) -> f64 {
        let free = self.free.parts.iter().position(|(of, _)| *of == part);
        match free {
            Some(k) => x[self.own() + k],
            None => self.horizons.parts()[part],
        }
    }

    /// The whole horizon for the unknowns `x`.
    pub fn whole_at(&self, x: &DVector<f64>) -> f64 {
        let parts = self.horizons.parts();
        match &self.free.parts[..] {
            [] => self.horizons.whole(),
            [_] if parts.len() == 1 => x[self.own()],
            _ => (0..parts.len()).map(|part| self.horizon_at(x, part)).sum::<f64>() * self.horizons.share(),
        }
    }

    /// True for the start and the end if its state is fixed.
    pub fn fixed_ends(&self) -> [bool; 2] {
        let ends = self.basis.continuity();
        let free = ends.free_final_velocity || ends.free_final_position;
        [!ends.free_start, !free]
    }

    /// Sets the diagonal of the norm of steps of the border: the relative change of the horizon, in its mean over all
    /// parts, and the mean way of the curve in the change of the time of a waypoint.
    pub fn norm_of_border(&self, corner: &mut DMatrix<f64>) {
        if !self.moving.is_empty() {
            // A curve that stays where it is has no slope.
            corner.fill_diagonal(self.mean_square_slope().max(LEAST_SQUARE_SLOPE));
        }
        for (k, (part, _)) in self.free.parts.iter().enumerate() {
            corner[(k, k)] = self.horizons.share() * self.horizons.parts()[*part].powi(-2);
        }
    }

    /// The mean square of the slope of the curve in normalised time.
    fn mean_square_slope(&self) -> f64 {
        let (grid, mut sum) = (&self.grid, 0.0);
        let mut states = DMatrix::zeros(self.coefficients.nrows(), grid.table.ncols());
        for e in 0..grid.segments {
            place(&self.coefficients, grid.first(e), &grid.table, &mut states);
            for (g, weight) in grid.weights.iter().enumerate() {
                sum += weight * states.column(3 * g + 1).norm_squared();
            }
        }
        sum
    }
}
