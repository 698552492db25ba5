//! Robots by name or by path.

use super::{LoadReport, UrdfOptions, builtin_robot, load_urdf_with};
use crate::error::{Error, Result};
use crate::model::Model;
use std::path::Path;

/// The robot that is built in under this name, or else the one in the URDF file at this path below `folder`.
///
/// # Errors
/// Names the file, the element and what is wrong with it.
pub fn load_robot(name_or_path: &str, folder: &Path) -> Result<(Model, LoadReport)> {
    load_robot_with(name_or_path, folder, UrdfOptions::default())
}

/// As [`load_robot`], a URDF file being read as `options` say.
///
/// # Errors
/// As [`load_robot`].
pub fn load_robot_with(
    name_or_path: &str,
    folder: &Path,
    options: UrdfOptions,
) -> Result<(Model, LoadReport)> {
    if let Some(robot) = builtin_robot(name_or_path) {
        return robot;
    }
    let path = folder.join(name_or_path);
    if !path.exists() {
        let condition = "there is neither a file nor a built-in robot of this name";
        return Err(Error::input(path.display().to_string(), "robot", condition));
    }
    load_urdf_with(&path, options)
}
