//! Lower bounds on the distances of convex shapes on a piece of a motion, by directions that separate them.

use super::Direction;
use super::clearance::{ALLOWANCE, Beside, Least, MAX_CLAIM, Model, Pair, lower};
use crate::{Quantity, RobotShape, Scenario};
use aghf::certify::Bernstein;
use aghf::error::Result;
use aghf::geometry::{Convex, ConvexPiece, PIECE_RADIUS, Placed, Shape, Solid, gap, gap_to};
use aghf::model::{Collision, CollisionShape};
use aghf::scalar::AlgebraOver;
use aghf::spatial::Placement;
use nalgebra::Vector3;

/// The steps from zero to one of the coordinates of a direction: an error of one step changes the gap beside a long
/// edge by a small share of the gaps of motions.
const DECIMALS: f64 = 1e7;

/// A shape of a link: a solid, or a convex piece of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Part {
    link: String,
    body: Option<usize>,
    /// The placement in the body; that of a piece is about the middle of the box of its corners.
    placement: Placement<f64>,
    solid: Option<Shape<f64>>,
    convex: Option<Convex>,
}

/// The shapes of a robot.
pub(super) struct Parts {
    pub(super) all: Vec<Part>,
    /// The pieces of each mesh, in the frame of its shape.
    pub(super) pieces: Vec<Vec<ConvexPiece>>,
}

/// The shapes of a robot, by the names of their links, and that of its load; `None` if it is represented by balls.
pub(super) fn parts(scenario: &Scenario) -> Result<Option<Parts>> {
    if !matches!(scenario.robot_shape(), RobotShape::Collision { .. }) {
        return Ok(None);
    }
    let load = match &scenario.file.payload {
        Some(load) => load.collision(&scenario.model, &scenario.name)?,
        None => None,
    };
    let mut of_meshes = scenario.scene.robot().pieces.iter();
    let with_pieces = |shape| match shape {
        &Collision { shape: CollisionShape::Mesh { .. }, .. } => (shape, of_meshes.next()),
        _ => (shape, None),
    };
    let mut shapes: Vec<(&Collision, _)> = scenario.model.collisions().iter().map(with_pieces).collect();
    shapes.sort_by(|(a, _), (b, _)| a.link.cmp(&b.link));
    let (mut all, mut pieces) = (Vec::new(), Vec::new());
    for (Collision { link, body, placement, shape }, own) in shapes.into_iter().chain(load.iter().map(|of| (of, None)))
    {
        let part = |placement, solid, convex| Part { link: link.clone(), body: *body, placement, solid, convex };
        if let CollisionShape::Solid(shape) = *shape {
            let convex = Convex::of_solid(&Solid { placement: Placement::identity(), shape });
            all.push(part(*placement, Some(shape), convex));
        }
        for ConvexPiece { corners, .. } in own.into_iter().flatten() {
            let middle = middle(corners);
            let at = Placement::new(placement.rotation, placement.point(&middle));
            let about = corners.iter().map(|corner| corner - middle).collect();
            all.push(part(at, None, Some(Convex::of_corners(about, PIECE_RADIUS))));
        }
        pieces.extend(own.cloned());
    }
    let is_ball = |part: &Part| matches!(part.solid, Some(Shape::Sphere { .. }));
    Ok((!all.iter().all(is_ball)).then_some(Parts { all, pieces }))
}

/// The middle of the box of points along the axes.
fn middle(points: &[Vector3<f64>]) -> Vector3<f64> {
    let lower = points.iter().fold(points[0], |least, p| least.inf(p));
    let upper = points.iter().fold(points[0], |most, p| most.sup(p));
    (lower + upper) * 0.5
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

/// A shape on a piece of a motion: its placement there, and in the middle.
struct Moving<'a> {
    /// The solid; none of a convex piece.
    solid: Option<Shape<f64>>,
    /// The convex body in the frame of the shape, or that of an obstacle in the base frame; none of a half-space.
    convex: Option<&'a Convex>,
    is_obstacle: bool,
    at: Placement<Model>,
    middle: Placement<f64>,
    /// The radius of a ball about its centre that contains it, m.
    radius: f64,
    /// A bound on the way of its centre from the middle, m.
    way: f64,
}

impl Moving<'_> {
    fn in_middle(&self) -> Option<Placed<'_, f64, f64>> {
        let placement = (!self.is_obstacle).then_some(&self.middle);
        self.convex.map(|convex| Placed { convex, placement })
    }
}

/// The shapes of the robot and the obstacles on a piece.
pub(super) struct Shapes<'a> {
    basis: &'a Bernstein,
    left: f64,
    parts: &'a [Part],
    placed: Vec<Moving<'a>>,
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
        let place = |body: Option<usize>, own: &Placement<f64>, solid, convex: Option<&'a Convex>, is_obstacle| {
            let at = match body {
                Some(body) => bodies[body].compose_constant(own),
                None => Placement::new(own.rotation.map(Model::constant), constant(&own.translation)),
            };
            let middle = |x: Model| x.coefficients()[0];
            Moving {
                solid,
                convex,
                is_obstacle,
                middle: Placement::new(at.rotation.map(middle), at.translation.map(middle)),
                radius: convex.map_or(f64::INFINITY, |convex| convex.ball().radius),
                way: at.translation.map(|x| x.variation() + (1.0 + left) * x.radius()).norm(),
                at,
            }
        };
        let obstacles = scenario.scene.obstacles();
        let of_robot =
            parts.iter().map(|part| place(part.body, &part.placement, part.solid, part.convex.as_ref(), false));
        let of_world = obstacles.iter().zip(scenario.scene.forms()).map(|(obstacle, convex)| {
            let Solid { placement, shape } = &obstacle.solid;
            place(None, placement, Some(*shape), convex.as_ref(), true)
        });
        Self {
            basis,
            left,
            parts,
            placed: of_robot.chain(of_world).collect(),
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
            (self.apart(of) - pair.margin - ALLOWANCE, of, pair.margin)
        };
        let mut all: Vec<_> = pairs.iter().map(rough).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut claim, mut middle, mut place) = (MAX_CLAIM, MAX_CLAIM, String::new());
        let mut directions = Vec::new();
        for (bound, of, margin) in all {
            if bound >= claim {
                break;
            }
            let along = self.along_centres(of);
            let bound = self.bound(of, &along, margin).max(bound);
            if bound >= claim {
                continue;
            }
            let off = self.towards(of);
            if off.norm() - margin < middle {
                middle = off.norm() - margin;
                place = self.names_of(of);
            }
            let mut fine = bound;
            if !self.is_half_space(of[1]) {
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

    /// The distance between the balls about two shapes, at least, m.
    fn apart(&self, of: [usize; 2]) -> f64 {
        let [a, b] = of.map(|i| &self.placed[i]);
        let off = (b.middle.translation - a.middle.translation).norm() - a.way - b.way;
        (off - a.radius - b.radius) - 8.0 * f64::EPSILON * off.abs()
    }

    /// The direction of the centres in the middle, or against the normal of a half-space.
    fn along_centres(&self, of: [usize; 2]) -> Vector3<Model> {
        let [a, b] = of.map(|i| &self.placed[i]);
        if self.is_half_space(of[1]) {
            return -b.at.rotation.column(2);
        }
        constant(&(b.middle.translation - a.middle.translation))
    }

    /// The shortest way from one shape to the other in the middle; zero where they overlap.
    fn towards(&self, of: [usize; 2]) -> Vector3<f64> {
        let [a, b] = of.map(|i| &self.placed[i]);
        let Some(first) = a.in_middle() else {
            return Vector3::zeros();
        };
        let Some(second) = b.in_middle() else {
            let half_space = Solid { placement: b.middle, shape: Shape::HalfSpace };
            let distance = gap_to(&first, (&half_space, None)).distance;
            return -b.middle.rotation.column(2) * distance.max(0.0);
        };
        let found = gap(&[first, second]);
        if found.distance > 0.0 { found.points[1] - found.points[0] } else { Vector3::zeros() }
    }

    fn is_half_space(&self, of: usize) -> bool {
        self.placed[of].convex.is_none()
    }

    /// A lower bound on the distance between two shapes in a direction from one to the other, less the margin and the
    /// allowance for another arithmetic.
    fn bound(&self, of: [usize; 2], n: &Vector3<Model>, margin: f64) -> f64 {
        let [a, b] = of.map(|i| &self.placed[i]);
        let mut gap = n.dot(&(b.at.translation - a.at.translation));
        let (mut radius, mut turns) = (0.0, 0.0);
        // Each shape with the direction away from the other one.
        let sides = [(a, -*n), (b, *n)];
        let mut corners = None;
        for (shape, n) in &sides {
            if let Some(solid) = &shape.solid {
                gap -= extent(solid, &shape.at, n);
                continue;
            }
            let own = shape.convex.map_or(&[][..], Convex::corners);
            radius += PIECE_RADIUS;
            let along = shape.at.rotation.transpose() * n;
            if let Some((before, own_before)) = corners.replace((along, own)) {
                // The nearest corner of the first piece, and how far others of it come nearer.
                let first = nearest(&before, own_before);
                gap += along_of(&before, &first);
                let others = own_before.iter().map(|c| along_of(&before, &(c - first)));
                turns = self.least_of(others);
            }
        }
        let least = match corners {
            Some((along, own)) => self.least_of(own.iter().map(|c| gap + along_of(&along, c))),
            None => lower(self.basis, self.left, gap),
        };
        (least + turns) / n.dot(n).magnitude().sqrt() - radius - margin - ALLOWANCE
    }

    /// A lower bound on the least of several values.
    fn least_of(&self, values: impl Iterator<Item = Model>) -> f64 {
        let rough = |x: Model| x.coefficients()[0] - x.variation() - self.left * x.radius();
        let mut all: Vec<_> = values.map(|x| (rough(x), x)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut least = f64::INFINITY;
        for (rough, x) in all {
            if rough >= least {
                break;
            }
            let fine = lower(self.basis, self.left, x);
            // NaN stays.
            least = if fine >= least { least } else { fine };
        }
        least
    }
}

/// The corner that is nearest in the middle.
fn nearest(along: &Vector3<Model>, corners: &[Vector3<f64>]) -> Vector3<f64> {
    let along = along.map(|x| x.coefficients()[0]);
    let least = corners.iter().min_by(|a, b| along.dot(a).total_cmp(&along.dot(b)));
    least.copied().unwrap_or_default()
}

/// The product of a direction and a constant vector.
fn along_of(along: &Vector3<Model>, c: &Vector3<f64>) -> Model {
    along.x.scale(c.x) + along.y.scale(c.y) + along.z.scale(c.z)
}

fn constant(x: &Vector3<f64>) -> Vector3<Model> {
    x.map(Model::constant)
}

/// An upper bound on the extent of a shape from its centre in a direction and against it: that of a ball, of edges, or
/// of an axis and a disc, with $\sqrt x \le (x + b) / (2 \sqrt b)$ for any $b > 0$.
fn extent(shape: &Shape<f64>, at: &Placement<Model>, n: &Vector3<Model>) -> Model {
    let along = at.rotation.transpose() * n;
    let squares = along.map(|x| x * x);
    let root = |square: Model| {
        let near = square.coefficients()[0].max(0.3 * square.variation()).max(1e-12);
        (square + Model::constant(near)).divided_by(2.0 * near.sqrt())
    };
    let ball = |radius: f64| root(n.dot(n)).scale(radius);
    match *shape {
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
