//! The RRT-Connect algorithm.

use super::sampler::Sampler;
use super::{Checker, Plan, PlanSettings, between, distance};
use crate::constraint::Constraint;
use crate::error::Result;
use rand_chacha::ChaCha8Rng;

/// The share of a step by which it comes nearer after its projection, and by how much longer it may then be.
const MIN_PROGRESS: f64 = 0.2;
const FARTHEST: f64 = 2.0;

/// A tree of configurations, each joined to its parent by a free line.
struct Tree {
    dof: usize,
    /// The configurations, one after the other.
    nodes: Vec<f64>,
    parents: Vec<usize>,
}

impl Tree {
    fn new(root: &[f64]) -> Self {
        Self { dof: root.len(), nodes: root.to_vec(), parents: vec![0] }
    }

    fn len(&self) -> usize {
        self.parents.len()
    }

    fn node(&self, i: usize) -> &[f64] {
        &self.nodes[i * self.dof..(i + 1) * self.dof]
    }

    fn add(&mut self, q: &[f64], parent: usize) -> usize {
        self.nodes.extend_from_slice(q);
        self.parents.push(parent);
        self.len() - 1
    }

    /// The nearest node, the first one if there are several, and the square of its distance.
    fn nearest(&self, q: &[f64]) -> (usize, f64) {
        let mut nearest = (0, f64::INFINITY);
        for (i, node) in self.nodes.chunks_exact(self.dof).enumerate() {
            let squares = node.iter().zip(q).map(|(a, b)| (a - b) * (a - b));
            let square: f64 = squares.sum();
            if square < nearest.1 {
                nearest = (i, square);
            }
        }
        nearest
    }

    /// The path from a node to the root.
    fn to_root(&self, mut node: usize) -> Vec<Vec<f64>> {
        let mut path = vec![self.node(node).to_vec()];
        while node != 0 {
            node = self.parents[node];
            path.push(self.node(node).to_vec());
        }
        path
    }
}

/// Grows a tree from each end until they meet.
pub(super) fn connect<K: Constraint + ?Sized>(
    checker: &mut Checker<'_, K>,
    sampler: &Sampler<'_>,
    settings: &PlanSettings,
    rng: &mut ChaCha8Rng,
    stopped: &dyn Fn() -> bool,
) -> Result<Plan> {
    let ends = sampler.ends;
    if !checker.is_projected() && checker.is_line_free(ends[0], ends[1])? {
        return Ok(Plan::Found(ends.map(<[f64]>::to_vec).to_vec()));
    }
    let (mut trees, range) = (ends.map(Tree::new), settings.range);
    if checker.is_projected()
        && let Some(met) = reach(checker, &mut trees[0], ends[1], settings)?
    {
        let mut path = trees[0].to_root(met);
        path.reverse();
        return Ok(Plan::Found(path));
    }
    let mut sample = vec![0.0; ends[0].len()];
    while checker.checks() < settings.most_checks {
        if stopped() {
            return Ok(Plan::Stopped);
        }
        sampler.sample(&mut sample, rng);
        // The smaller tree grows, so that both keep about the same size.
        let own = usize::from(trees[1].len() < trees[0].len());
        let (near, square) = trees[own].nearest(&sample);
        let from = trees[own].node(near);
        let to = between(from, &sample, (range / square.sqrt()).min(1.0));
        let Some(to) = checker.projected(to)? else {
            continue;
        };
        if distance(from, &to) > FARTHEST * range || !checker.is_line_free(from, &to)? {
            continue;
        }
        let new = trees[own].add(&to, near);
        if let Some(met) = reach(checker, &mut trees[1 - own], &to, settings)? {
            let [mut path, rest] = match own {
                0 => [trees[0].to_root(new), trees[1].to_root(met)],
                _ => [trees[0].to_root(met), trees[1].to_root(new)],
            };
            path.reverse();
            // Both paths contain the node where the trees meet.
            path.extend(rest.into_iter().skip(1));
            return Ok(Plan::Found(path));
        }
    }
    let checks = checker.checks();
    Ok(Plan::OutOfBudget { checks })
}

/// The end of a free step towards a configuration, of the length `range` before it is projected, or that configuration
/// if it is as near; `None` if it is not free, or a projection leads aside.
pub(super) fn step<K: Constraint + ?Sized>(
    checker: &mut Checker<'_, K>,
    from: &[f64],
    to: &[f64],
    range: f64,
) -> Result<Option<Vec<f64>>> {
    let far = distance(from, to);
    let next = if far <= range {
        to.to_vec()
    } else {
        let Some(next) = checker.projected(between(from, to, range / far))? else {
            return Ok(None);
        };
        if distance(&next, to) > far - MIN_PROGRESS * range || distance(from, &next) > FARTHEST * range {
            return Ok(None);
        }
        next
    };
    Ok(checker.is_line_free(from, &next)?.then_some(next))
}

/// Grows a tree straight towards a configuration as far as the line is free and the number of checks allows; returns
/// the last node if it is that configuration.
fn reach<K: Constraint + ?Sized>(
    checker: &mut Checker<'_, K>,
    tree: &mut Tree,
    to: &[f64],
    settings: &PlanSettings,
) -> Result<Option<usize>> {
    let (range, (mut at, _)) = (settings.range, tree.nearest(to));
    while checker.checks() < settings.most_checks {
        let from = tree.node(at);
        let far = distance(from, to);
        let last = far <= range;
        let Some(next) = step(checker, from, to, range)? else {
            return Ok(None);
        };
        at = tree.add(&next, at);
        if last {
            return Ok(Some(at));
        }
    }
    Ok(None)
}
