//! The report in Markdown.

use super::format::{distinct, figures, in_words};
use super::timing::{BATCH_SECONDS, BATCHES};
use super::{Reproduction, ScenarioResult, Search, Series, SystemResult, fit};
use crate::sweep::FlowPoint;
use aghf_scenario::Limit;

/// A table, for Markdown and for a page.
pub(super) struct Table {
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub(super) fn new(header: &[&str]) -> Self {
        Self {
            header: header.iter().map(|h| (*h).to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The table as Markdown.
    pub(super) fn text(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule: Vec<String> = self.header.iter().map(|_| "---".to_owned()).collect();
        let rows = self.rows.iter().map(|row| line(row));
        [line(&self.header), line(&rule)]
            .into_iter()
            .chain(rows)
            .collect()
    }
}

/// The text next to the table of the searches.
pub(super) const SEARCHED: &str = "Each scenario of a system was solved with every set of the grid. Best: the fastest set among those that succeed in most \
    scenarios, while other solves ran, and the one of least effort among them.\n";

/// Builds the report. Values that the supplement does not give are empty cells.
pub(super) fn report(reproduction: &Reproduction) -> String {
    let mut parts = vec!["# The paper's experiments, run anew\n".to_owned()];
    if !reproduction.searches.is_empty() {
        parts.push(searches(&reproduction.searches).text());
        parts.push(SEARCHED.to_owned());
    }
    if !reproduction.systems.is_empty() {
        parts.push(solves(&reproduction.systems).text());
        parts.push(solve_settings(reproduction));
    }
    if reproduction.has_times() {
        parts.push(times(&reproduction.series).text());
        parts.push(fits(&reproduction.series).text());
        parts.push(time_settings(reproduction));
    }
    parts.push(machine(reproduction.seconds));
    parts.join("\n")
}

/// One row per system that has a grid.
pub(super) fn searches(searches: &[Search]) -> Table {
    let mut table = Table::new(&[
        "system",
        "grid",
        "sets",
        "succeed in all scenarios",
        "solve time in all, s",
        "fastest set p, k, s_max (k_cons, c_cons)",
        "set of least effort",
    ]);
    for search in searches {
        let [fastest, least] = match &search.best {
            None => ["none succeeds".to_owned(), String::new()],
            Some(best) => best.each_ref().map(|r| {
                let FlowPoint { p, k, s_max, .. } = r.point;
                let constraints = r.point.k_cons.zip(r.point.c_cons);
                format!(
                    "{}, {:.0} %",
                    set(p, k, s_max, constraints),
                    100.0 * r.success_rate
                )
            }),
        };
        table.row([
            search.system.title.to_owned(),
            search.sweep.clone(),
            search.sets.to_string(),
            search.succeeding.to_string(),
            figures(search.solve_seconds, 3),
            fastest,
            least,
        ]);
    }
    table
}

/// One row per system and set.
pub(super) fn solves(systems: &[SystemResult]) -> Table {
    let mut table = Table::new(&[
        "system",
        "set of",
        "p, k, s_max (k_cons, c_cons)",
        "success",
        "solve, ms",
        "effort",
        "action",
        "open loop",
        "with feedback",
        "clearance, m",
        "limits broken q, v, u",
    ]);
    for system in systems {
        let results = &system.results;
        let sets = results.iter().map(|r| {
            let flow = r.file.flow;
            let constraints = r.constrained().then_some((flow.k_cons, flow.c_cons));
            set(flow.p, flow.k, flow.s_max, constraints)
        });
        let good: Vec<&ScenarioResult> = results.iter().filter(|r| r.success).collect();
        let mean_of_good = |f: fn(&ScenarioResult) -> f64| match good.len() {
            0 => String::new(),
            count => figures(good.iter().map(|r| f(r)).sum::<f64>() / count as f64, 4),
        };
        let seconds = results.iter().map(|r| r.solve_seconds).sum::<f64>() / results.len() as f64;
        let clearances = results
            .iter()
            .filter_map(|r| r.feasibility.smallest_clearance_m);
        let breaking = [Limit::Position, Limit::Velocity, Limit::Torque].map(|limit| {
            let breaking = results.iter().filter(|r| r.joints_beyond(limit) > 0);
            breaking.count().to_string()
        });
        table.row([
            system.system.title.to_owned(),
            system.origins(),
            distinct(sets, "; "),
            format!("{}/{}", good.len(), results.len()),
            figures(1e3 * seconds, 2),
            mean_of_good(|r| r.effort),
            mean_of_good(|r| r.action),
            worst(results, |r| r.open_loop_error),
            worst(results, |r| r.feedback_error),
            clearances
                .min_by(f64::total_cmp)
                .map_or_else(String::new, |m| format!("{m:.3}")),
            breaking.join(", "),
        ]);
    }
    table
}

pub(super) fn solve_settings(reproduction: &Reproduction) -> String {
    let results = || reproduction.systems.iter().flat_map(|s| &s.results);
    let gains = (reproduction.systems.iter()).flat_map(|s| {
        s.results.iter().map(|r| {
            let feedback = r.file.feedback;
            let name = s.system.title.split(',').next().unwrap_or_default();
            format!("{name} {}, {}", feedback.kp, feedback.kv)
        })
    });
    format!(
        "Sets: the paper's best, our own in the scenarios, the best of a grid. Success: at the goal with feedback, hitting nothing. \
        Solve time: median of {} runs after one more, or of one where it fails, mean over the scenarios. Effort (integral of |u|^2) and action, on 2001 times: \
        mean over the scenarios that succeed. Errors: the largest entry of the final-state error, worst scenario. Clearance: the \
        smallest distance from an obstacle, negative in a collision, worst scenario; of the joint frames in the paper's scenarios, of \
        the links in the families made to be harder. Limits broken: in how many scenarios a joint exceeds its limits of position, velocity \
        and torque, none of which is enforced here.\n\
        Tolerance {}, guess {}, horizon {} s, success below {}, feedback gains: {}. The supplement prints the best sets, which \
        by its definition succeed, and no other number of these columns.\n",
        reproduction.settings.repetitions,
        distinct(results().map(|r| format!("{:e}", r.tolerance)), ", "),
        distinct(results().map(|r| r.file.flow.guess.to_string()), ", "),
        distinct(results().map(|r| r.file.horizon_s.to_string()), ", "),
        distinct(
            results().map(|r| r.file.success_threshold.to_string()),
            ", "
        ),
        distinct(gains, "; "),
    )
}

/// Means and standard deviations by the number of joints.
pub(super) fn times(series: &[Series]) -> Table {
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
    table
}

/// The growth with the number of joints.
pub(super) fn fits(series: &[Series]) -> Table {
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
    table
}

pub(super) fn time_settings(reproduction: &Reproduction) -> String {
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

/// The machine and the build.
pub(super) fn machine(seconds: f64) -> String {
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

/// The name of the processor, if the system provides it like Linux.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn set(p: usize, k: f64, s_max: f64, constraints: Option<(f64, f64)>) -> String {
    let constraints = constraints.map(|(k_cons, c_cons)| format!(" ({k_cons:e}, {c_cons})"));
    format!("{p}, {k:e}, {s_max}{}", constraints.unwrap_or_default())
}

/// The largest error, or a remark that a simulation stopped.
fn worst(results: &[ScenarioResult], error: fn(&ScenarioResult) -> Option<f64>) -> String {
    let errors: Option<Vec<f64>> = results.iter().map(error).collect();
    errors.map_or_else(
        || "stopped".to_owned(),
        |errors| figures(errors.into_iter().fold(0.0, f64::max), 2),
    )
}
