//! `aghf degrees`.

use super::output::OutArgs;
use super::{RobotArgs, print};
use crate::degree_study::{Size, by_size, size_page, size_table, write_sizes};
use aghf::error::Result;
use clap::Args;
use indicatif::ProgressBar;
use std::path::Path;
use std::process::ExitCode;

/// The output files.
const FILES: [&str; 2] = ["degrees.csv", "report.html"];

/// Show how the effort of a scenario decreases with higher degrees and more segments.
///
/// Relaxes a scenario with motions of several sizes, one after the other, each from its own starts. A new folder,
/// out/degrees/SCENARIO or with a number after that, gets degrees.csv and report.html, a page with the results.
#[derive(Debug, Args)]
pub(super) struct Degrees {
    /// A built-in scenario, or the path of a JSON file, "-" for the standard input.
    scenario: String,
    #[command(flatten)]
    robot: RobotArgs,
    /// Numbers of segments and their degree.
    #[arg(default_values = ["1x9", "1x16", "1x24", "1x32", "2x7", "2x9", "4x7", "4x9", "8x7", "8x9"])]
    sizes: Vec<String>,
    /// Number of starts [default: 8].
    #[arg(long)]
    starts: Option<usize>,
    #[command(flatten)]
    out: OutArgs,
}

impl Degrees {
    pub(super) fn run(self) -> Result<ExitCode> {
        let scenario = self.robot.scenario(&self.scenario)?;
        let sizes = self.sizes.iter().map(|size| size.parse());
        let sizes = sizes.collect::<Result<Vec<Size>>>()?;
        let default = Path::new("out/degrees").join(&scenario.name);
        let folder = self.out.folder(&default, &FILES)?;
        let progress = ProgressBar::new(sizes.len() as u64);
        let rows = by_size(&scenario, &sizes, self.starts, &mut |size| {
            progress.set_message(size.to_string());
            progress.inc(1);
        })?;
        progress.finish_and_clear();
        print(&size_table(&rows))?;
        let [table, page] = FILES.map(|name| folder.path().join(name));
        write_sizes(&rows, &table)?;
        size_page(&scenario, &rows)?.write(&page)?;
        for file in [table, page] {
            print(&format!("wrote {}", file.display()))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
