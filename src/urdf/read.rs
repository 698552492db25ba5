//! Reading of robots from URDF files.

use super::elements::Elements;
use super::{LoadReport, UrdfOptions, build_model};
use crate::error::{Error, Result};
use crate::input::read_text;
use crate::model::Model;
use std::path::Path;
use urdf_rs::utils::convert_xacro_to_urdf;

/// Reads the robot in the URDF file at `path`. See [`parse_urdf`]. A file with the extension `xacro` is expanded by the
/// program `xacro` of ROS, without arguments.
///
/// # Errors
/// The file cannot be read or expanded, or those of [`parse_urdf`].
pub fn load_urdf(path: &Path) -> Result<(Model, LoadReport)> {
    load_urdf_with(path, UrdfOptions::default())
}

/// Reads the robot in the URDF file at `path` with options. See [`load_urdf`].
///
/// # Errors
/// Those of [`load_urdf`].
pub fn load_urdf_with(path: &Path, options: UrdfOptions) -> Result<(Model, LoadReport)> {
    let text = expand_xacro(read_text(path)?, path)?;
    parse_urdf_with(&text, &path.display().to_string(), options)
}

/// Reads a robot from the text of a URDF file; `file` names it in errors.
///
/// Fixed joints are merged into the body before them. A velocity or effort limit of zero, a limit element of zeros, and
/// a limit of 1e10 or more mean no limit, with a note; soft limits of a safety controller are noted and not kept. The
/// first of several axes counts, and a mass without moments of inertia is a point mass, with a note. Collision elements
/// become [`Model::collisions`], without those of radius zero, which get a note; files of meshes are not read. Visual
/// elements, materials, transmissions, elements and attributes with a prefix, and all other elements without dynamics
/// or collision shapes are ignored.
///
/// # Errors
/// Names the faulty element and the reason: text that is not a URDF; negative or non-finite numbers; zero axes;
/// repeated names; several roots; loops; unknown links; floating, planar, spherical and mimic joints; joints whose
/// subtree has no inertia about them; and collision elements without a shape, with an unknown one or with another size
/// that is not positive.
pub fn parse_urdf(text: &str, file: &str) -> Result<(Model, LoadReport)> {
    parse_urdf_with(text, file, UrdfOptions::default())
}

/// Reads a robot from the text of a URDF file with options. See [`parse_urdf`].
///
/// # Errors
/// Those of [`parse_urdf`].
pub fn parse_urdf_with(text: &str, file: &str, options: UrdfOptions) -> Result<(Model, LoadReport)> {
    let (robot, mut notes) = Elements::read(text, file)?.whole()?;
    let (model, more) = build_model(&robot, file, options)?;
    notes.extend(more);
    Ok((model, notes))
}

/// The URDF in the file at `path` with this text: the text itself, unless the extension is `xacro`.
///
/// # Errors
/// There is no program `xacro`, or it fails.
pub(super) fn expand_xacro(text: String, path: &Path) -> Result<String> {
    if path.extension().is_none_or(|extension| extension != "xacro") {
        return Ok(text);
    }
    convert_xacro_to_urdf(path).map_err(|e| Error::input(path.display().to_string(), "robot", e.to_string()))
}
