//! A curve with its multipliers.

use super::place::Place;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::curve::{Basis, Curve};
use crate::direct::{DirectSettings, parts};
use crate::error::{Error, Result};
use crate::motion::{Path, Problem, curve_of, path_of, states_at_nodes};
use crate::transcription::{Grid, Horizons, Rows};

/// The start or the end of a minimisation.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub path: Path,
    pub horizons: Horizons<f64>,
    /// The alternative of a [goal](crate::direct::GoalSet) that is a set.
    pub alternative: usize,
    /// The normalised times of the waypoints.
    pub times: Vec<f64>,
    pub multipliers: Multipliers,
    /// The first penalty of a violation, if it is not that of the options.
    pub penalty: Option<f64>,
    /// The integral of the running cost by a quadrature finer than that of the minimisation.
    pub cost: f64,
    /// The same with the cost of time.
    pub objective: f64,
    /// The largest excess of a row, in its unit; negative in the interior.
    pub violation: f64,
    /// The largest torque of a passive joint between its collocated points, relative to the largest torque.
    pub passive_share: f64,
    /// The largest deviation of an equality of the state between its collocated points, in its unit.
    pub deviation: f64,
    pub gradient_norm: f64,
    /// The gradient of the Lagrangian, relative to the cost.
    pub stationarity: f64,
    /// The last barrier parameter, relative to the cost and summed over all rows.
    pub complementarity: f64,
    pub smallest_curvature: f64,
    pub points: usize,
    /// The relative difference between the quadrature and the finer one.
    pub quadrature_error: f64,
    /// True if all convergence criteria are met.
    pub converged: bool,
    /// True if the curve satisfies the constraints but not all other criteria.
    pub kept: bool,
}

/// The polynomials of a curve in parts through Chebyshev nodes, with $v = \dot q$.
fn curve_in_parts(path: &Path, horizons: &Horizons<f64>) -> Result<Curve> {
    let segments = path.basis.segments();
    let x = states_at_nodes(path, |time| {
        let place = Place::new(&path.basis, &path.coefficients, time, horizons);
        let horizon = horizons.parts()[horizons.part(place.segment, segments)];
        [place.q.column(0).into_owned(), place.q.column(1) / horizon]
    })?;
    let lengths = horizons.parts().iter().map(|part| part * horizons.share());
    Curve::in_parts(&lengths.collect::<Vec<_>>(), segments, x)
}

/// A curve in parts in another basis, whose breakpoints are among its own.
fn in_parts(path: &Path, horizons: &Horizons<f64>, basis: Basis) -> Path {
    let dof = path.coefficients.nrows();
    let coefficients = basis.fit(dof, |time| {
        let place = Place::new(&path.basis, &path.coefficients, time, horizons);
        [0, 1, 2].map(|d| place.q.column(d).into_owned())
    });
    let mut path = Path { basis, coefficients };
    unstretch(&mut path, horizons);
    path
}

/// Divides the slopes at breakpoints, in normalised time, by the factors of their parts, so that they are slopes in the
/// time of the reference.
fn unstretch(path: &mut Path, horizons: &Horizons<f64>) {
    let segments = path.basis.segments();
    for breakpoint in 0..=segments {
        let (segment, _) = path.basis.functions_at(breakpoint as f64 / segments as f64);
        let part = horizons.part(segment, segments);
        let mut slope = path.coefficients.column_mut(path.basis.slope(breakpoint));
        slope /= horizons.stretch(part).unwrap_or(1.0);
    }
}

/// Multipliers of all rows at given normalised times, with which a search can begin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Multipliers {
    pub(crate) times: Vec<f64>,
    /// The multipliers, row by row for each time.
    pub(crate) values: Vec<f64>,
    /// The multipliers of the rows of waypoints and of a goal.
    pub(crate) of_points: Vec<f64>,
}

impl Candidate {
    /// The motion.
    pub fn curve(&self, problem: &Problem<'_>) -> Result<Curve> {
        let problem = problem.with_horizon(self.horizons.whole())?;
        match self.horizons.reference() {
            None => curve_of(&problem, &self.path),
            Some(_) => curve_in_parts(&self.path, &self.horizons),
        }
    }

    /// The start along a curve: its shape between the ends of a problem, in the basis of the settings.
    pub fn of_curve(curve: &Curve, problem: &Problem<'_>, settings: &DirectSettings) -> Self {
        let basis = settings.basis(problem);
        if curve.parts() == 1 || curve.parts() != settings.parts.len() {
            let path = path_of(curve, basis).between_ends_of(problem);
            return Self::new(path, problem.horizon());
        }
        let (own, horizon) = (|part| curve.horizon_of(part), problem.horizon());
        let horizons = Horizons::of_parts((0..curve.parts()).map(own).collect(), horizon);
        let mut path = path_of(curve, basis);
        unstretch(&mut path, &horizons);
        Self {
            horizons: parts::horizons(&settings.parts, own, horizon),
            ..Self::new(path.between_ends_of(problem), horizon)
        }
    }

    /// The time at a normalised one, s.
    pub fn time(&self, normalised: f64) -> f64 {
        let basis = &self.path.basis;
        let (segment, _) = basis.functions_at(normalised);
        let part = self.horizons.part(segment, basis.segments());
        self.horizons.time(part, normalised)
    }

    /// Changes to the same curve, or its best approximation, in another basis.
    pub fn change_basis(&mut self, basis: Basis) {
        let path = &self.path;
        self.path = match self.horizons.reference() {
            None => path.in_basis(basis),
            Some(_) => in_parts(path, &self.horizons, basis),
        };
    }

    /// An untested curve.
    pub fn new(path: Path, horizon: f64) -> Self {
        Self {
            path,
            horizons: Horizons::one(horizon),
            alternative: 0,
            times: Vec::new(),
            multipliers: Multipliers::default(),
            penalty: None,
            cost: f64::NAN,
            objective: f64::NAN,
            violation: f64::NAN,
            passive_share: 0.0,
            deviation: 0.0,
            gradient_norm: f64::NAN,
            stationarity: f64::NAN,
            complementarity: 0.0,
            smallest_curvature: f64::NAN,
            points: 0,
            quadrature_error: f64::NAN,
            converged: false,
            kept: false,
        }
    }
}

impl Multipliers {
    /// Multipliers at ascending normalised times: those of `rows` rows that are not zero, by time, row and value, and
    /// those of waypoints and of a goal.
    ///
    /// # Errors
    /// An entry has no such time or row, an entry or a time is not finite, or the times do not ascend.
    pub fn of_entries(
        times: Vec<f64>,
        rows: usize,
        entries: &[(usize, usize, f64)],
        of_points: Vec<f64>,
    ) -> Result<Self> {
        let refuse = |element, condition| Err(Error::input("multipliers", element, condition));
        if !(times.iter().all(|t| t.is_finite()) && times.is_sorted()) {
            return refuse("times", "they are not finite and ascending");
        }
        let mut values = vec![0.0; times.len() * rows];
        for (at, row, value) in entries {
            if *at >= times.len() || *row >= rows || !value.is_finite() {
                return refuse("entries", "one is at no time or row, or not finite");
            }
            values[at * rows + row] = *value;
        }
        Ok(Self { times, values, of_points })
    }

    /// The normalised times.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.times.len().max(1)
    }

    /// The multipliers of at least the share `least` of the largest one, by time, row and value.
    #[must_use]
    pub fn entries(&self, least: f64) -> Vec<(usize, usize, f64)> {
        let (rows, values) = (self.rows(), self.values.iter());
        let largest = values.clone().fold(0.0, |most: f64, z| most.max(z.abs()));
        let own = values.enumerate();
        let own = own.filter(|(_, z)| **z != 0.0 && z.abs() >= least * largest);
        own.map(|(at, z)| (at / rows, at % rows, *z)).collect()
    }

    /// The multipliers of the rows of waypoints and of a goal.
    #[must_use]
    pub fn of_points(&self) -> &[f64] {
        &self.of_points
    }

    /// Takes over the multipliers of rows, row by row for each point of a grid, but not those of waypoints and a goal.
    /// The multiplier of a row at a point where it is not enforced is interpolated between the neighbouring points
    /// where it is.
    pub(crate) fn put<K: Constraint, P: CostWithControl>(
        &mut self,
        grid: &Grid<f64>,
        rows: &Rows<'_, K, P>,
        all: &[f64],
    ) {
        let count = rows.count();
        let Self { times, values, .. } = self;
        times.clone_from(&grid.times);
        values.clear();
        values.extend_from_slice(&all[..times.len() * count]);
        if grid.collocated.contains(&true) {
            for (row, equality) in rows.attributes().equalities.iter().enumerate() {
                let idle = |g: &usize| grid.collocated[g % grid.points()] != *equality;
                let (without, with): (Vec<usize>, Vec<usize>) = (0..times.len()).partition(idle);
                let held = Self {
                    times: with.iter().map(|g| times[*g]).collect(),
                    values: with.iter().map(|g| values[g * count + row]).collect(),
                    ..Self::default()
                };
                for g in without {
                    let between = held.at(&times[g..=g], 1);
                    values[g * count + row] = between.map_or(0.0, |z| z[0]);
                }
            }
        }
    }

    /// The multipliers for a multiple of the objective.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let by = |values: &[f64]| values.iter().map(|z| factor * z).collect();
        Self { values: by(&self.values), of_points: by(&self.of_points), ..self.clone() }
    }

    /// The multipliers after a change of the cost of a second from one value to another, which they follow as the
    /// objective does; `density` is its cost per second without that.
    #[must_use]
    pub fn reweighted(&self, density: f64, [before, after]: [f64; 2]) -> Self {
        self.scaled((density + after) / (density + before))
    }

    /// Takes over other multipliers in the memory of these.
    pub(crate) fn set(&mut self, from: &Self) {
        self.times.clone_from(&from.times);
        self.values.clone_from(&from.values);
        self.of_points.clone_from(&from.of_points);
    }

    /// Changes the times to those of the rest of a motion after this share of it, from 0 to less than 1.
    pub(crate) fn begin_after(&mut self, share: f64) {
        for time in &mut self.times {
            *time = (*time - share) / (1.0 - share);
        }
    }

    /// The multipliers at other times, interpolated linearly, then those of waypoints and of a goal; `None` without
    /// multipliers.
    pub(crate) fn at(&self, times: &[f64], rows: usize) -> Option<Vec<f64>> {
        let mut found = Vec::new();
        self.at_in(times, rows, &mut found).map(|()| found)
    }

    /// Computes [`at`](Self::at) into `found`.
    pub(crate) fn at_in(&self, times: &[f64], rows: usize, found: &mut Vec<f64>) -> Option<()> {
        let last = self.times.len().checked_sub(1)?;
        found.clear();
        found.resize(times.len() * rows, 0.0);
        for (time, to) in times.iter().zip(found.chunks_exact_mut(rows.max(1))) {
            let after = self.times.partition_point(|t| t < time);
            let (a, b) = (after.saturating_sub(1), after.min(last));
            let span = self.times[b] - self.times[a];
            let share = if span > 0.0 { (time - self.times[a]) / span } else { 0.0 };
            for (row, to) in to.iter_mut().enumerate() {
                let [x, y] = [a, b].map(|i| self.values[i * rows + row]);
                *to = x + share * (y - x);
            }
        }
        found.extend(&self.of_points);
        Some(())
    }
}
