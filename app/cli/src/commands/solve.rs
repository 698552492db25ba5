//! `aghf solve`.

use super::choice::choice;
use super::output::{OutArgs, SamplingArgs};
use super::progress::Progress;
use super::stages::Stages;
use super::{FAILED, RobotArgs, print, print_json, signals, tell};
use crate::output::{OutputFolder, REPORT_FILES, summary_table, write_report};
use crate::report::{Motion, page};
use aghf::error::{Error, Result, plain};
use aghf::flow::jacobian::JacobianKind;
use aghf::motion::Guess;
use aghf::ode::IntegratorKind;
use aghf::relax::PlannedStarts;
use aghf_scenario::{FlowVariant, Method, SolveOptions, solve};
use clap::Args;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Solve a scenario and write the trajectory.
///
/// `aghf scenarios` lists the built-in scenarios. The default parameters of the flow are those of the scenario. A new
/// folder, out/SCENARIO or out/SCENARIO-2 and so on, gets trajectory.csv (t in s, then q, v, a and u of every joint;
/// for more rows see `aghf sample`), summary.json, from which the solve can be repeated, and report.html, a page that
/// shows the motion (`aghf view` opens it). If the solve fails they are called trajectory.failed.csv and so on, next to
/// those of an earlier success. Ctrl-C ends the search with the best motion so far.
#[derive(Debug, Args)]
pub(super) struct Solve {
    /// A built-in scenario, or the path of a JSON file, "-" for the standard input: a scenario, or the summary.json of
    /// a solve, which is repeated.
    #[arg(default_value = "kinova_table_01")]
    scenario: String,
    #[command(flatten)]
    robot: RobotArgs,
    /// Method [default: relax].
    #[arg(long, value_parser = choice::<Method>())]
    method: Option<Method>,
    /// For flow: the variant [default: published].
    #[arg(long, value_parser = choice::<FlowVariant>())]
    variant: Option<FlowVariant>,
    /// Degree of the polynomial, or of each segment [default: 16; the scenario's for the published flow; 8 with passive
    /// joints].
    #[arg(long, alias = "p")]
    degree: Option<usize>,
    /// For relax and the flow to rest: number of polynomials on equal parts of the horizon [default: 1, 8 with passive
    /// joints].
    #[arg(long, alias = "pieces")]
    segments: Option<usize>,
    /// For relax: increase the degree until the relative change of the effort is below this value, such as 0.01.
    #[arg(long, alias = "adaptive", allow_negative_numbers = true)]
    degree_tolerance: Option<f64>,
    /// For relax: the relative gradient norm at the end. For flow: the tolerance of the integrator [default: 1e-8,
    /// 1e-4].
    #[arg(long, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// For relax and the flow to rest: number of starts [default: for relax 16 up to 7 joints and fewer beyond, 1
    /// within limits of the joints; for the flow 1; 40 with passive joints; more while none ends within the
    /// constraints].
    #[arg(long)]
    starts: Option<usize>,
    /// For relax and the flow to rest: seed of the starts [default: 0].
    #[arg(long)]
    seed: Option<u64>,
    /// For relax: the starts that follow planned paths around obstacles [default: later].
    #[arg(long, value_parser = choice::<PlannedStarts>())]
    planned_starts: Option<PlannedStarts>,
    /// Time limit, s, after which the search stops with the best motion so far, as by Ctrl-C. Until then relax tries
    /// further starts.
    #[arg(long)]
    seconds: Option<f64>,
    /// For relax: number of threads for the starts, with the same result [default: all cores].
    #[arg(long)]
    threads: Option<usize>,
    /// For flow: method of computing the Jacobian [default: control-form].
    #[arg(long, value_parser = choice::<JacobianKind>())]
    jacobian: Option<JacobianKind>,
    /// For flow: the integrator [default: bdf].
    #[arg(long, value_parser = choice::<IntegratorKind>())]
    integrator: Option<IntegratorKind>,
    /// For flow: penalty on velocities that differ from those of the curve.
    #[arg(long, allow_negative_numbers = true)]
    k: Option<f64>,
    /// For flow: value of s at which it stops.
    #[arg(long, allow_negative_numbers = true)]
    s_max: Option<f64>,
    /// For flow: the initial curve, a line in the whole state or in the configuration with the corresponding velocity.
    #[arg(long, value_parser = choice::<Guess>())]
    guess: Option<Guess>,
    /// For flow: weight of the constraints.
    #[arg(long, allow_negative_numbers = true)]
    k_cons: Option<f64>,
    /// For flow: sharpness of the activation of the constraints.
    #[arg(long, allow_negative_numbers = true)]
    c_cons: Option<f64>,
    #[command(flatten)]
    sampling: SamplingArgs,
    #[command(flatten)]
    out: OutArgs,
    /// Do not write report.html, the page that shows the motion.
    #[arg(long)]
    no_report: bool,
    /// Print only the summary, as JSON.
    #[arg(long)]
    json: bool,
    /// Print a line for every stage of the search to the standard error.
    #[arg(long, short)]
    verbose: bool,
}

impl Default for Solve {
    /// The solve of the program without arguments.
    fn default() -> Self {
        Self {
            scenario: "kinova_table_01".to_owned(),
            robot: RobotArgs::default(),
            method: None,
            variant: None,
            degree: None,
            segments: None,
            degree_tolerance: None,
            tolerance: None,
            starts: None,
            seed: None,
            planned_starts: None,
            seconds: None,
            threads: None,
            jacobian: None,
            integrator: None,
            k: None,
            s_max: None,
            guess: None,
            k_cons: None,
            c_cons: None,
            sampling: SamplingArgs::default(),
            out: OutArgs::default(),
            no_report: false,
            json: false,
            verbose: false,
        }
    }
}

impl Solve {
    pub(super) fn run(self) -> Result<ExitCode> {
        let (scenario, repeated) = self.robot.scenario_with_options(&self.scenario)?;
        let options = self.options(repeated)?;
        let sampling = self.sampling.sampling();
        // Better to learn now than in the end that it cannot be written.
        let longest = scenario.file.free_horizon.map(|free| free.longest_s);
        let _ = sampling.times(longest.unwrap_or(scenario.file.horizon_s))?;
        let default = Path::new("out").join(&scenario.name);
        let folder = self.out.folder(&default, &REPORT_FILES)?;
        signals::stop_first(&options.interrupt);
        let hidden = self.json || self.verbose;
        let mut progress = Progress::new(&scenario, &options, hidden);
        let mut stages = Stages::default();
        let outcome = solve(&scenario, &options, &mut |record| {
            if self.verbose {
                stages.observe(record);
            }
            progress.observe(record);
        })?;
        stages.finish();
        progress.finish();

        let model = &scenario.model;
        let page = match self.no_report {
            true => None,
            false => Some(page(&[Motion::of_report(&scenario, &outcome)])?),
        };
        let page = page.as_deref();
        let files = write_report(model, &outcome, page, &folder, sampling).or_else(|error| {
            // A motion is not lost because the folder is gone, full, or taken by another process meanwhile.
            tell(&format!("aghf: {error}"));
            let spare = OutputFolder::private(&scenario.name)?;
            tell(&format!(
                "aghf: the files are in {}",
                spare.path().display()
            ));
            write_report(model, &outcome, page, &spare, sampling)
        })?;
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

    /// The given options, completed by those of the repeated solve if that used the same method.
    fn options(&self, repeated: SolveOptions) -> Result<SolveOptions> {
        let duration = |seconds| {
            Duration::try_from_secs_f64(seconds).map_err(|_| {
                let seconds = plain(seconds);
                let condition = format!("it is {seconds}, a time that is not negative is needed");
                Error::input("options", "seconds", condition)
            })
        };
        let time_limit = self.seconds.map(duration).transpose()?;
        let method = self.method.unwrap_or(repeated.method);
        let other = if method == repeated.method {
            repeated
        } else {
            SolveOptions::default()
        };
        Ok(SolveOptions {
            method,
            variant: self.variant.or(other.variant),
            degree: self.degree.or(other.degree),
            segments: self.segments.or(other.segments),
            degree_tolerance: self.degree_tolerance.or(other.degree_tolerance),
            tolerance: self.tolerance.or(other.tolerance),
            num_starts: self.starts.or(other.num_starts),
            jacobian: self.jacobian.or(other.jacobian),
            integrator: self.integrator.or(other.integrator),
            k: self.k.or(other.k),
            s_max: self.s_max.or(other.s_max),
            guess: self.guess.or(other.guess),
            k_cons: self.k_cons.or(other.k_cons),
            c_cons: self.c_cons.or(other.c_cons),
            threads: self.threads.or(other.threads),
            seed: self.seed.or(other.seed),
            planned_starts: self.planned_starts.or(other.planned_starts),
            time_limit: time_limit.or(other.time_limit),
            interrupt: other.interrupt,
        })
    }
}
