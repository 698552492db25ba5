//! Robots, timing and the table of medians that the benchmarks share.
#![allow(dead_code)] // every benchmark uses its own part of it

use aghf::model::{Model, random_chain};
use aghf::urdf::{builtin_robot, builtin_robots};
use criterion::Criterion;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// Seconds per call, by what was called and `N`.
pub type Times = BTreeMap<(String, usize), Vec<f64>>;

/// Short runs: the whole of a benchmark takes minutes.
pub fn criterion() -> Criterion {
    Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600))
        .configure_from_args()
}

/// `count` numbers between -1 and 1.
pub fn wave(count: usize, frequency: f64) -> Vec<f64> {
    let at = |i: usize| (frequency * (i as f64 + 1.0)).sin();
    (0..count).map(at).collect()
}

/// The first built-in robot of each number of joints but the single pendulum, and chains of 32, 64 and 128 joints:
/// times are named by the number of joints.
pub fn models() -> Vec<Model> {
    let mut seen = BTreeSet::from([1]);
    let built_in = builtin_robots().map(|name| builtin_robot(name).expect("it loads"));
    let built_in = built_in.filter(|model| seen.insert(model.dof()));
    let chains = [32, 64, 128].map(|n| random_chain(n, 1).expect("it has joints"));
    built_in.chain(chains).collect()
}

/// Times `call` under the name `what` for a robot of `n` joints.
pub fn measure(criterion: &mut Criterion, times: &mut Times, what: &str, n: usize, mut call: impl FnMut()) {
    let mut seen = Vec::new();
    criterion.bench_function(&format!("{what}/{n}"), |bencher| {
        bencher.iter_custom(|iterations| {
            let start = Instant::now();
            (0..iterations).for_each(|_| call());
            let elapsed = start.elapsed();
            seen.push(elapsed.as_secs_f64() / iterations as f64);
            elapsed
        });
    });
    times.insert((what.to_owned(), n), seen);
}

/// Prints the medians, and the exponent `e` of the growth `N^e` that fits the four largest robots of each row best.
pub fn report(times: &mut Times) {
    let mut columns: BTreeMap<&str, Vec<(usize, f64)>> = BTreeMap::new();
    for ((what, n), seen) in times.iter_mut() {
        seen.sort_by(f64::total_cmp);
        if let Some(median) = seen.get(seen.len() / 2) {
            columns.entry(what).or_default().push((*n, *median));
        }
    }
    println!("\nmedians in microseconds by N; growth fitted over the four largest robots");
    for (what, points) in columns {
        let row: Vec<String> = (points.iter()).map(|(n, t)| format!("{n}: {:.2}", 1e6 * t)).collect();
        let largest = &points[points.len().saturating_sub(4)..];
        println!("{what:24} {}  growth N^{:.2}", row.join("  "), growth(largest));
    }
}

/// The exponent of the power of `N` that fits the times best: least squares in the logarithms.
fn growth(points: &[(usize, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(n, t)| ((*n as f64).ln(), t.ln())).collect();
    let count = logs.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let covariance: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    covariance / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}
