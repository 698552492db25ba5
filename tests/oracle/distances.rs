//! Distances of balls from obstacles compared with Parry's.

use crate::common::config;
use aghf::constraint::{CollisionSphere, Evaluator, SolidClearance};
use aghf::geometry::{Shape, Solid};
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf::urdf::builtin_robot;
use nalgebra::{Rotation3, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder, HalfSpace};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::cell::Cell;

/// The bound on the difference, in m.
const BOUND: f64 = 1e-9;

/// The number of balls per solid.
const BALLS: usize = 50;

/// Random shapes of all kinds, some of them much longer than wide.
fn shape() -> impl Strategy<Value = Shape> {
    let size = || prop_oneof![1 => 0.001..0.05_f64, 3 => 0.05..1.5_f64];
    prop_oneof![
        size().prop_map(|radius| Shape::Sphere { radius }),
        [size(), size(), size()].prop_map(|h| Shape::Cuboid { half_extents: h.into() }),
        [size(), size()].prop_map(|[radius, half_length]| Shape::Cylinder { radius, half_length }),
        [size(), size()].prop_map(|[radius, half_length]| Shape::Capsule { radius, half_length }),
    ]
}

/// Converts a shape with our axis `z` to a shape of Parry with the axis `y`.
fn theirs(shape: &Shape) -> Box<dyn PointQuery> {
    match *shape {
        Shape::Sphere { radius } => Box::new(Ball::new(radius)),
        Shape::Cuboid { half_extents: h } => Box::new(Cuboid::new(Vector::new(h.y, h.z, h.x))),
        Shape::Cylinder { radius, half_length } => Box::new(Cylinder::new(half_length, radius)),
        Shape::Capsule { radius, half_length } => Box::new(Capsule::new_y(half_length, radius)),
        Shape::HalfSpace => Box::new(HalfSpace::new(Vector::Y)),
    }
}

/// The rows of this library for balls on the base and a solid.
fn ours(model: &Model, solid: Solid, balls: &[([f64; 3], f64)]) -> Vec<f64> {
    let ball = |(centre, radius): &([f64; 3], f64)| CollisionSphere {
        body: None,
        centre: Vector3::from(*centre),
        radius: *radius,
    };
    let clearance = SolidClearance { balls: balls.iter().map(ball).collect(), solids: vec![solid], names: Vec::new() };
    let x = vec![0.0; 2 * model.dof()];
    let mut g = vec![0.0; balls.len()];
    let mut evaluator = Evaluator::new(model);
    let here = evaluator.at(&x).expect("as many as joints");
    here.value(&clearance, &mut g).expect("they are on the base");
    g
}

/// Compares a million pairs of a ball and an obstacle, in about a second, unless `AGHF_CASES` is set.
#[test]
fn distances() {
    let model = builtin_robot("pendulum_1").expect("it is built in");
    let worst = Cell::new(0.0_f64);
    let vector = |reach: f64| [-reach..reach, -reach..reach, -reach..reach];
    let balls = prop::collection::vec((vector(2.0), 0.0..0.3_f64), BALLS);
    let settings = Config { source_file: Some(file!()), max_shrink_iters: 100, ..config(20_000) };
    let solid = (shape(), vector(3.0), vector(1.0));
    let run = TestRunner::new(settings).run(&(solid, balls), |((shape, turn, off), balls)| {
        let placement = Placement::new(Rotation3::new(turn.into()).into_inner(), off.into());
        let rows = ours(&model, Solid { placement, shape }, &balls);
        // The rotation from Parry's frame to ours: its axes x, y, z are our y, z, x.
        let cycle = Rotation::from_mat3(&parry3d_f64::math::Matrix::from_cols(Vector::Y, Vector::Z, Vector::X));
        let turned = Rotation::from_scaled_axis(Vector::from_array(turn)) * cycle;
        let pose = Pose::from_parts(Vector::from_array(off), turned);
        let theirs = theirs(&shape);
        for ((centre, radius), row) in balls.iter().zip(rows) {
            let centre = Vector::from_array(*centre);
            let nearest = theirs.project_point(&pose, centre, false);
            let off = (nearest.point - centre).length();
            let distance = if nearest.is_inside { -off } else { off };
            let difference = (row - (radius - distance)).abs();
            prop_assert!(difference <= BOUND, "{shape:?} at {centre:?}: {difference:e}");
            worst.set(worst.get().max(difference));
        }
        Ok(())
    });
    println!("distances: worst difference {:.1e} m", worst.get());
    run.unwrap_or_else(|e| panic!("{e}"));
}
