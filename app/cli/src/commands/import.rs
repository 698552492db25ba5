//! `aghf import`.

use super::choice::choice;
use super::{PackageArgs, print, tell, tell_notes};
use crate::output::{refuse_existing, write_json, write_text};
use aghf::error::Result;
use aghf::urdf::Mimic;
use aghf_scenario::{MoveIt, MoveItHorizon, Preset};
use clap::{Args, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// Converts the problem of another planner to a scenario.
#[derive(Debug, Args)]
pub(super) struct Import {
    #[command(subcommand)]
    from: From,
}

#[derive(Debug, Subcommand)]
enum From {
    Moveit(FromMoveIt),
}

/// Converts a planning scene and a planning request of MoveIt, both in YAML, to a scenario.
///
/// The motion goes from the joint state of the request, with its velocities, to rest at its goal, by joints or by pose,
/// within all limits of the robot times the scaling factors of the request, and keeps path constraints and the speed of
/// a link; joints outside of the goal, for a goal by pose outside of the group, are locked. The goal of a continuous
/// joint is an angle, and moved by whole turns to be near its start, with a note. Boxes, cylinders and spheres of the
/// scene are obstacles. The robot has the shapes of its URDF.
///
/// A scenario is written only if all that bears on the motion could be read: every field of both files is read, or
/// refused by its name if it has a value, or has no meaning for the motion, such as a label, a colour, or the choice
/// and the time of a planner. A table of all fields is in the guide of aghf-scenario, page moveit.
#[derive(Debug, Args)]
struct FromMoveIt {
    /// The planning scene.
    scene: PathBuf,
    /// The planning request.
    request: PathBuf,
    /// A built-in robot, or the path of a URDF file.
    #[arg(long)]
    urdf: String,
    /// The SRDF, which lists links that may overlap [default: neighbours]; those that always do are added, as in
    /// `aghf pairs`.
    #[arg(long)]
    srdf: Option<PathBuf>,
    /// Treatment of mimic joints: refuse the robot, or let them move independently.
    #[arg(long, value_parser = choice::<Mimic>(), default_value_t)]
    mimic: Mimic,
    /// MoveIt's joint_limits.yaml, whose limits of velocity, acceleration and jerk are kept too, times the scaling
    /// factors of the request, otherwise its default ones. A factor of accelerations needs it.
    #[arg(long)]
    joint_limits: Option<PathBuf>,
    /// Distance by which convex pieces may extend beyond a mesh where dividing them saves enough, m.
    #[arg(long, default_value_t = 0.005, allow_negative_numbers = true)]
    excess: f64,
    #[command(flatten)]
    packages: PackageArgs,
    /// Horizon, s [default: free].
    #[arg(long, conflicts_with = "horizon_bounds", allow_negative_numbers = true)]
    horizon: Option<f64>,
    /// Bounds of a free horizon, s [default: the shortest that the velocity limits allow, and fifteen times that or the
    /// time that limits of acceleration and of the speed of a link take].
    #[arg(long, num_args = 2, value_names = ["SHORTEST", "LONGEST"], allow_negative_numbers = true)]
    horizon_bounds: Option<Vec<f64>>,
    /// Objective; a motion on a given horizon has least effort.
    #[arg(long, value_parser = choice::<Preset>(), default_value_t = Preset::Balanced)]
    objective: Preset,
    /// File for the scenario.
    #[arg(long, short)]
    out: PathBuf,
    /// Replaces that file if it exists.
    #[arg(long)]
    force: bool,
}

impl Import {
    pub(super) fn run(self) -> Result<ExitCode> {
        let From::Moveit(problem) = self.from;
        problem.run()
    }
}

impl FromMoveIt {
    fn run(self) -> Result<ExitCode> {
        refuse_existing(&self.out, self.force)?;
        let horizon = match (self.horizon, self.horizon_bounds.as_deref()) {
            (Some(horizon), _) => MoveItHorizon::Given(horizon),
            (None, Some([shortest, longest])) => MoveItHorizon::Between(*shortest, *longest),
            (None, _) => MoveItHorizon::Free,
        };
        let problem = MoveIt {
            scene: self.scene,
            request: self.request,
            urdf: self.urdf,
            mimic: self.mimic,
            packages: self.packages.folders(),
            srdf: self.srdf,
            joint_limits: self.joint_limits,
            excess: self.excess,
            horizon,
            objective: self.objective,
        };
        let scenario = problem.scenario(&self.out.display().to_string())?;
        tell_notes(&scenario.file.robot, &scenario.load_notes);
        if let Err(error) = scenario.check_feasible() {
            tell(&format!("note: it has no solution: {error}"));
        }
        let mut text = Vec::new();
        write_json(&scenario.file, &mut text).map_err(|e| aghf::Error::io(self.out.clone(), e))?;
        let text = String::from_utf8_lossy(&text);
        write_text(&format!("{text}\n"), &self.out)?;
        print(&format!("wrote {}", self.out.display()))?;
        Ok(ExitCode::SUCCESS)
    }
}
