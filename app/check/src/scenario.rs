//! The promises of a scenario.

use crate::Checked;
use crate::json::{array, entries, get, number, option, require, text};
use crate::robot::{Robot, pose_of};
use crate::shape::{Solid, solid_of};
use serde_json::Value;

/// A limit of a joint: the name of the promise, the joint, and the bounds.
pub(crate) struct Limit(pub(crate) &'static str, pub(crate) usize, pub(crate) [f64; 2]);

/// The limits that a scenario enforces.
pub(crate) fn limits(scenario: &Value, robot: &Robot) -> Checked<Vec<Limit>> {
    let none = Value::Null;
    let enforced = option(scenario, "enforced_limits").unwrap_or(&none);
    let passive: Vec<&str> = entries(scenario, "passive").iter().map(text).collect::<Checked<_>>()?;
    let share = |key: &str, joint: &str| -> Checked<Option<f64>> {
        Ok(match option(enforced, key) {
            None | Some(Value::Bool(true)) => Some(1.0),
            Some(Value::Bool(false)) => None,
            Some(Value::Number(share)) => share.as_f64(),
            Some(part) => {
                let named =
                    option(part, "joints").map_or(Ok(true), |j| Ok::<_, String>(array(j)?.iter().any(|n| n == joint)));
                let share = option(part, "share").map_or(Ok(1.0), number)?;
                named?.then_some(share)
            }
        })
    };
    let most = |key: &str, i: usize| -> Checked<Option<f64>> {
        match option(enforced, key) {
            None => Ok(None),
            Some(Value::Array(each)) => each.get(i).filter(|x| !x.is_null()).map(number).transpose(),
            Some(same) => Ok(Some(number(same).map_err(|_| format!("{key}: use the scenario of the summary"))?)),
        }
    };
    let mut all = Vec::new();
    for promise in ["position", "velocity", "acceleration", "jerk", "torque"] {
        for (i, joint) in robot.joints.iter().enumerate() {
            let [lower, upper, velocity, effort] = joint.limits;
            let given = match promise {
                "velocity" => most("max_velocity", i)?,
                "acceleration" | "jerk" => most(promise, i)?,
                _ => None,
            };
            let share = share(promise, &joint.name)?;
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
            if bounds.iter().any(|b| b.is_finite()) {
                all.push(Limit(promise, i, bounds));
            }
        }
    }
    Ok(all)
}

pub(crate) fn same_limits(limits: &[Limit], listed: &[Value]) -> Checked<()> {
    require(limits.len() == listed.len(), "the limits are not those of the scenario")?;
    for (Limit(promise, joint, bounds), listed) in limits.iter().zip(listed) {
        let own = [option(listed, "at_least"), option(listed, "at_most")];
        let same = bounds.iter().zip(own).all(|(bound, own)| match own.map(number) {
            Some(Ok(own)) => (own - bound).abs() <= 1e-14 * bound.abs(),
            Some(Err(_)) => false,
            None => !bound.is_finite(),
        });
        let is_it = *get(listed, "promise")? == *promise && *get(listed, "joint")? == *joint;
        require(same && is_it, format!("a {promise} limit is not that of the scenario"))?;
    }
    Ok(())
}

/// The promises of a scenario that no certificate covers; the certificate has to list them.
pub(crate) fn not_certified(scenario: &Value, robot: &Robot, listed: &Value) -> Checked<Vec<String>> {
    let some = |key: &str| !entries(scenario, key).is_empty();
    let by_shape = option(scenario, "robot_shape").is_none_or(|s| s.get("collision").is_some() || s == "collision");
    let apart = by_shape && option(scenario, "self_collision").is_none_or(|s| s != "off");
    let wanted = [
        ("passive_joints", some("passive")),
        ("obstacles", !robot.is_known && some("obstacles")),
        ("self_collision", !robot.is_known && apart),
    ];
    let wanted: Vec<&str> = wanted.into_iter().filter(|(_, is_missing)| *is_missing).map(|(name, _)| name).collect();
    let listed = array(listed)?.iter().map(|entry| text(get(entry, "promise")?).map(str::to_owned));
    let listed = listed.collect::<Checked<Vec<_>>>()?;
    require(listed == wanted, format!("what is not certified is {wanted:?}"))?;
    Ok(listed)
}

/// An obstacle, and the distance that is kept.
pub(crate) struct Obstacle {
    pub(crate) solid: Solid,
    pub(crate) margin: f64,
}

pub(crate) fn obstacles(scenario: &Value) -> Checked<Vec<Obstacle>> {
    let given = option(scenario, "clearance_m");
    let beside = given
        .map_or(Ok(0.0), |c| if c.is_object() { option(c, "obstacles").map_or(Ok(0.0), number) } else { number(c) })?;
    let mut all = Vec::new();
    for obstacle in entries(scenario, "obstacles") {
        let (at, (kind, size)) = (pose_of(get(obstacle, "pose")?)?, solid_of(get(obstacle, "shape")?)?);
        let margin = option(obstacle, "clearance_m").map_or(Ok(beside), number)?;
        all.push(Obstacle { solid: Solid { at, kind, size }, margin });
    }
    Ok(all)
}

/// Two shapes of the robot, or one and an obstacle, and the distance that is kept.
pub(crate) struct Pair {
    pub(crate) part: usize,
    pub(crate) other: Result<usize, usize>,
    pub(crate) margin: f64,
}

/// The pairs of a shape on a moving body and an obstacle, and those of shapes of links that keep clear of each other.
pub(crate) fn pairs(
    scenario: &Value,
    certificate: &Value,
    robot: &Robot,
    obstacles: &[Obstacle],
) -> Checked<[Vec<Pair>; 2]> {
    let (mut beside, mut links) = (Vec::new(), Vec::new());
    let given = option(scenario, "clearance_m");
    let itself = given
        .map_or(Ok(0.0), |c| if c.is_object() { option(c, "itself").map_or(Ok(0.0), number) } else { number(c) })?;
    let of_pair = |a: &str, b: &str| -> Checked<f64> {
        let own = given.and_then(|c| option(c, "pairs")).and_then(Value::as_array);
        let own = own.into_iter().flatten().find(|p| is_pair(p.get("links"), a, b));
        own.map_or(Ok(itself), |p| number(get(p, "clearance_m")?))
    };
    if !robot.is_known {
        return Ok([Vec::new(), Vec::new()]);
    }
    let free = array(get(certificate, "may_overlap")?)?;
    let off = option(scenario, "self_collision").is_some_and(|s| s == "off");
    for (i, part) in robot.parts.iter().enumerate() {
        if part.body.is_some() {
            let all = obstacles.iter().enumerate();
            beside.extend(all.map(|(o, obstacle)| Pair { part: i, other: Err(o), margin: obstacle.margin }));
        }
        for (j, other) in robot.parts.iter().enumerate().skip(i + 1) {
            let (a, b) = (part.link.as_str(), other.link.as_str());
            let apart = !off && !a.is_empty() && !b.is_empty() && a != b && part.body != other.body;
            if apart && !free.iter().any(|pair| is_pair(Some(pair), a, b)) {
                links.push(Pair { part: i, other: Ok(j), margin: of_pair(a, b)? });
            }
        }
    }
    Ok([beside, links])
}

pub(crate) fn is_pair(value: Option<&Value>, a: &str, b: &str) -> bool {
    let names = value.and_then(Value::as_array).filter(|names| names.len() == 2);
    names.is_some_and(|n| n[0] == a && n[1] == b || n[0] == b && n[1] == a)
}

/// The number of pairs of links about which nothing is claimed although the scenario does not name them, in words.
pub(crate) fn unnamed(scenario: &Value, free: &[Value]) -> String {
    let ignored = option(scenario, "self_collision").and_then(|s| option(s, "ignored_pairs")).and_then(Value::as_array);
    let names = |pair: &Value| Some([pair.get(0)?.as_str()?.to_owned(), pair.get(1)?.as_str()?.to_owned()]);
    let is_named = |[a, b]: [String; 2]| ignored.into_iter().flatten().any(|p| is_pair(Some(p), &a, &b));
    match free.iter().filter(|pair| !names(pair).is_some_and(is_named)).count() {
        0 => String::new(),
        count => format!("; assumed: {count} pairs of links that the scenario does not name may overlap or never meet"),
    }
}

/// True if the objective has a cost of time, so that the horizon is free.
pub(crate) fn weighs_time(scenario: &Value) -> Checked<bool> {
    match option(scenario, "objective") {
        Some(Value::String(preset)) => Ok(preset != "least-effort"),
        Some(weights) => Ok(option(weights, "time").map_or(Ok(0.0), number)? > 0.0),
        None => Ok(false),
    }
}
