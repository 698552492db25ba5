//! `aghf export`.

use super::compare::summary_at;
use super::output::SamplingArgs;
use super::{print, tell};
use crate::export::{joint_trajectory, save_mcap, write_yaml};
use crate::output::{refuse_existing, short, write_json, write_whole};
use aghf::error::{Error, Result};
use aghf::input::read_bytes;
use aghf_scenario::{JointTrajectory, Solved, Verdict, sha256};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Writes the motion of a solve, or several of which each continues the one before, for ROS 2.
///
/// A trajectory is a trajectory_msgs/JointTrajectory with positions, velocities, accelerations, efforts and
/// time_from_start, for a controller of joints; `aghf judge` reads it back. An MCAP file is a recording that Foxglove,
/// rerun and `ros2 bag` open: /robot_description, /obstacles, /plan, /joint_states and /tf, from time zero. The header
/// of the trajectory has the SHA-256 of the summary as its frame, by which `aghf check-certificate --table` knows the
/// motion; that of several has none. Motions at speed continue each other with `a_start` and `a_goal`.
#[derive(Debug, Args)]
pub(super) struct Export {
    /// Folders of solves, or their summary.json.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Form of the motion.
    #[arg(long, value_enum)]
    to: Target,
    /// Format of a trajectory.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    sampling: SamplingArgs,
    /// The file [default: trajectory.yaml, trajectory.json or motion.mcap beside the summary].
    #[arg(long, short)]
    out: Option<PathBuf>,
    /// Replaces the file if it exists.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Target {
    /// A trajectory_msgs/JointTrajectory; by default with as many points as `aghf judge` needs.
    Trajectory,
    /// An MCAP file of one motion; by default at 100 Hz.
    Mcap,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    #[default]
    Yaml,
    Json,
}

impl Export {
    pub(super) fn run(self) -> Result<ExitCode> {
        let summaries = self.runs.iter().map(|run| summary_at(run)).collect::<Result<Vec<_>>>()?;
        let name = match (self.to, self.format) {
            (Target::Trajectory, Format::Yaml) => "trajectory.yaml",
            (Target::Trajectory, Format::Json) => "trajectory.json",
            (Target::Mcap, _) => "motion.mcap",
        };
        let path = self.out.unwrap_or_else(|| Path::new(&summaries[0]).with_file_name(name));
        if matches!(self.to, Target::Mcap) && summaries.len() > 1 {
            return Err(Error::input(&summaries[0], "mcap", "a recording has one motion, a trajectory several"));
        }
        refuse_existing(&path, self.force)?;
        let sampling = self.sampling.sampling();
        let mut message: Option<JointTrajectory> = None;
        for summary in &summaries {
            let solved = Solved::load(summary)?;
            tell_verdict(summary, &solved);
            let (scenario, curve) = (&solved.scenario, &solved.curve);
            let run = sha256(&read_bytes(Path::new(summary))?);
            match (self.to, &mut message) {
                (Target::Mcap, _) => save_mcap(scenario, curve, sampling, Some(&run), &path)?,
                (Target::Trajectory, Some(before)) => {
                    before.append(joint_trajectory(scenario, curve, sampling, None)?, summary)?;
                }
                (Target::Trajectory, before) => {
                    *before = Some(joint_trajectory(scenario, curve, sampling, Some(&run))?);
                }
            }
        }
        if let Some(message) = message {
            write_whole(&path, |file| match self.format {
                Format::Yaml => write_yaml(&message, file),
                Format::Json => write_json(&message, file),
            })?;
        }
        print(&format!("wrote {}", path.display()))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Tells the reason why a motion is not valid, if it is not.
fn tell_verdict(summary: &str, solved: &Solved) {
    let found = &solved.summary;
    let reason = match found.verdict {
        Verdict::Optimal | Verdict::Valid => None,
        Verdict::AtSMax => Some(format!(
            "its velocities differ from the rates of its positions by up to {}",
            short(found.dynamics_defect)
        )),
        Verdict::NotValid => found.failure.clone(),
    };
    if let Some(reason) = reason {
        let verdict = found.verdict;
        tell(&format!("note: {summary}: the motion is {verdict}: {reason}"));
    }
}
