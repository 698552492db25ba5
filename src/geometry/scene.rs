//! A robot among obstacles: the pairs that keep clear of each other, and their distances.

use super::collision::{CollisionGeometry, placement_of};
use super::{BallTree, Convex, Gap, Placed, Solid, Sphere, gap_to};
use crate::error::Result;
use crate::spatial::Placement;
use nalgebra::Vector3;
use std::collections::HashSet;

/// An obstacle at rest in the base frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Its name in reports.
    pub name: String,
    /// The solid.
    pub solid: Solid,
}

/// A robot among obstacles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    robot: CollisionGeometry,
    obstacles: Vec<Obstacle>,
    /// The convex forms of the obstacles; `None` for half-spaces.
    forms: Vec<Option<Convex>>,
    /// Those of the robot, and their pairs.
    trees: Vec<BallTree>,
    tree_pairs: Vec<[usize; 2]>,
    pairs: Vec<[usize; 2]>,
    /// The placements of the bodies at the given ends of a motion.
    ends: Vec<Vec<Placement<f64>>>,
    /// The distances that are kept: from each obstacle, and of each pair of trees, m.
    obstacle_margins: Vec<f64>,
    pair_margins: Vec<f64>,
}

/// A part of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part<'a> {
    /// The body; `None` is the base.
    pub body: Option<usize>,
    /// The link; `None` if the balls of the robot belong to no links.
    pub link: Option<&'a str>,
}

/// A part of the robot or an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Collider<'a> {
    /// A part of the robot.
    Robot(Part<'a>),
    /// An obstacle, by its name.
    Obstacle(&'a str),
}

/// A part of the robot and an obstacle or another part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPair<'a> {
    /// The distance of the pair, m; negative in an overlap.
    pub distance: f64,
    /// The part of the robot.
    pub part: Part<'a>,
    /// The obstacle or other part.
    pub other: Collider<'a>,
    /// The closest point of each, in the base frame.
    pub points: [Vector3<f64>; 2],
    /// The margin that was taken off the distance, m.
    pub margin: f64,
}

impl Scene {
    /// A robot with these obstacles. With `ignored_pairs` its links keep clear of each other, except for these pairs;
    /// with `None` they may overlap.
    #[must_use]
    pub fn new(robot: CollisionGeometry, obstacles: Vec<Obstacle>, ignored_pairs: Option<&[[String; 2]]>) -> Self {
        let by_balls = ignored_pairs.filter(|_| robot.parts.is_empty());
        let tree_pairs = ignored_pairs.map_or_else(Vec::new, |ignored| robot.tree_pairs(ignored));
        Self {
            trees: robot.trees(),
            obstacle_margins: vec![0.0; obstacles.len()],
            pair_margins: vec![0.0; tree_pairs.len()],
            tree_pairs,
            ends: Vec::new(),
            pairs: by_balls.map_or_else(Vec::new, |ignored| robot.pairs(ignored)),
            robot,
            forms: forms(&obstacles),
            obstacles,
        }
    }

    /// The same with distances that the robot keeps, m: from each obstacle, by its index, and between two links, by
    /// their names; without names for balls that belong to no links.
    #[must_use]
    pub fn with_margins(mut self, of_obstacle: impl Fn(usize) -> f64, of_links: impl Fn([&str; 2]) -> f64) -> Self {
        self.obstacle_margins = (0..self.obstacles.len()).map(of_obstacle).collect();
        let link = |i: usize| self.robot.link_of(&self.trees[i]).unwrap_or_default();
        let pairs = self.tree_pairs.iter();
        self.pair_margins = pairs.map(|pair| of_links(pair.map(link))).collect();
        self
    }

    /// The same with other obstacles, from which the robot keeps no distance yet.
    #[must_use]
    pub fn with_obstacles(mut self, obstacles: Vec<Obstacle>) -> Self {
        self.obstacle_margins = vec![0.0; obstacles.len()];
        self.forms = forms(&obstacles);
        self.obstacles = obstacles;
        self
    }

    /// The same with the placements of the bodies at the given ends of a motion, where rows are smoothed no more than
    /// the distances there allow.
    ///
    /// # Errors
    /// An end has no entry for a body.
    pub fn with_ends(mut self, ends: Vec<Vec<Placement<f64>>>) -> Result<Self> {
        for (placements, ball) in ends.iter().flat_map(|end| self.robot.balls.iter().map(move |ball| (end, ball))) {
            placement_of(ball.body, placements)?;
        }
        self.ends = ends;
        Ok(self)
    }

    /// The placements of the bodies at the given ends of a motion.
    #[must_use]
    pub fn ends(&self) -> &[Vec<Placement<f64>>] {
        &self.ends
    }

    /// The distances that the robot keeps from each obstacle, m.
    #[must_use]
    pub fn obstacle_margins(&self) -> &[f64] {
        &self.obstacle_margins
    }

    /// The distances that are kept between each [pair of trees](Self::tree_pairs), m.
    #[must_use]
    pub fn pair_margins(&self) -> &[f64] {
        &self.pair_margins
    }

    /// The robot.
    #[must_use]
    pub fn robot(&self) -> &CollisionGeometry {
        &self.robot
    }

    /// The obstacles.
    #[must_use]
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// The convex form of each obstacle; `None` for a half-space.
    #[must_use]
    pub fn forms(&self) -> &[Option<Convex>] {
        &self.forms
    }

    /// The pairs of balls of the robot that keep clear of each other, as [`CollisionGeometry::pairs`] sorts them; none
    /// if they contain convex [parts](CollisionGeometry::parts).
    #[must_use]
    pub fn pairs(&self) -> &[[usize; 2]] {
        &self.pairs
    }

    /// The [pairs](Self::pairs) of balls that keep this distance, m.
    #[must_use]
    pub fn pairs_with_margin(&self, margin: f64) -> Vec<[usize; 2]> {
        let own = self.pair_margins.iter().filter(|own| **own == margin);
        if own.count() == self.pair_margins.len() {
            return self.pairs.clone();
        }
        let mut tree_of = vec![0; self.robot.balls.len()];
        for (i, tree) in self.trees.iter().enumerate() {
            for ball in tree.nodes.iter().filter_map(|node| node.leaf) {
                tree_of[ball] = i;
            }
        }
        let pairs = self.tree_pairs.iter().zip(&self.pair_margins);
        let of_margin = pairs.filter(|(_, own)| **own == margin);
        let of_margin: HashSet<_> = of_margin.flat_map(|([i, j], _)| [[*i, *j], [*j, *i]]).collect();
        let pairs = self.pairs.iter().copied();
        pairs.filter(|pair| of_margin.contains(&pair.map(|ball| tree_of[ball]))).collect()
    }

    /// The [trees](CollisionGeometry::trees) of the robot.
    #[must_use]
    pub fn trees(&self) -> &[BallTree] {
        &self.trees
    }

    /// The pairs of trees that keep clear of each other.
    #[must_use]
    pub fn tree_pairs(&self) -> &[[usize; 2]] {
        &self.tree_pairs
    }

    /// Returns true if the robot has no obstacle and no other link to keep clear of.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.obstacles.is_empty() && self.tree_pairs.is_empty()
    }

    /// Finds the closest pair with the bodies at `placements`; `None` if the scene is [empty](Self::is_empty). The
    /// distances of capsules from spheres and half-spaces and those of convex bodies are exact; all others are those of
    /// the balls. Cost: one distance per pair of a link and an obstacle or another link, and those of balls that may be
    /// closer than all before.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    pub fn closest_pair(&self, placements: &[Placement<f64>]) -> Result<Option<ClosestPair<'_>>> {
        self.closest_pair_within(placements, f64::INFINITY)
    }

    /// Finds the [closest pair](Self::closest_pair) if it is closer than `most`, m.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    pub fn closest_pair_within(&self, placements: &[Placement<f64>], most: f64) -> Result<Option<ClosestPair<'_>>> {
        self.closest(placements, true, most)
    }

    /// Finds the [closest pair](Self::closest_pair) by the balls or convex bodies alone, with their distances less the
    /// [margins](Self::with_margins), as the constraints do.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    pub fn deepest_contact(&self, placements: &[Placement<f64>]) -> Result<Option<ClosestPair<'_>>> {
        self.closest(placements, false, f64::INFINITY)
    }

    /// The distance of the [closest pair](Self::closest_pair), m; infinite if the scene is empty.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    pub fn clearance(&self, placements: &[Placement<f64>]) -> Result<f64> {
        let closest = self.closest_pair(placements)?;
        Ok(closest.map_or(f64::INFINITY, |pair| pair.distance))
    }

    fn closest(&self, placements: &[Placement<f64>], by_capsules: bool, most: f64) -> Result<Option<ClosestPair<'_>>> {
        let kept = |margin: &f64| if by_capsules { 0.0 } else { *margin };
        let places = self.trees.iter().map(|t| placement_of(t.body, placements));
        let mut search = Search {
            robot: &self.robot,
            trees: &self.trees,
            places: places.collect::<Result<_>>()?,
            most,
            closest: None,
        };
        let obstacles = self.obstacles.iter().zip(&self.forms);
        for ((obstacle, form), margin) in obstacles.zip(&self.obstacle_margins) {
            let nearest = if by_capsules { self.robot.nearest_balls(placements, &obstacle.solid)? } else { None };
            search.obstacle((obstacle, form.as_ref()), kept(margin), nearest);
        }
        for (pair, margin) in self.tree_pairs.iter().zip(&self.pair_margins) {
            search.pair(*pair, kept(margin));
        }
        Ok(search.closest)
    }
}

fn forms(obstacles: &[Obstacle]) -> Vec<Option<Convex>> {
    obstacles.iter().map(|obstacle| Convex::of_solid(&obstacle.solid)).collect()
}

/// A search for the closest pair among those nearer than `most`, m.
struct Search<'a> {
    robot: &'a CollisionGeometry,
    trees: &'a [BallTree],
    places: Vec<Placement<f64>>,
    most: f64,
    closest: Option<ClosestPair<'a>>,
}

impl<'a> Search<'a> {
    /// Looks at an obstacle beside these balls, or beside all of the robot.
    fn obstacle(&mut self, (obstacle, form): (&'a Obstacle, Option<&Convex>), margin: f64, balls: Option<Vec<Sphere>>) {
        let Obstacle { name, solid } = obstacle;
        let distance_of = |ball: &Sphere| solid.distance(&ball.centre) - ball.radius - margin;
        let pair = |ball: &Sphere, part, distance| ClosestPair {
            distance,
            part,
            other: Collider::Obstacle(name),
            points: along(ball, &solid.distance_derivatives(&ball.centre).normal, distance),
            margin,
        };
        if let Some(balls) = balls {
            for (capsule, ball) in self.robot.capsules.iter().zip(&balls) {
                let distance = distance_of(ball);
                if self.is_closer(distance, &self.closest) {
                    let (body, link) = (capsule.body, None);
                    self.closest = Some(pair(ball, Part { body, link }, distance));
                }
            }
            return;
        }
        for (t, tree) in self.trees.iter().enumerate() {
            let mut found = self.closest;
            tree.search(
                |at| distance_of(&self.placed(t, at)),
                f64::lt,
                |at, distance| {
                    let is_near = self.is_closer(*distance, &found);
                    if let Some(i) = tree.nodes[at].leaf.filter(|_| is_near) {
                        let part = self.part(i, t);
                        let new = match self.robot.parts.get(i) {
                            None => pair(&self.placed(t, at), part, *distance),
                            Some(convex) => {
                                let Gap { distance, points } = gap_to(&self.convex(t, convex), (solid, form));
                                let other = Collider::Obstacle(name);
                                ClosestPair { distance: distance - margin, part, other, points, margin }
                            }
                        };
                        if self.is_closer(new.distance, &found) {
                            found = Some(new);
                        }
                    }
                    is_near
                },
            );
            self.closest = found;
        }
    }

    /// Looks at the balls of two trees beside each other.
    fn pair(&mut self, [t, u]: [usize; 2], margin: f64) {
        let (tree, other) = (&self.trees[t], &self.trees[u]);
        let balls = |[i, j]: [usize; 2]| [self.placed(t, i), self.placed(u, j)];
        let gap = |at| {
            let [ball, beside] = balls(at);
            ball.gap(&beside) - margin
        };
        let mut found = self.closest;
        tree.search_pairs(other, gap, f64::lt, |[i, j], gap| {
            let is_near = self.is_closer(*gap, &found);
            let leaves = (tree.nodes[i].leaf, other.nodes[j].leaf);
            if let (true, (Some(a), Some(b))) = (is_near, leaves) {
                let (distance, points) = if self.robot.parts.is_empty() {
                    let [ball, beside] = balls([i, j]);
                    let between = ball.centre - beside.centre;
                    let normal = between.try_normalize(0.0).unwrap_or_else(Vector3::z);
                    (*gap, along(&ball, &normal, *gap))
                } else {
                    let convex = |tree: usize, part: usize| self.convex(tree, &self.robot.parts[part]);
                    let Gap { distance, points } = super::gap(&[convex(t, a), convex(u, b)]);
                    (distance - margin, points)
                };
                if self.is_closer(distance, &found) {
                    found = Some(ClosestPair {
                        distance,
                        part: self.part(a, t),
                        other: Collider::Robot(self.part(b, u)),
                        points,
                        margin,
                    });
                }
            }
            is_near
        });
        self.closest = found;
    }

    fn is_closer(&self, distance: f64, than: &Option<ClosestPair<'_>>) -> bool {
        distance < than.map_or(self.most, |known| known.distance)
    }

    /// The bound of a node of a tree, in the base frame.
    fn placed(&self, tree: usize, node: usize) -> Sphere {
        let (place, bound) = (&self.places[tree], &self.trees[tree].nodes[node].bound);
        Sphere { centre: place.rotation * bound.centre + place.translation, radius: bound.radius }
    }

    /// A convex body of a tree in the base frame.
    fn convex<'c>(&'c self, tree: usize, convex: &'c Convex) -> Placed<'c, f64, f64> {
        Placed { convex, placement: Some(&self.places[tree]) }
    }

    /// The part of the robot with this ball.
    fn part(&self, ball: usize, tree: usize) -> Part<'a> {
        Part { body: self.trees[tree].body, link: self.robot.links.get(ball).map(String::as_str) }
    }
}

/// The point of a ball that is nearest to a surface with this outer normal, and that of the surface.
fn along(ball: &Sphere, normal: &Vector3<f64>, distance: f64) -> [Vector3<f64>; 2] {
    [0.0, distance].map(|further| ball.centre - normal * (ball.radius + further))
}
