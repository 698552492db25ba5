//! Trajectories in YAML.

use aghf_scenario::{JointTrajectory, Stamp};
use std::io::{self, Write};

/// Writes a trajectory as YAML, as `ros2 topic pub` reads it, with a line for each list of numbers.
///
/// # Errors
/// The writer fails.
pub fn write_yaml(trajectory: &JointTrajectory, mut writer: impl Write) -> io::Result<()> {
    // A string in JSON is also a string in YAML.
    let frame = serde_json::to_string(&trajectory.header.frame_id)?;
    writeln!(writer, "header: {{frame_id: {frame}}}")?;
    let names = serde_json::to_string(&trajectory.joint_names)?;
    writeln!(writer, "joint_names: {names}\npoints:")?;
    for point in &trajectory.points {
        let lists = [
            ("- positions", &point.positions),
            ("  velocities", &point.velocities),
            ("  accelerations", &point.accelerations),
            ("  effort", &point.effort),
        ];
        for (key, list) in lists {
            let numbers: Vec<String> = list.iter().map(|x| number(*x)).collect();
            writeln!(writer, "{key}: [{}]", numbers.join(", "))?;
        }
        let Stamp { sec, nanosec } = point.time_from_start;
        writeln!(writer, "  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}")?;
    }
    Ok(())
}

/// A number that is one in YAML 1.1 too, which requires a point, and a sign in the exponent.
fn number(x: f64) -> String {
    let text = format!("{x:?}");
    let Some((mantissa, exponent)) = text.split_once('e') else {
        return text;
    };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{mantissa}{point}e{sign}{exponent}")
}
