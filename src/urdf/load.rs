//! Robots by name or by path.

use super::read::expand_xacro;
use super::{LoadReport, UrdfOptions, builtin_robot_text, parse_urdf_with, read_robot};
use crate::error::Error;
use crate::error::Result;
use crate::input::is_standard_input;
use crate::input::read_named;
use crate::model::Model;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use urdf_rs::Robot;

/// Loads the built-in robot of this name, otherwise the one in the URDF file at this path, `-` for the standard input.
///
/// # Errors
/// Names the file, the element and the fault.
pub fn load_robot(name_or_path: &str) -> Result<(Model, LoadReport)> {
    load_robot_with(name_or_path, Path::new(""), UrdfOptions::default())
}

/// Loads as [`load_robot`] does, with paths relative to `folder` and with options for a URDF file.
///
/// # Errors
/// Those of [`load_robot`].
pub fn load_robot_with(name_or_path: &str, folder: &Path, options: UrdfOptions) -> Result<(Model, LoadReport)> {
    RobotSource::find(name_or_path, folder)?.parse(options)
}

/// The text of a robot and its origin.
#[derive(Clone, Debug)]
pub struct RobotSource {
    /// The text of the file.
    pub text: Cow<'static, str>,
    /// The name of a built-in robot, otherwise the path of its file.
    place: Place,
}

#[derive(Clone, Debug)]
enum Place {
    BuiltIn(String),
    File(PathBuf),
}

impl RobotSource {
    /// Finds the built-in robot of this name, otherwise the file at this path relative to `folder`.
    ///
    /// # Errors
    /// The file cannot be read or expanded.
    pub fn find(name_or_path: &str, folder: &Path) -> Result<Self> {
        if let Some(text) = builtin_robot_text(name_or_path) {
            return Ok(Self { text: Cow::Borrowed(text), place: Place::BuiltIn(name_or_path.to_owned()) });
        }
        let path = folder.join(name_or_path);
        Ok(Self { text: Cow::Owned(expand_xacro(read_named(&path, "robot")?, &path)?), place: Place::File(path) })
    }

    /// The elements of the robot, in the types of `urdf-rs`, without the notes that [`parse`](Self::parse) has as well.
    ///
    /// # Errors
    /// Those of [`read_robot`].
    pub fn elements(&self) -> Result<Robot> {
        read_robot(&self.text, &self.name())
    }

    /// Parses the robot with these options.
    ///
    /// # Errors
    /// Those of [`load_robot`].
    pub fn parse(&self, options: UrdfOptions) -> Result<(Model, LoadReport)> {
        parse_urdf_with(&self.text, &self.name(), options)
    }

    /// The name of a built-in robot, otherwise the path of its file.
    #[must_use]
    pub fn name(&self) -> String {
        match &self.place {
            Place::BuiltIn(name) => name.clone(),
            Place::File(path) => path.display().to_string(),
        }
    }

    /// The folder of the file, to which mesh paths are relative; the current one for the standard input and for
    /// built-in robots, which have no meshes.
    pub fn folder(&self) -> &Path {
        match &self.place {
            Place::BuiltIn(_) => Path::new(""),
            Place::File(path) => path.parent().unwrap_or(Path::new("")),
        }
    }

    /// The name of a built-in robot, otherwise the absolute path of its file.
    ///
    /// # Errors
    /// The current folder does not exist.
    pub fn absolute(&self) -> Result<String> {
        let path = match &self.place {
            Place::BuiltIn(name) => return Ok(name.clone()),
            Place::File(path) => path,
        };
        if is_standard_input(path) {
            return Ok(path.display().to_string());
        }
        let absolute = std::path::absolute(path).map_err(|e| Error::io(path, e))?;
        Ok(absolute.to_string_lossy().into_owned())
    }
}
