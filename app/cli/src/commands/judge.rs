//! `aghf judge`.

use super::compare::summary_at;
use super::{CHECK_FAILED, IN_PART, RobotArgs, print};
use crate::output::{REPORT_FILES, judgement_table, refuse_existing, write_json, write_text};
use aghf::error::{Error, Result};
use aghf_scenario::judge::{Tolerances, Trajectory, Verdict, judge};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Judges whether a trajectory from any source is a motion of the scenario.
///
/// The trajectory is a trajectory_msgs/JointTrajectory in a file that ends in .yaml, .yml or .json, as `aghf export`
/// writes it, or a table, a CSV file as `aghf solve` writes it: a column t in s, a column q_JOINT for every joint, and
/// for all joints or none v_JOINT, a_JOINT (not without v_JOINT) and u_JOINT, in rad or m, per s, per s^2, N m or N.
///
/// Between its rows the table means the quintics through q, v and a, without a the cubics through q and v. Limits,
/// torques, conditions along the way and clearances are proved for these at all times. Of positions alone the rates are
/// derived with their uncertainty; what they leave open is not checked.
///
/// Exit code 0 if the trajectory is valid, 4 if it is valid in part: no check fails, and those that are named are not
/// made. Exit code 1 if it is not valid, with the worst row: a check fails or cannot be decided.
#[derive(Debug, Args)]
pub(super) struct Judge {
    /// A built-in or generated scenario, or the path of a JSON file, "-" for the standard input.
    scenario: String,
    #[command(flatten)]
    robot: RobotArgs,
    /// The trajectory, "-" for a table on the standard input; or the folder of a solve or its summary.json, whose table
    /// is judged.
    trajectory: PathBuf,
    /// Accepted deviation of everything but clearances: rad, m, rad/s, m/s, rad/s^2, m/s^2, s; for torques as a
    /// fraction of the largest torque of the motion.
    #[arg(long, default_value_t = Tolerances::default().tolerance, allow_negative_numbers = true)]
    tolerance: f64,
    /// Accepted depth of balls of the robot in obstacles or in each other, m; clearances are proved to a tenth of it.
    #[arg(long, default_value_t = Tolerances::default().overlap_m, allow_negative_numbers = true)]
    overlap: f64,
    /// File for the verdict as JSON.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Replaces that file if it exists.
    #[arg(long, requires = "json")]
    force: bool,
}

impl Judge {
    pub(super) fn run(self) -> Result<ExitCode> {
        if let Some(path) = &self.json {
            refuse_existing(path, self.force)?;
        }
        let scenario = self.robot.scenario(&self.scenario)?;
        let trajectory = Trajectory::load(&table_at(&self.trajectory)?, &scenario.model)?;
        let tolerances = Tolerances { tolerance: self.tolerance, overlap_m: self.overlap };
        let judgement = judge(&scenario, &trajectory, tolerances)?;
        print(&judgement_table(&judgement))?;
        if let Some(path) = &self.json {
            let mut text = Vec::new();
            write_json(&judgement, &mut text).map_err(|e| Error::io(path.clone(), e))?;
            let text = String::from_utf8_lossy(&text);
            write_text(&format!("{text}\n"), path)?;
            print(&format!("wrote {}", path.display()))?;
        }
        Ok(match judgement.verdict {
            Verdict::Valid => ExitCode::SUCCESS,
            Verdict::ValidInPart => ExitCode::from(IN_PART),
            Verdict::NotValid => ExitCode::from(CHECK_FAILED),
        })
    }
}

/// The table of a run by its folder or its summary; any other path is that of the trajectory itself.
fn table_at(path: &Path) -> Result<PathBuf> {
    let [table, summary, _, failed_table, failed_summary, _] = REPORT_FILES;
    if !path.is_dir() && !path.ends_with(summary) && !path.ends_with(failed_summary) {
        return Ok(path.to_owned());
    }
    let found = PathBuf::from(summary_at(path)?);
    let table = if found.ends_with(failed_summary) { failed_table } else { table };
    Ok(found.with_file_name(table))
}
