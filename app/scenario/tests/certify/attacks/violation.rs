//! Promises that a motion breaks, by a dense evaluation in `f64`.

use aghf::curve::Curve;
use aghf::dynamics::forward_kinematics;
use aghf::motion::{Sample, samples_at};
use aghf::spatial::Placement;
use aghf_scenario::{Continuous, CurveFile, Goal, Quantity, Scenario};
use nalgebra::Vector3;
use serde_json::Value;

/// The number of intervals of a motion, and the step of differences, s.
const INTERVALS: usize = 60;
const STEP: f64 = 1e-5;

/// More than the errors of this evaluation, relative to the size of a quantity or to one.
const ERROR: f64 = 1e-4;

/// The first promise that is found broken, in words.
pub fn violation(scenario: &Scenario, curve: &Value) -> Option<String> {
    let file: CurveFile = serde_json::from_value(curve.clone()).ok()?;
    let curve = match file.curve(&scenario.model, "attack") {
        Ok(curve) => curve,
        Err(error) => return Some(error.to_string()),
    };
    let horizon = curve.horizon();
    let [shortest, longest] = scenario.file.horizon_bounds();
    if !(shortest..=longest).contains(&horizon) {
        return Some(format!("the horizon is {horizon}"));
    }
    let times = |t: f64| (curve.segment_at(t), t);
    let all = (0..=INTERVALS).map(|k| times(horizon * k as f64 / INTERVALS as f64));
    let samples: Vec<Sample> = samples_at(&scenario.model, &curve, all).collect::<Result<_, _>>().ok()?;
    ends(scenario, &samples)
        .or_else(|| waypoints(scenario, &curve))
        .or_else(|| samples.iter().find_map(|sample| at_sample(scenario, sample)))
        .or_else(|| {
            (1..INTERVALS).find_map(|k| by_differences(scenario, &curve, horizon * k as f64 / INTERVALS as f64))
        })
}

/// True if a value is beyond another one by more than errors.
fn is_beyond(x: f64, most: f64) -> bool {
    // A value that is no number is beyond.
    let is_within = x <= most + ERROR * most.abs().max(1.0);
    !is_within
}

fn is_off(all: &[f64], wanted: &[f64]) -> bool {
    let mut pairs = all.iter().zip(wanted);
    all.len() != wanted.len() || !pairs.all(|(x, y)| (x - y).abs() <= 1e-6)
}

fn ends(scenario: &Scenario, samples: &[Sample]) -> Option<String> {
    let file = &scenario.file;
    let (first, last) = (samples.first()?, samples.last()?);
    let zeros = vec![0.0; first.q.len()];
    let smooth = file.continuity() == Continuous::Acceleration;
    let free = file.free_final_velocity;
    let pushed = |a: &[f64]| a.iter().any(|a| is_beyond(a.abs(), 0.0));
    let off_goal = |goal: &Goal| violation_of_poses(scenario, goal, &last.q).is_some();
    let found = [
        ("the start is off", is_off(&first.q, &file.q_start) || is_off(&first.v, &file.v_start)),
        ("the goal is off", file.goal.is_empty() && is_off(&last.q, &file.q_goal)),
        ("no goal is met", !file.goal.is_empty() && file.goal.iter().all(off_goal)),
        ("the goal velocity is off", !free && is_off(&last.v, &file.v_goal)),
        ("the start is not at rest", smooth && file.v_start == zeros && pushed(&first.a)),
        ("the goal is not at rest", smooth && !free && file.v_goal == zeros && pushed(&last.a)),
    ];
    found.into_iter().find(|(_, is_it)| *is_it).map(|(what, _)| what.to_owned())
}

fn waypoints(scenario: &Scenario, curve: &Curve) -> Option<String> {
    let states = (0..=20 * INTERVALS).map(|k| curve.at(curve.horizon() * k as f64 / (20 * INTERVALS) as f64).0);
    let states: Vec<_> = states.collect();
    scenario.file.waypoints.iter().enumerate().find_map(|(i, point)| {
        let aims = point.q.as_ref()?;
        let off =
            |x: &nalgebra::DVector<f64>| aims.iter().zip(x.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let least = states.iter().map(off).fold(f64::INFINITY, f64::min);
        // Between samples a joint moves by less than this.
        (least > 0.01).then(|| format!("waypoint {i} is missed by {least}"))
    })
}

/// The promises at a sample: limits, clearances, poses, the foot.
fn at_sample(scenario: &Scenario, sample: &Sample) -> Option<String> {
    let model = &scenario.model;
    let powers = sample.u.iter().zip(&sample.v).map(|(u, v)| u * v).collect();
    let kinds: [(Quantity, &Vec<f64>); 5] = [
        (Quantity::Position, &sample.q),
        (Quantity::Velocity, &sample.v),
        (Quantity::Acceleration, &sample.a),
        (Quantity::Torque, &sample.u),
        (Quantity::Power, &powers),
    ];
    for (limit, values) in kinds {
        for (joint, x) in values.iter().enumerate() {
            if let Some([lower, upper]) = scenario.bound(limit, joint)
                && (is_beyond(*x, upper) || is_beyond(-x, -lower))
            {
                return Some(format!("{} of joint {joint} is {x} at {}", limit.name(), sample.t));
            }
        }
    }
    if is_off(&sample.qdot, &sample.v) {
        return Some(format!("velocities slip at {}", sample.t));
    }
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, &sample.q, &mut placements).ok()?;
    let closest = scenario.scene.deepest_contact(&placements).ok()?;
    if let Some(pair) = closest.filter(|pair| pair.distance < -ERROR) {
        return Some(format!("a clearance is short by {} at {}", -pair.distance, sample.t));
    }
    let contact = scenario.contact([&sample.q, &sample.v, &sample.a]).ok()?;
    if contact.is_some_and(|contact| is_beyond(contact.excess, 0.0)) {
        return Some(format!("the foot does not hold at {}", sample.t));
    }
    let kept = scenario.file.keep.iter().filter(|kept| is_within(kept.times(), sample.t));
    kept.filter_map(|kept| kept.poses.as_ref()).find_map(|poses| violation_of_poses(scenario, poses, &sample.q))
}

fn is_within([from, to]: [f64; 2], t: f64) -> bool {
    from + STEP < t && t < to - STEP
}

/// The placement of a link.
fn link(scenario: &Scenario, name: &str, q: &[f64]) -> Option<Placement<f64>> {
    let model = &scenario.model;
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements).ok()?;
    let frame = model.frames().iter().find(|frame| frame.name == name)?;
    Some(frame.body.map_or_else(|| frame.placement, |body| placements[body].compose(&frame.placement)))
}

/// The position of a set of poses in the base frame, and its orientation, if they are off.
fn violation_of_poses(scenario: &Scenario, poses: &Goal, q: &[f64]) -> Option<String> {
    let at = link(scenario, &poses.frame, q)?;
    if let (Some(position), None) = (poses.position_m, &poses.relative_to) {
        let off = (at.translation - Vector3::from(position)).norm();
        if is_beyond(off, poses.tolerance_m.unwrap_or(0.0)) {
            return Some(format!("'{}' is {off} m off", poses.frame));
        }
    }
    None
}

/// The promises on derivatives: speeds of points and jerks.
fn by_differences(scenario: &Scenario, curve: &Curve, t: f64) -> Option<String> {
    let (segment, n) = (curve.segment_at(t), scenario.model.dof());
    let inside = [t - STEP, t + STEP].iter().all(|t| curve.segment_at(*t) == segment);
    let states = [t - STEP, t + STEP].map(|t| curve.at(t));
    for joint in 0..n {
        let [before, after] = states.each_ref().map(|(_, rates)| rates[n + joint]);
        let jerk = (after - before) / (2.0 * STEP);
        if let Some([lower, upper]) = scenario.bound(Quantity::Jerk, joint)
            && inside
            && (is_beyond(jerk, upper) || is_beyond(-jerk, -lower))
        {
            return Some(format!("the jerk of joint {joint} is {jerk} at {t}"));
        }
    }
    for kept in &scenario.file.keep {
        let Some(speed) = kept.speed.as_ref().filter(|_| is_within(kept.times(), t)) else {
            continue;
        };
        let place = |x: &nalgebra::DVector<f64>| {
            let at = link(scenario, &speed.frame, &x.as_slice()[..n])?;
            Some(at.rotation * Vector3::from(speed.point_m) + at.translation)
        };
        let found = (place(&states[1].0)? - place(&states[0].0)?).norm() / (2.0 * STEP);
        if is_beyond(found, speed.most_m_s) {
            return Some(format!("the speed of '{}' is {found} at {t}", speed.frame));
        }
    }
    None
}
