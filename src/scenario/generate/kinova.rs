//! Obstacles for the Kinova arm.

use super::paths::Paths;
use super::{CLEAR, Candidate, HIT, KINOVA};
use crate::error::Result;
use crate::model::Model;
use crate::scenario::HalfSpaceObstacle;
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Numbers in a file are rounded to this many parts of a metre or radian.
const ROUND: f64 = 1000.0;

pub(super) fn rounded(x: f64) -> f64 {
    (x * ROUND).round() / ROUND
}

/// A random motion at rest at both ends within the limits, and a random bend.
fn motion(model: &Model, rng: &mut ChaCha8Rng) -> Result<Paths> {
    let (mut start, mut goal, mut bend) = (Vec::new(), Vec::new(), Vec::new());
    for joint in model.joints() {
        // Joints that turn more than once are taken to start within half a turn.
        let reach = 0.85 * joint.limits().upper.min(std::f64::consts::PI);
        let from = rng.random_range(-reach..reach);
        let far = 0.9 * joint.limits().upper;
        let to = (from + rng.random_range(-1.6..1.6)).clamp(-far, far);
        start.push(rounded(from));
        goal.push(rounded(to));
        bend.push(rng.random_range(-0.9..0.9));
    }
    Paths::new(model, [start, goal], &bend, KINOVA.link_radius)
}

fn direction(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        if v.norm() > 0.1 {
            return v.normalize();
        }
    }
}

fn round_vector(v: Vector3<f64>) -> Vector3<f64> {
    v.map(rounded)
}

/// Five spheres, at least two of which the line hits.
pub(super) fn cross(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let paths = motion(model, rng)?;
    let (mut spheres, mut hits) = (Vec::new(), 0);
    for _ in 0..60 {
        let (centre, radius) = near_line(&paths, rng);
        let hit = paths.line.clearance(centre, radius)? < -HIT;
        let wanted = if hit {
            hits < 3
        } else {
            spheres.len() - hits < 3
        };
        if wanted && paths.free(centre, radius)? {
            spheres.push((centre, radius));
            hits += usize::from(hit);
        }
        if spheres.len() == 5 && hits >= 2 {
            return Ok(Some(Candidate {
                paths,
                spheres,
                half_spaces: Vec::new(),
            }));
        }
    }
    Ok(None)
}

/// A sphere somewhere about a link on its way along the line.
fn near_line(paths: &Paths, rng: &mut ChaCha8Rng) -> (Vector3<f64>, f64) {
    let capsule = rng.random_range(2..paths.line.capsules().len());
    let [from, to] = paths.line.segment(capsule, rng.random_range(0.25..0.75));
    let on_link = from + (to - from) * rng.random_range(0.0..1.0);
    let off = direction(rng) * rng.random_range(0.0..0.15);
    (
        round_vector(on_link + off),
        rounded(rng.random_range(0.06..0.12)),
    )
}

/// Two spheres on either side of a link of the bent path, so that it has little room, and the line hits one of them.
pub(super) fn gap(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let paths = motion(model, rng)?;
    let capsules = paths.bent.capsules().len();
    for _ in 0..40 {
        let capsule = rng.random_range(capsules / 2..capsules);
        let t = rng.random_range(0.4..0.6);
        let [from, to] = paths.bent.segment(capsule, t);
        let middle = from + (to - from) * rng.random_range(0.0..1.0);
        let across = direction(rng);
        let radius = rounded(rng.random_range(0.08..0.12));
        let apart = radius + KINOVA.link_radius + CLEAR + rng.random_range(0.0..0.015);
        let spheres = [1.0, -1.0].map(|s| (round_vector(middle + across * (s * apart)), radius));
        let (mut free, mut hit) = (true, false);
        for (centre, radius) in spheres {
            free = free && paths.free(centre, radius)?;
            hit = hit || paths.line.clearance(centre, radius)? < -HIT;
        }
        if free && hit {
            return Ok(Some(Candidate {
                paths,
                spheres: spheres.to_vec(),
                half_spaces: Vec::new(),
            }));
        }
    }
    Ok(None)
}

/// A floor below the bent path that the line dips into.
pub(super) fn floor(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let paths = motion(model, rng)?;
    let height = ((paths.bent.lowest()? - CLEAR) * ROUND).floor() / ROUND;
    // Not above the base, nor so low that it is no floor of this arm.
    let sensible = (-0.5..=0.05).contains(&height);
    if !sensible || paths.line.lowest()? > height - 2.0 * HIT {
        return Ok(None);
    }
    Ok(Some(Candidate {
        paths,
        spheres: Vec::new(),
        half_spaces: vec![HalfSpaceObstacle {
            normal: [0.0, 0.0, 1.0],
            offset_m: height,
        }],
    }))
}
