//! Obstacles for Digit.

use super::kinova::rounded;
use super::paths::Paths;
use super::{Candidate, DIGIT_LINK_RADIUS, HIT};
use crate::constraint::Capsule;
use crate::error::Result;
use crate::model::Model;
use crate::scenario::ScenarioFile;
use crate::scenario::builtin::builtin_scenario;
use crate::scenario::json::read_json;
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The step whose boundary states are taken.
const STEP: &str = "digit_free_step";

/// A box of spheres on the ground where the line of the step drags the right foot.
pub(super) fn step_over_box(model: &Model, rng: &mut ChaCha8Rng) -> Result<Option<Candidate>> {
    let step: ScenarioFile = read_json(builtin_scenario(STEP).unwrap_or_default(), STEP)?;
    let swinging = model
        .joints()
        .iter()
        .map(|j| j.name().starts_with("right_"));
    let leg: Vec<bool> = (swinging.zip(model.joints()))
        .map(|(right, j)| right && !j.name().contains("shoulder") && !j.name().contains("elbow"))
        .collect();
    let mut near = |q: &[f64]| -> Vec<f64> {
        let joints = q.iter().zip(&leg).zip(model.joints());
        joints
            .map(|((q, leg), joint)| {
                let by = if *leg {
                    rng.random_range(-0.05..0.05)
                } else {
                    0.0
                };
                rounded(q + by).clamp(joint.limits().lower, joint.limits().upper)
            })
            .collect()
    };
    let ends = [near(&step.q_start), near(&step.q_goal)];
    let bend: Vec<f64> = (leg.iter())
        .map(|leg| {
            if *leg {
                rng.random_range(-1.2..1.2)
            } else {
                0.0
            }
        })
        .collect();
    let mut paths = Paths::new(model, ends, &bend, DIGIT_LINK_RADIUS)?;
    paths.rates = [step.v_start, step.v_goal];

    let capsules = paths.line.capsules();
    let foot = |c: &Capsule| {
        c.body
            .is_some_and(|b| model.joints()[b].name().contains("right_toe"))
    };
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
            free = free && paths.free(centre, size)?;
            hit = hit || paths.line.clearance(centre, size)? < -HIT;
            spheres.push((centre, size));
        }
    }
    Ok((free && hit).then_some(Candidate {
        paths,
        spheres,
        half_spaces: Vec::new(),
    }))
}
