//! `aghf eval`.

use super::{UrdfArgs, print_json};
use crate::output::evaluate;
use aghf::error::Result;
use aghf::input::read_text;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Evaluates the dynamics of a robot at a given state and prints JSON, to compare with other code.
///
/// INPUT is a JSON file with the keys q, v, a, or with x, xdot, xddot, k; "-" reads the standard input. With x, q and v
/// are its halves and a is the second half of xdot. Joints are numbered as in `aghf robots ROBOT`. Matrices are lists
/// of rows; mass_matrix_dot is the rate along v (along the first half of xdot if that is given); forward_dynamics is
/// the acceleration under the torque of the key tau, zero by default. omega needs x, xdot, xddot and k.
#[derive(Debug, Args)]
pub(super) struct Eval {
    /// A built-in robot, or the path of a URDF file, "-" for the standard input.
    robot: String,
    #[command(flatten)]
    reading: UrdfArgs,
    /// The JSON file, "-" for the standard input.
    input: PathBuf,
}

impl Eval {
    pub(super) fn run(self) -> Result<ExitCode> {
        let model = self.reading.load(&self.robot)?;
        let text = read_text(&self.input)?;
        let name = self.input.display().to_string();
        print_json(&evaluate(&model, &text, &name)?)?;
        Ok(ExitCode::SUCCESS)
    }
}
