//! `aghf solve`.

use super::choice::choice;
use super::{FAILED, RobotArgs, print, print_json};
use crate::error::{Error, Result};
use crate::flow::jacobian::JacobianKind;
use crate::motion::Guess;
use crate::ode::IntegratorKind;
use crate::output::{summary_table, write_report};
use crate::relax::Iteration;
use crate::scenario::{Method, Record, SolveOptions, solve};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Solve a scenario and write the trajectory that was found.
///
/// `aghf scenarios` lists what is built in. Parameters of the flow that are not given are the scenario's.
#[derive(Debug, Args)]
pub(super) struct Solve {
    /// A scenario that is built in, or the path of a JSON file.
    #[arg(default_value = "kinova_free_01")]
    scenario: String,
    #[command(flatten)]
    robot: RobotArgs,
    /// How to solve it.
    #[arg(long, value_parser = choice::<Method>(), default_value_t)]
    method: Method,
    /// Degree of the polynomial, or of each segment [default: 16 for relax].
    #[arg(long, alias = "p")]
    degree: Option<usize>,
    /// Of relax: of how many polynomials on equal parts of the horizon the motion is made [default: 1].
    #[arg(long, alias = "pieces")]
    segments: Option<usize>,
    /// Of relax: go on to higher degrees until the effort changes by less than this part of it from one to the next, such as 0.01.
    #[arg(long, alias = "adaptive", allow_negative_numbers = true)]
    degree_tolerance: Option<f64>,
    /// Of relax: the relative gradient norm at the end. Of flow: the tolerance of the integrator [default: 1e-8, 1e-4].
    #[arg(long, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Of relax: how many starts to try [default: 16 up to 7 joints and fewer beyond, 1 within limits of the joints; more while none ends within the constraints].
    #[arg(long)]
    starts: Option<usize>,
    /// Of relax: try starts for so long, s, and keep the best. Of flow: stop after that, as a failure.
    #[arg(long)]
    seconds: Option<f64>,
    /// Of relax: how many threads work on starts, with the same result [default: all cores].
    #[arg(long)]
    threads: Option<usize>,
    /// Of flow: how to compute the Jacobian [default: control-form].
    #[arg(long, value_parser = choice::<JacobianKind>())]
    jacobian: Option<JacobianKind>,
    /// Of flow: what integrates it [default: bdf].
    #[arg(long, value_parser = choice::<IntegratorKind>())]
    integrator: Option<IntegratorKind>,
    /// Of flow: penalty on velocities that are not those of the curve.
    #[arg(long, allow_negative_numbers = true)]
    k: Option<f64>,
    /// Of flow: how far it runs.
    #[arg(long, allow_negative_numbers = true)]
    s_max: Option<f64>,
    /// Of flow: the curve to start from, a line in the whole state or in the configuration with the velocity that goes with it.
    #[arg(long, value_parser = choice::<Guess>())]
    guess: Option<Guess>,
    /// Of flow: weight of the constraints.
    #[arg(long, allow_negative_numbers = true)]
    k_cons: Option<f64>,
    /// Of flow: sharpness of the activation of the constraints.
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
            robot: RobotArgs::default(),
            method: Method::default(),
            degree: None,
            segments: None,
            degree_tolerance: None,
            tolerance: None,
            starts: None,
            seconds: None,
            threads: None,
            jacobian: None,
            integrator: None,
            k: None,
            s_max: None,
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
        let scenario = self.robot.scenario(&self.scenario)?;
        let duration = |seconds| {
            Duration::try_from_secs_f64(seconds).map_err(|_| {
                let condition = format!("it is {seconds}, a time that is not negative is needed");
                Error::input("options", "seconds", condition)
            })
        };
        let time_limit = self.seconds.map(duration).transpose()?;
        let options = SolveOptions {
            method: self.method,
            degree: self.degree,
            segments: self.segments,
            degree_tolerance: self.degree_tolerance,
            tolerance: self.tolerance,
            num_starts: self.starts,
            jacobian: self.jacobian,
            integrator: self.integrator,
            k: self.k,
            s_max: self.s_max,
            guess: self.guess,
            k_cons: self.k_cons,
            c_cons: self.c_cons,
            threads: self.threads,
            time_limit,
        };
        let progress = if self.json {
            ProgressBar::hidden()
        } else {
            match self.method {
                Method::Flow => bar(options.flow_settings(&scenario).s_max),
                Method::Relax => ProgressBar::new_spinner(),
            }
        };
        let outcome = solve(&scenario, &options, &mut |record| {
            progress.set_message(message(&record));
            progress.inc(1);
        })?;
        progress.finish_and_clear();

        let folder = self
            .out
            .unwrap_or_else(|| PathBuf::from("out").join(&scenario.name));
        let files = write_report(&scenario.model, &outcome, &folder)?;
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

/// How far a solve has come.
fn message(record: &Record) -> String {
    match record {
        Record::Flow(r) => format!("s {:.1e}, action {:.4e}", r.s, r.action_at_nodes),
        Record::Relax(i) => {
            let Iteration { degree, cost, .. } = i;
            format!(
                "degree {degree}, cost {cost:.4e}, gradient {:.1e}",
                i.gradient_norm
            )
        }
    }
}

/// A bar that fills as the flow passes the values of `s` on its grid; shown when somebody watches.
fn bar(s_max: f64) -> ProgressBar {
    let style = ProgressStyle::with_template("{elapsed:>4} {bar:30} {msg}");
    ProgressBar::new(crate::flow::output_count(s_max))
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
