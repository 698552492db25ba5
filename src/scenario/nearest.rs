//! What a robot is nearest to.

use super::environment::{apart, centre};
use super::robot_shape::{Body, alone};
use super::{Environment, Scenario};
use crate::constraint::{Capsule, CollisionSphere};
use crate::error::Result;
use crate::spatial::Placement;
use nalgebra::Vector3;

/// The robot and what it is nearest to.
#[derive(Clone, Debug)]
pub struct Nearest {
    /// The distance between the two, m; negative where they overlap.
    pub clearance: f64,
    /// The names of the link, or of its joint where the shape of the robot has no links, and of the obstacle or other link.
    pub names: [String; 2],
    /// A point of each, nearest to the other, in the base frame.
    pub points: [Vector3<f64>; 2],
}

/// The distances between a robot and what it has to keep clear of, as [`Environment::clearance`] has them, prepared for many configurations.
pub struct Distances<'a> {
    scenario: &'a Scenario,
    /// The exact shape, for spheres and half-spaces.
    exact: Vec<Capsule>,
    balls: Vec<CollisionSphere>,
    pairs: Vec<[usize; 2]>,
}

/// Two that are near each other, by their indices.
#[derive(Clone, Copy)]
enum Pair {
    Sphere(usize, usize),
    HalfSpace(usize, usize),
    Solid(usize, usize),
    Balls([usize; 2]),
}

impl<'a> Distances<'a> {
    /// Those of a scenario; `None` where there is nothing to keep clear of.
    ///
    /// # Errors
    /// As [`Environment::balls`].
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

    /// What the robot is nearest to with its bodies at `placements`. Cost: one distance for each pair.
    ///
    /// # Errors
    /// The placements are those of another robot.
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
                let names = [self.part(Some(i), capsule.body), sphere.name().to_owned()];
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
                let names = [
                    self.part(Some(i), capsule.body),
                    half_space.name().to_owned(),
                ];
                (names, along(lower, normal, capsule.radius))
            }
            Some(Pair::Solid(i, j)) => {
                let (ball, solid) = (&self.balls[i], &solids[j]);
                let centre = centre(ball, placements)?;
                let normal = solid.placed.distance_derivatives(&centre).normal;
                let names = [self.part(Some(i), ball.body), solid.name().to_owned()];
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

    /// The name of the link of a ball, or else of the joint that moves the body.
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
