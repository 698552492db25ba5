//! Findings about the joints and links of a URDF.

use super::{Finding, Severity};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use urdf_rs::{Inertial, Joint, JointLimit, JointType, Pose, Robot};

/// The number of joints of each kind.
pub(super) fn kinds(robot: &Robot) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for joint in &robot.joints {
        *counts.entry(kind(joint)).or_default() += 1;
    }
    counts
}

fn kind(joint: &Joint) -> &'static str {
    match joint.joint_type {
        JointType::Revolute => "revolute",
        JointType::Continuous => "continuous",
        JointType::Prismatic => "prismatic",
        JointType::Fixed => "fixed",
        JointType::Floating => "floating",
        JointType::Planar => "planar",
        JointType::Spherical => "spherical",
    }
}

fn has_several_degrees(joint: &Joint) -> bool {
    use JointType::{Floating, Planar, Spherical};
    matches!(joint.joint_type, Floating | Planar | Spherical)
}

/// The robot without a link or a joint that is called as in errors: such a link is empty, and such a joint fixed at the
/// origin of its parent. `None` if nothing of the robot is called so.
pub(super) fn without(robot: &Robot, element: &str) -> Option<Robot> {
    let mut less = robot.clone();
    let named = |kind: &str, name: &str| {
        let name = format!("{kind} '{name}'");
        (element.strip_prefix(&name)).is_some_and(|rest| rest.is_empty() || rest.starts_with(':'))
    };
    let mut found = false;
    for link in less.links.iter_mut().filter(|l| named("link", &l.name)) {
        link.inertial = Inertial::default();
        link.collision.clear();
        found = true;
    }
    for joint in less.joints.iter_mut().filter(|j| named("joint", &j.name)) {
        joint.joint_type = JointType::Fixed;
        joint.origin = Pose::default();
        found = true;
    }
    found.then_some(less)
}

/// Larger numbers are unlikely for robots, and frequent in files in degrees, millimetres or grams: a limit of position,
/// rad, and of velocity, rad/s or m/s, a position in a parent or a limit, m, and the mass of a link, kg. A number of
/// `NO_LIMIT` or more is no limit.
const NO_LIMIT: f64 = 1e5;
const FAR: f64 = 20.0 * PI;
const FAST: f64 = 100.0;
const LONG: f64 = 10.0;
const HEAVY: f64 = 1000.0;
/// The remedy for numbers in other units.
const UNITS: &str = "the file, which is in m, rad and kg";

/// The finding about angles of an origin beyond a turn.
const BEYOND_A_TURN: [&str; 2] = ["rpy of an origin is beyond a turn: are these degrees?", UNITS];

/// Returns true for angles beyond a turn, which are most often in degrees. A full turn may be written with few digits.
fn is_beyond_a_turn(origin: &Pose) -> bool {
    origin.rpy.iter().any(|angle| angle.abs() > 1.01 * TAU)
}

/// A property of a joint.
type Property = fn(&Joint) -> bool;

/// The findings about joints.
pub(super) fn of_joints(robot: &Robot) -> Vec<Finding> {
    let moving = |joint: &&Joint| joint.joint_type != JointType::Fixed;
    let moving: Vec<&Joint> = robot.joints.iter().filter(moving).collect();
    let mut found = vec![Finding::about(
        Severity::NeedsKey,
        "joint",
        names(&moving, has_several_degrees),
        [
            "it has several degrees of freedom, and every joint has one here; it is held in what follows",
            "\"srdf\": FILE and \"group\": NAME (--group NAME) of joints without it, which hold it; or \
             type=\"fixed\" in the file",
        ],
    )];
    let mimic = moving.iter().filter_map(|joint| {
        let mimic = joint.mimic.as_ref()?;
        let (factor, offset) = (mimic.multiplier.unwrap_or(1.0), mimic.offset.unwrap_or(0.0));
        Some(format!("{} = {factor} {} + {offset}", joint.name, mimic.joint))
    });
    found.push(Finding::about(
        Severity::NeedsKey,
        "mimic joint",
        mimic,
        [
            "it follows another joint",
            "\"srdf\": FILE and \"group\": NAME (--group NAME), which hold it with that joint; or \
             \"mimic\": \"independent\" (--mimic independent), which lets it move by itself",
        ],
    ));
    found.extend(notes(&moving));
    let turned = robot.joints.iter().filter(|joint| is_beyond_a_turn(&joint.origin));
    found.push(Finding::about(Severity::Note, "joint", turned.map(|joint| joint.name.clone()), BEYOND_A_TURN));
    found.into_iter().flatten().collect()
}

/// The notes about limits and losses of the joints that move.
fn notes(moving: &[&Joint]) -> [Option<Finding>; 13] {
    let losses = "\"losses\": true (--losses); {\"armature\": ...} adds rotor inertia, which a URDF does not have";
    let in_file = "the limit element in the file";
    let rates = "\"enforced_limits\": {\"acceleration\": NUMBER}, a list, or {\"file\": MoveIt's joint_limits.yaml}";
    let given = "\"enforced_limits\": {\"acceleration\": \"urdf\", \"jerk\": \"urdf\"}";
    let notes: [(&str, &str, Property); 13] = [
        ("limits of position beyond ten turns: are these degrees?", UNITS, |j| {
            j.joint_type == JointType::Revolute && (FAR..NO_LIMIT).contains(&farthest(&j.limit))
        }),
        ("a limit of velocity above 100 rad/s: are these degrees?", UNITS, |j| {
            is_turning(j) && (FAST..NO_LIMIT).contains(&j.limit.velocity)
        }),
        ("its origin is more than 10 m from its parent: are these millimetres?", UNITS, |j| {
            j.origin.xyz.iter().any(|x| x.abs() > LONG)
        }),
        ("limits of position beyond 10 m: are these millimetres?", UNITS, |j| {
            j.joint_type == JointType::Prismatic && (LONG..NO_LIMIT).contains(&farthest(&j.limit))
        }),
        ("a limit of velocity above 100 m/s: are these millimetres?", UNITS, |j| {
            j.joint_type == JointType::Prismatic && (FAST..NO_LIMIT).contains(&j.limit.velocity)
        }),
        ("no limits of any kind", in_file, |j| has_one_degree(j) && !has_limits(&j.limit)),
        ("no limit of velocity", in_file, |j| has_limits(&j.limit) && j.limit.velocity == 0.0),
        ("no limit of effort", in_file, |j| has_limits(&j.limit) && j.limit.effort == 0.0),
        ("its range of positions is a single one", in_file, |j| {
            let turns = j.joint_type == JointType::Continuous;
            has_limits(&j.limit) && !turns && j.limit.lower == j.limit.upper
        }),
        ("no limit of acceleration or jerk", rates, |j| has_one_degree(j) && !has_limits_of_rates(&j.limit)),
        ("limits of acceleration or jerk, not kept by default", given, |j| {
            has_one_degree(j) && has_limits_of_rates(&j.limit)
        }),
        ("damping is not counted by default", losses, |j| {
            j.dynamics.as_ref().is_some_and(|dynamics| dynamics.damping != 0.0)
        }),
        ("friction is not counted by default", losses, |j| {
            j.dynamics.as_ref().is_some_and(|dynamics| dynamics.friction != 0.0)
        }),
    ];
    notes.map(|(condition, remedy, property)| {
        let names = names(moving, property);
        Finding::about(Severity::Note, "joint", names, [condition, remedy])
    })
}

/// The names of the joints with a property.
fn names(joints: &[&Joint], property: Property) -> Vec<String> {
    let with = joints.iter().filter(|joint| property(joint));
    with.map(|joint| joint.name.clone()).collect()
}

fn has_one_degree(joint: &Joint) -> bool {
    !has_several_degrees(joint)
}

/// True if there is a limit element with a number other than zero.
fn has_limits(limit: &JointLimit) -> bool {
    let all = [limit.lower, limit.upper, limit.velocity, limit.effort];
    all.iter().any(|x| *x != 0.0)
}

fn has_limits_of_rates(limit: &JointLimit) -> bool {
    let all = [limit.acceleration, limit.deceleration, limit.jerk];
    all.iter().any(|x| *x != f64::INFINITY)
}

/// The larger one of the distances of both limits of position from zero.
fn farthest(limit: &JointLimit) -> f64 {
    limit.lower.abs().max(limit.upper.abs())
}

/// True for an angle, which is in rad.
fn is_turning(joint: &Joint) -> bool {
    matches!(joint.joint_type, JointType::Revolute | JointType::Continuous)
}

/// The findings about links.
pub(super) fn of_links(robot: &Robot) -> Vec<Finding> {
    let carried = |link: &str| {
        let mut joints = robot.joints.iter();
        joints.any(|joint| joint.joint_type != JointType::Fixed && joint.child.link == link)
    };
    let massless = robot.links.iter().filter(|link| {
        let inertia = &link.inertial.inertia;
        let numbers = [inertia.ixx, inertia.iyy, inertia.izz, link.inertial.mass.value];
        numbers.iter().all(|x| *x == 0.0) && carried(&link.name)
    });
    let heavy = robot.links.iter().filter(|link| link.inertial.mass.value > HEAVY);
    let heavy = Finding::about(
        Severity::Note,
        "link",
        heavy.map(|link| link.name.clone()),
        ["a mass above 1000 kg: are these grams?", UNITS],
    );
    let found = Finding::about(
        Severity::Note,
        "link",
        massless.map(|link| link.name.clone()),
        ["it moves and has no inertia, so it counts as massless", ""],
    );
    let turned = robot.links.iter().filter(|link| {
        let mut shapes = link.collision.iter();
        is_beyond_a_turn(&link.inertial.origin) || shapes.any(|shape| is_beyond_a_turn(&shape.origin))
    });
    let turned = Finding::about(Severity::Note, "link", turned.map(|link| link.name.clone()), BEYOND_A_TURN);
    found.into_iter().chain(heavy).chain(turned).collect()
}
