//! Motions that are difficult for the limits of any robot.

use super::paths::Paths;
use super::witness::{HORIZON_RATIO, Witness, least_horizon};
use super::{CLEAR, Candidate, HIT, direction, round_up, round_vector, rounded, sphere};
use crate::RobotShape;
use aghf::dynamics::path_to_base;
use aghf::error::Result;
use aghf::geometry::Capsule;
use aghf::model::{Joint, Model};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use std::ops::Range;

/// The shortest duration, s. Shorter ones need too much torque for robots with high velocity limits.
const MIN_HORIZON: f64 = 0.5;
/// The central part of the range of a joint from which its ends are drawn.
const RANGE: f64 = 0.9;
/// The largest shares of the torque limits that the known motion uses, without and with an obstacle.
const TORQUE_SHARES: [f64; 2] = [0.9, 0.95];
/// The largest distance of the path around an obstacle from the line, rad or m.
const BEND: f64 = 0.9;
/// The radius of the links of a robot with a reach of 1 m or more, m; links, obstacles and margins of smaller robots
/// are scaled by their reach.
const LINK_RADIUS: f64 = 0.05;
/// The radii of the obstacles, m.
const RADII: Range<f64> = 0.04..0.12;
/// The largest distance of the obstacle centres from the links, m.
const OFF: f64 = 0.1;
/// The reach below which a robot gets no obstacles, m.
const MIN_REACH: f64 = 0.05;
/// The number of bent paths tried for a pair.
const BENDS: usize = 8;
/// The number of places tried for the obstacle of one path.
const PLACES: usize = 20;

/// The range from which the ends of a joint are drawn: most of the joint's range, and at most one turn.
fn range(joint: &Joint<f64>) -> [f64; 2] {
    let limits = joint.limits();
    let (lower, upper) = match (limits.lower.max(-PI), limits.upper.min(PI)) {
        (lower, upper) if lower < upper => (lower, upper),
        // A range that lies beyond half a turn on one side.
        (lower, _) if lower == limits.lower => (lower, limits.upper.min(lower + 2.0 * PI)),
        (_, upper) => (limits.lower.max(upper - 2.0 * PI), upper),
    };
    let (middle, half) = (0.5 * (lower + upper), 0.5 * RANGE * (upper - lower));
    [middle - half, middle + half]
}

/// Random ends within the limits, and the duration of the motion between them.
fn pair(model: &Model, rng: &mut ChaCha8Rng) -> ([Vec<f64>; 2], f64) {
    let mut configuration = || -> Vec<f64> {
        let draw = |joint: &Joint<f64>| {
            let [lower, upper] = range(joint);
            rounded(lower + (upper - lower) * rng.random_range(0.0..1.0))
        };
        model.joints().iter().map(draw).collect()
    };
    let ends = [configuration(), configuration()];
    let least = least_horizon(model, &ends);
    (ends, round_up(HORIZON_RATIO * least).max(MIN_HORIZON))
}

/// A random pair, rest to rest, for which a polynomial on the straight line satisfies all limits.
pub(super) fn without_obstacle(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let (ends, horizon) = pair(model, rng);
    let witness = Witness { model, ends, bend: vec![0.0; model.dof()], horizon };
    let good = witness.keeps_limits(TORQUE_SHARES[0])?;
    Ok(good.then(|| Candidate { shape: RobotShape::JointFrames, ..Candidate::new(witness, 0.0) }))
}

/// The length of the longest chain of links, m.
fn reach(model: &Model) -> f64 {
    let mut reaches: Vec<f64> = Vec::new();
    for joint in model.joints() {
        let before = joint.parent().map_or(0.0, |p| reaches[p]);
        // The part before the first joint is not a link that moves.
        let link = joint.parent().map_or(0.0, |_| joint.origin().translation.norm());
        reaches.push(before + link);
    }
    let frames = model.frames().iter();
    let tips = frames.filter_map(|f| Some(reaches[f.body?] + f.placement.translation.norm()));
    tips.chain(reaches.iter().copied()).fold(0.0, f64::max)
}

/// A random pair and a sphere that the links hit on the straight line, while a polynomial next to it is clear and
/// within all limits.
pub(super) fn with_obstacle(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let scale = reach(model).min(1.0);
    if scale < MIN_REACH {
        return Ok(None);
    }
    let (ends, horizon) = pair(model, rng);
    let straight = Witness::bent(model, ends, vec![0.0; model.dof()], horizon);
    if !straight.keeps_limits(TORQUE_SHARES[1])? {
        return Ok(None);
    }
    let radius = rounded(LINK_RADIUS * scale);
    for _ in 0..BENDS {
        let capsules = Capsule::along_links(model, radius);
        let capsule = moving_capsule(capsules.len(), rng);
        // Only joints that move this link are bent.
        let mut wish = vec![0.0; model.dof()];
        let moving = capsules[capsule].body.into_iter();
        for joint in moving.flat_map(|body| path_to_base(model, body)) {
            wish[joint] = rng.random_range(-BEND..BEND);
        }
        let witness = Witness::bent(model, straight.ends.clone(), wish, horizon);
        if !witness.keeps_limits(TORQUE_SHARES[1])? {
            continue;
        }
        let paths = Paths::new(witness, radius)?;
        for _ in 0..PLACES {
            let radii = RADII.start * scale..RADII.end * scale;
            let (centre, size) = near_line(&paths, capsule, OFF * scale, radii, rng);
            if paths.line.clearance(centre, size)? < -HIT * scale && paths.free(centre, size, CLEAR * scale)? {
                let made = Candidate::new(paths.witness, radius);
                return Ok(Some(made.with_obstacles(vec![sphere((centre, size))])));
            }
        }
    }
    Ok(None)
}

/// A random capsule, except the first ones, which hardly move.
pub(super) fn moving_capsule(capsules: usize, rng: &mut ChaCha8Rng) -> usize {
    rng.random_range(2.min(capsules - 1)..capsules)
}

/// A sphere whose centre is at most `off` from a link while it moves along the line.
pub(super) fn near_line(
    paths: &Paths,
    capsule: usize,
    off: f64,
    radii: Range<f64>,
    rng: &mut ChaCha8Rng,
) -> (Vector3<f64>, f64) {
    let [from, to] = paths.line.segment(capsule, rng.random_range(0.25..0.75));
    let on_link = from + (to - from) * rng.random_range(0.0..1.0);
    let off = direction(rng) * rng.random_range(0.0..off);
    (round_vector(on_link + off), rounded(rng.random_range(radii)))
}
