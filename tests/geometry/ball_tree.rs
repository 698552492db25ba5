//! Balls in trees.

use crate::common::config;
use aghf::geometry::{BallTree, CollisionSphere, Sphere};
use nalgebra::Vector3;
use proptest::prelude::*;

/// Balls on a body.
fn balls(body: Option<usize>) -> impl Strategy<Value = Vec<CollisionSphere>> {
    let centre = prop::array::uniform3(-1.0..1.0);
    let ball = (centre, 0.01..0.3).prop_map(move |(centre, radius)| CollisionSphere {
        body,
        centre: Vector3::from(centre),
        radius,
    });
    prop::collection::vec(ball, 1..40)
}

fn tree(balls: &[CollisionSphere]) -> BallTree {
    BallTree::new(balls, (0..balls.len()).collect())
}

fn sphere(ball: &CollisionSphere) -> Sphere {
    Sphere { centre: ball.centre, radius: ball.radius }
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn a_node_contains_what_is_below_and_each_ball_is_a_leaf(balls in balls(Some(3))) {
        let tree = tree(&balls);
        prop_assert_eq!(tree.body, Some(3));
        let mut leaves: Vec<_> = tree.nodes.iter().filter_map(|node| node.leaf).collect();
        leaves.sort_unstable();
        prop_assert_eq!(leaves, (0..balls.len()).collect::<Vec<_>>());
        for (i, node) in tree.nodes.iter().enumerate() {
            for below in &tree.nodes[i..node.next] {
                let off = (below.bound.centre - node.bound.centre).norm() + below.bound.radius;
                // The bounds of nodes are those of their balls, not of the nodes below.
                if let Some(ball) = below.leaf {
                    prop_assert!(off <= node.bound.radius * (1.0 + 1e-12), "{off} {}", node.bound.radius);
                    prop_assert_eq!(below.bound, sphere(&balls[ball]));
                }
            }
        }
    }

    /// With each branch that is no nearer than the best ball before left out.
    #[test]
    fn a_search_finds_the_nearest(
        (first, second) in (balls(None), balls(None)),
        point in prop::array::uniform3(-2.0..2.0),
    ) {
        let point = Sphere { centre: Vector3::from(point), radius: 0.0 };
        let (a, b) = (tree(&first), tree(&second));
        let mut least = f64::INFINITY;
        let mut visited = 0;
        a.search(|at| a.nodes[at].bound.gap(&point), f64::lt, |at, gap| {
            visited += 1;
            let is_near = *gap < least;
            if is_near && a.nodes[at].leaf.is_some() {
                least = *gap;
            }
            is_near
        });
        let one_by_one = first.iter().map(|ball| sphere(ball).gap(&point)).fold(f64::INFINITY, f64::min);
        prop_assert_eq!(least, one_by_one);
        prop_assert!(visited <= a.nodes.len());

        let mut least = f64::INFINITY;
        let gap = |[i, j]: [usize; 2]| a.nodes[i].bound.gap(&b.nodes[j].bound);
        a.search_pairs(&b, gap, f64::lt, |[i, j], gap| {
            let is_near = *gap < least;
            if is_near && a.nodes[i].leaf.is_some() && b.nodes[j].leaf.is_some() {
                least = *gap;
            }
            is_near
        });
        let pairs = first.iter().flat_map(|x| second.iter().map(move |y| sphere(x).gap(&sphere(y))));
        prop_assert_eq!(least, pairs.fold(f64::INFINITY, f64::min));
    }
}
