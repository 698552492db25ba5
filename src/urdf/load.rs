//! Robots by name or by path.

use super::{LoadReport, UrdfOptions, builtin_robot_text, parse_urdf, parse_urdf_with};
use crate::error::Result;
use crate::input::read_named;
use crate::model::Model;
use std::path::Path;

/// The built-in robot of this name, or else the one in the URDF file at this path, `-` for the standard input.
///
/// # Errors
/// Names the file, the element and what is wrong with it.
pub fn load_robot(name_or_path: &str) -> Result<(Model, LoadReport)> {
    load_robot_with(name_or_path, Path::new(""), UrdfOptions::default())
}

/// As [`load_robot`], with paths relative to `folder` and a URDF file read as `options` say.
///
/// # Errors
/// As [`load_robot`].
pub fn load_robot_with(
    name_or_path: &str,
    folder: &Path,
    options: UrdfOptions,
) -> Result<(Model, LoadReport)> {
    if let Some(text) = builtin_robot_text(name_or_path) {
        return parse_urdf(text, name_or_path);
    }
    let path = folder.join(name_or_path);
    let text = read_named(&path, "robot")?;
    parse_urdf_with(&text, &path.display().to_string(), options)
}

/// The name of the robot that is built in under this name, or else the absolute path of the file at this path below `folder`, and
/// its text.
///
/// # Errors
/// The file cannot be read.
#[cfg(feature = "output")]
pub(crate) fn robot_text(name_or_path: &str, folder: &Path) -> Result<(String, String)> {
    if let Some(text) = builtin_robot_text(name_or_path) {
        return Ok((name_or_path.to_owned(), text.to_owned()));
    }
    let path = folder.join(name_or_path);
    let text = crate::input::read_text(&path)?;
    let place = if crate::input::is_standard_input(&path) {
        path
    } else {
        std::path::absolute(&path).map_err(|e| crate::error::Error::io(&path, e))?
    };
    Ok((place.to_string_lossy().into_owned(), text))
}
