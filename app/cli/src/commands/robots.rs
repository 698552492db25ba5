//! `aghf robots`.

use super::{UrdfArgs, print, print_json};
use crate::output::{refuse_existing, robot_table, short, write_text};
use aghf::error::{Error, Result};
use aghf::model::Model;
use aghf::urdf::{LoadReport, Srdf, builtin_robots};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Lists the built-in robots, or shows one: joints, limits, masses, and notes from loading.
#[derive(Debug, Args)]
pub(super) struct Robots {
    /// A built-in robot, or the path of a URDF file, "-" for the standard input [default: list all built-in ones].
    robot: Option<String>,
    #[command(flatten)]
    reading: UrdfArgs,
    /// Writes the robot that was read to this file as a URDF, shapes included, fixed joints merged.
    #[arg(long, requires = "robot")]
    urdf: Option<PathBuf>,
    /// An SRDF, whose spheres replace the shapes of their links.
    #[arg(long, requires = "robot")]
    srdf: Option<PathBuf>,
    /// Replaces that file if it exists.
    #[arg(long, requires = "urdf")]
    force: bool,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
}

impl Robots {
    pub(super) fn run(self) -> Result<ExitCode> {
        let names: Vec<&str> = match &self.robot {
            Some(robot) => vec![robot],
            None => builtin_robots().collect(),
        };
        if let Some(path) = &self.urdf {
            refuse_existing(path, self.force)?;
        }
        let mut all = Vec::new();
        for name in names {
            let (mut model, report) = self.reading.load_silently(name)?;
            if let Some(path) = &self.srdf {
                model = Srdf::load(path, &model)?.with_spheres(model)?;
            }
            if let Some(path) = &self.urdf {
                write_text(&model.to_urdf()?, path)?;
            }
            if self.json {
                all.push(as_json(name, &model, &report));
            } else {
                print(&format!("{name}: {} joints, {} kg moving", model.dof(), short(model.mass())))?;
                print(&robot_table(&model))?;
                for note in report {
                    print(&format!("  {note}"))?;
                }
                if let Some(path) = &self.urdf {
                    print(&format!("wrote {}", path.display()))?;
                }
                print("")?;
            }
        }
        if self.json {
            print_json(&all)?;
        }
        Ok::<_, Error>(ExitCode::SUCCESS)
    }
}

/// A robot in JSON; missing limits are null.
fn as_json(name: &str, model: &Model, report: &LoadReport) -> serde_json::Value {
    let joints = model.joints().iter().zip(model.inertias()).map(|(joint, inertia)| {
        let limits = joint.limits();
        json!({
            "name": joint.name(),
            "kind": joint.kind().name(),
            "parent": joint.parent().map(|p| model.joints()[p].name()),
            "lower": limits.lower,
            "upper": limits.upper,
            "velocity": limits.velocity,
            "effort": limits.effort,
            "mass_kg": inertia.mass,
        })
    });
    json!({
        "robot": name,
        "mass_kg": model.mass(),
        "joints": joints.collect::<Vec<_>>(),
        "notes": report.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}
