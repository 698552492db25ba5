//! `aghf tradeoff`.

use super::options::OptionArgs;
use super::output::{OutArgs, spare};
use super::progress::Progress;
use super::{FAILED, RobotArgs, print, signals};
use crate::output::{tradeoff_rows, tradeoff_table, write_tradeoff};
use crate::report::tradeoff_page;
use aghf::error::{Error, Result};
use aghf::motion::Interrupt;
use aghf_scenario::{SolveOptions, Tradeoff};
use clap::Args;
use std::path::Path;
use std::process::ExitCode;

/// Shows the trade-off between duration and effort: motions of a scenario from the least duration to the least effort.
///
/// Each motion is found from the one before, so that twenty take about as long as a few solves; the objective of the
/// scenario has no effect. A new folder, out/tradeoff/SCENARIO, gets tradeoff.csv, report.html, a page with the curve
/// on which a click chooses the motion, and a summary_NN.json of each motion, for `aghf sample` and `aghf export`.
/// Ctrl-C ends the search with the motions so far.
#[derive(Debug, Args)]
pub(super) struct TradeoffArgs {
    /// A built-in scenario, or the path of a JSON file, "-" for the standard input.
    scenario: String,
    #[command(flatten)]
    robot: RobotArgs,
    /// Number of motions.
    #[arg(long, default_value_t = Tradeoff::POINTS)]
    points: usize,
    #[command(flatten)]
    options: OptionArgs,
    #[command(flatten)]
    out: OutArgs,
}

impl TradeoffArgs {
    pub(super) fn run(self) -> Result<ExitCode> {
        let scenario = self.robot.scenario(&self.scenario)?;
        let options = self.options.over(&SolveOptions::default())?;
        let SolveOptions::Direct(own) = &options else {
            let condition = format!("supported by the method 'direct' only, not by '{}'", options.method());
            return Err(Error::input(&scenario.name, "tradeoff", condition));
        };
        let files = ["tradeoff.csv", "report.html"];
        let folder = self.out.folder(Path::new("out/tradeoff"), &scenario.name, &files)?;
        let interrupt = Interrupt::default();
        signals::stop_first(&interrupt);
        let mut progress = Progress::new(&scenario, &options, false)?;
        let found = Tradeoff::new(&scenario)
            .points(self.points)
            .options(own.clone())
            .interrupt(interrupt)
            .observe(|record| progress.observe(record))
            .run()?;
        progress.finish();
        let page = tradeoff_page(&found)?;
        print(&tradeoff_table(&tradeoff_rows(&found)))?;
        let files = write_tradeoff(&found, &page, &folder)
            .or_else(|error| write_tradeoff(&found, &page, &spare(&error, &scenario.name)?))?;
        for file in files {
            print(&format!("wrote {}", file.display()))?;
        }
        Ok(if found.iter().all(|(_, report)| report.summary.success) {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(FAILED)
        })
    }
}
