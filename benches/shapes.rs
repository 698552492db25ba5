//! The shapes of robots and the time of their rows.
//!
//! `cargo bench --bench shapes -- EXCESS ROBOT.urdf ...`, with a number or `default` for the excess, prints a line per
//! robot: balls or convex bodies and the time in which they were found, the rows of the pairs of links that are no
//! neighbours and do not always overlap, and the mean time of the rows at a configuration, of four side by side, over
//! random ones.

use aghf::constraint::{AnyConstraint, Constraint, Evaluator};
use aghf::error::Result;
use aghf::geometry::Scene;
use aghf::scalar::{Lanes, Wide};
use aghf::urdf::{Mimic, RobotSource, UrdfOptions};
use aghf_scenario::{IgnoredPairs, link_shapes};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::time::Instant;

/// The number of configurations, four at a time.
const SAMPLES: usize = 1000;

fn main() -> Result<()> {
    let mut given = std::env::args().skip(1).filter(|arg| arg != "--bench");
    let excess = given.next().and_then(|text| text.parse().ok());
    println!("| robot | bodies | shapes, s | pairs, s | rows | a point, us |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for path in given {
        match line(&path, excess) {
            Ok(line) => println!("{line}"),
            Err(error) => println!("| {path} | {error} |"),
        }
    }
    Ok(())
}

fn line(path: &str, excess: Option<f64>) -> Result<String> {
    let source = RobotSource::find(path, Path::new(""))?;
    let mimic = Mimic::Independent;
    let (model, _) = source.parse(UrdfOptions { mimic, ..UrdfOptions::default() })?;
    let begin = Instant::now();
    let robot = link_shapes(&model, source.folder(), excess)?;
    let shapes = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let ignored = IgnoredPairs::by_sampling(&model, &robot)?.ignored_pairs;
    let pairs = begin.elapsed().as_secs_f64();
    let ignored: Vec<_> = ignored.into_iter().map(|pair| pair.links).collect();
    let bodies = robot.balls.len();
    let rows = AnyConstraint::of_scene(&Scene::new(robot, Vec::new(), Some(&ignored)));
    let mut g = vec![Wide::splat(0.0); rows.dim()];
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut evaluator = Evaluator::<f64, Wide>::new(&model);
    let mut states = Vec::new();
    for _ in 0..SAMPLES {
        let four = [(); 4].map(|()| model.random_configuration(&mut rng));
        let q = (0..model.dof()).map(|i| Lanes(std::array::from_fn(|lane| four[lane][i])));
        let v = std::iter::repeat_n(Wide::splat(0.0), model.dof());
        states.push(q.chain(v).collect::<Vec<_>>());
    }
    let begin = Instant::now();
    for x in &states {
        evaluator.at(x)?.value(&rows, &mut g)?;
    }
    let point = begin.elapsed().as_secs_f64() / (4 * SAMPLES) as f64 * 1e6;
    let (name, rows) = (model.name(), g.len());
    Ok(format!("| {name} | {bodies} | {shapes:.2} | {pairs:.2} | {rows} | {point:.1} |"))
}
