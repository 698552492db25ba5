//! `aghf pairs`.

use super::{UrdfArgs, print, tell, tell_notes};
use crate::output::{refuse_existing, write_text};
use aghf::error::Result;
use aghf::urdf::{RobotSource, Srdf};
use aghf_scenario::{IgnoredPairs, link_shapes};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Lists the pairs of links of a robot that may overlap, with the reasons.
///
/// The pairs are those that an SRDF disables, otherwise, or if it disables none, neighbours, and pairs that overlap at
/// each of 10000 random configurations. The file can be edited, and used by a scenario: "self_collision":
/// {"ignored_pairs_file": PATH}.
#[derive(Debug, Args)]
pub(super) struct Pairs {
    /// A built-in robot, or the path of a URDF file, "-" for the standard input.
    urdf: String,
    #[command(flatten)]
    reading: UrdfArgs,
    /// SRDF of the robot.
    #[arg(long)]
    srdf: Option<PathBuf>,
    /// Distance by which convex pieces may extend beyond a mesh where dividing them saves enough, m [default:
    /// 0.005].
    #[arg(long, allow_negative_numbers = true)]
    excess: Option<f64>,
    /// File for the pairs [default: printed].
    #[arg(long, short)]
    out: Option<PathBuf>,
    /// Replaces that file if it exists.
    #[arg(long, requires = "out")]
    force: bool,
}

impl Pairs {
    pub(super) fn run(self) -> Result<ExitCode> {
        if let Some(path) = &self.out {
            refuse_existing(path, self.force)?;
        }
        let source = RobotSource::find(&self.urdf, Path::new(""))?;
        let (model, notes) = source.parse(self.reading.options())?;
        tell_notes(&self.urdf, &notes);
        let srdf = self.srdf.as_ref().map(|path| Ok((Srdf::load(path, &model)?, path.display())));
        let srdf = srdf.transpose()?;
        for (link, path) in srdf.iter().flat_map(|(srdf, path)| srdf.unknown_links.iter().map(move |l| (l, path))) {
            tell(&format!("note: {path}: the robot has no link '{link}', whose pairs are left out"));
        }
        let pairs = match (&srdf, model.collisions()) {
            // Without shapes nothing overlaps.
            (Some((srdf, _)), []) => IgnoredPairs::of_srdf(&model, srdf),
            _ => {
                let links = link_shapes(&model, source.folder(), self.excess)?;
                IgnoredPairs::find(&model, srdf.as_ref().map(|(srdf, _)| srdf), &links)?
            }
        };
        match &self.out {
            None => print(pairs.to_json().trim_end())?,
            Some(path) => {
                write_text(&pairs.to_json(), path)?;
                let count = pairs.ignored_pairs.len();
                print(&format!("wrote {}: {count} pairs", path.display()))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
