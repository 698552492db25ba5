//! The obstacles around the robot of a scenario, and the shape of the robot.

use super::obstacles::{Named, placed};
use super::robot_shape::{Body, alone};
use super::self_collision::{check_links, self_pairs};
use super::{ScenarioFile, SelfCollision};
use aghf::constraint::{
    AnyConstraint, CollisionSphere, HalfSpace, HalfSpaceClearance, SelfClearance, SolidClearance,
    Sphere, SphereClearance,
};
use aghf::dynamics::forward_kinematics;
use aghf::error::{Error, Result, check_length};
use aghf::geometry::{Shape, Solid};
use aghf::model::Model;
use aghf::spatial::Placement;
use nalgebra::Vector3;
use std::path::Path;

/// The largest number of distances between a ball and an obstacle: each is a row of the constraints, which takes about
/// 10 kB at degree 16.
const MOST_DISTANCES: f64 = 5e4;

/// The shape of a robot among obstacles.
#[derive(Clone, Debug)]
pub struct Environment {
    pub(super) body: Body,
    pub(super) spheres: Vec<Named<Sphere>>,
    pub(super) solids: Vec<Named<Solid>>,
    pub(super) half_spaces: Vec<Named<HalfSpace>>,
    /// The pairs of links that may overlap; without any list of them the robot may overlap itself anywhere.
    ignored_pairs: Option<Vec<[String; 2]>>,
}

/// An overlap of a ball of the robot with an obstacle or another link.
pub(super) struct Overlap {
    /// The obstacle in quotes, or the other link.
    pub(super) obstacle: String,
    /// The body that carries the ball.
    pub(super) body: Option<usize>,
    /// The link of the ball, if the ball belongs to one.
    pub(super) link: Option<String>,
    /// The depth of the ball in the obstacle, m; negative when it is clear.
    pub(super) depth: f64,
}

impl Environment {
    /// Builds the environment of a scenario; `path` names the scenario in errors. Meshes are looked for from `folder`.
    pub(super) fn new(
        model: &Model,
        file: &ScenarioFile,
        folder: &Path,
        path: &str,
    ) -> Result<Self> {
        let (mut spheres, mut half_spaces, mut solids) = (Vec::new(), Vec::new(), Vec::new());
        for Named { name, placed } in placed(&file.obstacles, path)? {
            let Placement {
                rotation,
                translation: centre,
            } = placed.placement;
            match placed.shape {
                Shape::Sphere { radius } => spheres.push(Named {
                    name,
                    placed: Sphere { centre, radius },
                }),
                Shape::HalfSpace => {
                    let normal = rotation.column(2).into_owned();
                    let offset = normal.dot(&centre);
                    let placed = HalfSpace { normal, offset };
                    half_spaces.push(Named { name, placed });
                }
                _ => solids.push(Named { name, placed }),
            }
        }
        let environment = Self {
            spheres,
            solids,
            half_spaces,
            body: Body::new(model, file.robot_shape, folder, path)?,
            ignored_pairs: match &file.self_collision {
                None => None,
                Some(SelfCollision::IgnoredPairs(pairs)) => Some(pairs.clone()),
                Some(SelfCollision::IgnoredPairsFile(_)) => {
                    let condition = "a file is read when a scenario is, and not here";
                    return Err(Error::input(path, "self_collision", condition));
                }
            },
        };
        if let Some(pairs) = &environment.ignored_pairs {
            check_links(pairs, model, path)?;
            if matches!(environment.body, Body::Capsules { .. }) {
                let condition = "links are told apart with the robot_shape 'collision' only";
                return Err(Error::input(path, "self_collision", condition));
            }
        }
        let Self {
            spheres,
            solids,
            half_spaces,
            ..
        } = &environment;
        let obstacles = spheres.len() + solids.len() + half_spaces.len();
        let (count, pairs) = (environment.body.count(), environment.self_pairs().len());
        if count * obstacles as f64 + pairs as f64 > MOST_DISTANCES {
            let key = match obstacles {
                0 => "robot_shape",
                _ => "obstacles",
            };
            let own = match pairs {
                0 => String::new(),
                pairs => format!(", {pairs} pairs of these included"),
            };
            let condition = format!(
                "{obstacles} obstacles and {count} balls of the robot have more than {MOST_DISTANCES} distances between them{own}"
            );
            return Err(Error::input(path, key, condition));
        }
        Ok(environment)
    }

    /// Moves the shape to a reduced robot whose bodies contain those of the full one: per body the one that contains
    /// it, and its placement there.
    pub(super) fn reduced(mut self, bodies: &[(Option<usize>, Placement<f64>)]) -> Self {
        self.body.reduced(bodies);
        self
    }

    /// Returns true if the robot has no obstacle and no other link to keep clear of.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty()
            && self.solids.is_empty()
            && self.half_spaces.is_empty()
            && self.self_pairs().is_empty()
    }

    /// The balls that represent the robot, those on its base included.
    ///
    /// # Errors
    /// As [`Capsule::balls`](aghf::constraint::Capsule::balls).
    pub fn balls(&self) -> Result<Vec<CollisionSphere>> {
        self.body.balls()
    }

    /// The pairs of [balls](Self::balls) that keep clear of each other: balls of different bodies, on links that may
    /// not overlap.
    #[must_use]
    pub fn self_pairs(&self) -> Vec<[usize; 2]> {
        match (&self.body, &self.ignored_pairs) {
            (Body::Balls(balls), Some(ignored)) => self_pairs(balls, ignored),
            _ => Vec::new(),
        }
    }

    /// The sphere obstacles, in the order of the scenario.
    pub fn spheres(&self) -> impl Iterator<Item = &Sphere> {
        self.spheres.iter().map(|named| &named.placed)
    }

    /// The box, cylinder and capsule obstacles, in this order.
    pub fn solids(&self) -> impl Iterator<Item = &Solid> {
        self.solids.iter().map(|named| &named.placed)
    }

    /// The half-spaces that the robot must stay in.
    pub fn half_spaces(&self) -> impl Iterator<Item = &HalfSpace> {
        self.half_spaces.iter().map(|named| &named.placed)
    }

    /// The names of all obstacles, each after its key and number: those of the spheres, the half-spaces and the solids.
    #[must_use]
    pub fn obstacle_names(&self) -> Vec<String> {
        let spheres = self.spheres.iter().map(|named| named.name.clone());
        let half_spaces = self.half_spaces.iter().map(|named| named.name.clone());
        let solids = self.solids.iter().map(|named| named.name.clone());
        spheres.chain(half_spaces).chain(solids).collect()
    }

    /// The link of one of the [balls](Self::balls); `None` if the balls represent no links.
    #[must_use]
    pub fn link_of_ball(&self, ball: usize) -> Option<&str> {
        match &self.body {
            Body::Balls(balls) => balls.get(ball).map(|ball| ball.link.as_str()),
            Body::Capsules { .. } => None,
        }
    }

    /// The constraints that keep the robot clear of obstacles and of itself. Balls fixed to the base count only for
    /// self-collision, because they never move.
    ///
    /// # Errors
    /// As [`balls`](Self::balls).
    pub fn constraints(&self) -> Result<Vec<AnyConstraint>> {
        let all = self.balls()?;
        let moving = all.iter().filter(|ball| ball.body.is_some());
        let balls: Vec<CollisionSphere> = moving.copied().collect();
        let mut constraints = Vec::new();
        if !self.spheres.is_empty() {
            constraints.push(AnyConstraint::Spheres(SphereClearance {
                balls: balls.clone(),
                spheres: self.spheres().copied().collect(),
            }));
        }
        constraints.extend(self.half_spaces().map(|half_space| {
            AnyConstraint::HalfSpace(HalfSpaceClearance {
                balls: balls.clone(),
                half_space: *half_space,
            })
        }));
        if !self.solids.is_empty() {
            let names = self.solids.iter().map(|solid| solid.name.clone());
            constraints.push(AnyConstraint::Solids(SolidClearance {
                balls,
                solids: self.solids().copied().collect(),
                names: names.collect(),
            }));
        }
        let pairs = self.self_pairs();
        if !pairs.is_empty() {
            constraints.push(AnyConstraint::SelfCollision(SelfClearance {
                balls: all,
                pairs,
            }));
        }
        Ok(constraints)
    }

    /// The deepest overlap between a ball and an obstacle or another ball of the constraints, with the bodies at
    /// `placements`; a negative one is the smallest distance. `None` without obstacles or pairs of links.
    pub(super) fn deepest(&self, placements: &[Placement<f64>]) -> Result<Option<Overlap>> {
        let balls = self.balls()?;
        let link = |i: usize| self.link_of_ball(i).map(str::to_owned);
        let mut overlaps = Vec::new();
        for (i, ball) in balls.iter().enumerate() {
            let mut add = |obstacle: String, clearance: f64| {
                overlaps.push(Overlap {
                    obstacle,
                    body: ball.body,
                    link: link(i),
                    depth: -clearance,
                });
            };
            let capsule = alone(*ball);
            for sphere in &self.spheres {
                let clearance = capsule.clearance(placements, &sphere.placed)?;
                add(format!("'{}'", sphere.name), clearance);
            }
            for half_space in &self.half_spaces {
                let height = capsule.height(placements, &half_space.placed)?;
                add(format!("'{}'", half_space.name), height);
            }
            let centre = centre(ball, placements)?;
            for solid in &self.solids {
                let clearance = solid.placed.distance(&centre) - ball.radius;
                add(format!("'{}'", solid.name), clearance);
            }
        }
        for [i, j] in self.self_pairs() {
            overlaps.push(Overlap {
                obstacle: format!("link '{}'", link(j).unwrap_or_default()),
                body: balls[i].body,
                link: link(i),
                depth: -apart([&balls[i], &balls[j]], placements)?,
            });
        }
        let deepest = overlaps
            .into_iter()
            .max_by(|a, b| a.depth.total_cmp(&b.depth));
        Ok(deepest)
    }

    /// The distance from the robot to the nearest obstacle, or between two of its links that keep clear of each other,
    /// with its bodies at `placements`, in m; negative in a collision, infinite without obstacles or pairs of links.
    /// Distances of swept links from spheres and half-spaces are exact; all others are those of the balls that cover
    /// the shape.
    ///
    /// # Errors
    /// `placements` has the wrong length.
    pub fn clearance(&self, placements: &[Placement<f64>]) -> Result<f64> {
        let balls = self.balls()?;
        let exact = match &self.body {
            Body::Capsules { capsules, .. } => capsules.clone(),
            Body::Balls(_) => balls.iter().copied().map(alone).collect(),
        };
        let mut smallest = f64::INFINITY;
        for capsule in exact {
            for sphere in self.spheres() {
                smallest = smallest.min(capsule.clearance(placements, sphere)?);
            }
            for half_space in self.half_spaces() {
                smallest = smallest.min(capsule.height(placements, half_space)?);
            }
        }
        for ball in &balls {
            let centre = centre(ball, placements)?;
            for solid in self.solids() {
                smallest = smallest.min(solid.distance(&centre) - ball.radius);
            }
        }
        for pair in self.self_pairs() {
            smallest = smallest.min(apart(pair.map(|i| &balls[i]), placements)?);
        }
        Ok(smallest)
    }

    /// The smallest clearance over configurations, in m; `None` without obstacles.
    ///
    /// # Errors
    /// A configuration has the wrong length.
    pub fn smallest_clearance<'q>(
        &self,
        model: &Model,
        configurations: impl Iterator<Item = &'q [f64]>,
    ) -> Result<Option<f64>> {
        if self.is_empty() {
            return Ok(None);
        }
        let mut placements = vec![Placement::identity(); model.dof()];
        let mut smallest = f64::INFINITY;
        for q in configurations {
            forward_kinematics(model, q, &mut placements)?;
            smallest = smallest.min(self.clearance(&placements)?);
        }
        Ok(Some(smallest))
    }
}

/// The centre of a ball in the base frame.
pub(super) fn centre(
    ball: &CollisionSphere,
    placements: &[Placement<f64>],
) -> Result<Vector3<f64>> {
    let Some(body) = ball.body else {
        return Ok(ball.centre);
    };
    check_length(
        "placements",
        placements.len().max(body + 1),
        placements.len(),
    )?;
    let placement = &placements[body];
    Ok(placement.rotation * ball.centre + placement.translation)
}

/// The distance between two balls, m; negative where they overlap.
pub(super) fn apart(balls: [&CollisionSphere; 2], placements: &[Placement<f64>]) -> Result<f64> {
    let [first, second] = balls;
    let between = centre(first, placements)? - centre(second, placements)?;
    Ok(between.norm() - first.radius - second.radius)
}
