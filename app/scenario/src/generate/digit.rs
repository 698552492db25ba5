//! Obstacles for Digit.

use super::paths::Paths;
use super::witness::Witness;
use super::{CLEAR, Candidate, HIT, rounded, sphere};
use crate::ScenarioFile;
use crate::builtin::builtin_scenario;
use crate::keys::json::read_json;
use aghf::error::Result;
use aghf::geometry::Capsule;
use aghf::model::Model;
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The step whose boundary states are used.
const STEP: &str = "digit_free_step";

/// The radius of the capsules that represent the links, m.
const LINK_RADIUS: f64 = 0.03;

/// A box of spheres on the ground where the line of the step drags the right foot.
pub(super) fn step_over_box(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let step: ScenarioFile = read_json(builtin_scenario(STEP).unwrap_or_default(), STEP)?;
    let swinging = model.joints().iter().map(|j| j.name().starts_with("right_"));
    let leg: Vec<bool> = (swinging.zip(model.joints()))
        .map(|(right, j)| right && !j.name().contains("shoulder") && !j.name().contains("elbow"))
        .collect();
    let mut near = |q: &[f64]| -> Vec<f64> {
        let joints = q.iter().zip(&leg).zip(model.joints());
        joints
            .map(|((q, leg), joint)| {
                let by = if *leg { rng.random_range(-0.05..0.05) } else { 0.0 };
                rounded(q + by).clamp(joint.limits().lower, joint.limits().upper)
            })
            .collect()
    };
    let ends = [near(&step.q_start), near(&step.q_goal)];
    let bend: Vec<f64> = (leg.iter()).map(|leg| if *leg { rng.random_range(-1.2..1.2) } else { 0.0 }).collect();
    let witness = Witness { model, ends, bend, horizon: step.horizon_s };
    let paths = Paths::new(witness, LINK_RADIUS)?;

    let capsules = paths.line.capsules();
    let foot = |c: &Capsule| c.body.is_some_and(|b| model.joints()[b].name().contains("right_toe"));
    let Some(foot) = capsules.iter().rposition(foot) else {
        return Ok(None);
    };
    let [_, sole] = paths.line.segment(foot, 0.5);
    let size = rounded(rng.random_range(0.03..0.045));
    let (columns, rows) = (rng.random_range(1..=2), rng.random_range(2..=3));
    let mut spheres = Vec::new();
    let (mut free, mut hit) = (true, false);
    for i in 0..columns {
        for j in 0..rows {
            let along = (f64::from(i) - 0.5 * f64::from(columns - 1)) * size;
            let across = (f64::from(j) - 0.5 * f64::from(rows - 1)) * size;
            let centre = Vector3::new(sole.x + along, sole.y + across, sole.z).map(rounded);
            free = free && paths.free(centre, size, CLEAR)?;
            hit = hit || paths.line.clearance(centre, size)? < -HIT;
            spheres.push(sphere((centre, size)));
        }
    }
    let mut made = Candidate::new(paths.witness, LINK_RADIUS).with_obstacles(spheres);
    made.rates = [step.v_start, step.v_goal];
    Ok((free && hit).then_some(made))
}
