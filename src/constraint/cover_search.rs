//! The search for the nearest balls of covers.

use super::{ActivePair, ActivePairs, CoverClearance, PlacedState};
use crate::error::{Error, Result};
use crate::geometry::{BallTree, FLAT, SETS};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Placement, dot};
use nalgebra::Vector3;
use std::ops::Range;

/// The number of balls of two links up to which all their pairs are compared: 64 squares of distances cost about as
/// much as four bounds.
const MAX_COMPARED: usize = 8;

/// The nearest of several distances.
#[derive(Clone, Copy)]
pub(super) struct Nearest<S: Scalar> {
    /// The row.
    pub g: S,
    /// The centres of the balls.
    pub points: [Vector3<S>; 2],
    /// Negative if all are far.
    pub is_near: S,
}

impl<S: Scalar> Nearest<S> {
    fn none(least: S) -> Self {
        Self { g: least, points: [Vector3::zeros(); 2], is_near: -S::one() }
    }

    /// Takes a row with a larger value, or one that is not a number, and its points if they are needed.
    #[inline]
    fn take(&mut self, g: S, points: Option<[&Vector3<S>; 2]>) {
        let smaller = g - self.g;
        self.g = smaller.if_negative(self.g, g);
        self.is_near = smaller.if_negative(self.is_near, S::one());
        for (own, new) in self.points.iter_mut().zip(points.into_iter().flatten()) {
            *own = own.zip_map(new, |own, new| smaller.if_negative(own, new));
        }
    }
}

/// Returns true if a number is negative in all lanes.
#[inline(always)]
fn is_negative<S: Scalar>(x: S) -> bool {
    x.if_negative(S::zero(), S::one()).vanishes()
}

/// Returns true if a number is negative in no lane.
#[inline(always)]
fn is_nowhere_negative<S: Scalar>(x: S) -> bool {
    x.if_negative(S::one(), S::zero()).vanishes()
}

/// The length of a vector and its inverse; both zero below [`FLAT`].
#[inline]
pub(super) fn length_and_inverse<S: Scalar>(d: &Vector3<S>) -> [S; 2] {
    let square = dot(d, d);
    let short = square - S::from_f64(FLAT * FLAT);
    let length = square.sqrt();
    [length, S::one() / length].map(|x| short.if_negative(S::zero(), x))
}

/// The position of a point of a body with this placement; `None` is the base.
#[inline(always)]
pub(crate) fn place<C: Scalar, S: AlgebraOver<C>>(placement: Option<&Placement<S>>, point: &Vector3<C>) -> Vector3<S> {
    match placement {
        None => point.map(S::lift),
        Some(placement) => placement.point(point),
    }
}

/// The rows of a pair.
struct Rows<'p, S: Scalar> {
    /// All of them, `count`, from `first` on.
    all: [Nearest<S>; SETS],
    first: usize,
    count: usize,
    /// True while all are far.
    is_far: bool,
    /// A bit per row that is not.
    taken: u64,
    far: S,
    /// The least value of a row that is searched for, and that of the rows, at least the former: balls further than
    /// this need no look.
    from: S,
    least: S,
    /// The number of active pairs before those of this pair.
    before: usize,
    /// The active pairs that were taken, if they are asked for.
    active_pairs: Option<&'p mut Vec<ActivePair>>,
}

impl<S: Scalar> Rows<'_, S> {
    /// Begins the rows of a pair, all far.
    fn begin(&mut self, first: usize, count: usize) {
        (self.first, self.count, self.least) = (first, count, self.from);
        (self.is_far, self.taken) = (true, 0);
        self.before = self.active_pairs.as_ref().map_or(0, |active_pairs| active_pairs.len());
    }

    /// The value of a row so far.
    #[inline]
    fn value(&self, row: usize) -> S {
        if self.is_far { self.far } else { self.all[row].g }
    }

    /// Takes the distance of the balls of two nodes for a row, unless it is nowhere larger than that of others.
    fn take(&mut self, row: usize, g: S, points: [&Vector3<S>; 2], of: [usize; 2]) {
        // A search finds again the active pairs with which it begins. NaN is taken.
        let is_finite = (g * S::zero()).vanishes();
        if is_finite && is_nowhere_negative(self.value(row) - g) {
            return;
        }
        if std::mem::take(&mut self.is_far) {
            self.all[..self.count].fill(Nearest::none(self.far));
        }
        let all = &mut self.all[..self.count];
        let before = all[row].g;
        // With active pairs for the points, none of them is read.
        let points = self.active_pairs.is_none().then_some(points);
        all[row].take(g, points);
        self.taken |= 1 << row;
        // While one of the rows is far, and where this one was larger than the least, that remains.
        let are_all = self.taken.count_ones() as usize == self.count;
        if are_all && !is_negative(self.least - before) {
            let smaller = |a: S, b: S| (a - b).if_negative(a, b);
            let least = all.iter().map(|row| row.g).reduce(smaller);
            let least = least.unwrap_or(self.far);
            self.least = (least - self.from).if_negative(self.from, least);
        }
        if let Some(active_pairs) = &mut self.active_pairs {
            let row = self.first + row;
            active_pairs.push(ActivePair { row, of });
        }
    }

    /// Drops the active pairs of this pair that are not active, for their values.
    fn drop_pieces(&mut self, value: impl Fn([usize; 2]) -> S) {
        let (first, before, all) = (self.first, self.before, &self.all);
        let Some(active_pairs) = &mut self.active_pairs else {
            return;
        };
        let mut kept = before;
        for at in before..active_pairs.len() {
            let ActivePair { row, of } = active_pairs[at];
            if !is_negative(value(of) - all[row - first].g) {
                active_pairs[kept] = active_pairs[at];
                kept += 1;
            }
        }
        active_pairs.truncate(kept);
        // Those that the search began with are found again.
        active_pairs[before..].sort_unstable_by_key(|pair| (pair.row, pair.of));
        kept = before;
        for at in before..active_pairs.len() {
            if kept == before || active_pairs[kept - 1] != active_pairs[at] {
                active_pairs[kept] = active_pairs[at];
                kept += 1;
            }
        }
        active_pairs.truncate(kept);
    }
}

/// Two links, or a link and a solid, with the placements of their bodies.
#[derive(Clone, Copy)]
struct Pair<'a, C: Scalar, S: Scalar> {
    of: &'a CoverClearance<C>,
    links: [&'a BallTree<C>; 2],
    placements: [Option<&'a Placement<S>>; 2],
    /// The index of the solid in place of the second link.
    solid: Option<usize>,
}

impl<C: Scalar, S: AlgebraOver<C>> Pair<'_, C, S> {
    /// The centre of the ball of a node of the first or the second link.
    #[inline(always)]
    fn centre(&self, side: usize, node: usize) -> Vector3<S> {
        place(self.placements[side], &self.links[side].nodes[node].bound.centre)
    }

    /// The row of the ball of a node beside the solid, and its centre.
    #[inline]
    fn beside(&self, solid: usize, node: usize) -> (S, Vector3<S>) {
        let p = self.centre(0, node);
        let reach = self.links[0].nodes[node].bound.radius + self.of.margins[0];
        (S::lift(reach) - self.of.solids[solid].distance(&p), p)
    }

    /// The row of the balls of two nodes, and their centres.
    #[inline]
    fn between(&self, [k, l]: [usize; 2]) -> (S, [Vector3<S>; 2]) {
        let (p, q) = (self.centre(0, k), self.centre(1, l));
        let [length, _] = length_and_inverse(&(p - q));
        let radii = self.links[0].nodes[k].bound.radius + self.links[1].nodes[l].bound.radius;
        (S::lift(radii + self.of.margins[1]) - length, [p, q])
    }

    /// The value of a piece, and the centres of its balls.
    fn piece(&self, of: [usize; 2]) -> (S, [Vector3<S>; 2]) {
        match self.solid {
            Some(solid) => {
                let (g, p) = self.beside(solid, of[0]);
                (g, [p, p])
            }
            None => self.between(of),
        }
    }

    /// Searches the nearest balls.
    fn search(&self, rows: &mut Rows<'_, S>) {
        let [tree, other] = self.links;
        if let Some(solid) = self.solid {
            let is_nearer = |(a, _): &(S, Vector3<S>), (b, _): &(S, Vector3<S>)| is_negative(*b - *a);
            let bound = |node| self.beside(solid, node);
            tree.search(bound, is_nearer, |node, (g, p)| {
                let is_near = !is_negative(*g - rows.least);
                if let Some(ball) = tree.nodes[node].leaf.filter(|_| is_near) {
                    rows.take(self.of.sets[ball], *g, [p, p], [node; 2]);
                }
                is_near
            });
            return;
        }
        let bound = |of| self.between(of).0;
        let is_nearer = |a: &S, b: &S| is_negative(*b - *a);
        // Of `n` nodes half are leaves.
        let are_few = |tree: &BallTree<C>, node: usize| tree.nodes[node].next - node < 2 * MAX_COMPARED;
        tree.search_pairs(other, bound, is_nearer, |[k, l], g| {
            let is_near = !is_negative(*g - rows.least);
            let are_few = are_few(tree, k) && are_few(other, l);
            if is_near && are_few {
                self.compare([k, l], rows);
            }
            is_near && !are_few
        });
    }

    /// Compares all balls below two nodes.
    fn compare(&self, [k, l]: [usize; 2], rows: &mut Rows<'_, S>) {
        let [tree, other] = self.links;
        let mut few = [(0, 0, C::zero(), Vector3::zeros()); MAX_COMPARED];
        let leaves = (k..tree.nodes[k].next).filter_map(|k| tree.nodes[k].leaf.map(|a| (k, a)));
        let mut count = 0;
        for (found, (k, a)) in few.iter_mut().zip(leaves) {
            let radius = tree.nodes[k].bound.radius;
            *found = (k, self.of.sets[a], radius, self.centre(0, k));
            count += 1;
        }
        for l in l..other.nodes[l].next {
            let Some(ball) = other.nodes[l].leaf else {
                continue;
            };
            let (set, q, radius) = (self.of.sets[ball], self.centre(1, l), other.nodes[l].bound.radius);
            for (k, own, beside, p) in &few[..count] {
                let sum = own + set;
                let row = if sum < rows.count { sum } else { sum - rows.count };
                // Summed as in `between`, so that a piece has the same value to the last digit.
                let (reach, d) = (S::lift(*beside + radius + self.of.margins[1]), p - q);
                // Without a root where the distance is larger than the least one so far.
                let most = reach - rows.value(row);
                if !is_negative(most * most - dot(&d, &d)) {
                    let [length, _] = length_and_inverse(&d);
                    rows.take(row, reach - length, [p, &q], [*k, l]);
                }
            }
        }
    }
}

impl<C: Scalar> CoverClearance<C> {
    /// Calls `visit` with the index of each pair that has a row that is needed, those of solids first, and with the
    /// range of its rows and these, none if all are far. Appends the active pairs of the rows if they are asked for.
    pub(super) fn visit<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        is_needed: impl Fn(&Range<usize>) -> bool,
        active_pairs: Option<&mut Vec<ActivePair>>,
        mut visit: impl FnMut(usize, Range<usize>, &[Nearest<S>]) -> Result<()>,
    ) -> Result<()> {
        let bodies = self.links.iter().filter_map(|link| link.body);
        if let Some(last) = bodies.max().filter(|last| *last >= at.placements.len()) {
            return Err(Error::Length {
                what: "bodies of the robot of a constraint",
                expected: last + 1,
                found: at.placements.len(),
            });
        }
        let far = S::lift(-self.far);
        let known = at.active_pairs.unwrap_or(ActivePairs::new(&[]));
        let from = match at.active_pairs.map(|active_pairs| active_pairs.searched_from()) {
            Some(from) => {
                let from = S::from_f64(from);
                (from - far).if_negative(far, from)
            }
            None => far,
        };
        let mut rows = Rows {
            all: [Nearest::none(far); SETS],
            first: 0,
            count: 0,
            is_far: true,
            taken: 0,
            far,
            from,
            least: from,
            before: 0,
            active_pairs,
        };
        let mut first = 0;
        let searches = at.active_pairs.is_none_or(|active_pairs| active_pairs.searched_from() < f64::INFINITY);
        let mut known = known.iter().peekable();
        for (k, count) in self.counts().enumerate() {
            let own = first..first + count;
            if is_needed(&own) {
                if count > SETS {
                    return Err(Error::Length { what: "sets of the balls of a link", expected: SETS, found: count });
                }
                rows.begin(first, count);
                let pair = self.pair(at, k);
                while known.next_if(|pair| pair.row < first).is_some() {}
                while let Some(ActivePair { row, of }) = known.next_if(|of| of.row < own.end) {
                    let (g, [p, q]) = pair.piece(of);
                    rows.take(row - first, g, [&p, &q], of);
                }
                if searches {
                    pair.search(&mut rows);
                }
                rows.drop_pieces(|of| pair.piece(of).0);
                let found = if rows.is_far { 0 } else { count };
                visit(k, own.clone(), &rows.all[..found])?;
            }
            first = own.end;
        }
        Ok(())
    }

    /// A pair with the placements of its bodies.
    fn pair<'a, S: AlgebraOver<C>>(&'a self, at: &PlacedState<'a, C, S>, k: usize) -> Pair<'a, C, S> {
        let ([i, j], solid) = match self.solid_pairs.get(k) {
            Some([i, j]) => ([*i, *i], Some(*j)),
            None => (self.pairs[k - self.solid_pairs.len()], None),
        };
        let links = [&self.links[i], &self.links[j]];
        let placement = |link: &BallTree<C>| link.body.map(|body| &at.placements[body]);
        Pair { of: self, links, placements: [placement(links[0]), placement(links[1])], solid }
    }
}
