//! Lower bounds on the distances of convex shapes on a piece of a motion, by directions that separate them.

use super::Direction;
use super::clearance::{ALLOWANCE, Beside, Least, MAX_CLAIM, Model, Pair, lower};
use crate::{Quantity, RobotShape, Scenario};
use aghf::certify::Bernstein;
use aghf::error::Result;
use aghf::geometry::{Shape, Solid};
use aghf::model::Collision;
use aghf::scalar::AlgebraOver;
use aghf::spatial::Placement;
use nalgebra::Vector3;

/// The number of projections from one shape onto the other.
const PROJECTIONS: usize = 200;

/// The steps from zero to one of the coordinates of a direction: an error of one step changes the gap beside a long
/// edge by a small share of the gaps of motions.
const DECIMALS: f64 = 1e7;

/// A shape of a link.
#[derive(Clone, Debug)]
pub(super) struct Part {
    link: String,
    body: Option<usize>,
    solid: Solid<f64>,
}

/// The shapes of a robot, by the names of their links, and that of its load; `None` if it is represented by balls or
/// one is a mesh.
pub(super) fn parts(scenario: &Scenario) -> Result<Option<Vec<Part>>> {
    if !matches!(scenario.robot_shape(), RobotShape::Collision { .. }) {
        return Ok(None);
    }
    let load = match &scenario.file.payload {
        Some(load) => load.collision(&scenario.model, &scenario.name)?,
        None => None,
    };
    let part = |c: &Collision| Some(Part { link: c.link.clone(), body: c.body, solid: c.solid()? });
    let mut shapes: Vec<&Collision> = scenario.model.collisions().iter().collect();
    shapes.sort_by(|a, b| a.link.cmp(&b.link));
    let parts: Option<Vec<Part>> = shapes.into_iter().chain(&load).map(part).collect();
    let is_ball = |part: &Part| matches!(part.solid.shape, Shape::Sphere { .. });
    Ok(parts.filter(|parts| !parts.iter().all(is_ball)))
}

/// The pairs of the promise.
pub(super) fn pairs(scenario: &Scenario, parts: &[Part], promise: Quantity) -> Result<Vec<Pair>> {
    let scene = &scenario.scene;
    let all = || parts.iter().enumerate();
    let mut pairs = Vec::new();
    if promise == Quantity::Obstacles {
        for (i, _) in all().filter(|(_, part)| part.body.is_some()) {
            let beside = scene.obstacle_margins().iter().enumerate();
            pairs.extend(beside.map(|(o, margin)| Pair { part: i, beside: Beside::Obstacle(o), margin: *margin }));
        }
        return Ok(pairs);
    }
    for (trees, margin) in scenario.kept_apart()? {
        let [a, b] = trees.map(|tree| {
            let link = scene.robot().link_of(&scene.trees()[tree]);
            all().filter(move |(_, part)| Some(&*part.link) == link)
        });
        for (i, _) in a {
            for (j, _) in b.clone() {
                pairs.push(Pair { part: i.min(j), beside: Beside::Part(i.max(j)), margin });
            }
        }
    }
    Ok(pairs)
}

/// A shape on a piece: its placement there, and in the middle.
struct Placed {
    shape: Shape<f64>,
    at: Placement<Model>,
    middle: Solid<f64>,
}

/// The shapes of the robot and the obstacles on a piece.
pub(super) struct Shapes<'a> {
    basis: &'a Bernstein,
    left: f64,
    parts: &'a [Part],
    placed: Vec<Placed>,
    names: Vec<&'a str>,
}

impl<'a> Shapes<'a> {
    pub(super) fn new(
        scenario: &'a Scenario,
        parts: &'a [Part],
        basis: &'a Bernstein,
        bodies: &[Placement<Model>],
        left: f64,
    ) -> Self {
        let place = |body: Option<usize>, solid: &Solid<f64>| {
            let own = &solid.placement;
            let at = match body {
                Some(body) => bodies[body].compose_constant(own),
                None => Placement::new(own.rotation.map(Model::constant), constant(&own.translation)),
            };
            let middle = |x: Model| x.coefficients()[0];
            Placed {
                shape: solid.shape,
                middle: Solid {
                    placement: Placement::new(at.rotation.map(middle), at.translation.map(middle)),
                    shape: solid.shape,
                },
                at,
            }
        };
        let obstacles = scenario.scene.obstacles();
        let of_robot = parts.iter().map(|part| place(part.body, &part.solid));
        Self {
            basis,
            left,
            parts,
            placed: of_robot.chain(obstacles.iter().map(|o| place(None, &o.solid))).collect(),
            names: obstacles.iter().map(|o| &*o.name).collect(),
        }
    }

    /// The least reserve of these pairs, and the directions that it takes beside those of the centres.
    pub(super) fn least(&self, pairs: &[Pair]) -> (Least, Vec<Direction>) {
        let index = |pair: &Pair| match pair.beside {
            Beside::Obstacle(o) => [pair.part, self.parts.len() + o],
            Beside::Part(j) => [pair.part, j],
        };
        let rough = |pair: &Pair| {
            let of = index(pair);
            let b = &self.placed[of[1]];
            let (n, is_bounded) = match b.shape {
                Shape::HalfSpace => (-b.at.rotation.column(2), false),
                _ => (constant(&(b.middle.placement.translation - self.centre(of[0]))), true),
            };
            (self.bound(of, &n, pair.margin), of, pair.margin, is_bounded)
        };
        let mut all: Vec<_> = pairs.iter().map(rough).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut claim, mut middle, mut place) = (MAX_CLAIM, MAX_CLAIM, String::new());
        let mut directions = Vec::new();
        for (bound, of, margin, is_bounded) in all {
            if bound >= claim {
                break;
            }
            let off = self.towards(of);
            if off.norm() - margin < middle {
                middle = off.norm() - margin;
                place = self.names_of(of);
            }
            let mut fine = bound;
            if is_bounded {
                let n = off.normalize().map(|x| (x * DECIMALS).round() / DECIMALS);
                let by_direction = self.bound(of, &constant(&n), margin);
                if by_direction > bound {
                    fine = by_direction;
                    directions.push((bound, Direction(of[0], of[1], n.into())));
                }
            }
            // A claim that is not a number stays NaN.
            claim = if fine >= claim { claim } else { fine };
        }
        directions.retain(|(bound, _)| *bound < claim);
        let directions = directions.into_iter().map(|(_, direction)| direction);
        let least = Least { claim, middle, place };
        (least, directions.collect())
    }

    fn names_of(&self, of: [usize; 2]) -> String {
        let name = |i: usize| match self.parts.get(i) {
            Some(part) => format!("link '{}'", part.link),
            None => format!("'{}'", self.names[i - self.parts.len()]),
        };
        format!("{} and {}", name(of[0]), name(of[1]))
    }

    /// The way from one shape to the other in the middle, by projections from each onto the other: not longer than
    /// there is between two of their points.
    fn towards(&self, of: [usize; 2]) -> Vector3<f64> {
        let [a, b] = of.map(|i| &self.placed[i].middle);
        let onto = |solid: &Solid<f64>, p: Vector3<f64>| {
            let distance = solid.distance_derivatives(&p);
            p - distance.normal * distance.value.max(0.0)
        };
        let mut p = a.placement.translation;
        let mut q = onto(b, p);
        for _ in 0..PROJECTIONS {
            p = onto(a, q);
            q = onto(b, p);
        }
        q - p
    }

    fn centre(&self, of: usize) -> Vector3<f64> {
        self.placed[of].middle.placement.translation
    }

    /// A lower bound on the distance between two shapes in a direction from one to the other, less the margin and the
    /// allowance for another arithmetic.
    fn bound(&self, of: [usize; 2], n: &Vector3<Model>, margin: f64) -> f64 {
        let [a, b] = of.map(|i| &self.placed[i]);
        let off = b.at.translation - a.at.translation;
        let gap = n.dot(&off) - extent(a, n) - extent(b, n);
        lower(self.basis, self.left, gap) / n.dot(n).magnitude().sqrt() - margin - ALLOWANCE
    }
}

fn constant(x: &Vector3<f64>) -> Vector3<Model> {
    x.map(Model::constant)
}

/// An upper bound on the extent of a shape from its centre in a direction and against it: that of a ball, of edges, or
/// of an axis and a disc, with $\sqrt x \le (x + b) / (2 \sqrt b)$ for any $b > 0$.
fn extent(of: &Placed, n: &Vector3<Model>) -> Model {
    let along = of.at.rotation.transpose() * n;
    let squares = along.map(|x| x * x);
    let root = |square: Model| {
        let near = square.coefficients()[0].max(0.3 * square.variation()).max(1e-12);
        (square + Model::constant(near)).divided_by(2.0 * near.sqrt())
    };
    let ball = |radius: f64| root(n.dot(n)).scale(radius);
    match of.shape {
        Shape::Sphere { radius } => ball(radius),
        Shape::Cuboid { half_extents: h } => {
            let edges = [0, 1, 2].map(|i| root(squares[i]).scale(h[i]));
            edges[0] + edges[1] + edges[2]
        }
        Shape::Capsule { radius, half_length } => root(squares.z).scale(half_length) + ball(radius),
        Shape::Cylinder { radius, half_length } => {
            root(squares.z).scale(half_length) + root(squares.x + squares.y).scale(radius)
        }
        // In the direction against its normal, the only one in which it has an end.
        Shape::HalfSpace => Model::constant(0.0),
    }
}
