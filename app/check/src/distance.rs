//! Lower bounds on distances.

use crate::arithmetic::{Bernstein, Tm, UNIT, Vector, apply, dot, sub, transpose, vector};
use crate::mesh::RADIUS;
use crate::robot::{Pose, Robot};
use crate::scenario::{Obstacle, Pair};
use crate::shape::{Solid, extent, radius_about};
use std::collections::BTreeMap;

/// Lower bounds on distances.
pub(crate) struct Distances<'a>(pub(crate) &'a Bernstein);

impl Distances<'_> {
    pub(crate) fn lower(&self, x: Tm) -> f64 {
        self.0.least(&x.c, x.r, f64::INFINITY, 1e-12)
    }
    pub(crate) fn length(&self, of: &[Tm]) -> f64 {
        let square = of.iter().fold(Tm::new(0.0), |sum, x| sum + *x * *x);
        let square = self.lower(square);
        if square < 0.0 { 0.0 } else { square.sqrt() * (1.0 - 4.0 * UNIT) }
    }
    /// From the surface of an obstacle, negative inside.
    pub(crate) fn from(&self, obstacle: &Solid, p: Vector) -> f64 {
        let p = apply(transpose(obstacle.at.0), sub(p, obstacle.at.1));
        let [r, h, _] = obstacle.size;
        let beyond = |i: usize, half: f64| {
            let off = if p[i].c[0] < 0.0 { -p[i] } else { p[i] } - Tm::new(half);
            (off, self.lower(off))
        };
        match obstacle.kind {
            "sphere" => self.length(&p) - r,
            "half_space" => self.lower(p[2]),
            "capsule" => {
                let (off, least) = beyond(2, h);
                self.length(&[p[0], p[1], off][..if least >= 0.0 { 3 } else { 2 }]) - r
            }
            "cylinder" => {
                let (along, across) = (beyond(2, h).1, self.length(&p[..2]) - r);
                if along >= 0.0 && across >= 0.0 { along.hypot(across) * (1.0 - 4.0 * UNIT) } else { along.max(across) }
            }
            _ => {
                let faces = [0, 1, 2].map(|i| beyond(i, obstacle.size[i]));
                let out: Vec<Tm> = faces.iter().filter(|f| f.1 >= 0.0).map(|f| f.0).collect();
                if out.len() >= 2 { self.length(&out) } else { faces.iter().fold(f64::NEG_INFINITY, |a, f| a.max(f.1)) }
            }
        }
    }
}

/// The distance of a point from the surface of an obstacle, negative inside, with an error of at most `ROUGH`, m.
fn rough(obstacle: &Solid, p: [f64; 3]) -> f64 {
    let off: [f64; 3] = std::array::from_fn(|i| p[i] - obstacle.at.1[i].c[0]);
    let axes = transpose(obstacle.at.0);
    let [x, y, z] = axes.map(|row| row[0].c[0] * off[0] + row[1].c[0] * off[1] + row[2].c[0] * off[2]);
    let [r, h, _] = obstacle.size;
    let outside = |excess: &[f64]| {
        let most = excess.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let length = excess.iter().map(|e| e.max(0.0).powi(2)).sum::<f64>().sqrt();
        if most > 0.0 { length } else { most }
    };
    match obstacle.kind {
        "sphere" => x.hypot(y).hypot(z) - r,
        "half_space" => z,
        "capsule" => x.hypot(y).hypot((z.abs() - h).max(0.0)) - r,
        "cylinder" => outside(&[x.hypot(y) - r, z.abs() - h]),
        _ => outside(&[x.abs() - obstacle.size[0], y.abs() - obstacle.size[1], z.abs() - obstacle.size[2]]),
    }
}

/// More than the error of distances in `f64` up to the largest length, m, by rounding and by the enclosure of a
/// rotation.
const ROUGH: f64 = 1e-8;
const MAX_COORDINATE: f64 = 1e6;

/// The directions that are listed for pairs of shapes on an interval; obstacles follow the shapes of the robot.
pub(crate) type Directions = BTreeMap<[usize; 2], [f64; 3]>;

/// The shapes of a robot on an interval, and the bodies of which they keep clear.
pub(crate) struct Clearances<'a> {
    pub(crate) robot: &'a Robot,
    pub(crate) obstacles: &'a [Obstacle],
    pub(crate) placed: Vec<Pose>,
    pub(crate) directions: Directions,
    pub(crate) by: Distances<'a>,
}

impl Clearances<'_> {
    /// True if all pairs keep their distances, and the distance `claim` in addition.
    pub(crate) fn keep(&self, claim: f64, pairs: &[Pair]) -> bool {
        pairs
            .iter()
            .all(|pair| if self.robot.has_balls { self.ball_keeps(claim, pair) } else { self.keeps(claim, pair) })
    }

    fn ball_keeps(&self, claim: f64, pair: &Pair) -> bool {
        let radius = |i: usize| self.robot.parts[i].solid.size[0];
        let middle = |i: usize| self.placed[i].1.map(|x| x.c[0]);
        let way = |i: usize| {
            let off = self.placed[i].1.map(|x| x.turn().1.most());
            let is_rough = middle(i).into_iter().all(|x| x.abs() <= MAX_COORDINATE);
            if is_rough { off.iter().map(|x| x * x).sum::<f64>().sqrt() + ROUGH } else { f64::INFINITY }
        };
        let apart = |p: [f64; 3], q: [f64; 3]| (p[0] - q[0]).hypot(p[1] - q[1]).hypot(p[2] - q[2]);
        let i = pair.part;
        let kept = radius(i) + pair.margin + claim;
        // For most pairs the distance in the middle less the ways from there is sufficient.
        let (surface, way) = match pair.other {
            Err(o) => (rough(&self.obstacles[o].solid, middle(i)), way(i)),
            Ok(j) => (apart(middle(i), middle(j)) - radius(j), way(i) + way(j)),
        };
        if surface - way - 2.0 * ROUGH >= kept {
            return true;
        }
        let surface = match pair.other {
            Err(o) => self.by.from(&self.obstacles[o].solid, self.placed[i].1),
            Ok(j) => self.by.length(&sub(self.placed[i].1, self.placed[j].1)) - radius(j),
        };
        surface - radius(i) - pair.margin >= claim
    }

    /// True if balls about two shapes, or a direction, separate them by their distance and the claim.
    fn keeps(&self, claim: f64, pair: &Pair) -> bool {
        let (i, parts) = (pair.part, &self.robot.parts);
        let part = |j: usize| (Solid { at: self.placed[j], ..parts[j].solid }, parts[j].corners.as_slice());
        let (a, b, j) = match pair.other {
            Ok(j) => (part(i), part(j), j),
            Err(o) => (part(i), (self.obstacles[o].solid, &[][..]), parts.len() + o),
        };
        let off = sub(b.0.at.1, a.0.at.1);
        let (middle, way) = (off.map(|x| x.c[0]), off.map(|x| x.turn().1.most()));
        let length = |x: [f64; 3]| x[0].hypot(x[1]).hypot(x[2]);
        let apart = length(middle) * (1.0 - 8.0 * UNIT) - length(way) * (1.0 + 8.0 * UNIT);
        let kept = claim + pair.margin;
        if apart - radius_about(&a.0) - radius_about(&b.0) - 16.0 * UNIT * length(middle) >= kept {
            return true;
        }
        let n = match (b.0.kind, self.directions.get(&[i, j])) {
            ("half_space", _) => transpose(b.0.at.0)[2].map(|x| -x),
            (_, Some(n)) => vector(*n),
            (_, None) => middle.map(Tm::new),
        };
        let kept = kept * dot(n, n).most().sqrt() * (1.0 + 4.0 * UNIT);
        dot(n, n).c[0] > 1e-6 && kept.is_finite() && self.gap(a, b, n) >= kept
    }

    /// A lower bound on the gap between two shapes, with corners if they are pieces, along a direction from one to the
    /// other, in units of the length of the direction.
    fn gap(&self, a: (Solid, &[[f64; 3]]), b: (Solid, &[[f64; 3]]), n: Vector) -> f64 {
        let mut gap = dot(n, sub(b.0.at.1, a.0.at.1));
        // The way along the direction, from the centre of a shape towards the other one, of each of its corners.
        let mut ways = Vec::new();
        for ((solid, corners), towards) in [(a, n.map(|x| -x)), (b, n)] {
            if solid.kind == "piece" {
                let along = apply(transpose(solid.at.0), towards);
                let way = |c: &[f64; 3]| along[0].scaled(c[0]) + along[1].scaled(c[1]) + along[2].scaled(c[2]);
                ways.push(corners.iter().map(way).collect::<Vec<Tm>>());
                gap = gap - Tm::new(RADIUS * dot(n, n).most().sqrt() * (1.0 + 4.0 * UNIT));
            } else {
                gap = gap - extent(&solid, n);
            }
        }
        let Some(last) = ways.pop() else { return self.by.lower(gap) };
        let Some(first) = ways.pop() else { return self.least(last.into_iter().map(|way| gap + way)) };
        // The corner that is nearest in the middle stands for those of a piece, less the way by which others pass it.
        let nearest = first.iter().copied().reduce(|p, q| if q.c[0] < p.c[0] { q } else { p });
        let nearest = nearest.unwrap_or(Tm::new(f64::NAN));
        let passing = self.least(first.into_iter().map(|way| way - nearest));
        self.least(last.into_iter().map(|way| gap + nearest + way)) + passing
    }

    /// A lower bound on the least of several values.
    fn least(&self, values: impl Iterator<Item = Tm>) -> f64 {
        let rough = |x: &Tm| x.c[0] - x.turn().1.most() - 4.0 * UNIT * x.c[0].abs();
        let mut all: Vec<(f64, Tm)> = values.map(|x| (rough(&x), x)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut least = f64::INFINITY;
        for (rough, x) in all {
            if rough >= least {
                break;
            }
            let fine = self.by.lower(x);
            // NaN stays.
            least = if fine >= least { least } else { fine };
        }
        least
    }
}
