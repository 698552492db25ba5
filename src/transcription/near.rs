//! The rows of the state that may be near their bounds, at the points of a grid.

use crate::constraint::Constraint;
use crate::scalar::{LANES, Wide};
use crate::spatial::Placement;
use std::ops::Range;

/// The rows that may be near their bounds, at points that are evaluated side by side: a group.
///
/// All rows of a group are evaluated at first, and clearances are listed while they are near their bounds. The others
/// are far until a body has moved further than a distance since then, because no clearance of two balls changes by more
/// than their centres move; then all rows are evaluated again. A point of a body that is `r` from its origin moves by
/// at most $|\Delta p| + r |\Delta R|$, and the norm of a difference of rotations is its Frobenius norm over
/// $\sqrt 2$.
#[derive(Clone, Debug, Default)]
pub(crate) struct Near {
    /// The value of each scaled row below which it is far; not a number for those that never are.
    far: Vec<f64>,
    /// The bodies of clearances, with the largest distance of a ball from their origin.
    bodies: Vec<(usize, f64)>,
    /// The distance by which a body may move, in m.
    moved: f64,
    /// The times of the points, in parts of a segment; no points without lists.
    times: Vec<f64>,
    groups: Vec<Group>,
}

/// The rows of a group.
#[derive(Clone, Debug, Default)]
struct Group {
    /// The rows that may be near in ascending order, and the placements of the bodies at which they were; none before.
    rows: Vec<usize>,
    placements: Vec<Placement<Wide>>,
    /// Rows that are listed although they are far: those of the working set, and those that have a margin.
    working: Vec<usize>,
    raised: Vec<usize>,
}

impl Near {
    /// Begins lists for segments with points at these times, for rows that are far below these values until a body has
    /// moved by a distance, in m.
    pub fn begin<K: Constraint>(
        &mut self,
        state: &K,
        far: impl Iterator<Item = f64>,
        moved: f64,
        (times, segments): (Vec<f64>, usize),
    ) {
        self.bodies.clear();
        self.far.clear();
        let mut any = false;
        for (row, far) in far.enumerate() {
            let Some(gap) = state.gap(row).filter(|_| far.is_finite()) else {
                self.far.push(f64::NAN);
                continue;
            };
            any = true;
            for ball in gap.balls.iter().flatten() {
                let Some(body) = ball.body else { continue };
                let r = ball.centre.norm();
                match self.bodies.iter_mut().find(|(of, _)| *of == body) {
                    Some((_, most)) => *most = most.max(r),
                    None => self.bodies.push((body, r)),
                }
            }
            let least = gap.distance(far) + gap.moving() as f64 * moved;
            self.far.push(gap.value(least));
        }
        self.moved = moved;
        let groups = if any { times.len().div_ceil(LANES) * segments } else { 0 };
        self.groups = vec![Group::default(); groups];
        self.times = times;
    }

    /// The group of the points from `start` on of a segment that begins with point `first`, if there are lists.
    pub fn group(&self, first: usize, start: usize, points: usize) -> Option<usize> {
        let own = points == self.times.len() && !self.groups.is_empty();
        own.then(|| first / points * points.div_ceil(LANES) + start / LANES)
    }

    /// The rows of a group that may be near with the bodies placed like this; `None` if any may be.
    pub fn rows(&self, group: usize, placed: &[Placement<Wide>]) -> Option<&[usize]> {
        let Group { rows, placements, .. } = &self.groups[group];
        let same = |body: usize| placements[body];
        (!placements.is_empty() && self.is_close(placed, same, 0.5 * self.moved)).then_some(rows)
    }

    /// The rows that were listed last at a point, if there are lists.
    pub fn at(&self, g: usize) -> Option<&[usize]> {
        (!self.groups.is_empty()).then(|| self.last(self.of_point(g)))
    }

    /// The rows that were listed last for a group.
    pub fn last(&self, group: usize) -> &[usize] {
        &self.groups[group].rows
    }

    /// The same at other points, near these times of the segment.
    pub fn rows_between(
        &self,
        group: usize,
        times: &[f64],
        placed: &[Placement<Wide>],
    ) -> Option<&[usize]> {
        let Group { rows, placements, .. } = &self.groups[group];
        let first = group % self.times.len().div_ceil(LANES) * LANES;
        let own = &self.times[first..self.times.len().min(first + LANES)];
        let lanes: [usize; LANES] = std::array::from_fn(|lane| {
            let time = times[lane.min(times.len() - 1)];
            let after = own.partition_point(|t| *t < time);
            match after {
                0 => 0,
                k if k == own.len() => k - 1,
                k if time - own[k - 1] < own[k] - time => k - 1,
                k => k,
            }
        });
        let nearest = |body: usize| {
            let of: &Placement<Wide> = &placements[body];
            let pick = |x: &Wide| crate::scalar::Lanes(lanes.map(|lane| x.0[lane]));
            Placement::new(of.rotation.map(|x| pick(&x)), of.translation.map(|x| pick(&x)))
        };
        (!placements.is_empty() && self.is_close(placed, nearest, self.moved)).then_some(rows)
    }

    /// Returns true if no body has moved further than allowed from its other placement.
    fn is_close(
        &self,
        placed: &[Placement<Wide>],
        other: impl Fn(usize) -> Placement<Wide>,
        most: f64,
    ) -> bool {
        self.bodies.iter().all(|(body, r)| {
            let (here, there) = (&placed[*body], other(*body));
            let square = |sum: Wide, x: Wide| sum + x * x;
            let zero = Wide::splat(0.0);
            let turned = (here.rotation - there.rotation).iter().fold(zero, |sum, x| square(sum, *x));
            let moved = (here.translation - there.translation).iter().fold(zero, |sum, x| square(sum, *x));
            let distances = moved.0.iter().zip(turned.0);
            // NaN is not close.
            distances
                .map(|(moved, turned)| moved.sqrt() + r * (0.5 * turned).sqrt())
                .fold(true, |close, moved| close & (moved <= most))
        })
    }

    /// Lists the rows of a group that may be near, for values of all rows at `found` points.
    pub fn list(
        &mut self,
        group: usize,
        placed: &[Placement<Wide>],
        (values, scales, found): (&[Wide], &[f64], usize),
    ) {
        let Group { rows, placements, working, raised } = &mut self.groups[group];
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
        rows.extend(working.iter().chain(raised.iter()));
        rows.sort_unstable();
        rows.dedup();
    }

    /// The group of a point.
    fn of_point(&self, g: usize) -> usize {
        let points = self.times.len();
        g / points * points.div_ceil(LANES) + g % points / LANES
    }

    /// Takes the rows of the working set, by points, in place of the last ones.
    pub fn set_working(&mut self, rows: impl Iterator<Item = (usize, usize)>) {
        if self.groups.is_empty() {
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

    /// Lists a row at a point; returns true if it was not listed, so that all rows have to be evaluated there.
    pub fn raise(&mut self, g: usize, row: usize) -> bool {
        if self.groups.is_empty() || row >= self.far.len() {
            return false;
        }
        let group = self.of_point(g);
        let Group { rows, placements, raised, .. } = &mut self.groups[group];
        let is_new = !raised.contains(&row);
        if is_new {
            raised.push(row);
        }
        let missing = rows.binary_search(&row).is_err();
        if missing {
            placements.clear();
        }
        missing
    }

    /// Forgets the rows that have a margin.
    pub fn lower(&mut self) {
        for group in &mut self.groups {
            group.raised.clear();
        }
    }

    /// The groups of a segment, each with its part of `intervals` intervals between the points.
    pub fn parts(&self, segment: usize, intervals: usize) -> impl Iterator<Item = (Option<usize>, Range<usize>)> + use<> {
        let count = match self.groups.is_empty() {
            true => 1,
            false => self.times.len().div_ceil(LANES),
        };
        let with_lists = !self.groups.is_empty();
        // The middle between the last point of a group and the first one of the next.
        let ends: Vec<_> = (1..=count).map(|k| match k * LANES {
            next if k < count && with_lists => {
                let middle = 0.5 * (self.times[next - 1] + self.times[next]);
                ((middle * intervals as f64).ceil() as usize).clamp(1, intervals)
            }
            _ => intervals,
        }).collect();
        (0..count).scan(1, move |begin, k| {
            let own = *begin..ends[k].max(*begin);
            *begin = own.end;
            Some((with_lists.then_some(segment * count + k), own))
        })
    }
}
