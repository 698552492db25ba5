//! `aghf ik`.

use super::{FAILED, UrdfArgs, print, print_json, tell};
use crate::output::configurations_table;
use aghf::error::{Error, Result};
use aghf_scenario::{AxisDirection, Goal, Scenario};
use clap::Args;
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

/// Finds joint positions that take a frame of a robot to a pose.
///
/// The search is the one by which `aghf solve` finds the ends of goals. The positions are within the limits of the
/// joints, and the motors hold them; the nearest to `--near` comes first. There is one row per configuration, with a
/// number for each joint. Exit code 3 if none is found.
#[derive(Debug, Args)]
pub(super) struct Ik {
    /// A built-in robot, or the path of a URDF file.
    robot: String,
    #[command(flatten)]
    reading: UrdfArgs,
    /// The frame, a link of the robot.
    #[arg(long)]
    frame: String,
    /// The position of its origin in the base frame, m: x,y,z [default: any].
    #[arg(
        long,
        value_parser = numbers::<3>,
        allow_hyphen_values = true,
        required_unless_present_any = ["orientation", "axis"]
    )]
    position: Option<[f64; 3]>,
    /// The largest distance from the position, m [default: 0].
    #[arg(long, requires = "position")]
    tolerance_m: Option<f64>,
    /// The unit quaternion that rotates the axes of the base into those of the frame: x,y,z,w [default: any].
    #[arg(long, value_parser = numbers::<4>, allow_hyphen_values = true)]
    orientation: Option<[f64; 4]>,
    /// An axis of the frame and its direction in the base frame: x,y,z,x,y,z.
    #[arg(long, value_parser = numbers::<6>, allow_hyphen_values = true, conflicts_with = "orientation")]
    axis: Option<[f64; 6]>,
    /// The largest angle from the orientation or the direction, rad [default: 0].
    #[arg(long)]
    tolerance_rad: Option<f64>,
    /// The joint positions at which the search begins, rad or m, separated by commas [default: as close to zero as the
    /// limits allow].
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    near: Option<Vec<f64>>,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
}

impl Ik {
    pub(super) fn run(self) -> Result<ExitCode> {
        let model = self.reading.load(&self.robot)?;
        let near = self.near.clone().unwrap_or_else(|| {
            let joints = model.joints().iter();
            joints.map(|joint| joint.limits().nearest(0.0)).collect()
        });
        let scenario = json!({
            "robot": self.robot,
            "mimic": self.reading.mimic.to_string(),
            "packages": self.reading.packages.folders(),
            "horizon_s": 1.0,
            "q_start": near,
            "v_start": vec![0.0; model.dof()],
            "goal": self.goal(),
        });
        let scenario = Scenario::parse(&scenario.to_string(), "options", Path::new(""))?;
        let mut ends = match scenario.goal_with_ends() {
            Ok(goal) => goal.map_or_else(Vec::new, |goal| goal.ends),
            Err(Error::Input { element, condition, .. }) if element == "goal" => {
                tell(&format!("aghf: {condition}"));
                return Ok(ExitCode::from(FAILED));
            }
            Err(other) => return Err(other),
        };
        let distance = |q: &[f64]| -> f64 { q.iter().zip(&near).map(|(a, b)| (a - b).powi(2)).sum() };
        ends.sort_by(|a, b| distance(&a.q).total_cmp(&distance(&b.q)));
        let found: Vec<_> = ends.into_iter().map(|end| end.q).collect();
        if self.json {
            print_json(&found)?;
        } else {
            print(&configurations_table(&model, &found))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The goal of the options.
    fn goal(&self) -> Goal {
        Goal {
            frame: self.frame.clone(),
            relative_to: None,
            position_m: self.position,
            tolerance_m: self.tolerance_m,
            within: None,
            orientation_xyzw: self.orientation,
            axis: self.axis.map(|[a, b, c, x, y, z]| AxisDirection { of_frame: [a, b, c], direction: [x, y, z] }),
            tolerance_rad: self.tolerance_rad,
        }
    }
}

/// Reads numbers that are separated by commas.
fn numbers<const N: usize>(text: &str) -> std::result::Result<[f64; N], String> {
    let all = text.split(',').map(|number| number.trim().parse());
    let all = all.collect::<std::result::Result<Vec<f64>, _>>().map_err(|e| e.to_string())?;
    let found = all.len();
    <[f64; N]>::try_from(all).map_err(|_| format!("{N} numbers are needed, there are {found}"))
}
