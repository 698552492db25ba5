//! The nearest obstacle of a robot.

use super::environment::{apart, centre};
use super::robot_shape::{Body, alone};
use super::{Environment, Scenario};
use aghf::constraint::{Capsule, CollisionSphere};
use aghf::error::Result;
use aghf::spatial::Placement;
use nalgebra::Vector3;

/// The closest pair of a part of the robot and an obstacle or another part.
#[derive(Clone, Debug)]
pub struct Nearest {
    /// The distance of the pair, m; negative in an overlap.
    pub clearance: f64,
    /// The names of the link (or of its joint if the shape of the robot has no links) and of the obstacle or other
    /// link.
    pub names: [String; 2],
    /// The closest point of each, in the base frame.
    pub points: [Vector3<f64>; 2],
}

/// The distances between a robot and its obstacles, as [`Environment::clearance`] defines them, prepared for many
/// configurations.
pub struct Distances<'a> {
    scenario: &'a Scenario,
    /// The exact shape, for spheres and half-spaces.
    exact: Vec<Capsule>,
    balls: Vec<CollisionSphere>,
    pairs: Vec<[usize; 2]>,
}

/// A candidate pair, by indices.
#[derive(Clone, Copy)]
enum Pair {
    Sphere(usize, usize),
    HalfSpace(usize, usize),
    Solid(usize, usize),
    Balls([usize; 2]),
}

impl<'a> Distances<'a> {
    /// Prepares the distances of a scenario; `None` without obstacles or pairs of links.
    ///
    /// # Errors
    /// Those of [`Environment::balls`].
    pub fn new(scenario: &'a Scenario) -> Result<Option<Self>> {
        let environment = &scenario.environment;
        if environment.is_empty() {
            return Ok(None);
        }
        let balls = environment.balls()?;
        Ok(Some(Self {
            scenario,
            exact: match &environment.body {
                Body::Capsules { capsules, .. } => capsules.clone(),
                Body::Balls(_) => balls.iter().copied().map(alone).collect(),
            },
            balls,
            pairs: environment.self_pairs(),
        }))
    }

    /// Finds the closest pair with the bodies at `placements`. Cost: one distance per pair.
    ///
    /// # Errors
    /// `placements` has the wrong length.
    pub fn nearest(&self, placements: &[Placement<f64>]) -> Result<Nearest> {
        let Environment {
            spheres,
            solids,
            half_spaces,
            ..
        } = &self.scenario.environment;
        let mut least = (f64::INFINITY, None);
        let mut take = |clearance: f64, pair: Pair| {
            if clearance < least.0 {
                least = (clearance, Some(pair));
            }
        };
        for (i, capsule) in self.exact.iter().enumerate() {
            for (j, sphere) in spheres.iter().enumerate() {
                let clearance = capsule.clearance(placements, &sphere.placed)?;
                take(clearance, Pair::Sphere(i, j));
            }
            for (j, half_space) in half_spaces.iter().enumerate() {
                let height = capsule.height(placements, &half_space.placed)?;
                take(height, Pair::HalfSpace(i, j));
            }
        }
        for (i, ball) in self.balls.iter().enumerate() {
            let centre = centre(ball, placements)?;
            for (j, solid) in solids.iter().enumerate() {
                take(
                    solid.placed.distance(&centre) - ball.radius,
                    Pair::Solid(i, j),
                );
            }
        }
        for pair in &self.pairs {
            let gap = apart(pair.map(|i| &self.balls[i]), placements)?;
            take(gap, Pair::Balls(*pair));
        }
        self.named(least, placements)
    }

    fn named(
        &self,
        (clearance, pair): (f64, Option<Pair>),
        placements: &[Placement<f64>],
    ) -> Result<Nearest> {
        let Environment {
            spheres,
            solids,
            half_spaces,
            ..
        } = &self.scenario.environment;
        // From a point of the robot, inside by a radius, along the normal of the obstacle.
        let along = |from: Vector3<f64>, normal: Vector3<f64>, radius: f64| {
            [from - normal * radius, from - normal * (radius + clearance)]
        };
        let (names, points) = match pair {
            None => Default::default(),
            Some(Pair::Sphere(i, j)) => {
                let (capsule, sphere) = (&self.exact[i], &spheres[j]);
                let [from, to] = ends(capsule, placements)?;
                let (way, off) = (to - from, sphere.placed.centre - from);
                let share =
                    (off.dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                let point = from + way * share;
                let normal = (point - sphere.placed.centre)
                    .try_normalize(0.0)
                    .unwrap_or_else(Vector3::z);
                let names = [self.part(Some(i), capsule.body), sphere.name.clone()];
                (names, along(point, normal, capsule.radius))
            }
            Some(Pair::HalfSpace(i, j)) => {
                let (capsule, half_space) = (&self.exact[i], &half_spaces[j]);
                let [from, to] = ends(capsule, placements)?;
                let normal = half_space.placed.normal;
                let lower = if normal.dot(&from) < normal.dot(&to) {
                    from
                } else {
                    to
                };
                let names = [self.part(Some(i), capsule.body), half_space.name.clone()];
                (names, along(lower, normal, capsule.radius))
            }
            Some(Pair::Solid(i, j)) => {
                let (ball, solid) = (&self.balls[i], &solids[j]);
                let centre = centre(ball, placements)?;
                let normal = solid.placed.distance_derivatives(&centre).normal;
                let names = [self.part(Some(i), ball.body), solid.name.clone()];
                (names, along(centre, normal, ball.radius))
            }
            Some(Pair::Balls([i, j])) => {
                let [a, b] = [i, j].map(|i| &self.balls[i]);
                let between = centre(a, placements)? - centre(b, placements)?;
                let normal = between.try_normalize(0.0).unwrap_or_else(Vector3::z);
                let names = [self.part(Some(i), a.body), self.part(Some(j), b.body)];
                (names, along(centre(a, placements)?, normal, a.radius))
            }
        };
        Ok(Nearest {
            clearance,
            names,
            points,
        })
    }

    /// The name of the link of a ball, or otherwise of the joint that moves the body.
    fn part(&self, ball: Option<usize>, body: Option<usize>) -> String {
        let link = ball.and_then(|i| self.scenario.environment.link_of_ball(i));
        let joint = body.map(|body| self.scenario.model.joints()[body].name());
        link.or(joint).unwrap_or("base").to_owned()
    }
}

/// The ends of a capsule in the base frame.
fn ends(capsule: &Capsule, placements: &[Placement<f64>]) -> Result<[Vector3<f64>; 2]> {
    let end = |i: usize| {
        let ball = CollisionSphere {
            body: capsule.body,
            centre: capsule.ends[i],
            radius: capsule.radius,
        };
        centre(&ball, placements)
    };
    Ok([end(0)?, end(1)?])
}
