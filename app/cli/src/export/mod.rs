//! Motions in the formats of ROS 2: a message for a controller of joints, and a recording for viewers.

mod markers;
mod mcap;
mod messages;
mod schemas;
mod yaml;

pub use mcap::{DEFAULT_RATE, write_mcap};
pub use yaml::write_yaml;

use crate::output::{Sampling, write_whole};
use aghf::curve::Curve;
use aghf::error::Result;
use aghf::motion::samples_at;
use aghf_scenario::certify::NAME;
use aghf_scenario::{JointTrajectory, Scenario};
use std::path::Path;

/// The motion as a message, by default with [as many points](Sampling::or_sufficient) as the judge needs. The SHA-256
/// of the summary, if there is one, is in the `frame_id` of its header, by which a certificate knows the motion.
///
/// # Errors
/// The sampling is out of range, or the curve has another number of joints than the robot.
pub fn joint_trajectory(
    scenario: &Scenario,
    curve: &Curve,
    sampling: Option<Sampling>,
    run: Option<&str>,
) -> Result<JointTrajectory> {
    let times = Sampling::or_sufficient(sampling, scenario, curve)?.times(curve.horizon())?;
    let times = times.map(|t| (curve.segment_at(t), t));
    let samples = samples_at(&scenario.model, curve, times).collect::<Result<Vec<_>>>()?;
    let mut message = JointTrajectory::of_samples(&scenario.model, samples);
    message.header.frame_id = run.map_or_else(String::new, |hash| format!("{NAME}{hash}"));
    Ok(message)
}

/// Writes the motion to the MCAP file at `path` by [`write_mcap`], by default at [`DEFAULT_RATE`].
///
/// # Errors
/// Those of [`joint_trajectory`], or the file cannot be written.
pub fn save_mcap(
    scenario: &Scenario,
    curve: &Curve,
    sampling: Option<Sampling>,
    run: Option<&str>,
    path: &Path,
) -> Result<()> {
    let sampling = sampling.unwrap_or(Sampling::Rate(DEFAULT_RATE));
    let plan = joint_trajectory(scenario, curve, Some(sampling), run)?;
    write_whole(path, |file| write_mcap(scenario, plan, file))
}
