//! `aghf compare`.

use super::print;
use crate::output::{REPORT_FILES, refuse_existing};
use crate::report::{Motion, write_page};
use aghf::error::{Error, Result};
use aghf_scenario::Solved;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The summaries in the folder of a solve, that of a success first.
const SUMMARIES: [&str; 2] = [REPORT_FILES[1], REPORT_FILES[4]];

/// Shows two motions side by side in time, on one page.
///
/// They may belong to one scenario solved by two methods, or to two scenarios.
#[derive(Debug, Args)]
pub(super) struct Compare {
    /// Folder of a solve, or its summary.json.
    first: PathBuf,
    /// Folder or summary.json of another solve.
    second: PathBuf,
    /// File for the page.
    #[arg(long, short, default_value = "compare.html")]
    out: PathBuf,
    /// Replaces the file if it exists.
    #[arg(long)]
    force: bool,
}

impl Compare {
    pub(super) fn run(self) -> Result<ExitCode> {
        refuse_existing(&self.out, self.force)?;
        let paths = [summary_at(&self.first)?, summary_at(&self.second)?];
        let [first, second] = &paths;
        let solved = [Solved::load(first)?, Solved::load(second)?];
        let motions = [Motion::of_solved(&solved[0], first)?, Motion::of_solved(&solved[1], second)?];
        write_page(&motions, &self.out)?;
        print(&format!("wrote {}", self.out.display()))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// The path of the summary in a folder, or of the file itself.
pub(super) fn summary_at(path: &Path) -> Result<String> {
    let summaries = SUMMARIES.map(|name| path.join(name));
    let found = if path.is_dir() { summaries.iter().find(|p| p.is_file()).map(PathBuf::as_path) } else { Some(path) };
    let found = found.ok_or_else(|| {
        let [success, failure] = SUMMARIES;
        let condition = format!("this folder has neither '{success}' nor '{failure}'");
        Error::input(path.display().to_string(), "summary", condition)
    })?;
    Ok(found.display().to_string())
}
