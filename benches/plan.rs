//! Times of the planner alone.
//!
//! `cargo bench --bench plan` prints them over the scenarios of the Panda; `cargo bench --bench plan -- FILE...` over
//! others.

use aghf::plan::{Plan, PlanSettings, plan};
use aghf_scenario::Scenario;
use std::time::Instant;

/// The scenarios without others being asked for.
fn panda() -> std::io::Result<Vec<String>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda/scenarios");
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        files.push(entry?.path().display().to_string());
    }
    Ok(files)
}

/// The smallest value that at least `percent` of all do not exceed.
fn percentile(ascending: &[f64], percent: usize) -> f64 {
    let index = (ascending.len() * percent).div_ceil(100).max(1) - 1;
    ascending.get(index).copied().unwrap_or(f64::NAN)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut files: Vec<String> = std::env::args().skip(1).filter(|name| !name.starts_with("--")).collect();
    if files.is_empty() {
        files = panda()?;
    }
    // As the direct method plans its starts.
    let settings = PlanSettings { roundings: 0, ..PlanSettings::default() };
    let (mut times, mut found) = (Vec::new(), 0);
    for file in &files {
        let scenario = Scenario::load(file)?;
        let (problem, constraints) = (scenario.problem()?, scenario.constraints());
        let begin = Instant::now();
        let path = plan(&problem, &constraints.state, &settings, &|| false)?;
        times.push(1e3 * begin.elapsed().as_secs_f64());
        found += usize::from(matches!(path, Plan::Found(_)));
    }
    times.sort_by(f64::total_cmp);
    let [median, most, worst] = [50, 99, 100].map(|percent| percentile(&times, percent));
    println!(
        "{found} paths of {} problems: median {median:.2} ms, 99 % {most:.1} ms, at most {worst:.1} ms",
        files.len()
    );
    Ok(())
}
