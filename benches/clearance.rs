//! Clearances at four points side by side: an arm with 59 balls, the pairs of those on links that are not neighbours,
//! and 12 boxes.
//!
//! `cargo bench --bench clearance` measures and prints the medians in microseconds at the end, for the four points
//! together, by the number of rows. "One in twenty": the weights of the other rows vanish.

mod common;

use aghf::constraint::{CollisionSphere, Constraint, Evaluator, SelfClearance, SolidClearance, Weights};
use aghf::geometry::{Shape, Solid};
use aghf::model::Model;
use aghf::scalar::{Lanes, Scalar, Wide};
use aghf::spatial::Placement;
use aghf::urdf::builtin_robot;
use common::{Times, criterion, measure, report, wave};
use criterion::Criterion;
use nalgebra::{Rotation3, Vector3};
use std::hint::black_box;

/// As many as a Panda has in the sphere set of its planners.
const BALLS: usize = 59;
const BOXES: usize = 12;

/// Balls about the line of an arm, as many on the base as on each link.
fn balls(model: &Model) -> Vec<CollisionSphere> {
    let links = model.dof() + 1;
    let ball = |i: usize| CollisionSphere {
        body: (i * links / BALLS).checked_sub(1),
        centre: Vector3::from_column_slice(&wave(3, i as f64)) * 0.08,
        radius: 0.05,
    };
    (0..BALLS).map(ball).collect()
}

/// The pairs of balls on links that are not neighbours.
fn pairs(balls: &[CollisionSphere]) -> Vec<[usize; 2]> {
    let link = |i: usize| balls[i].body.map_or(0, |body| body + 1);
    let all = (0..balls.len()).flat_map(|i| (0..i).map(move |j| [j, i]));
    let mut pairs: Vec<_> = all.filter(|[j, i]| link(*i) - link(*j) > 1).collect();
    pairs.sort_by_key(|[j, i]| (link(*j), link(*i)));
    pairs
}

fn boxes() -> Vec<Solid> {
    let solid = |i: usize| {
        let [at, turn] = [1.7, 2.9].map(|f| Vector3::from_column_slice(&wave(3, f * i as f64)));
        Solid {
            placement: Placement::new(Rotation3::new(turn).into_inner(), at * 0.8),
            shape: Shape::Cuboid { half_extents: Vector3::new(0.3, 0.2, 0.05) },
        }
    };
    (1..=BOXES).map(solid).collect()
}

fn time(criterion: &mut Criterion, times: &mut Times, name: &str, model: &Model, constraint: &impl Constraint) {
    let rows = constraint.dim();
    let x: Vec<Wide> =
        (0..2 * model.dof()).map(|i| Lanes([0.0, 0.1, 0.2, 0.3].map(|t| (0.7 * i as f64 + t).sin()))).collect();
    let all: Vec<Wide> = wave(rows, 0.7).into_iter().map(Lanes::splat).collect();
    let mut some = all.clone();
    for (_, w) in some.iter_mut().enumerate().filter(|(i, _)| i % 20 > 0) {
        *w = Wide::from_f64(0.0);
    }
    let mut g = all.clone();
    let mut evaluator = Evaluator::<f64, Wide>::new(model);
    measure(criterion, times, &format!("{name}, values"), rows, || {
        let here = evaluator.at(black_box(&x)).expect("the same robot");
        here.value(constraint, &mut g).expect("as many rows");
    });
    for (what, w) in [("all rows", &all), ("one in twenty", &some)] {
        let name = format!("{name}, values and derivatives, {what}");
        measure(criterion, times, &name, rows, || {
            let mut here = evaluator.at(black_box(&x)).expect("the same robot");
            here.value(constraint, &mut g).expect("as many rows");
            let weights = Weights { first_order: w, gauss_newton: Some(w) };
            let sums = here.weighted_derivatives(constraint, weights);
            black_box(sums.expect("as many weights"));
        });
    }
}

fn main() {
    let (mut criterion, mut times) = (criterion(), Times::new());
    let model = builtin_robot("kinova_gen3").expect("it is built in");
    let balls = balls(&model);
    let own = SelfClearance { pairs: pairs(&balls), balls: balls.clone() };
    let solids = SolidClearance { balls, solids: boxes(), names: Vec::new() };
    time(&mut criterion, &mut times, "itself", &model, &own);
    time(&mut criterion, &mut times, "12 boxes", &model, &solids);
    time(&mut criterion, &mut times, "both", &model, &(own, solids));
    criterion.final_summary();
    report(&mut times);
}
