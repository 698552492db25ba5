//! `aghf doctor`.

use super::{FAILED, PackageArgs, print, print_json};
use crate::doctor::{Examination, Plannable, examine, page};
use aghf::error::Result;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Examines the file of a robot, and lists faults that prevent its use.
///
/// Each finding comes with the key of a scenario, the option or the change of the file as its remedy: joints and mimic
/// joints, inertias, limits, losses, collision shapes and their convex pieces, and links that overlap at zero or
/// in the named states of an SRDF. Faults for which the other commands refuse the file are listed, and the rest is
/// examined without them. Exit code 3 if no key makes it possible to plan motions.
#[derive(Debug, Args)]
pub(super) struct Doctor {
    /// The path of a URDF file, "-" for the standard input, or a built-in robot.
    robot: String,
    /// SRDF of the robot: pairs of links that may overlap, spheres, named states.
    #[arg(long)]
    srdf: Option<PathBuf>,
    #[command(flatten)]
    packages: PackageArgs,
    /// Distance by which convex pieces may extend beyond a mesh where dividing them saves enough, m [default:
    /// 0.005].
    #[arg(long, allow_negative_numbers = true)]
    excess: Option<f64>,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
}

impl Doctor {
    pub(super) fn run(self) -> Result<ExitCode> {
        let diagnosis = examine(&Examination {
            robot: self.robot,
            srdf: self.srdf,
            packages: self.packages.folders(),
            excess: self.excess,
        })?;
        if self.json {
            print_json(&diagnosis)?
        } else {
            print(&page(&diagnosis))?
        }
        Ok(match diagnosis.plannable {
            Plannable::Yes | Plannable::WithKeys => ExitCode::SUCCESS,
            Plannable::No => ExitCode::from(FAILED),
        })
    }
}
