//! Obstacles for the Kinova arm.

use super::limits::{moving_capsule, near_line};
use super::paths::Paths;
use super::witness::{HORIZON_RATIO, Witness, least_horizon};
use super::{CLEAR, Candidate, HIT, direction, obstacle, round_down, round_up, round_vector, rounded, sphere};
use crate::ObstacleShape;
use aghf::error::Result;
use aghf::model::Model;
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The radius of the capsules that represent the links, m.
const LINK_RADIUS: f64 = 0.05;
/// The shortest duration, that of the paper's scenarios, s.
const MIN_HORIZON: f64 = 2.0;
/// The largest share of the torque limits that the bent path uses.
const TORQUE_SHARE: f64 = 0.9;

/// A random motion at rest at both ends, within the limits on the line and on the bent path next to it.
fn motion<'a>(model: &'a Model, rng: &mut ChaCha8Rng) -> Result<Option<Paths<'a>>> {
    let (mut start, mut goal, mut wish) = (Vec::new(), Vec::new(), Vec::new());
    for joint in model.joints() {
        // Joints that turn more than once are taken to start within half a turn.
        let reach = 0.85 * joint.limits().upper.min(std::f64::consts::PI);
        let from = rng.random_range(-reach..reach);
        let far = 0.9 * joint.limits().upper;
        let to = (from + rng.random_range(-1.6..1.6)).clamp(-far, far);
        start.push(rounded(from));
        goal.push(rounded(to));
        wish.push(rng.random_range(-0.9..0.9));
    }
    let ends = [start, goal];
    let horizon = round_up(HORIZON_RATIO * least_horizon(model, &ends)).max(MIN_HORIZON);
    let witness = Witness::bent(model, ends, wish, horizon);
    if !witness.keeps_limits(TORQUE_SHARE)? {
        return Ok(None);
    }
    Paths::new(witness, LINK_RADIUS).map(Some)
}

/// Five spheres, at least two of which intersect the line.
pub(super) fn cross(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let Some(paths) = motion(model, rng)? else {
        return Ok(None);
    };
    let (mut spheres, mut hits) = (Vec::new(), 0);
    for _ in 0..60 {
        let capsule = moving_capsule(paths.line.capsules().len(), rng);
        let (centre, radius) = near_line(&paths, capsule, 0.15, 0.06..0.12, rng);
        let hit = paths.line.clearance(centre, radius)? < -HIT;
        let wanted = if hit { hits < 3 } else { spheres.len() - hits < 3 };
        if wanted && paths.free(centre, radius, CLEAR)? {
            spheres.push(sphere((centre, radius)));
            hits += usize::from(hit);
        }
        if spheres.len() == 5 && hits >= 2 {
            return Ok(Some(Candidate::new(paths.witness, LINK_RADIUS).with_obstacles(spheres)));
        }
    }
    Ok(None)
}

/// Two spheres on either side of a link of the bent path, so that the gap is narrow; the line hits one of them.
pub(super) fn gap(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let Some(paths) = motion(model, rng)? else {
        return Ok(None);
    };
    let capsules = paths.bent.capsules().len();
    for _ in 0..40 {
        let capsule = rng.random_range(capsules / 2..capsules);
        let t = rng.random_range(0.4..0.6);
        let [from, to] = paths.bent.segment(capsule, t);
        let middle = from + (to - from) * rng.random_range(0.0..1.0);
        let across = direction(rng);
        let radius = rounded(rng.random_range(0.08..0.12));
        let apart = radius + LINK_RADIUS + CLEAR + rng.random_range(0.0..0.015);
        let spheres = [1.0, -1.0].map(|s| (round_vector(middle + across * (s * apart)), radius));
        let (mut free, mut hit) = (true, false);
        for (centre, radius) in spheres {
            free = free && paths.free(centre, radius, CLEAR)?;
            hit = hit || paths.line.clearance(centre, radius)? < -HIT;
        }
        if free && hit {
            return Ok(Some(Candidate::new(paths.witness, LINK_RADIUS).with_obstacles(spheres.map(sphere).to_vec())));
        }
    }
    Ok(None)
}

/// A floor below the bent path that the line dips into.
pub(super) fn floor(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let Some(paths) = motion(model, rng)? else {
        return Ok(None);
    };
    let height = round_down(paths.bent.lowest()? - CLEAR);
    // Not above the base, nor too low for a floor of this arm.
    let sensible = (-0.5..=0.05).contains(&height);
    if !sensible || paths.line.lowest()? > height - 2.0 * HIT {
        return Ok(None);
    }
    let made = Candidate::new(paths.witness, LINK_RADIUS);
    let floor = obstacle(ObstacleShape::HalfSpace {}, Vector3::z() * height);
    Ok(Some(made.with_obstacles(vec![floor])))
}
