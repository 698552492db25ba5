//! The unknowns of a program, and the candidates that they belong to.

use super::Candidate;
use super::ends::PeriodicEnds;
use super::program::Program;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::nlp::{Bordered, Iterate, Kkt};
use nalgebra::{DMatrix, DVector};

/// The least mean square of slopes in the norm of the times of waypoints, rad^2: that of a motion by a milliradian.
const LEAST_SQUARE_SLOPE: f64 = 1e-6;

/// The functions with free coefficients: slope and value at the start of a periodic motion, those whose coefficients
/// are the first unknowns, and slope and value at the end, which follow from those at the start.
fn parts(free: &[usize], is_periodic: bool) -> [&[usize]; 3] {
    let ends = 2 * usize::from(is_periodic);
    let (start, rest) = free.split_at(ends);
    let (between, end) = rest.split_at(rest.len() - ends);
    [start, between, end]
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// The known multipliers at the points, without those of rows beside ends that another program had.
    pub fn known_multipliers<'k>(&self, of: &Candidate, known: &'k mut Vec<f64>) -> Option<&'k [f64]> {
        let count = self.objective.cost().rows.count();
        of.multipliers.at_in(&self.grid.times, count, known)?;
        known.truncate(self.range_of_points().end);
        Some(known)
    }

    /// Sets the multipliers of a candidate to those of an iterate, but those of waypoints and of a goal.
    pub fn put_multipliers(&mut self, iterate: &Iterate, candidate: &mut Candidate) {
        iterate.multipliers_in(self.margins.len(), &mut self.multipliers);
        let (all, rows) = (&self.multipliers, &self.objective.cost().rows);
        candidate.multipliers.put(&self.grid, rows, all);
    }

    /// The norm of steps: the mean square of the velocities in normalised time, the relative change of the horizon, in
    /// its mean over all parts, the mean way of the curve in the change of the time of a waypoint, and the square of
    /// the change of the configuration at the ends of a periodic motion.
    pub fn kkt(&self) -> Option<Kkt> {
        let mut norm = Bordered::with_border(self.objective.gram(), self.border());
        self.norm_of_border(&mut norm.corner);
        if let Some(period) = &self.period {
            norm = period.reduced(&norm);
            let (n, order) = (self.objective.dof(), norm.corner.nrows());
            for value in order - n..order {
                norm.corner[(value, value)] += 1.0;
            }
        }
        Kkt::new(norm)
    }

    /// Begins with the norm of the current horizon and times.
    pub fn restart_kkt(&self, kkt: &mut Kkt) {
        kkt.restart(|corner| self.norm_of_border(corner));
    }

    /// Sets the diagonal of the norm of steps of the border.
    fn norm_of_border(&self, corner: &mut DMatrix<f64>) {
        if !self.moving.is_empty() {
            // A curve that stays where it is has no slope.
            corner.fill_diagonal(self.mean_square_slope().max(LEAST_SQUARE_SLOPE));
        }
        for (k, (part, _)) in self.free.parts.iter().enumerate() {
            corner[(k, k)] = self.horizons.share() * self.horizons.parts()[*part].powi(-2);
        }
    }

    /// The unknowns of a curve in the basis.
    pub fn unknowns(&self, of: &Candidate) -> DVector<f64> {
        let ends = self.period.as_ref().map_or(0, PeriodicEnds::count);
        let mut x = DVector::zeros(self.own() + self.border() + ends);
        self.unknowns_in(of, &mut x);
        x
    }

    /// Computes the unknowns of a curve in the basis.
    pub fn unknowns_in(&self, of: &Candidate, x: &mut DVector<f64>) {
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

    /// Sets path, horizons and times of waypoints of a candidate to those of unknowns.
    pub fn put(&mut self, x: &DVector<f64>, candidate: &mut Candidate) {
        self.place(x);
        candidate.path.coefficients.copy_from(&self.coefficients);
        candidate.horizons.assign(&self.horizons);
        candidate.times.clone_from(&self.times);
    }

    /// The number of unknown coefficients before the unknowns of the border.
    pub(super) fn own(&self) -> usize {
        let ends = self.period.as_ref().map_or(0, PeriodicEnds::count);
        self.derivatives.gradient.len() - 2 * ends
    }

    /// Sets coefficients, horizons and times.
    pub(super) fn place(&mut self, x: &DVector<f64>) {
        let (grid, n, own) = (self.grid.clone(), self.objective.dof(), self.own());
        let [start, between, end] = parts(&grid.free, self.period.is_some());
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
            for (column, _) in self.basis.fixed_slopes() {
                let mut slope = self.coefficients.column_mut(column);
                slope.copy_from(&self.rates.column(column));
                slope *= self.horizons.whole();
            }
        }
        self.set_times(x);
        self.objective.set_horizons(&self.horizons);
    }
}
