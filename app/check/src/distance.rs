//! Lower bounds on distances.

use crate::arithmetic::{Bernstein, Tm, UNIT, Vector, add, apply};
use crate::robot::Robot;
use crate::scenario::{Obstacle, Pair};

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
    pub(crate) fn from(&self, obstacle: &Obstacle, p: Vector) -> f64 {
        let p = apply(obstacle.inverse, add(p, obstacle.at.map(|x| -x)));
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
fn rough(obstacle: &Obstacle, p: [f64; 3]) -> f64 {
    let off: [f64; 3] = std::array::from_fn(|i| p[i] - obstacle.at[i].c[0]);
    let [x, y, z] = obstacle.inverse.map(|row| row[0].c[0] * off[0] + row[1].c[0] * off[1] + row[2].c[0] * off[2]);
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

/// More than the error of distances in `f64` up to the largest length of a scenario, 1e6 m.
const ROUGH: f64 = 1e-8;

/// True if all pairs keep their distances and `claim` beyond them.
pub(crate) fn keeps(
    claim: f64,
    pairs: &[Pair],
    robot: &Robot,
    obstacles: &[Obstacle],
    centres: &[Vector],
    by: &Distances,
) -> bool {
    let middles: Vec<[f64; 3]> = centres.iter().map(|c| c.map(|x| x.c[0])).collect();
    let way = |c: &Vector| {
        let off = c.map(|x| x.turn().1.most());
        off.iter().map(|x| x * x).sum::<f64>().sqrt() + ROUGH
    };
    let ways: Vec<f64> = centres.iter().map(way).collect();
    let apart = |p: [f64; 3], q: [f64; 3]| (p[0] - q[0]).hypot(p[1] - q[1]).hypot(p[2] - q[2]);
    pairs.iter().all(|pair| {
        let (i, part) = (pair.part, &robot.parts[pair.part]);
        // The distance in the middle less the ways from there is enough for most.
        let (surface, way) = match pair.other {
            Err(o) => (rough(&obstacles[o], middles[i]), ways[i]),
            Ok(j) => (apart(middles[i], middles[j]) - robot.parts[j].radius, ways[i] + ways[j]),
        };
        if surface - part.radius - pair.margin - way - ROUGH >= claim {
            return true;
        }
        let surface = match pair.other {
            Err(o) => by.from(&obstacles[o], centres[i]),
            Ok(j) => by.length(&add(centres[i], centres[j].map(|x| -x))) - robot.parts[j].radius,
        };
        surface - part.radius - pair.margin >= claim
    })
}
