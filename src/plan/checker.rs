//! The test of configurations for collisions and limits.

use super::InverseKinematics;
use super::distances::Distances;
use crate::constraint::{AnyConstraint, Constraint, Evaluator};
use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::{LANES, Wide};
use std::ops::Range;

/// The number of parts of a line, four configurations each, up to which they are checked one by one after the first
/// four. More are checked four by four, so that collisions in other parts of the line are found.
const PARTS: usize = 8;

/// The share of a line below which intervals count as empty, as rounding makes them.
const EMPTY: f64 = 1e-9;

/// The test whether configurations are free: every row of a constraint is within its bound at `(q, v = 0)`, except for
/// those of sets of poses with equalities, which a [plan](super::plan) keeps by projection.
#[derive(Debug)]
pub struct Checker<'a, K: ?Sized> {
    model: &'a Model,
    constraint: &'a K,
    evaluator: Evaluator<'a, f64, Wide>,
    /// The motion of a joint below which a line is not divided further.
    resolution: f64,
    /// The rows that are distances or bounds of positions.
    distances: Distances<'a>,
    /// True if there are others; then the rows of all are computed.
    has_others: bool,
    /// The pairs of distances, those first that were not free last.
    order: Vec<usize>,
    /// The largest value of each row that counts as free.
    bounds: Vec<f64>,
    scales: Vec<f64>,
    /// The search for configurations that keep the sets with equalities, if there are any.
    projection: Option<InverseKinematics<'a, [AnyConstraint]>>,
    /// $[q; 0]$ of several configurations, and the rows there.
    x: Vec<Wide>,
    g: Vec<Wide>,
    checks: usize,
    /// The number of configurations after which a line counts as not free.
    most_checks: usize,
    parts: Vec<Part>,
    /// The pairs of each part.
    near: Vec<usize>,
    found: Vec<(usize, u8)>,
}

/// A part of a line, and the pairs that may not be free there.
#[derive(Clone, Debug)]
struct Part {
    begin: f64,
    end: f64,
    pairs: Range<usize>,
}

impl<'a, K: Constraint + ?Sized> Checker<'a, K> {
    /// Prepares the test for the rows of `constraint`, with lines checked whenever a joint has moved by `resolution`,
    /// rad or m, which is positive, or less often where distances are large.
    ///
    /// # Errors
    /// The constraint fails at the configuration zero, such as one with another number of joints.
    pub fn new(model: &'a Model, constraint: &'a K, resolution: f64) -> Result<Self> {
        let (rows, zero) = (constraint.dim(), Wide::splat(0.0));
        let bound = |row| if constraint.row_set(row).is_equality { f64::INFINITY } else { 0.0 };
        let scales = constraint.row_scales();
        let mut checker = Self {
            model,
            constraint,
            evaluator: Evaluator::new(model),
            resolution,
            distances: Distances::default(),
            has_others: true,
            order: Vec::new(),
            bounds: (0..rows).map(bound).collect(),
            scales,
            projection: None,
            x: vec![zero; 2 * model.dof()],
            g: vec![zero; rows],
            checks: 0,
            most_checks: usize::MAX,
            parts: Vec::new(),
            near: Vec::new(),
            found: Vec::new(),
        };
        // Refuses bodies that the robot does not have.
        checker.evaluate()?;
        let mut parts = Vec::new();
        let all = constraint.parts(&mut parts);
        let (distances, others) = Distances::new(model, &parts);
        checker.has_others = others || !all;
        checker.order = (0..distances.pairs()).collect();
        checker.distances = distances;
        Ok(checker)
    }

    /// Takes a line for not free where so many configurations do not decide it, as between ends that are far apart.
    pub(super) fn limit(&mut self, most_checks: usize) {
        self.most_checks = most_checks;
    }

    /// Takes configurations to these sets, which they keep then, within bounds of the joints.
    pub(super) fn project_onto(&mut self, sets: &'a [AnyConstraint], bounds: Vec<[f64; 2]>) -> Result<()> {
        if !sets.is_empty() {
            self.projection = Some(InverseKinematics::new(self.model, sets, bounds)?);
        }
        Ok(())
    }

    /// True if there are sets with equalities.
    pub(super) fn is_projected(&self) -> bool {
        self.projection.is_some()
    }

    /// A configuration near to this one that keeps the sets with equalities; `None` if none is found.
    pub(super) fn projected(&mut self, q: Vec<f64>) -> Result<Option<Vec<f64>>> {
        let Some(search) = &mut self.projection else {
            return Ok(Some(q));
        };
        // So that a search for configurations that do not exist ends.
        self.checks += 1;
        let end = search.solve(&q)?;
        let kept = end.violation <= InverseKinematics::<[AnyConstraint]>::TOLERANCE;
        Ok(kept.then_some(end.q))
    }

    /// Requires every distance and row to be `margin` inside its bound, in its unit, or as far inside as at both `ends`
    /// if that is less. The distance of a link from an obstacle or from another link is that of their nearest balls.
    ///
    /// # Errors
    /// An end does not have `N` entries.
    pub fn keep(&mut self, margin: f64, ends: [&[f64]; 2]) -> Result<()> {
        self.place(&ends)?;
        self.evaluate()?;
        for ((bound, scale), g) in self.bounds.iter_mut().zip(&self.scales).zip(&self.g) {
            *bound = g.0.iter().copied().fold(-margin * scale, f64::max);
        }
        let placed = self.evaluator.at(&self.x)?;
        self.distances.keep(margin, &self.x, placed.state().placements);
        Ok(())
    }

    /// The row that a configuration violates most, and the violation in the unit of the row: negative if all rows are
    /// satisfied. A row that is NaN has an infinite violation; without rows the violation is minus infinity.
    ///
    /// # Errors
    /// `q` does not have `N` entries.
    pub fn worst(&mut self, q: &[f64]) -> Result<(usize, f64)> {
        self.place(&[q])?;
        self.evaluate()?;
        let mut worst = (0, f64::NEG_INFINITY);
        for (row, (g, scale)) in self.g.iter().zip(&self.scales).enumerate() {
            let is_equality = self.bounds[row] == f64::INFINITY;
            let by = if is_equality { g.0[0].abs() / scale } else { g.0[0] / scale };
            let by = if by.is_nan() { f64::INFINITY } else { by };
            if by > worst.1 {
                worst = (row, by);
            }
        }
        Ok(worst)
    }

    /// Returns true if a configuration is free.
    ///
    /// # Errors
    /// `q` does not have `N` entries.
    pub fn is_free(&mut self, q: &[f64]) -> Result<bool> {
        self.are_free(&[q])
    }

    /// Returns true if the straight line between two configurations, without its beginning, is free: each distance is
    /// so large that it cannot vanish between checked configurations, or these are at most the resolution apart.
    /// Widely spaced ones are checked first, so that collisions are found early.
    ///
    /// # Errors
    /// A configuration does not have `N` entries.
    pub fn is_line_free(&mut self, from: &[f64], to: &[f64]) -> Result<bool> {
        let n = self.x.len() / 2;
        for q in [from, to] {
            check_length("q", n, q.len())?;
        }
        let moves: Vec<f64> = from.iter().zip(to).map(|(a, b)| (b - a).abs()).collect();
        let farthest = moves.iter().copied().fold(0.0, f64::max);
        self.distances.begin_line(&moves);
        self.near.clone_from(&self.order);
        self.parts.clear();
        self.parts.push(Part { begin: 0.0, end: 1.0, pairs: 0..self.near.len() });
        let (mut next, before) = (0, self.checks);
        while let Some(Part { begin, end, pairs }) = self.parts.get(next).cloned() {
            // The first ones include the end, which is most often not free.
            let (first, spacing) = match next {
                0 => (1.0 / 7.0, 2.0 / 7.0),
                _ => (begin + (end - begin) / 8.0, (end - begin) / 4.0),
            };
            next += 1;
            if self.checks - before >= self.most_checks {
                return Ok(false);
            }
            for lane in 0..LANES {
                let share = (first + spacing * lane as f64).min(1.0);
                for ((x, a), b) in self.x.iter_mut().zip(from).zip(to) {
                    x.0[lane] = a + share * (b - a);
                }
            }
            let is_fine = spacing * farthest <= self.resolution;
            let reach = if is_fine { 0.0 } else { 0.5 * spacing + EMPTY };
            if !self.looks_free(LANES, pairs, reach)? {
                return Ok(false);
            }
            if is_fine {
                continue;
            }
            let needed = ((end - begin) * farthest / (4.0 * self.resolution)).ceil() as usize;
            let count = if needed <= PARTS { needed } else { LANES };
            for k in 0..count {
                let at = |k: usize| begin + (end - begin) * k as f64 / count as f64;
                let (begin, end) = (at(k), at(k + 1));
                let mut lanes = 0;
                for lane in 0..LANES {
                    let beside = first + spacing * lane as f64 - 0.5 * spacing;
                    if beside + EMPTY < end && beside + spacing > begin + EMPTY {
                        lanes |= 1 << lane;
                    }
                }
                let from = self.near.len();
                let found = self.found.iter().filter(|(_, near)| near & lanes != 0);
                self.near.extend(found.map(|(pair, _)| *pair));
                if from < self.near.len() || self.has_others {
                    self.parts.push(Part { begin, end, pairs: from..self.near.len() });
                }
            }
        }
        Ok(true)
    }

    /// Returns true if all configurations are free.
    ///
    /// # Errors
    /// A configuration does not have `N` entries.
    pub fn are_free<Q: AsRef<[f64]>>(&mut self, all: &[Q]) -> Result<bool> {
        for some in all.chunks(LANES) {
            self.place(some)?;
            self.near.clone_from(&self.order);
            if !self.looks_free(some.len(), 0..self.order.len(), 0.0)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The number of configurations checked so far.
    #[must_use]
    pub fn checks(&self) -> usize {
        self.checks
    }

    /// Returns true if the configurations in `x` are free as to these of the near pairs, and collects those that may
    /// not be within the share `reach` of a line.
    fn looks_free(&mut self, count: usize, pairs: Range<usize>, reach: f64) -> Result<bool> {
        self.checks += count;
        self.found.clear();
        if !self.distances.is_inside(&self.x) {
            return Ok(false);
        }
        let placed = self.evaluator.at(&self.x)?;
        self.distances.place(placed.state().placements);
        for pair in &self.near[pairs] {
            let look = self.distances.look(*pair, placed.state().placements, reach);
            if look.hit {
                if let Some(at) = self.order.iter().position(|other| other == pair) {
                    self.order[..=at].rotate_right(1);
                }
                return Ok(false);
            }
            if look.near != 0 {
                self.found.push((*pair, look.near));
            }
        }
        if self.has_others {
            placed.value(self.constraint, &mut self.g)?;
            let mut rows = self.g.iter().zip(&self.bounds);
            // False for NaN.
            return Ok(rows.all(|(g, bound)| g.0.iter().all(|g| g <= bound)));
        }
        Ok(true)
    }

    /// Takes one to four configurations into `x`; unused lanes hold the last one.
    fn place<Q: AsRef<[f64]>>(&mut self, some: &[Q]) -> Result<()> {
        let n = self.x.len() / 2;
        for lane in 0..LANES {
            let q = some[lane.min(some.len() - 1)].as_ref();
            check_length("q", n, q.len())?;
            for (x, q) in self.x.iter_mut().zip(q) {
                x.0[lane] = *q;
            }
        }
        Ok(())
    }

    /// Computes all rows.
    fn evaluate(&mut self) -> Result<()> {
        let placed = self.evaluator.at(&self.x)?;
        placed.value(self.constraint, &mut self.g)
    }
}
