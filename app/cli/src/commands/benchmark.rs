//! `aghf benchmark`.

use super::{CHECK_FAILED, PackageArgs, print, tell};
use crate::benchmark::{End, families, problems, run, table};
use crate::output::write_text;
use aghf::error::{Error, Result};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// The commands that download the problems.
const DOWNLOAD: &str = "to get it: pip download --no-deps --no-binary vamp-planner vamp-planner==0.6.4; \
    tar xzf vamp_planner-0.6.4.tar.gz; \
    tar xjf vamp_planner-0.6.4/resources/panda/problems.tar.bz2 -C vamp_planner-0.6.4/resources/panda; \
    then name vamp_planner-0.6.4/resources/panda";

/// Solves the planning problems of a folder one by one on one core, judges each motion, and reports by family.
///
/// The folder contains scenarios, FAMILY_NUMBER.json, such as robots/panda/scenarios; or one folder per family with
/// MoveIt's planning scenes and requests, sceneNUMBER.yaml and requestNUMBER.yaml, directly or in a subfolder
/// "problems", as MotionBenchMaker comes with the sources of vamp-planner. An interrupted run is resumed; a
/// problem that is refused has a line with the reason. Exit code 1 if a problem that is not known to be infeasible has
/// no valid motion.
#[derive(Debug, Args)]
pub(super) struct Benchmark {
    /// The folder.
    folder: PathBuf,
    /// The robot of scenes and requests: a built-in name, or the path of a URDF file.
    #[arg(long, default_value = "panda")]
    robot: String,
    #[command(flatten)]
    packages: PackageArgs,
    /// The folder for results.csv and table.md.
    #[arg(long, short, default_value = "out/benchmark")]
    out: PathBuf,
}

impl Benchmark {
    pub(super) fn run(self) -> Result<ExitCode> {
        if !self.folder.is_dir() {
            let condition = format!("there is no such folder; {DOWNLOAD}");
            return Err(Error::input(self.folder.display().to_string(), "folder", condition));
        }
        let problems = problems(&self.folder, &self.robot, &self.packages.folders())?;
        std::fs::create_dir_all(&self.out).map_err(|error| Error::io(&self.out, error))?;
        let (results, summary) = (self.out.join("results.csv"), self.out.join("table.md"));
        let rows = run(&problems, &results, &mut |row| {
            if !row.end.is_valid() {
                tell(&format!("{}: {:?}: {}", row.problem, row.end, row.reason));
            }
        })?;
        let text = table(&families(&rows));
        write_text(&text, &summary)?;
        print(text.trim_end())?;
        print(&format!("wrote {}", results.display()))?;
        print(&format!("wrote {}", summary.display()))?;
        let good = |end: End| end.is_valid() || end == End::Impossible;
        Ok(if rows.iter().all(|row| good(row.end)) { ExitCode::SUCCESS } else { ExitCode::from(CHECK_FAILED) })
    }
}
