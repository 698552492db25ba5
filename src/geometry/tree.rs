//! Boxes in a tree, to find those near a point.

use super::cells::bounds;
use nalgebra::Vector3;

/// A box with edges along the axes.
type Bounds = [Vector3<f64>; 2];

/// Boxes in a binary tree, in the order in which it is visited.
pub(super) struct Tree {
    nodes: Vec<Node>,
}

struct Node {
    bounds: Bounds,
    /// The node that follows those below this one.
    next: usize,
    /// The index of the box of a leaf.
    leaf: Option<usize>,
}

impl Tree {
    /// Sorts boxes into a tree. Cost O(n log^2 n).
    pub fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self { nodes: Vec::new() };
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        tree.add(boxes, &mut order);
        tree
    }

    fn add(&mut self, boxes: &[Bounds], some: &mut [usize]) {
        if some.is_empty() {
            return;
        }
        let (at, bounds) = (self.nodes.len(), bounds(some.iter().flat_map(|i| &boxes[*i])));
        let leaf = (some.len() == 1).then_some(some[0]);
        self.nodes.push(Node { bounds, next: 0, leaf });
        if leaf.is_none() {
            let axis = (bounds[1] - bounds[0]).imax();
            let middle = |i: &usize| boxes[*i][0][axis] + boxes[*i][1][axis];
            some.sort_by(|a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
            let (first, second) = some.split_at_mut(some.len() / 2);
            self.add(boxes, first);
            self.add(boxes, second);
        }
        self.nodes[at].next = self.nodes.len();
    }

    /// Calls `visit` with every box that is not further than a distance from a point. The point and the distance are
    /// those that `visit` returned last, `ball` at first; the ball must not extend beyond the one before.
    pub fn visit(&self, mut ball: (Vector3<f64>, f64), mut visit: impl FnMut(usize) -> (Vector3<f64>, f64)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            let [lower, upper] = &node.bounds;
            let off = ball.0 - ball.0.sup(lower).inf(upper);
            if off.norm_squared() > ball.1 * ball.1 {
                at = node.next;
                continue;
            }
            if let Some(leaf) = node.leaf {
                ball = visit(leaf);
            }
            at += 1;
        }
    }
}
