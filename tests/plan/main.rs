//! Planned paths, and planned starts of the direct method.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod distances;
mod fit;
mod inverse_kinematics;
mod paths;
mod sampler;
mod starts;

use aghf::constraint::{AnyConstraint, CollisionSphere, Sphere, SphereClearance};
use aghf::model::Model;
use aghf::motion::Problem;
use nalgebra::Vector3;

/// A point on sliders along x and y.
fn point() -> Model {
    common::point_mass(&[Vector3::x(), Vector3::y()])
}

/// From rest at (0, 0) to rest at (1, 0) in a second.
fn across(model: &Model) -> Problem<'_> {
    Problem::new(model, vec![0.0; 4], vec![1.0, 0.0, 0.0, 0.0], 1.0).expect("valid")
}

/// The constraint that keeps the point outside balls of this radius.
fn outside(centres: impl IntoIterator<Item = [f64; 2]>, radius: f64) -> Vec<AnyConstraint> {
    let ball = CollisionSphere { body: Some(1), centre: Vector3::zeros(), radius: 0.0 };
    let spheres = centres.into_iter().map(|[x, y]| Sphere { centre: Vector3::new(x, y, 0.0), radius });
    vec![AnyConstraint::Spheres(SphereClearance { balls: vec![ball], spheres: spheres.collect() })]
}

/// A wall of balls across the path, beyond both ends of the range of y, open in these ranges less 0.1 at each end.
fn wall(open: &[[f64; 2]]) -> Vec<AnyConstraint> {
    let heights = (-24..=24).map(|k| 0.05 * f64::from(k));
    let closed = heights.filter(|y| !open.iter().any(|[low, high]| (low..high).contains(&y)));
    outside(closed.map(|y| [0.5, y]), 0.1)
}

/// A wall that is open from 0.95 to 1.05.
fn wall_with_a_gap() -> Vec<AnyConstraint> {
    wall(&[[0.86, 1.14]])
}

/// Balls all around the goal.
fn ring() -> Vec<AnyConstraint> {
    let angles = (0..24).map(|k| std::f64::consts::TAU * f64::from(k) / 24.0);
    outside(angles.map(|a| [1.0 + 0.4 * a.cos(), 0.4 * a.sin()]), 0.1)
}
