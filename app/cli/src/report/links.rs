//! Capsules along the links of a robot without shapes.

use super::scene::{Item, Tip};
use aghf::geometry::Shape;
use aghf::model::{JointKind, Model};
use aghf::spatial::{Placement, rotation_of_z_to};
use nalgebra::Vector3;

/// The radius of a link relative to the reach of the robot, and to its longest link: the smaller one is used.
const OF_REACH: f64 = 0.042;
const OF_LONGEST: f64 = 0.11;
/// The radius of the ball at a joint relative to that of the links.
const JOINT: f64 = 1.3;
/// The radius at the end of the longest chain relative to that at its base.
const TAPER: f64 = 0.55;
/// The largest number of points whose paths are drawn.
const MAX_TIPS: usize = 4;

/// The end points of a body in its frame: the origins of its children, or the tip of a last link.
fn ends(model: &Model, body: usize) -> Vec<Vector3<f64>> {
    let children = model.joints().iter().filter(|j| j.parent() == Some(body));
    let ends: Vec<_> = children.map(|j| j.origin().translation).collect();
    if ends.is_empty() {
        return vec![tip(model, body).1];
    }
    ends
}

/// The tip of a last link, and its name: the frame furthest from the joint, otherwise twice the vector to the centre of
/// mass.
fn tip(model: &Model, body: usize) -> (String, Vector3<f64>) {
    let frames = model.frames().iter().filter(|f| f.body == Some(body));
    let furthest = frames.max_by(|a, b| {
        let [a, b] = [a, b].map(|f| f.placement.translation.norm());
        a.total_cmp(&b)
    });
    let name = furthest.map_or_else(|| model.joints()[body].name().to_owned(), |f| f.name.clone());
    let point = furthest.map_or_else(Vector3::zeros, |f| f.placement.translation);
    if point.norm() > 1e-6 {
        return (name, point);
    }
    let inertia = &model.inertias()[body];
    if inertia.mass > 0.0 {
        return (name, inertia.first_moment * (2.0 / inertia.mass));
    }
    (name, point)
}

/// The distance along the links from the base to each joint, m.
fn ways(model: &Model) -> Vec<f64> {
    let mut ways: Vec<f64> = Vec::with_capacity(model.dof());
    for joint in model.joints() {
        let before = joint.parent().map_or(0.0, |p| ways[p]);
        ways.push(before + joint.origin().translation.norm());
    }
    ways
}

/// The ends of the last links, the longest chains first.
pub(super) fn tips(model: &Model) -> Vec<Tip> {
    let ways = ways(model);
    let last = |body: &usize| model.joints().iter().all(|j| j.parent() != Some(*body));
    let mut tips: Vec<_> = (0..model.dof())
        .filter(last)
        .map(|body| {
            let (name, point) = tip(model, body);
            (ways[body] + point.norm(), Tip { name, body, point: point.into() })
        })
        .collect();
    tips.sort_by(|a, b| b.0.total_cmp(&a.0));
    tips.into_iter().map(|(_, tip)| tip).take(MAX_TIPS).collect()
}

/// The radii of the links at each joint, m.
fn radii(model: &Model) -> Vec<f64> {
    let ways = ways(model);
    let lengths = |body: usize| ends(model, body).into_iter().map(|end| end.norm());
    let of_links = (0..model.dof()).flat_map(lengths);
    let longest = of_links.fold(0.0, f64::max);
    let reach = (0..model.dof()).map(|body| ways[body] + lengths(body).fold(0.0, f64::max)).fold(0.0, f64::max);
    let radius = match (OF_REACH * reach).min(OF_LONGEST * longest) {
        radius if radius > 0.0 => radius,
        // All joints are in one place.
        _ => 0.05,
    };
    let share = |way: f64| if reach > 0.0 { way / reach } else { 0.0 };
    ways.iter().map(|way| radius * (1.0 - (1.0 - TAPER) * share(*way))).collect()
}

/// Links from joint to joint, and a ball at each joint, for the given bodies.
pub(super) fn capsules_along_links(model: &Model, bodies: &[Option<usize>]) -> Vec<Item> {
    let radii = radii(model);
    let mut shapes = Vec::new();
    for body in 0..model.dof() {
        if !bodies.contains(&Some(body)) {
            continue;
        }
        let radius = radii[body];
        let own = match model.joints()[body].kind() {
            JointKind::Prismatic => Shape::Cuboid { half_extents: Vector3::repeat(JOINT * radius) },
            JointKind::Revolute | JointKind::Continuous => Shape::Sphere { radius: JOINT * radius },
        };
        shapes.push(Item { joint: true, ..Item::new(Some(body), &Placement::identity(), &own) });
        shapes.extend(rail(model, body, 0.4 * radius));
        for end in ends(model, body) {
            shapes.extend(capsule(Some(body), end, radius));
        }
    }
    shapes
}

/// The base: links from it to the first joints, and a plate under it.
pub(super) fn base_shapes(model: &Model) -> Vec<Item> {
    let radius = radii(model).iter().copied().fold(0.0, f64::max);
    let plate = Shape::Cylinder { radius: 1.9 * radius, half_length: 0.25 * radius };
    let first = model.joints().iter().filter(|j| j.parent().is_none());
    let mut shapes: Vec<Item> = first.filter_map(|joint| capsule(None, joint.origin().translation, radius)).collect();
    shapes.push(Item { joint: true, ..Item::new(None, &Placement::identity(), &plate) });
    shapes
}

/// The rail of a prismatic joint, between its limits if it has both.
fn rail(model: &Model, body: usize, radius: f64) -> Option<Item> {
    let joint = &model.joints()[body];
    let [lower, upper] = [joint.limits().lower, joint.limits().upper];
    let sliding = joint.kind() == JointKind::Prismatic && lower.is_finite() && upper.is_finite();
    if !sliding {
        return None;
    }
    let axis = joint.axis();
    let middle = Placement::new(rotation_of_z_to(axis), axis * (0.5 * (lower + upper)));
    let shape = Shape::Capsule { radius, half_length: 0.5 * (upper - lower) };
    let placement = joint.origin().compose(&middle);
    Some(Item::new(joint.parent(), &placement, &shape))
}

/// A capsule from the origin of a body to `end`; `None` if that is inside the ball at the joint.
fn capsule(body: Option<usize>, end: Vector3<f64>, radius: f64) -> Option<Item> {
    let length = end.norm();
    if length < 0.5 * radius {
        return None;
    }
    let placement = Placement::new(rotation_of_z_to(&end), end * 0.5);
    let shape = Shape::Capsule { radius, half_length: 0.5 * length };
    Some(Item::new(body, &placement, &shape))
}
