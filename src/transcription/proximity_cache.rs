//! The rows of the state that may be near their bounds, at the points of a grid and between them.

use crate::constraint::{ActivePair, Constraint};
use crate::scalar::{AlgebraOver, LANES, Lanes, Scalar, Wide};
use crate::spatial::Placement;
use std::ops::Range;

/// The rows that may be near their bounds, by groups of points that are evaluated side by side.
///
/// At first all rows of a group are evaluated, and clearances are listed while they are near. The others are far until
/// a body has moved by more than a distance since then, for no [gap](Constraint::gap) changes by more than its balls
/// move; then all are evaluated again. A point of a body that is `r` from its origin moves by at most
/// $|\Delta p| + r\\, |\Delta R|$, and the norm of a difference of two rotations is its Frobenius norm over $\sqrt 2$.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProximityCache {
    /// The value of each scaled row of the state below which it is not listed; NaN for those that always are.
    far: Vec<f64>,
    /// The bodies of clearances, with the largest distance of the centre of a ball from their origin, in m.
    bodies: Vec<(usize, f64)>,
    /// The distance by which a body may move, in m.
    moved: f64,
    /// The times of the points of a segment, in parts of it.
    times: Vec<f64>,
    groups: Vec<Group>,
    /// The pairs that were near each other at the last times between the points.
    pub(super) between_points: Vec<ActivePair<Wide>>,
}

/// The rows of a group.
#[derive(Clone, Debug, Default)]
struct Group {
    /// The listed rows in ascending order, and the placements of the bodies at the points then; none before.
    rows: Vec<usize>,
    placements: Vec<Placement<Wide>>,
    /// Rows that are listed although they are far: those of the working set, and those between the points.
    working: Vec<usize>,
    between: Vec<usize>,
    /// The pairs that were near each other at the last evaluation.
    active_pairs: Vec<ActivePair<Wide>>,
}

impl ProximityCache {
    /// Begins lists at points with these times in parts of each of several segments. Rows that are not listed are below
    /// the values of `far` until a body has moved by more than `moved`, in m; an infinite one lists its row.
    pub fn begin<K: Constraint>(&mut self, state: &K, far: &[f64], moved: f64, (times, segments): (Vec<f64>, usize)) {
        self.bodies.clear();
        self.far.clear();
        for (row, far) in far.iter().copied().enumerate() {
            let gap = state.row_set(row).distance.filter(|_| far.is_finite());
            self.far.push(gap.map_or(f64::NAN, |gap| {
                let moving = gap.bodies.iter().flatten();
                gap.value(gap.distance(far) + moving.count() as f64 * moved)
            }));
            for (body, r) in gap.iter().flat_map(|gap| gap.bodies).flatten() {
                match self.bodies.iter_mut().find(|(of, _)| *of == body) {
                    Some((_, most)) => *most = most.max(r),
                    None => self.bodies.push((body, r)),
                }
            }
        }
        let per_segment = times.len().div_ceil(LANES);
        self.groups = vec![Group::default(); segments * per_segment];
        (self.moved, self.times) = (moved, times);
    }

    /// Allocates memory for lists of all rows, of which `pairs` are of bodies with a plane between them.
    pub fn allocate(&mut self, pairs: usize) {
        let rows = if self.has_lists() { self.far.len() } else { 0 };
        for group in &mut self.groups {
            group.working.reserve(LANES * rows);
            group.between.reserve(rows);
            group.rows.reserve((LANES + 2) * rows);
            group.active_pairs.reserve(pairs);
        }
        self.between_points.reserve(pairs);
    }

    /// True if there are clearances to list.
    pub fn has_lists(&self) -> bool {
        !self.bodies.is_empty()
    }

    /// The group of the points from `start` on among all points of a segment, the first of which is `first`.
    pub fn group(&self, first: usize, start: usize, points: usize) -> Option<usize> {
        let is_known = points == self.times.len() && !self.groups.is_empty();
        is_known.then(|| first / points * points.div_ceil(LANES) + start / LANES)
    }

    /// The pairs that were near each other at the points of a group when it was evaluated last.
    pub(super) fn active_pairs(&mut self, group: usize) -> &mut Vec<ActivePair<Wide>> {
        &mut self.groups[group].active_pairs
    }

    /// Memory for the pairs between the points. In the part of a group they are those at its points for the first
    /// times, and for others those at the times before; elsewhere there are none.
    pub(super) fn begin_between(&mut self, group: Option<usize>, start: usize) -> Vec<ActivePair<Wide>> {
        let mut pairs = std::mem::take(&mut self.between_points);
        match group {
            Some(group) if start == 0 => pairs.clone_from(&self.groups[group].active_pairs),
            Some(_) => {}
            None => pairs.clear(),
        }
        pairs
    }

    /// The group of a point.
    fn of_point(&self, g: usize) -> usize {
        let points = self.times.len();
        g / points * points.div_ceil(LANES) + g % points / LANES
    }

    /// The rows that were listed last for a group.
    pub fn listed(&self, group: usize) -> &[usize] {
        &self.groups[group].rows
    }

    /// The rows that were listed last at a point, if there are lists.
    pub fn at(&self, g: usize) -> Option<&[usize]> {
        self.has_lists().then(|| self.listed(self.of_point(g)))
    }

    /// The rows of a group that may be near with the bodies placed like this at its points; `None` if others may be.
    /// Half of the distance is left for the times between the points.
    pub fn at_points(&self, group: usize, placed: &[Placement<Wide>]) -> Option<&[usize]> {
        let Group { rows, placements, .. } = &self.groups[group];
        let is_known = self.has_lists() && !placements.is_empty();
        (is_known && self.are_close(placed, |body| placements[body], 0.5 * self.moved)).then_some(rows)
    }

    /// The rows of a group that may be near with the bodies placed like this at the first of these times, which are in
    /// parts of the segment; `None` if others may be. Each time is compared with the nearest point.
    pub fn between(&self, group: usize, times: &[f64], placed: &[Placement<Wide>]) -> Option<&[usize]> {
        let Group { rows, placements, .. } = &self.groups[group];
        let first = group % self.times.len().div_ceil(LANES) * LANES;
        let points = &self.times[first..self.times.len().min(first + LANES)];
        let nearest: [usize; LANES] = std::array::from_fn(|lane| {
            let time = times[lane.min(times.len() - 1)];
            let middles = points.windows(2).map(|two| 0.5 * (two[0] + two[1]));
            middles.take_while(|middle| *middle < time).count()
        });
        let pick = |x: &Wide| Lanes(nearest.map(|point| x.0[point]));
        let other = |body: usize| {
            let Placement { rotation, translation } = &placements[body];
            Placement::new(rotation.map(|x| pick(&x)), translation.map(|x| pick(&x)))
        };
        let is_known = !placements.is_empty();
        (is_known && self.are_close(placed, other, self.moved)).then_some(rows)
    }

    /// Returns true if no ball has moved by more than `most` from the other placement of its body.
    fn are_close(&self, placed: &[Placement<Wide>], other: impl Fn(usize) -> Placement<Wide>, most: f64) -> bool {
        let add_square = |sum: Wide, x: &Wide| sum + *x * *x;
        self.bodies.iter().all(|(body, r)| {
            let (here, there) = (&placed[*body], other(*body));
            let (p, turn) = (here.translation - there.translation, here.rotation - there.rotation);
            let [p, turn] =
                [p.as_slice(), turn.as_slice()].map(|of| of.iter().fold(Wide::splat(0.0), add_square).sqrt());
            let moved = p + turn.scale(std::f64::consts::FRAC_1_SQRT_2 * r);
            // NaN is not close.
            moved.0.iter().fold(true, |all, moved| all & (*moved <= most))
        })
    }

    /// Lists the rows of a group that may be near, for the values of all rows at the first `found` points.
    pub fn list(
        &mut self,
        group: usize,
        placed: &[Placement<Wide>],
        (values, scales, found): (&[Wide], &[f64], usize),
    ) {
        let Group { rows, placements, working, between, .. } = &mut self.groups[group];
        placements.clear();
        placements.extend_from_slice(placed);
        rows.clear();
        let all = values.iter().zip(scales).zip(&self.far).enumerate();
        for (row, ((value, scale), far)) in all {
            // NaN counts as near.
            let is_far = |value: &f64| value * scale < *far;
            if !value.0[..found].iter().all(is_far) {
                rows.push(row);
            }
        }
        rows.extend(working.iter().chain(between.iter()));
        rows.sort_unstable();
        rows.dedup();
    }

    /// Takes the points and the rows of the working set in place of the last ones.
    pub fn set_working(&mut self, rows: impl Iterator<Item = (usize, usize)>) {
        if !self.has_lists() {
            return;
        }
        for group in &mut self.groups {
            group.working.clear();
        }
        for (g, row) in rows.filter(|(_, row)| *row < self.far.len()) {
            let group = self.of_point(g);
            self.groups[group].working.push(row);
        }
    }

    /// Lists a row at a point whatever its value is; returns true if it was not listed and so has to be evaluated.
    pub fn hold(&mut self, g: usize, row: usize) -> bool {
        if !self.has_lists() || row >= self.far.len() {
            return false;
        }
        let group = self.of_point(g);
        let Group { rows, placements, between, .. } = &mut self.groups[group];
        if !between.contains(&row) {
            between.push(row);
        }
        let is_missing = rows.binary_search(&row).is_err();
        if is_missing {
            placements.clear();
        }
        is_missing
    }

    /// Forgets the rows that were [held](Self::hold).
    pub fn release(&mut self) {
        for group in &mut self.groups {
            group.between.clear();
        }
    }

    /// The number of parts of a segment between the points: one for each group, or the segment itself without lists.
    pub fn parts(&self) -> usize {
        if self.has_lists() { self.times.len().div_ceil(LANES) } else { 1 }
    }

    /// The group of a part of a segment, and the part of the times between its first and its last one, `intervals`
    /// intervals from each other.
    pub fn part(&self, segment: usize, k: usize, intervals: usize) -> (Option<usize>, Range<usize>) {
        let count = self.parts();
        let end = |k: usize| match k {
            0 => 1,
            k if k == count => intervals,
            k => {
                let beside = [k * LANES - 1, k * LANES].map(|point| self.times[point]);
                let middle = 0.5 * (beside[0] + beside[1]) * intervals as f64;
                (middle.ceil() as usize).clamp(1, intervals)
            }
        };
        let group = self.has_lists().then_some(segment * count + k);
        (group, end(k)..end(k + 1))
    }
}
