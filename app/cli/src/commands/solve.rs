//! `aghf solve`.

use super::compare::summary_at;
use super::options::OptionArgs;
use super::output::{OutArgs, SamplingArgs, spare};
use super::progress::Progress;
use super::stages::Stages;
use super::sweep::{solve_missing, summary};
use super::{FAILED, RobotArgs, print, print_json, signals, tell, tell_notes_of};
use crate::output::{OutputFolder, REPORT_FILES, summary_table, walk_table, write_report};
use crate::report::{Motion, page};
use crate::sweep::{Motions, Row, RowOutcome, Shard, Sweep};
use aghf::error::{Error, Result};
use aghf::motion::Interrupt;
use aghf_scenario::{Solve, SolveOptions, Solved, Walk};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// The time after which a search stops with the best motion so far unless `--time-limit-s` is given: a
/// minute, after which few people still wait.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// Solves a scenario, or several, and writes the trajectories.
///
/// `aghf scenarios` lists the built-in scenarios. The default parameters of the flow are those of the scenario. A new
/// folder, out/SCENARIO or out/SCENARIO-2 and so on, gets trajectory.csv (t in s, then q, v, a and u of every joint;
/// for more rows see `aghf sample`), summary.json, from which the solve can be repeated, and report.html, a page that
/// shows the motion (`aghf view` opens it). The verdict is optimal; valid, if the motion keeps everything but the
/// search has not converged; at s_max, the curve at the end of the published flow with its dynamics defect; or not
/// valid, with the worst violations: then the files are called trajectory.failed.csv and so on, next to those of an
/// earlier motion. Ctrl-C, or a limit of 60 s unless --time-limit-s is given, ends the search with the best motion so
/// far. A walk, a scenario with phases, gets a folder of such files per phase: phase_1 and so on.
///
/// Several scenarios, or folders of them, are solved on all cores: out/NAME, with the name of the folder if it is one,
/// gets results.csv with a row per problem, also for one that is refused, with the reason, and the usual folder for
/// each motion. The same command after an interruption solves what has no row yet.
#[derive(Debug, Args)]
pub(super) struct SolveArgs {
    /// A built-in scenario, or the path of a JSON file, "-" for the standard input: a scenario, or the summary.json of
    /// a solve, which is repeated. Several, or folders of scenarios, get a table of results.
    #[arg(default_value = "kinova_table_01")]
    scenario: Vec<String>,
    /// The number of problems that are solved at the same time, of several [default: number of cores].
    #[arg(long)]
    jobs: Option<usize>,
    #[command(flatten)]
    robot: RobotArgs,
    #[command(flatten)]
    options: OptionArgs,
    /// Starts from the motion of another solve, its folder or summary.json, instead of from several starts; goal,
    /// obstacles and limits may be others. For direct.
    #[arg(long, value_name = "RUN")]
    start: Option<PathBuf>,
    #[command(flatten)]
    sampling: SamplingArgs,
    #[command(flatten)]
    out: OutArgs,
    /// Leaves out report.html, the page that shows the motion.
    #[arg(long)]
    no_report: bool,
    /// Prints only the summary, as JSON.
    #[arg(long)]
    json: bool,
    /// Prints the numbers of the method, too, and a line for every stage of the search to the standard error.
    #[arg(long, short)]
    verbose: bool,
}

impl Default for SolveArgs {
    /// The solve of the program without arguments.
    fn default() -> Self {
        Self {
            scenario: vec!["kinova_table_01".to_owned()],
            jobs: None,
            robot: RobotArgs::default(),
            options: OptionArgs::default(),
            start: None,
            sampling: SamplingArgs::default(),
            out: OutArgs::default(),
            no_report: false,
            json: false,
            verbose: false,
        }
    }
}

impl SolveArgs {
    pub(super) fn run(mut self) -> Result<ExitCode> {
        let one = match &self.scenario[..] {
            [one] if !Path::new(one).is_dir() => one,
            _ => return self.run_many(),
        };
        let (scenario, repeated) = self.robot.scenario_with_options(one)?;
        let options = std::mem::take(&mut self.options).over(&repeated)?;
        let sampling = self.sampling.sampling();
        // Tested now, so that a table that cannot be written is an error before the search.
        if let Some(sampling) = sampling {
            let longest = scenario.horizon_bounds().map(|free| free.longest_s);
            let _ = sampling.times(longest.unwrap_or(scenario.file.horizon_s))?;
        }
        let folder = (self.out).folder(Path::new("out"), &scenario.name, &REPORT_FILES)?;
        let folders = phase_folders(&folder, scenario.file.phases.len())?;
        let interrupt = if options.keys()?.contains_key("time_limit_s") {
            Interrupt::default()
        } else {
            Interrupt::after(TIME_LIMIT)
        };
        signals::stop_first(&interrupt);
        let hidden = self.json || self.verbose;
        let mut progress = Progress::new(&scenario, &options, hidden)?;
        let mut stages = Stages::default();
        let start = self.start.as_deref();
        let start = start.map(|run| Solved::load(&summary_at(run)?));
        let start = start.transpose()?;
        let mut solve = Solve::new(&scenario).options(options).interrupt(interrupt);
        if let Some(start) = &start {
            solve = solve.start(start);
        }
        let solve = solve.observe(|record| {
            if self.verbose {
                stages.observe(record);
            }
            progress.observe(record);
        });
        if !scenario.file.phases.is_empty() {
            let walk = solve.run_walk()?;
            stages.finish();
            progress.finish();
            return self.write_walk(&walk, &folders, &scenario.name);
        }
        let outcome = solve.run()?;
        stages.finish();
        progress.finish();

        let page = if self.no_report { None } else { Some(page(&[Motion::of_report(&scenario, &outcome)])?) };
        let page = page.as_deref();
        let files = write_report(&scenario, &outcome, page, &folder, sampling).or_else(|error| {
            let spare = spare(&error, &scenario.name)?;
            write_report(&scenario, &outcome, page, &spare, sampling)
        })?;
        if self.json {
            print_json(&outcome.summary)?;
        } else {
            print(&summary_table(&outcome.summary, self.verbose))?;
            let names = files.iter().filter_map(|file| file.file_name()).map(|name| name.to_string_lossy());
            let folder = files.first().and_then(|file| file.parent()).unwrap_or(Path::new(""));
            print(&format!("wrote {} in {}", names.collect::<Vec<_>>().join(", "), folder.display()))?;
        }
        Ok(code(outcome.summary.success))
    }

    /// Solves several problems: a sweep that keeps its motions.
    fn run_many(self) -> Result<ExitCode> {
        let given = [self.start.is_some(), self.out.replaces(), self.verbose];
        if let Some((option, _)) = ["--start", "--force", "--verbose"].iter().zip(given).find(|(_, given)| *given) {
            return Err(Error::input("solve", *option, "it is for one scenario, and there are several"));
        }
        let began = Instant::now();
        let name = match &self.scenario[..] {
            [folder] => Path::new(folder).canonicalize().map_err(|e| Error::io(folder, e))?,
            _ => PathBuf::from("problems"),
        };
        let name = name.file_name().unwrap_or_default().to_string_lossy();
        let options = self.options.over(&SolveOptions::default())?;
        let mut sweep = Sweep::from_scenarios(&name, self.scenario, &self.robot.given(), &options)?;
        tell_notes_of(sweep.scenarios());
        let folder = self.out.path().map_or_else(|| Path::new("out").join(&sweep.name), Path::to_owned);
        let sampling = self.sampling.sampling();
        sweep.motions = Some(Motions { folder: folder.clone(), sampling, with_page: !self.no_report });
        let (rows, table) = solve_missing(&sweep, Shard::WHOLE, &folder, self.jobs)?;
        let is_solved = |row: &&Row| row.outcome == RowOutcome::Success;
        if self.json {
            print_json(&rows)?;
        } else {
            for row in rows.iter().filter(|row| !is_solved(row)) {
                let reason = row.reason.as_deref().unwrap_or_default();
                tell(&format!("{}: {}: {reason}", row.scenario, row.outcome.name()));
            }
            print(&format!("wrote {}", table.display()))?;
            print(&summary(&rows, began.elapsed(), &folder))?;
        }
        Ok(code(rows.iter().all(|row| is_solved(&row))))
    }

    /// Writes the files of a walk, a folder per phase, and prints the result.
    fn write_walk(&self, walk: &Walk, folders: &[OutputFolder], name: &str) -> Result<ExitCode> {
        let written = self.write_phases(walk, folders);
        let folder = written.or_else(|error| {
            let spare = spare(&error, name)?;
            self.write_phases(walk, &phase_folders(&spare, walk.phases.len())?)
        })?;
        if self.json {
            let summaries = walk.phases.iter().map(|(_, outcome)| &outcome.summary);
            let phases: Vec<_> = summaries.collect();
            print_json(&serde_json::json!({ "phases": phases, "landings": walk.landings }))?;
        } else {
            print(&walk_table(walk))?;
            print(&format!("wrote {}", folder.join("phase_*").display()))?;
        }
        Ok(code(walk.is_valid()))
    }

    /// Writes the files of the phases; returns the folder that has theirs.
    fn write_phases(&self, walk: &Walk, folders: &[OutputFolder]) -> Result<PathBuf> {
        for ((phase, outcome), folder) in walk.phases.iter().zip(folders) {
            let page = if self.no_report { None } else { Some(page(&[Motion::of_report(phase, outcome)])?) };
            let sampling = self.sampling.sampling();
            write_report(phase, outcome, page.as_deref(), folder, sampling)?;
        }
        let parent = folders.first().and_then(|folder| folder.path().parent());
        Ok(parent.unwrap_or(Path::new("")).to_owned())
    }
}

/// The folders of the phases of a walk in another one.
fn phase_folders(folder: &OutputFolder, phases: usize) -> Result<Vec<OutputFolder>> {
    let path = |k: usize| folder.path().join(format!("phase_{k}"));
    let further = path(phases + 1);
    if phases > 0 && further.exists() {
        let condition = "it is of a longer walk, whose phases would be mistaken for those of this one";
        return Err(Error::input(further.display().to_string(), "output", condition));
    }
    let open = |k| OutputFolder::open(&path(k), &REPORT_FILES, folder.replaces());
    (1..=phases).map(open).collect()
}

/// The exit code of a solve.
fn code(success: bool) -> ExitCode {
    if success { ExitCode::SUCCESS } else { ExitCode::from(FAILED) }
}
