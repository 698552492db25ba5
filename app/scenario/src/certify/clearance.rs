//! Lower bounds on clearances on a piece of a motion.

use crate::{Quantity, Scenario};
use aghf::certify::{Bernstein, ORDER, Polynomial};
use aghf::error::Result;
use aghf::geometry::{CollisionSphere, Shape, Solid};
use aghf::scalar::{AlgebraOver, TaylorModel};
use aghf::spatial::Placement;
use nalgebra::Vector3;

/// The largest reserve that is claimed, m: distant pairs need no accurate bound.
pub(super) const MAX_CLAIM: f64 = 0.05;

/// The accuracy of squared distances, m^2, and the allowance of a claim for another arithmetic, m.
const ACCURACY: f64 = 1e-12;
pub(super) const ALLOWANCE: f64 = 1e-10;

pub(super) type Model = TaylorModel<ORDER>;

/// An object of which a ball or a shape of the robot keeps clear.
#[derive(Clone, Copy)]
pub(super) enum Beside {
    Obstacle(usize),
    Part(usize),
}

/// A ball or a shape, the object of which it keeps clear, and the distance that is kept, m.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) part: usize,
    pub(super) beside: Beside,
    pub(super) margin: f64,
}

/// The pairs of the promise.
pub(super) fn pairs(scenario: &Scenario, promise: Quantity) -> Result<Vec<Pair>> {
    let scene = &scenario.scene;
    let balls = |tree: usize| scene.trees()[tree].nodes.iter().filter_map(|node| node.leaf);
    if promise == Quantity::Obstacles {
        let moving = (0..scene.robot().balls.len()).filter(|i| scene.robot().balls[*i].body.is_some());
        let beside = scene.obstacle_margins().iter().enumerate();
        let of = |ball| {
            beside.clone().map(move |(obstacle, margin)| Pair {
                part: ball,
                beside: Beside::Obstacle(obstacle),
                margin: *margin,
            })
        };
        return Ok(moving.flat_map(of).collect());
    }
    let between = |([a, b], margin): ([usize; 2], f64)| {
        let all = balls(a).flat_map(move |i| balls(b).map(move |j| (i, j)));
        all.map(move |(ball, other)| Pair { part: ball, beside: Beside::Part(other), margin }).collect::<Vec<_>>()
    };
    let links = scenario.kept_apart()?.into_iter();
    Ok(links.flat_map(between).collect())
}

/// The least reserve on a piece, m.
pub(super) struct Least {
    pub(super) claim: f64,
    /// The distance of the nearest pair in the middle, less the distance that is kept, and its names.
    pub(super) middle: f64,
    pub(super) place: String,
}

/// The balls of the robot on a piece.
pub(super) struct Balls<'a> {
    scenario: &'a Scenario,
    basis: &'a Bernstein,
    centres: Vec<Vector3<Model>>,
    middles: Vec<Vector3<f64>>,
    /// Bounds on the ways of the centres from there, with an allowance for another arithmetic.
    ways: Vec<f64>,
    /// The multiple of errors that is left to another arithmetic.
    left: f64,
}

impl<'a> Balls<'a> {
    pub(super) fn new(
        scenario: &'a Scenario,
        basis: &'a Bernstein,
        placements: &[Placement<Model>],
        left: f64,
    ) -> Self {
        let centre = |ball: &CollisionSphere| match ball.body {
            None => ball.centre.map(Model::constant),
            Some(body) => {
                let Placement { rotation, translation } = &placements[body];
                let row = |i: usize| {
                    let terms = (0..3).map(|j| rotation[(i, j)].scale(ball.centre[j]));
                    terms.fold(translation[i], |sum, term| sum + term)
                };
                Vector3::new(row(0), row(1), row(2))
            }
        };
        let centres: Vec<_> = scenario.scene.robot().balls.iter().map(centre).collect();
        let way = |c: &Vector3<Model>| c.map(|x| x.variation() + (1.0 + left) * x.radius()).norm();
        Self {
            scenario,
            basis,
            middles: centres.iter().map(|c| c.map(|x| x.coefficients()[0])).collect(),
            ways: centres.iter().map(way).collect(),
            left,
            centres,
        }
    }

    /// The least reserve of these pairs.
    pub(super) fn least(&self, pairs: &[Pair]) -> Least {
        let balls = &self.scenario.scene.robot().balls;
        let rough = |pair: &Pair| {
            let p = &self.middles[pair.part];
            let (distance, way) = match pair.beside {
                Beside::Obstacle(i) => (self.solid(i).distance(p), 0.0),
                Beside::Part(i) => {
                    let gap = (p - self.middles[i]).norm() - balls[i].radius;
                    (gap, self.ways[i])
                }
            };
            let middle = distance - balls[pair.part].radius - pair.margin;
            (middle, middle - way - self.ways[pair.part])
        };
        let mut all: Vec<_> = pairs.iter().map(|pair| (rough(pair), pair)).collect();
        all.retain(|((_, bound), _)| {
            let is_far = *bound > MAX_CLAIM + ALLOWANCE;
            !is_far
        });
        all.sort_by(|a, b| a.0.1.total_cmp(&b.0.1));
        let mut claim = MAX_CLAIM;
        let mut nearest: Option<(f64, &Pair)> = None;
        for ((middle, bound), pair) in all {
            if bound >= claim + ALLOWANCE {
                break;
            }
            if nearest.is_none_or(|(known, _)| middle < known) {
                nearest = Some((middle, pair));
            }
            let fine = self.bound(pair) - ALLOWANCE;
            // A claim that is not a number stays NaN.
            claim = if fine >= claim { claim } else { fine };
        }
        Least {
            claim,
            middle: nearest.map_or(MAX_CLAIM, |(middle, _)| middle),
            place: nearest.map_or_else(String::new, |(_, pair)| self.names(pair)),
        }
    }

    fn solid(&self, obstacle: usize) -> &Solid {
        &self.scenario.scene.obstacles()[obstacle].solid
    }

    fn names(&self, pair: &Pair) -> String {
        let scene = &self.scenario.scene;
        let ball = |i: usize| match (scene.robot().links.get(i), scene.robot().balls[i].body) {
            (Some(link), _) => format!("link '{link}'"),
            (None, Some(body)) => {
                format!("the body of joint '{}'", self.scenario.model.joints()[body].name())
            }
            (None, None) => "the base".to_owned(),
        };
        match pair.beside {
            Beside::Obstacle(i) => {
                format!("{} and '{}'", ball(pair.part), scene.obstacles()[i].name)
            }
            Beside::Part(i) => format!("{} and {}", ball(pair.part), ball(i)),
        }
    }

    /// A lower bound on the length of a vector.
    fn length(&self, of: &[Model]) -> f64 {
        let square = of.iter().map(|x| *x * *x).reduce(|a, b| a + b);
        let square = square.map_or(0.0, |square| lower(self.basis, self.left, square));
        // NaN for a vector with NaN.
        if square < 0.0 { 0.0 } else { square.sqrt() * (1.0 - 4.0 * f64::EPSILON) }
    }

    /// A lower bound on the reserve of a pair, m.
    fn bound(&self, pair: &Pair) -> f64 {
        let balls = &self.scenario.scene.robot().balls;
        let p = &self.centres[pair.part];
        let distance = match pair.beside {
            Beside::Obstacle(i) => self.to_solid(self.solid(i), p),
            Beside::Part(i) => {
                let off = p - self.centres[i];
                self.length(off.as_slice()) - balls[i].radius
            }
        };
        distance - balls[pair.part].radius - pair.margin
    }

    /// A lower bound on the signed distance from a solid, in its own frame: that from the part of its surface that is
    /// nearest in the middle, where the signs of coordinates do not change.
    fn to_solid(&self, solid: &Solid, p: &Vector3<Model>) -> f64 {
        let Placement { rotation, translation } = &solid.placement;
        let from = Vector3::from_fn(|i, _| p[i] - Model::constant(translation[i]));
        let p = Vector3::from_fn(|j, _| {
            (0..3).map(|i| from[i].scale(rotation[(i, j)])).fold(Model::constant(0.0), |a, b| a + b)
        });
        // The distance from a face, beyond it.
        let beyond = |i: usize, half: f64| {
            let sign = if p[i].coefficients()[0] < 0.0 { -1.0 } else { 1.0 };
            let off = p[i].scale(sign) - Model::constant(half);
            (off, lower(self.basis, self.left, off))
        };
        match solid.shape {
            Shape::Sphere { radius } => self.length(p.as_slice()) - radius,
            Shape::HalfSpace => lower(self.basis, self.left, p.z),
            Shape::Cuboid { half_extents } => {
                let faces: Vec<_> = (0..3).map(|i| beyond(i, half_extents[i])).collect();
                let out: Vec<_> = faces.iter().filter(|(_, off)| *off >= 0.0).map(|f| f.0).collect();
                match out.len() {
                    2 | 3 => self.length(&out),
                    _ => faces.iter().map(|f| f.1).reduce(|a, b| if a >= b { a } else { b }).unwrap_or(f64::NAN),
                }
            }
            Shape::Capsule { radius, half_length } => {
                let (off, least) = beyond(2, half_length);
                let with_cap = [p.x, p.y, off];
                self.length(if least >= 0.0 { &with_cap } else { &with_cap[..2] }) - radius
            }
            Shape::Cylinder { radius, half_length } => {
                let (_, along) = beyond(2, half_length);
                let across = self.length(&[p.x, p.y]) - radius;
                if along >= 0.0 && across >= 0.0 {
                    along.hypot(across) * (1.0 - 4.0 * f64::EPSILON)
                } else if across >= along {
                    across
                } else {
                    along
                }
            }
        }
    }
}

/// A lower bound on the values of a model, less the allowance for another arithmetic.
pub(super) fn lower(basis: &Bernstein, left: f64, x: Model) -> f64 {
    basis.range(&Polynomial::from(x), ACCURACY).lower - left * x.radius()
}
