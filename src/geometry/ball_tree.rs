//! Balls of a link in a tree, so that those near something are found among many.

use super::{CollisionSphere, Sphere};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Balls on one body in a binary tree of balls that contain those below them.
#[derive(Clone, Debug, PartialEq)]
pub struct BallTree<C: Scalar = f64> {
    /// The body; `None` is the base.
    pub body: Option<usize>,
    /// The nodes, each followed by those below it.
    pub nodes: Vec<BallNode<C>>,
}

/// A node of a tree of balls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallNode<C: Scalar = f64> {
    /// A ball in the body that contains those below; of a leaf, the ball itself.
    pub bound: Sphere<C>,
    /// The index of the first node that is not below this one.
    pub next: usize,
    /// The index of the ball of a leaf among those of the robot.
    pub leaf: Option<usize>,
}

impl BallTree {
    /// Sorts the balls with the indices `own`, which are on one body, into a tree. Cost O(n log^2 n).
    #[must_use]
    pub fn new(balls: &[CollisionSphere], mut own: Vec<usize>) -> Self {
        let mut tree =
            Self { body: own.first().and_then(|i| balls[*i].body), nodes: Vec::with_capacity(2 * own.len()) };
        tree.add(balls, &mut own);
        tree
    }

    fn add(&mut self, balls: &[CollisionSphere], own: &mut [usize]) {
        if own.is_empty() {
            return;
        }
        let ends = |side: f64| own.iter().map(move |i| balls[*i].centre.add_scalar(side * balls[*i].radius));
        let none = Vector3::repeat(f64::INFINITY);
        let lower = ends(-1.0).fold(none, |m, p| m.inf(&p));
        let upper = ends(1.0).fold(-none, |m, p| m.sup(&p));
        let centre = (lower + upper) * 0.5;
        let reaches = own.iter().map(|i| (balls[*i].centre - centre).norm() + balls[*i].radius);
        let bound = Sphere { centre, radius: reaches.fold(0.0, f64::max) };
        let at = self.nodes.len();
        if let [i] = own {
            let CollisionSphere { centre, radius, .. } = balls[*i];
            self.nodes.push(BallNode { bound: Sphere { centre, radius }, next: at + 1, leaf: Some(*i) });
            return;
        }
        self.nodes.push(BallNode { bound, next: at, leaf: None });
        let axis = (upper - lower).imax();
        own.sort_by(|a, b| balls[*a].centre[axis].total_cmp(&balls[*b].centre[axis]).then(a.cmp(b)));
        let (first, second) = own.split_at_mut(own.len() / 2);
        self.add(balls, first);
        self.add(balls, second);
        self.nodes[at].next = self.nodes.len();
    }
}

impl<C: Scalar> BallTree<C> {
    /// The two nodes below one; `None` for a leaf.
    #[must_use]
    pub fn below(&self, node: usize) -> Option<[usize; 2]> {
        let first = node + 1;
        let is_leaf = self.nodes[node].leaf.is_some();
        (!is_leaf).then(|| [first, self.nodes[first].next])
    }

    /// The two pairs of nodes below a pair of nodes of two trees, with those below the one that has more; `None` for
    /// two leaves.
    #[must_use]
    pub fn below_pair(&self, other: &Self, [i, j]: [usize; 2]) -> Option<[[usize; 2]; 2]> {
        let has_more = self.nodes[i].next - i >= other.nodes[j].next - j;
        if has_more {
            self.below(i).map(|below| below.map(|i| [i, j]))
        } else {
            other.below(j).map(|below| below.map(|j| [i, j]))
        }
    }

    /// Searches the tree from the root on, of two branches the nearer one first: `bound` is that of a node, `is_nearer`
    /// compares two, and `visit` returns false where the branches below need no search.
    pub fn search<B>(
        &self,
        bound: impl Fn(usize) -> B,
        is_nearer: impl Fn(&B, &B) -> bool,
        mut visit: impl FnMut(usize, &B) -> bool,
    ) {
        if !self.nodes.is_empty() {
            let below = |node| self.below(node);
            descend(0, bound(0), &(below, bound, is_nearer), &mut visit);
        }
    }

    /// Searches pairs of nodes of two trees as [`search`](Self::search) does nodes.
    pub fn search_pairs<B>(
        &self,
        other: &Self,
        bound: impl Fn([usize; 2]) -> B,
        is_nearer: impl Fn(&B, &B) -> bool,
        mut visit: impl FnMut([usize; 2], &B) -> bool,
    ) {
        if !self.nodes.is_empty() && !other.nodes.is_empty() {
            let below = |pair| self.below_pair(other, pair);
            descend([0, 0], bound([0, 0]), &(below, bound, is_nearer), &mut visit);
        }
    }
}

/// Searches the part below a node with this bound.
fn descend<N: Copy, B>(
    node: N,
    own: B,
    of: &(impl Fn(N) -> Option<[N; 2]>, impl Fn(N) -> B, impl Fn(&B, &B) -> bool),
    visit: &mut impl FnMut(N, &B) -> bool,
) {
    if !visit(node, &own) {
        return;
    }
    let (below, bound, is_nearer) = of;
    if let Some([first, second]) = below(node) {
        let (a, b) = (bound(first), bound(second));
        let (near, far) = if is_nearer(&b, &a) { ((second, b), (first, a)) } else { ((first, a), (second, b)) };
        descend(near.0, near.1, of, visit);
        descend(far.0, far.1, of, visit);
    }
}
