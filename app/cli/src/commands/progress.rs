//! The progress line of a solve on a terminal.

use aghf::direct::{DirectSettings, Iteration};
use aghf::error::Result;
use aghf_scenario::{Record, Scenario, SolveOptions};
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// The time between two frames of the spinner.
const TICK: Duration = Duration::from_millis(100);

/// A progress line on the terminal: a bar for the published flow, whose end is known, otherwise the starts, the best
/// motion so far and the current iteration. It is absent if the standard error is not a terminal.
pub(super) struct Progress {
    bar: ProgressBar,
    /// The requested number of starts.
    starts: usize,
    /// The number of starts begun.
    begun: usize,
    /// The least cost of a curve that satisfies the constraints.
    least: Option<f64>,
}

impl Progress {
    /// The progress line of a solve of `scenario`; `hidden` if the output has other lines, or none.
    ///
    /// # Errors
    /// The time limit is out of range.
    pub fn new(scenario: &Scenario, options: &SolveOptions, hidden: bool) -> Result<Self> {
        let (bar, starts) = match options {
            _ if hidden => (ProgressBar::hidden(), 0),
            SolveOptions::Flow(own) => (bar(own.settings(scenario)?.s_max), 1),
            SolveOptions::Rest(own) | SolveOptions::Duals(own) | SolveOptions::TwoPhases(own) => {
                let settings = own.settings(scenario, options.method())?;
                (spinner(), settings.starts)
            }
            SolveOptions::Direct(own) => (spinner(), own.settings(scenario)?.starts),
        };
        Ok(Self { bar, starts, begun: 0, least: None })
    }

    /// Updates the line with a record.
    pub fn observe(&mut self, record: &Record) {
        if self.bar.is_hidden() {
            return;
        }
        let message = match record {
            Record::Flow(r) => format!("s {:.1e}, action {:.4e}", r.s, r.action_at_nodes),
            Record::Rest(r) => {
                format!("degree {}, action {:.4e}, gradient {:.1e}", r.degree, r.action, r.gradient_norm)
            }
            Record::Direct(iteration) => self.of_direct(iteration),
        };
        self.bar.set_message(message);
        self.bar.inc(1);
    }

    /// The progress of a direct solve.
    fn of_direct(&mut self, iteration: &Iteration) -> String {
        let Iteration { cost, violation, .. } = *iteration;
        self.begun = iteration.start.map_or(self.begun, |i| self.begun.max(i + 1));
        if violation <= DirectSettings::FEASIBLE {
            self.least = Some(self.least.map_or(cost, |least| least.min(cost)));
        }
        let stage = match iteration.start {
            Some(start) => format!("start {} of {}", start + 1, self.starts.max(self.begun)),
            None => format!("horizon {:.4} s", iteration.horizon),
        };
        let best = self
            .least
            .map_or_else(|| "nothing within the constraints yet".to_owned(), |least| format!("best {least:.5e}"));
        let off = if violation > 0.0 { format!(", violation {violation:.1e}") } else { String::new() };
        format!(
            "{best}; {stage}, degree {}: cost {cost:.4e}{off}, gradient {:.1e}",
            iteration.degree, iteration.gradient_norm
        )
    }

    /// Removes the line.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

/// A spinner that turns while the program works.
fn spinner() -> ProgressBar {
    let style = ProgressStyle::with_template("{elapsed:>4} {spinner} {wide_msg}");
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(TICK);
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
}

/// A bar that advances with the values of `s` of the flow.
fn bar(s_max: f64) -> ProgressBar {
    let style = ProgressStyle::with_template("{elapsed:>4} {bar:30} {msg}");
    ProgressBar::new(aghf::flow::output_count(s_max)).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
