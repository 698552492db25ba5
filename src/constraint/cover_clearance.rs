//! Clearances of a robot that is covered by many balls.

use super::any::distinct;
use super::clearance::distance;
use super::cover_search::length_and_inverse;
use super::label::name_of;
use super::solid_clearance::name_of_solid;
use super::{
    ActivePair, Constraint, PairDistance, PlacedState, Quantity, RowLabel, RowList, RowSet, WeightedDerivatives,
    Weights,
};
use crate::error::Result;
use crate::geometry::{BallTree, Scene, Solid};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{dot, outer};
use std::ops::Range;

/// The distance beyond its margin from which on balls no longer act, relative to the radius of the largest link. With
/// 0.25 an iteration takes as long, and 35 motions of a Panda with its meshes take 6603 of them in place of 4150.
const FAR: f64 = 0.35;

/// Links that are covered by balls stay clear of solids and of each other. The balls of a link are in sets: per pair of
/// a link and a solid there is one row per set, then per pair of links as many as the larger number `k` of their sets,
/// $g = m - \min(d, m + f)$ in m with `d` the least distance of their balls, `m` the margin, and `f` for
/// [`far`](Self::far). Balls of the sets `i` and `j` of two links are in row $(i + j) \bmod k$, so that a neighbour of
/// either in another set is in another row.
///
/// The nearest balls are found by branch and bound in the trees of links, so links further than $m + f$ from each other
/// cost one distance. Their rows are constant. Within, a row has a kink where two distances are the least. Balls of a
/// set are far from each other and so rarely equally near, while the nearest of all sets are neighbours. The
/// [pairs](ActivePair) of a row are pairs of nodes of two trees, or a node twice beside a solid.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverClearance<C: Scalar = f64> {
    /// The balls of each link.
    pub links: Vec<BallTree<C>>,
    /// The number of sets of each link, one at least and 32 at most.
    pub counts: Vec<usize>,
    /// The set of each ball among those of its link.
    pub sets: Vec<usize>,
    /// The solid obstacles, placed in the base frame.
    pub solids: Vec<Solid<C>>,
    /// The names of the solids for reports; a solid without one is called by its shape and number.
    pub names: Vec<String>,
    /// The indices of the link and of the solid of each pair that keeps clear.
    pub solid_pairs: Vec<[usize; 2]>,
    /// The indices of the two links of each pair that keeps clear.
    pub pairs: Vec<[usize; 2]>,
    /// The distances kept from solids and between links, m.
    pub margins: [C; 2],
    /// The distance beyond the margin from which on distances count as this, m.
    pub far: C,
}

impl CoverClearance {
    /// The rows of a scene whose balls are in [sets](crate::geometry::CollisionGeometry::with_sets), those with other
    /// margins apart.
    pub(super) fn of_scene(scene: &Scene) -> Vec<Self> {
        let (links, sets) = (scene.trees(), &scene.robot().sets);
        let count = |tree: &BallTree| {
            let leaves = tree.nodes.iter().filter_map(|node| node.leaf);
            leaves.map(|ball| sets[ball] + 1).max().unwrap_or(1)
        };
        let moving: Vec<_> = (0..links.len()).filter(|i| links[*i].body.is_some()).collect();
        let roots = links.iter().filter_map(|tree| tree.nodes.first());
        let radii = roots.map(|root| root.bound.radius);
        let far = FAR * radii.fold(0.0, f64::max);
        let (beside, between) = (scene.obstacle_margins(), scene.pair_margins());
        let margins = [beside, between].map(distinct);
        let of_margins = |k: usize| {
            let margins = margins.each_ref().map(|all| all.get(k).copied());
            let solids = (0..beside.len()).filter(|j| Some(beside[*j]) == margins[0]);
            let solids: Vec<_> = solids.collect();
            let pairs = scene.tree_pairs().iter().zip(between);
            let pairs = pairs.filter(|(_, own)| Some(**own) == margins[1]);
            Self {
                solid_pairs: moving.iter().flat_map(|i| solids.iter().map(move |j| [*i, *j])).collect(),
                solids: scene.obstacles().iter().map(|o| o.solid).collect(),
                names: scene.obstacles().iter().map(|o| o.name.clone()).collect(),
                pairs: pairs.map(|(pair, _)| *pair).collect(),
                margins: margins.map(Option::unwrap_or_default),
                far,
                counts: links.iter().map(count).collect(),
                sets: sets.clone(),
                links: links.to_vec(),
            }
        };
        let lengths = margins.each_ref().map(Vec::len);
        (0..lengths[0].max(lengths[1])).map(of_margins).collect()
    }
}

impl<C: Scalar> CoverClearance<C> {
    /// The number of rows per pair of a link and a solid, then per pair of links.
    pub(super) fn counts(&self) -> impl Iterator<Item = usize> {
        let count = |i: usize| self.counts[i];
        let of_solids = self.solid_pairs.iter().map(move |[i, _]| count(*i));
        let of_pairs = self.pairs.iter();
        of_solids.chain(of_pairs.map(move |[i, j]| count(*i).max(count(*j))))
    }

    /// The distance of the sets of a pair.
    fn gap(&self, pair: usize) -> PairDistance<C> {
        let links = match pair {
            k if k < self.solid_pairs.len() => [Some(self.solid_pairs[k][0]), None],
            k => self.pairs[k - self.solid_pairs.len()].map(Some),
        };
        let body = |link: usize| {
            let tree = &self.links[link];
            let root = tree.nodes.first()?.bound;
            let r = dot(&root.centre, &root.centre).sqrt() + root.radius;
            tree.body.map(|body| (body, r))
        };
        PairDistance { bodies: links.map(|link| link.and_then(body)), squared: None }
    }

    /// The number of the pair of a row.
    fn pair_of(&self, row: usize) -> Option<usize> {
        let mut end = 0;
        self.counts().position(|count| {
            end += count;
            row < end
        })
    }

    /// Computes the rows of needed pairs into `g`.
    fn values<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        is_needed: impl Fn(&Range<usize>) -> bool,
        active_pairs: Option<&mut Vec<ActivePair>>,
        g: &mut [S],
    ) -> Result<()> {
        let far = S::lift(-self.far);
        self.visit(at, is_needed, active_pairs, |_, own, rows| {
            match rows {
                [] => g[own].fill(far),
                rows => {
                    for (g, row) in g[own].iter_mut().zip(rows) {
                        *g = row.g;
                    }
                }
            }
            Ok(())
        })
    }
}

impl<C: Scalar> Constraint<C> for CoverClearance<C> {
    fn dim(&self) -> usize {
        self.counts().sum()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        self.values(at, |_| true, None, g)
    }

    fn value_of<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        rows: Option<RowList<'_>>,
        g: &mut [S],
        active_pairs: Option<&mut Vec<ActivePair>>,
    ) -> Result<()> {
        let is_needed = |own: &Range<usize>| rows.is_none_or(|rows| rows.has_any(own));
        self.values(at, is_needed, active_pairs, g)
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        let name = |link: usize| name_of(self.links[link].body, model);
        let Some(k) = self.pair_of(row) else {
            return RowLabel::numbered(row);
        };
        match self.solid_pairs.get(k) {
            Some([i, j]) => distance(name(*i), name_of_solid(&self.names, &self.solids, *j), Quantity::Obstacles),
            None => {
                let [i, j] = self.pairs[k - self.solid_pairs.len()];
                distance(name(i), name(j), Quantity::SelfCollision)
            }
        }
    }

    fn row_set(&self, row: usize) -> RowSet<C> {
        RowSet { cutoff: Some(self.far), ..RowSet::clearance(self.pair_of(row).map(|pair| self.gap(pair))) }
    }

    /// Those of the nearest balls. As a function of $s = d^2 / 2$ the row of two sets is $r - \sqrt{2 s}$, with
    /// derivatives $-1 / d$ and $1 / d^3$. Pairs with zero weights are skipped.
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let of_solids = self.solid_pairs.len();
        let is_needed = |own: &Range<usize>| own.clone().any(|row| !weights.vanish(row));
        self.visit(at, is_needed, None, |k, own, rows| {
            for (row, nearest) in own.zip(rows) {
                if weights.vanish(row) {
                    continue;
                }
                let c = weights.gauss_newton.map_or(S::zero(), |c| c[row]);
                let [w, c] = [weights.first_order[row], c].map(|w| nearest.is_near.if_negative(S::zero(), w));
                let [p, q] = &nearest.points;
                if let Some([i, j]) = self.solid_pairs.get(k) {
                    let near = self.solids[*j].distance_derivatives(p);
                    let stiffness = outer(&(near.normal * c), &near.normal) - near.curvature * w;
                    out.add_point(self.links[*i].body, p, &(near.normal * -w), &stiffness)?;
                } else {
                    let [_, inverse] = length_and_inverse(&(p - q));
                    let square = inverse * inverse;
                    let bodies = self.pairs[k - of_solids].map(|i| self.links[i].body);
                    out.add_pair(bodies, [p, q], -w * inverse, (w * inverse + c) * square)?;
                }
            }
            Ok(())
        })
    }
}
