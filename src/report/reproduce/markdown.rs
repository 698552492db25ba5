//! The report.

use super::timing::{BATCH_SECONDS, BATCHES};
use super::words::{distinct, figures, in_words};
use super::{Reproduction, ScenarioResult, Series, SystemResult, fit};
use crate::report::table::choice;
use crate::scenario::FlowParameters;

/// A table of Markdown.
struct Table(String);

impl Table {
    fn new(header: &[&str]) -> Self {
        let mut table = Self(String::new());
        table.row(header.iter().map(|h| (*h).to_owned()));
        table.row(header.iter().map(|_| "---".to_owned()));
        table
    }

    fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.0.push('|');
        for cell in cells {
            self.0.push_str(&format!(" {cell} |"));
        }
        self.0.push('\n');
    }
}

/// The whole report. What the supplement does not tell has an empty cell.
pub(super) fn report(reproduction: &Reproduction) -> String {
    let mut parts = vec!["# The paper's experiments, run anew\n".to_owned()];
    if !reproduction.systems.is_empty() {
        parts.push(solves(&reproduction.systems));
        parts.push(solve_settings(reproduction));
    }
    if reproduction.has_times() {
        parts.push(times(&reproduction.series));
        parts.push(fits(&reproduction.series));
        parts.push(time_settings(reproduction));
    }
    parts.push(machine(reproduction.seconds));
    parts.join("\n")
}

/// One row for each system and origin of its sets.
fn solves(systems: &[SystemResult]) -> String {
    let mut table = Table::new(&[
        "system",
        "set p, k, s_max",
        "paper's best set",
        "success",
        "solve, ms",
        "effort",
        "action",
        "open loop",
        "with feedback",
    ]);
    for system in systems {
        let results = &system.results;
        let paper = system.system.paper.map(|s| set(s.p, s.k, s.s_max));
        let sets = results.iter().map(|r| {
            let FlowParameters { p, k, s_max, .. } = r.file.flow;
            set(p, k, s_max)
        });
        let mean = |f: fn(&ScenarioResult) -> f64| {
            results.iter().map(f).sum::<f64>() / results.len() as f64
        };
        let successes = results.iter().filter(|r| r.success).count();
        table.row([
            system.system.title.to_owned(),
            distinct(sets, "; "),
            paper.unwrap_or_default(),
            format!("{successes}/{}", results.len()),
            figures(1e3 * mean(|r| r.solve_seconds), 2),
            figures(mean(|r| r.effort), 4),
            figures(mean(|r| r.action), 4),
            worst(results, |r| r.open_loop_error),
            worst(results, |r| r.feedback_error),
        ]);
    }
    table.0
}

fn solve_settings(reproduction: &Reproduction) -> String {
    let results = || reproduction.systems.iter().flat_map(|s| &s.results);
    let gains = (reproduction.systems.iter()).flat_map(|s| {
        s.results.iter().map(|r| {
            let feedback = r.file.feedback;
            let name = s.system.title.split(',').next().unwrap_or_default();
            format!("{name} {}, {}", feedback.kp, feedback.kv)
        })
    });
    format!(
        "Solve time: median of {} runs after one more, mean over the scenarios. Effort (integral of |u|^2) and action: mean on 2001 \
        times. Errors: the largest entry of the final-state error, worst scenario.\n\
        Tolerance {}, guess {}, horizon {} s, success below {}, feedback gains: {}. The supplement prints the best sets, which \
        by its definition succeed, and no other number of these columns.\n",
        reproduction.settings.repetitions,
        distinct(results().map(|r| format!("{:e}", r.tolerance)), ", "),
        distinct(results().map(|r| choice(&r.file.flow.guess)), ", "),
        distinct(results().map(|r| r.file.horizon_s.to_string()), ", "),
        distinct(
            results().map(|r| r.file.success_threshold.to_string()),
            ", "
        ),
        distinct(gains, "; "),
    )
}

/// Means and deviations by the number of joints.
fn times(series: &[Series]) -> String {
    let robots = series.first().map_or(&[][..], |s| &s.points);
    let header: Vec<String> = robots.iter().map(|(_, n, _)| format!("N = {n}")).collect();
    let first = ["microseconds a call at one node"];
    let header: Vec<&str> = first
        .into_iter()
        .chain(header.iter().map(String::as_str))
        .collect();
    let mut table = Table::new(&header);
    for series in series {
        let cells = series.points.iter().map(|(_, _, t)| {
            format!(
                "{} ± {} ({})",
                figures(1e6 * t.mean, 3),
                figures(1e6 * t.deviation, 1),
                figures(1e6 * t.median, 3)
            )
        });
        let name = format!(
            "{} (Figure {})",
            series.quantity.name(),
            series.quantity.figure()
        );
        table.row(std::iter::once(name).chain(cells));
    }
    table.0
}

/// The growth with the number of joints.
fn fits(series: &[Series]) -> String {
    let mut table = Table::new(&[
        "growth",
        "polynomial of least squares, microseconds",
        "its last term at the largest N",
        "power law",
        "paper, Figures 4 and 5",
    ]);
    for series in series {
        let polynomial = series.polynomial();
        let largest = series.means().last().map_or(0.0, |p| p.0);
        let share = polynomial.as_deref().and_then(|c| {
            let last = c.last()? * largest.powi(series.quantity.degree() as i32);
            Some(format!("{:.0} %", 100.0 * last / fit::value(c, largest)))
        });
        let power = series
            .power_law()
            .map(|(factor, exponent)| format!("{} N^{exponent:.2}", figures(factor, 2)));
        table.row([
            series.quantity.name().to_owned(),
            polynomial.as_deref().map(in_words).unwrap_or_default(),
            share.unwrap_or_default(),
            power.unwrap_or_default(),
            series.quantity.paper().unwrap_or_default().to_owned(),
        ]);
    }
    table.0
}

fn time_settings(reproduction: &Reproduction) -> String {
    let robots = reproduction.series.first().map_or(&[][..], |s| &s.points);
    let names: Vec<&str> = robots.iter().map(|(name, ..)| name.as_str()).collect();
    format!(
        "Mean ± standard deviation (median) over {} random configurations (seed {}) of {}; the time of a configuration is that of \
        the fastest of {BATCHES} batches of calls, each of about {} microseconds or more. Polynomial and power are fitted to the means; no fit, empty \
        cell: too few robots.\n",
        reproduction.settings.configurations,
        reproduction.settings.seed,
        names.join(", "),
        1e6 * BATCH_SECONDS,
    )
}

/// What this ran on.
fn machine(seconds: f64) -> String {
    let profile = if cfg!(debug_assertions) {
        "a development build, not for comparison"
    } else {
        "a release build"
    };
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let cores = if cores == 0 {
        String::new()
    } else {
        format!(" of {cores}")
    };
    format!(
        "aghf {}, {profile}, one core{cores} of {}, {} s in all.\n",
        env!("CARGO_PKG_VERSION"),
        processor().as_deref().unwrap_or("an unknown processor"),
        figures(seconds, 2)
    )
}

/// The name of the processor, where the system tells it the way Linux does.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn set(p: usize, k: f64, s_max: f64) -> String {
    format!("{p}, {k:e}, {s_max}")
}

/// The largest error, or that a simulation stopped.
fn worst(results: &[ScenarioResult], error: fn(&ScenarioResult) -> Option<f64>) -> String {
    let errors: Option<Vec<f64>> = results.iter().map(error).collect();
    errors.map_or_else(
        || "stopped".to_owned(),
        |errors| figures(errors.into_iter().fold(0.0, f64::max), 2),
    )
}
