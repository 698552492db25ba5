//! `aghf solve`.

use super::{FAILED, print, print_json};
use crate::aghf::jacobian::JacobianKind;
use crate::error::Result;
use crate::report::{summary_table, write_outcome};
use crate::scenario::{Method, Scenario, SolveOptions, solve};
use crate::solve::Guess;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;

/// Solve a scenario and write the trajectory that was found.
///
/// `aghf scenarios` lists what is built in. Parameters that are not given are the scenario's.
#[derive(Debug, Args)]
pub(super) struct Solve {
    /// A scenario that is built in, or the path of a JSON file.
    #[arg(default_value = "kinova_free_01")]
    scenario: String,
    /// How to solve it.
    #[arg(long, value_enum, default_value_t)]
    method: Method,
    /// How to compute the Jacobian.
    #[arg(long, value_enum, default_value_t)]
    jacobian: JacobianKind,
    /// Degree of the polynomial.
    #[arg(long)]
    p: Option<usize>,
    /// Penalty on velocities that are not those of the curve.
    #[arg(long, allow_negative_numbers = true)]
    k: Option<f64>,
    /// How far the flow runs.
    #[arg(long, allow_negative_numbers = true)]
    s_max: Option<f64>,
    /// Absolute and relative tolerance of the integrator [default: 1e-4].
    #[arg(long, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// The curve to start from: a line in the whole state, or in the configuration with the velocity that goes with it.
    #[arg(long, value_enum)]
    guess: Option<Guess>,
    /// Weight of the constraints.
    #[arg(long, allow_negative_numbers = true)]
    k_cons: Option<f64>,
    /// Sharpness of the activation of the constraints.
    #[arg(long, allow_negative_numbers = true)]
    c_cons: Option<f64>,
    /// The folder for trajectory.csv and summary.json [default: out/SCENARIO].
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print the summary as JSON and nothing else.
    #[arg(long)]
    json: bool,
}

impl Default for Solve {
    /// What runs without arguments.
    fn default() -> Self {
        Self {
            scenario: "kinova_free_01".to_owned(),
            method: Method::default(),
            jacobian: JacobianKind::default(),
            p: None,
            k: None,
            s_max: None,
            tolerance: None,
            guess: None,
            k_cons: None,
            c_cons: None,
            out: None,
            json: false,
        }
    }
}

impl Solve {
    pub(super) fn run(self) -> Result<ExitCode> {
        let scenario = Scenario::load(&self.scenario)?;
        let options = SolveOptions {
            method: self.method,
            jacobian: self.jacobian,
            p: self.p,
            k: self.k,
            s_max: self.s_max,
            tolerance: self.tolerance,
            guess: self.guess,
            k_cons: self.k_cons,
            c_cons: self.c_cons,
            time_limit: None,
        };
        let progress = if self.json {
            ProgressBar::hidden()
        } else {
            progress(options.flow_settings(&scenario).s_max)
        };
        let outcome = solve(&scenario, &options, &mut |record| {
            progress.set_message(format!(
                "s {:.1e}, action {:.4e}",
                record.s, record.action_at_nodes
            ));
            progress.inc(1);
        })?;
        progress.finish_and_clear();

        let folder = self
            .out
            .unwrap_or_else(|| PathBuf::from("out").join(&scenario.name));
        let files = write_outcome(&scenario.model, &outcome, &folder)?;
        if self.json {
            print_json(&outcome.summary)?;
        } else {
            print(&summary_table(&outcome.summary))?;
            for file in files {
                print(&format!("wrote {}", file.display()))?;
            }
        }
        Ok(if outcome.summary.success {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(FAILED)
        })
    }
}

/// A bar that fills as the flow passes the values of `s` on its grid; shown when somebody watches.
fn progress(s_max: f64) -> ProgressBar {
    let style = ProgressStyle::with_template("{elapsed:>4} {bar:30} {msg}");
    ProgressBar::new(crate::solve::output_count(s_max))
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
