//! The promises of a scenario.

use crate::Checked;
use crate::json::{entries, is_true, list, number, number_or, option, require, text};
use crate::robot::{Robot, pose_of};
use crate::shape::{Solid, solid_of};
use serde_json::Value;
use std::collections::BTreeSet;

/// The kinds of limits of joints, in the order of their promises.
pub(crate) const KINDS: [&str; 6] = ["position", "velocity", "acceleration", "jerk", "torque", "power"];

/// A limit of a joint: the name of the promise, the joint, the bounds, and the time from which on it is kept, s.
pub(crate) struct Limit(pub(crate) &'static str, pub(crate) usize, pub(crate) [f64; 2], pub(crate) f64);

/// The least distance from a limit at which a joint starts outside of it, rad or m.
const OUTSIDE: f64 = 1e-9;

/// The distance that such a joint may go further out.
const FURTHER: f64 = 5e-5;

/// The limits that a scenario enforces.
pub(crate) fn limits(scenario: &Value, robot: &Robot) -> Checked<Vec<Limit>> {
    let enforced = &scenario["enforced_limits"];
    let passive: Vec<&str> = entries(scenario, "passive").iter().map(text).collect();
    let is_joint = |name: &str| robot.joints.iter().any(|joint| joint.name == name);
    require(passive.iter().all(|name| is_joint(name)), "a passive joint is unknown")?;
    for (key, part) in enforced.as_object().into_iter().flatten() {
        let mut joints = entries(part, "joints").iter().map(text);
        require(joints.all(is_joint), format!("{key}: a joint is unknown"))?;
        let count = part.as_array().map_or(robot.joints.len(), Vec::len);
        require(count == robot.joints.len(), format!("{key}: {count} limits are given"))?;
    }
    let share = |key: &str, joint: &str| match option(enforced, key) {
        None | Some(Value::Bool(true)) => Some(1.0),
        Some(Value::Bool(false)) => None,
        Some(part @ Value::Object(_)) => {
            let is_named = option(part, "joints").is_none() || entries(part, "joints").iter().any(|n| n == joint);
            is_named.then_some(number_or(part, "share", 1.0))
        }
        Some(share) => Some(number(share)),
    };
    let most = |key: &str, i: usize| match option(enforced, key) {
        Some(Value::Array(each)) => each.get(i).filter(|x| !x.is_null()).map(number),
        same => same.map(number),
    };
    let mut all = Vec::new();
    for promise in KINDS {
        for (i, joint) in robot.joints.iter().enumerate() {
            let [lower, upper, velocity, effort] = joint.limits;
            let given = match promise {
                "velocity" => most("max_velocity", i),
                "acceleration" | "jerk" | "power" => most(promise, i),
                _ => None,
            };
            let share = share(promise, &joint.name);
            let mut bounds = match (promise, share) {
                ("position", Some(share)) => {
                    let cut = 0.5 * (1.0 - share) * (upper - lower);
                    if cut.is_finite() { [lower + cut, upper - cut] } else { [lower, upper] }
                }
                ("velocity", Some(share)) => [-share * velocity, share * velocity],
                ("torque", Some(share)) if !passive.contains(&joint.name.as_str()) => [-share * effort, share * effort],
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            };
            if let Some(most) = given {
                bounds = [bounds[0].max(-most), bounds[1].min(most)];
            }
            let mut from = f64::NEG_INFINITY;
            let start = list(&scenario["q_start"]).get(i).copied().unwrap_or(f64::NAN);
            let off = (bounds[0] - start).max(start - bounds[1]);
            if let (Some(accepted), "position") = (option(scenario, "start_tolerance"), promise)
                && off > OUTSIDE
                && off <= number_or(accepted, "position", 1e-4)
            {
                all.push(Limit(promise, i, [bounds[0].min(start - FURTHER), bounds[1].max(start + FURTHER)], from));
                from = number_or(accepted, "back_s", 0.25);
            }
            if bounds.iter().any(|b| b.is_finite()) {
                all.push(Limit(promise, i, bounds, from));
            }
        }
    }
    Ok(all)
}

/// What becomes of a key of a scenario: `proved`, `assumed` of the robot, `left out`, or `no promise`.
fn outcome(key: &str, scenario: &Value, robot: &Robot) -> &'static str {
    let some = |key: &str| !entries(scenario, key).is_empty();
    let apart = robot.has_links && scenario["self_collision"] != "off";
    let clear = |is_asked: bool| match (is_asked, robot.is_known) {
        (false, _) => "no promise",
        (true, false) => "left out",
        (true, true) => "proved",
    };
    let unless = |is_free: bool| if is_free { "no promise" } else { "proved" };
    match key {
        "q_start" | "v_start" | "a_start" | "start_tolerance" | "a_goal" | "goal" | "keep" | "waypoints" | "stand"
        | "continuity" | "free_horizon" | "enforced_limits" => "proved",
        "q_goal" => unless(some("goal")),
        "v_goal" => unless(is_true(scenario, "free_final_velocity")),
        "horizon_s" => unless(some("free_horizon") || weighs_time(scenario)),
        "obstacles" => clear(some("obstacles")),
        "self_collision" => clear(apart),
        "clearance_m" => clear(some("obstacles") || apart),
        "passive" if some("passive") => "left out",
        "robot" | "root" | "mount" | "gravity" | "mimic" | "locked_joints" | "losses" | "payload" | "robot_shape" => {
            "assumed"
        }
        _ => "no promise",
    }
}

/// The keys of a scenario and those that promise something by default, each with its outcome. The certificate lists
/// the same, and may leave out more. Returns the keys that it leaves out.
pub(crate) fn left_out(scenario: &Value, robot: &Robot, listed: &Value) -> Checked<Vec<String>> {
    let by_default = ["continuity", "enforced_limits", "self_collision"].map(str::to_owned);
    let given = scenario.as_object().into_iter().flatten().map(|(key, _)| key.clone());
    let listed = listed.as_object().ok_or("the keys are missing")?;
    let known: BTreeSet<String> = given.chain(by_default).collect();
    let is_left_out = |outcome: &str| outcome.starts_with("left out: ");
    for key in &known {
        let (own, found) = (outcome(key, scenario, robot), listed.get(key).map_or("", text));
        require(found == own || is_left_out(found), format!("'{key}' is listed as '{found}', and is {own}"))?;
        require(own != "left out" || is_left_out(found), format!("'{key}' is left out, and not listed"))?;
    }
    let (left_out, kept): (Vec<_>, Vec<_>) = listed.iter().partition(|(_, outcome)| is_left_out(text(outcome)));
    let are_known = kept.into_iter().all(|(key, _)| known.contains(key));
    require(are_known, "a key is listed that the scenario does not have")?;
    Ok(left_out.into_iter().map(|(key, _)| key.clone()).collect())
}

/// An obstacle, and the distance that is kept.
pub(crate) struct Obstacle {
    pub(crate) solid: Solid,
    pub(crate) margin: f64,
}

pub(crate) fn obstacles(scenario: &Value) -> Checked<Vec<Obstacle>> {
    let beside = clearance(scenario, "obstacles");
    let mut all = Vec::new();
    for obstacle in entries(scenario, "obstacles") {
        let (at, (kind, size)) = (pose_of(&obstacle["pose"])?, solid_of(&obstacle["shape"])?);
        let margin = number_or(obstacle, "clearance_m", beside);
        all.push(Obstacle { solid: Solid { at, kind, size }, margin });
    }
    Ok(all)
}

/// The distance that is kept from obstacles, or between links, unless they have one of their own.
fn clearance(scenario: &Value, of: &str) -> f64 {
    let given = &scenario["clearance_m"];
    if given.is_object() { number_or(given, of, 0.0) } else { number_or(scenario, "clearance_m", 0.0) }
}

/// Two shapes of the robot, or one and an obstacle, and the distance that is kept.
pub(crate) struct Pair {
    pub(crate) part: usize,
    pub(crate) other: Result<usize, usize>,
    pub(crate) margin: f64,
}

/// Pairs of names of links in a list, which are links of the robot, different, and each pair there once.
fn pairs_of<'a>(list: impl Iterator<Item = &'a Value>, robot: &Robot) -> Checked<Vec<BTreeSet<&'a str>>> {
    let mut all = Vec::new();
    for pair in list {
        let pair: BTreeSet<&str> = pair.as_array().into_iter().flatten().map(text).collect();
        let known = pair.len() == 2 && pair.iter().all(|link| robot.links.contains_key(*link));
        require(known && !all.contains(&pair), format!("{pair:?} is no pair of links, or is there twice"))?;
        all.push(pair);
    }
    Ok(all)
}

/// The pairs of a shape on a moving body and an obstacle, and those of shapes of links that keep clear of each other:
/// all on different bodies but those that the scenario names, by default those with one moving joint between them.
pub(crate) fn pairs(scenario: &Value, robot: &Robot, obstacles: &[Obstacle]) -> Checked<[Vec<Pair>; 2]> {
    let (mut beside, mut links) = (Vec::new(), Vec::new());
    let (itself, own) = (clearance(scenario, "itself"), entries(&scenario["clearance_m"], "pairs"));
    let own_pairs = pairs_of(own.iter().map(|pair| &pair["links"]), robot)?;
    let kept = &scenario["self_collision"];
    let ignored = option(kept, "ignored_pairs").map(|_| pairs_of(entries(kept, "ignored_pairs").iter(), robot));
    let ignored = ignored.transpose()?;
    let off = !robot.has_links || kept == "off";
    require(robot.has_links || ignored.is_none(), "links are told apart with the shape 'collision' only")?;
    if !robot.is_known {
        return Ok([Vec::new(), Vec::new()]);
    }
    let follows = |a: Option<usize>, b: Option<usize>| b.is_some_and(|b| robot.joints[b].parent == a);
    for (i, part) in robot.parts.iter().enumerate() {
        if part.body.is_some() {
            let all = obstacles.iter().enumerate();
            beside.extend(all.map(|(o, obstacle)| Pair { part: i, other: Err(o), margin: obstacle.margin }));
        }
        for (j, other) in robot.parts.iter().enumerate().skip(i + 1) {
            let names = BTreeSet::from([part.link.as_str(), other.link.as_str()]);
            let are_neighbours = follows(part.body, other.body) || follows(other.body, part.body);
            let may_overlap = ignored.as_ref().map_or(are_neighbours, |ignored| ignored.contains(&names));
            if !off && names.len() == 2 && part.body != other.body && !may_overlap {
                let own = own_pairs.iter().zip(own).find(|(pair, _)| **pair == names);
                let margin = own.map_or(itself, |(_, own)| number(&own["clearance_m"]));
                links.push(Pair { part: i, other: Ok(j), margin });
            }
        }
    }
    Ok([beside, links])
}

/// True if the objective has a cost of time, so that the horizon is free.
pub(crate) fn weighs_time(scenario: &Value) -> bool {
    match &scenario["objective"] {
        Value::String(preset) => preset != "least-effort",
        weights => number_or(weights, "time", 0.0) > 0.0,
    }
}
