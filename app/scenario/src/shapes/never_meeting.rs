//! Pairs of links that cannot meet.

use crate::judge::{Reach, carriers};
use aghf::error::Result;
use aghf::geometry::{BallTree, CollisionSphere, Convex, Sphere, gap};
use aghf::model::{JointKind, Limits, Model};
use std::cell::Cell;
use std::f64::consts::PI;

/// The largest number of joints between two links for a proof, whose cost grows with their ranges.
const MAX_JOINTS: usize = 3;

/// The largest number of distances for a proof: some milliseconds.
const MAX_DISTANCES: usize = 100_000;

/// The cost of the distance of two convex bodies, in distances of balls.
const OF_CONVEX: usize = 50;

/// Returns true if two links are proved to be further from each other than `margin`, m, wherever the joints between
/// them are within their limits, or, without `limited`, wherever they are; false if they meet or no proof was found.
///
/// The ranges of the joints between the links are halved until in each part the distances in its middle are larger than
/// the [ways](Reach::way) from there.
///
/// # Errors
/// A ball belongs to a body that the robot does not have.
pub(crate) fn never_meet(
    model: &Model,
    ([tree, other], parts): ([&BallTree; 2], &[Convex]),
    limited: bool,
    margin: f64,
) -> Result<bool> {
    let [of_tree, of_other] = [tree, other].map(|tree| carriers(model, tree.body));
    let alone =
        |of: &[usize], other: &[usize]| -> Vec<usize> { of.iter().filter(|i| !other.contains(i)).copied().collect() };
    let paths = [alone(&of_tree, &of_other), alone(&of_other, &of_tree)];
    let joints = paths.concat();
    let ranges: Option<Vec<_>> = joints.iter().map(|i| range(model, *i, limited)).collect();
    let Some(whole) = ranges.filter(|_| joints.len() <= MAX_JOINTS) else {
        return Ok(false);
    };
    let mut reach = Reach::new(model);
    let (mut q, mut ways) = (vec![0.0; model.dof()], vec![0.0; model.dof()]);
    let mut budget = MAX_DISTANCES;
    let mut open = vec![whole];
    while let Some(part) = open.pop() {
        for (i, [from, to]) in joints.iter().zip(&part) {
            q[*i] = 0.5 * (from + to);
            ways[*i] = 0.5 * (to - from);
        }
        reach.place(&q)?;
        let ball = |tree: &BallTree, node: usize| {
            let Sphere { centre, radius } = tree.nodes[node].bound;
            CollisionSphere { body: tree.body, centre, radius }
        };
        let convex = |tree: &BallTree, node: usize| {
            let convex = parts.get(tree.nodes[node].leaf?)?;
            Some(reach.placed(tree.body, convex))
        };
        let (mut meet, mut is_proved, spent) = (false, true, Cell::new(0));
        let bound = |[i, j]: [usize; 2]| {
            let (a, b) = (ball(tree, i), ball(other, j));
            let (gap, [first, second]) = match (convex(tree, i), convex(other, j)) {
                (Some(first), Some(second)) => {
                    spent.set(spent.get() + OF_CONVEX);
                    let way = |ball: &CollisionSphere, path: &[usize]| reach.way_within(ball, path, &ways);
                    (gap(&[first, second]).distance, [way(&a, &paths[0]), way(&b, &paths[1])])
                }
                _ => {
                    let [a, b] = [&a, &b].map(|ball| Sphere { centre: reach.centre(ball), radius: ball.radius });
                    let way = |ball: &Sphere, path: &[usize]| reach.way(&ball.centre, path, &ways);
                    (a.gap(&b), [way(&a, &paths[0]), way(&b, &paths[1])])
                }
            };
            let gap = gap - margin;
            [gap, gap - first - second]
        };
        tree.search_pairs(
            other,
            bound,
            |a, b| a[0] < b[0],
            |pair, [gap, least]| {
                budget = budget.saturating_sub(1 + spent.take());
                let may_meet = !meet && budget > 0 && *least <= 0.0;
                if may_meet && tree.below_pair(other, pair).is_none() {
                    is_proved = false;
                    meet = *gap <= 0.0;
                }
                // One pair of balls without a proof is enough to halve the part.
                may_meet && is_proved
            },
        );
        if meet || budget == 0 {
            return Ok(false);
        }
        if !is_proved {
            open.extend(halves(part));
        }
    }
    Ok(true)
}

/// The positions that a joint can have; `None` without bounds. A turn is enough for a joint that turns further.
fn range(model: &Model, joint: usize, limited: bool) -> Option<[f64; 2]> {
    let joint = &model.joints()[joint];
    let limits = if limited { *joint.limits() } else { Limits::NONE };
    let width = limits.upper - limits.lower;
    match joint.kind() {
        JointKind::Prismatic => width.is_finite().then_some([limits.lower, limits.upper]),
        JointKind::Revolute if width < 2.0 * PI => Some([limits.lower, limits.upper]),
        JointKind::Revolute | JointKind::Continuous => Some([-PI, PI]),
    }
}

/// The halves of a part, across its longest side.
fn halves(part: Vec<[f64; 2]>) -> [Vec<[f64; 2]>; 2] {
    let length = |i: &usize| part[*i][1] - part[*i][0];
    let longest = (0..part.len()).max_by(|i, j| length(i).total_cmp(&length(j)));
    let mut halves = [part.clone(), part];
    if let Some(i) = longest {
        let [from, to] = halves[0][i];
        let middle = 0.5 * (from + to);
        halves[0][i] = [from, middle];
        halves[1][i] = [middle, to];
    }
    halves
}
