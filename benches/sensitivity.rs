//! Iterations and successes of the direct method with each numerical option halved and doubled.
//!
//! `cargo bench --bench sensitivity` prints a table over forty mixed problems, which takes half an hour;
//! `cargo bench --bench sensitivity -- NAME...` one over scenarios by name or file.

use aghf::direct::{Direct, DirectSettings};
use aghf::nlp::Monotone;
use aghf_scenario::{DirectOptions, Scenario};
use std::sync::Arc;

/// Fewer starts than by default: the options of one minimisation matter here, not the luck of the best of many.
const STARTS: usize = 4;

/// A change of an option by a factor.
type Change = fn(&mut DirectSettings, f64);

/// The problems: without limits, with obstacles, within limits, underactuated, and among furniture.
fn problems() -> Vec<String> {
    let mut names: Vec<String> = [
        "pendulum_2_swingup",
        "pendulum_4_swingup",
        "kinova_free_01",
        "kinova_free_03",
        "kinova_table_01",
        "digit_free_stretch",
        "digit_obstacles_2",
        "two_arms_01",
        "acrobot_swingup",
        "cart_pole_swingup",
    ]
    .map(str::to_owned)
    .to_vec();
    names.extend((1..=5).map(|i| format!("kinova_obstacles_{i:02}")));
    names.extend((1..=11).map(|i| format!("limits_{i:02}")));
    let shelves = ["bookshelf_small", "bookshelf_tall", "bookshelf_thin"];
    let others = ["box", "cage", "table_pick", "table_under_pick"];
    for kind in shelves.into_iter().chain(others) {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda/scenarios");
        names.extend(["0001", "0040"].map(|number| format!("{folder}/{kind}_{number}.json")));
    }
    names
}

/// Multiplies a length, a tolerance or a weight.
fn scaled(x: &mut f64, by: f64) {
    *x *= by;
}

/// Multiplies a count, which stays at least 1.
fn count(x: &mut usize, by: f64) {
    *x = ((*x as f64 * by).round() as usize).max(1);
}

/// Multiplies the logarithm of a number between 0 and 1, so that it remains there and grows with the factor.
fn fraction(x: &mut f64, by: f64) {
    *x = x.powf(1.0 / by);
}

/// Multiplies the excess of a factor over 1.
fn factor(x: &mut f64, by: f64) {
    *x = 1.0 + (*x - 1.0) * by;
}

fn both(x: &mut [f64; 2], by: f64) {
    x.iter_mut().for_each(|x| scaled(x, by));
}

fn regularisation(x: &mut [f64; 3], by: f64) {
    let [first, later, after] = x;
    factor(first, by);
    factor(later, by);
    fraction(after, by);
}

fn shares(x: &mut [f64; 2], by: f64) {
    let [less, more] = x;
    fraction(less, by);
    factor(more, by);
}

/// The options by name, each with the function that changes it.
macro_rules! options {
    ($($change:ident: $($group:ident.$option:ident),*;)*) => {
        [$($((
            concat!(stringify!($group), ".", stringify!($option)),
            (|settings, by| $change(&mut settings.$group.$option, by)) as Change,
        )),*),*]
    };
}

fn options() -> Vec<(&'static str, Change)> {
    let mut all = options! {
        scaled: search.points, search.points_of_segments, search.quadrature_on_the_way, search.scan_depth,
            search.reserve, search.near, search.share_of_cutoff, search.moved, search.last_barrier_of_bounds,
            search.passive_share, search.deviation,
            search.lower_tolerance, search.lower_quadrature_tolerance, search.lower_last_barrier, search.lower_feasible,
            search.planned_penalty, search.largest_planned_penalty, search.same_minimum;
        count: search.most_points, search.scan, search.last_scan, search.exact_margins, search.largest_passive_size,
            search.batch, search.lower_iterations, search.segment_iterations, search.more_starts, search.most_starts,
            search.planned_segments, search.planned_degree, search.margin_checks, search.kept_ends;
        both: search.drop_ratio;
        factor: search.horizon_growth, search.planned_penalty_factor;
        fraction: search.share_of_starts;
        scaled: nlp.feasible, nlp.first_barrier, nlp.warm_barrier, nlp.last_barrier, nlp.longest_step, nlp.tangent,
            nlp.penalty, nlp.penalty_of_multipliers, nlp.row_penalty_of_multipliers,
            nlp.largest_penalty, nlp.infeasible_cost, nlp.sufficient_decrease, nlp.largest_warm_slack,
            nlp.multiplier_range, nlp.first_regularisation, nlp.smallest_regularisation, nlp.largest_regularisation,
            nlp.saddle_step;
        count: nlp.memory, nlp.max_backtracks, nlp.rounds, nlp.max_steps_without_curvature;
        fraction: nlp.fraction_to_boundary, nlp.infeasible_progress, nlp.backtracking, nlp.short_fraction,
            nlp.long_fraction, nlp.min_curvature_weight;
        shares: nlp.curvature_factors;
        factor: nlp.row_penalty_factor, nlp.penalty_factor;
        regularisation: nlp.regularisation_factors;
    }
    .to_vec();
    let rules: [(_, Change); 4] = [
        ("barrier.factor", |settings, by| monotone(settings, |rule| fraction(&mut rule.factor, by))),
        ("barrier.power", |settings, by| monotone(settings, |rule| factor(&mut rule.power, by))),
        ("barrier.done", |settings, by| monotone(settings, |rule| both(&mut rule.done, by))),
        ("barrier.stalled", |settings, by| monotone(settings, |rule| count(&mut rule.stalled, by))),
    ];
    all.extend(rules);
    all
}

/// Changes the default rule of the barrier parameter.
fn monotone(settings: &mut DirectSettings, change: impl Fn(&mut Monotone)) {
    let mut rule = Monotone::default();
    change(&mut rule);
    settings.nlp.barrier = Arc::new(rule);
}

/// Iterations and successes over all problems.
fn solved(scenarios: &[Scenario], change: impl Fn(&mut DirectSettings)) -> Result<[usize; 2], aghf::Error> {
    let mut sum = [0; 2];
    for scenario in scenarios {
        let mut settings = DirectOptions::default().settings(scenario)?;
        settings.starts = settings.starts.min(STARTS);
        change(&mut settings);
        let (problem, constraints) = (scenario.problem()?, scenario.constraints());
        let direct = Direct::new(&problem).cost(scenario.running_cost()?).constraints(&constraints);
        let solution = direct.settings(settings).solve()?;
        let success = solution.converged && solution.largest_violation <= DirectSettings::FEASIBLE;
        sum[0] += solution.iterations.len();
        sum[1] += usize::from(success);
    }
    Ok(sum)
}

fn main() -> Result<(), aghf::Error> {
    let mut names: Vec<String> = std::env::args().skip(1).filter(|name| !name.starts_with("--")).collect();
    if names.is_empty() {
        names = problems();
    }
    let scenarios = names.iter().map(|name| Scenario::load(name)).collect::<Result<Vec<_>, _>>()?;
    let cell = |[iterations, successes]: [usize; 2]| format!("{iterations} | {successes}");
    println!("Iterations and successes of {} problems, by default {}.\n", names.len(), {
        let [iterations, successes] = solved(&scenarios, |_| {})?;
        format!("{iterations} and {successes}")
    });
    println!("| option | halved: iterations | successes | doubled: iterations | successes |");
    println!("| --- | --- | --- | --- | --- |");
    for (name, change) in options() {
        // Half or twice of some options is out of range, which the cell then says.
        let [halved, doubled] = [0.5, 2.0].map(|by| {
            let found = solved(&scenarios, |settings| change(settings, by));
            found.map_or_else(|error| format!("{error} | -"), cell)
        });
        println!("| `{name}` | {halved} | {doubled} |");
    }
    Ok(())
}
