//! The triangles of the meshes in a URDF.

use super::collada::read_collada;
use super::elements::Read;
use super::shapes::{in_package, package_and_path};
use crate::error::{Error, Result};
use crate::geometry::Triangle;
use crate::input::{read_bytes, read_text};
use mesh_loader::{Scene, obj, stl};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{env, io};
use urdf_rs::utils::rospack_find;

/// Loads the triangles of the mesh that a URDF in `folder` calls `file`, with its axes scaled by `scale`, in m. The
/// formats are STL, binary or text, OBJ and COLLADA (`.dae`); coordinates of the former two have about seven digits.
/// A package is looked up in `folder`, in the folders above it, in those above the folder that symbolic links lead to,
/// in those of the variables `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`, and by the programs `rospack` or `ros2 pkg`.
///
/// # Errors
/// The file does not exist, has another format or no triangles, or contains numbers that are not finite.
pub fn load_mesh(file: &str, folder: &Path, scale: &Vector3<f64>) -> Result<Vec<Triangle>> {
    let extension = Path::new(file).extension().unwrap_or_default();
    let extension = extension.to_string_lossy().to_lowercase();
    if !["stl", "obj", "dae"].contains(&extension.as_str()) {
        let condition = "only STL, OBJ and COLLADA (.dae) can be read: convert it, or give the link spheres, boxes, \
                         cylinders or capsules instead";
        return Err(Error::input(file, "mesh", condition));
    }
    let path = find(file, folder).map_err(|e| Error::input(file, "mesh", e))?;
    let name = path.display().to_string();
    let refuse = |condition: String| Error::input(&name, "mesh", condition);
    let mut triangles = match extension.as_str() {
        "dae" => read_collada(&read_text(&path)?).map_err(refuse)?,
        "stl" => triangles(stl::from_slice(&stl_bytes(&path)?)).map_err(refuse)?,
        // Materials do not matter here: an empty file stands for each.
        _ => {
            triangles(obj::from_slice(&read_bytes(&path)?, Some(&path), |_| -> io::Result<Vec<u8>> { Ok(Vec::new()) }))
                .map_err(refuse)?
        }
    };
    for corner in triangles.iter_mut().flatten() {
        corner.component_mul_assign(scale);
    }
    let finite = |triangle: &Triangle| triangle.iter().all(|p| p.iter().all(|x| x.is_finite()));
    if triangles.is_empty() {
        return Err(refuse("it has no triangles".to_owned()));
    }
    if !triangles.iter().all(finite) {
        return Err(refuse("a coordinate of it is not a finite number".to_owned()));
    }
    Ok(triangles)
}

/// The path of the file that a URDF in `folder` calls `file`; `packages` are those of
/// [`UrdfOptions`](super::UrdfOptions). It is looked up as [`load_mesh`] does.
///
/// # Errors
/// The file does not exist.
pub fn mesh_path(file: &str, folder: &Path, packages: &BTreeMap<String, PathBuf>) -> Result<PathBuf> {
    let path = in_package(file.trim(), packages).and_then(|file| find(&file, folder));
    path.map_err(|e| Error::input(file, "mesh", e))
}

/// The bytes of an STL. One of the size of a binary file is one, whatever its header says: exporters write "solid"
/// there, the first word of a text. No text has that size: its letters would be the number of triangles, over half a
/// billion.
fn stl_bytes(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = read_bytes(path)?;
    if let Some((header, rest)) = bytes.split_first_chunk_mut::<80>()
        && let Some((count, data)) = rest.split_first_chunk()
        && data.len() as u64 == 50 * u64::from(u32::from_le_bytes(*count))
    {
        header.fill(0);
    }
    Ok(bytes)
}

/// The triangles of all meshes of a file.
fn triangles(scene: io::Result<Scene>) -> Read<Vec<Triangle>> {
    let mut all = Vec::new();
    for mesh in scene.map_err(|e| e.to_string())?.meshes {
        for face in &mesh.faces {
            let corner = |i: u32| mesh.vertices.get(i as usize).map(|p| p.map(f64::from).into());
            let [Some(a), Some(b), Some(c)] = face.map(corner) else {
                return Err("a face names a corner that is not there".to_owned());
            };
            all.push([a, b, c]);
        }
    }
    Ok(all)
}

/// Finds the file that a URDF in `folder` names. `package://NAME/PATH`, or `package:///NAME/PATH`, is `NAME/PATH` in
/// that folder or one above it, or `PATH` in one called `NAME`; likewise above the folder that symbolic links lead to,
/// in the folders of `ROS_PACKAGE_PATH` and in `share` of those of `AMENT_PREFIX_PATH`; or `PATH` in the package that
/// `rospack` or `ros2 pkg` finds, in this order.
/// Any other name is a path relative to `folder`.
fn find(file: &str, folder: &Path) -> Read<PathBuf> {
    if !file.starts_with("package://") {
        let path = folder.join(file.strip_prefix("file://").unwrap_or(file));
        let missing = || {
            if path.is_absolute() {
                "there is no such file".to_owned()
            } else if folder.as_os_str().is_empty() {
                "there is no such file in the current folder".to_owned()
            } else {
                format!("there is no such file, seen from '{}'", folder.display())
            }
        };
        return if path.is_file() { Ok(path) } else { Err(missing()) };
    }
    let (package, path) = package_and_path(file).ok_or("it has no path")?;
    // The folder of a file without one in its path is empty.
    let absolute = std::path::absolute(folder.join(".")).map_err(|e| e.to_string())?;
    let of_variable = |name| env::var_os(name).unwrap_or_default();
    let (ros, ament) = (of_variable("ROS_PACKAGE_PATH"), of_variable("AMENT_PREFIX_PATH"));
    // A folder that is not there has no canonical path, and no file above it.
    let canonical = absolute.canonicalize().ok();
    let above = [Some(&absolute), canonical.as_ref()].into_iter().flatten();
    let folders = above.flat_map(|path| path.ancestors()).map(Path::to_owned);
    let folders = folders.chain(env::split_paths(&ros));
    let folders = folders.chain(env::split_paths(&ament).map(|prefix| prefix.join("share")));
    let within = |above: PathBuf| {
        let own = above.ends_with(package).then(|| above.join(path));
        [Some(above.join(package).join(path)), own]
    };
    if let Some(path) = folders.flat_map(within).flatten().find(|path| path.is_file()) {
        return Ok(path);
    }
    let found = rospack_find(package);
    if let Some(path) = found.as_ref().ok().map(|found| Path::new(found).join(path))
        && path.is_file()
    {
        return Ok(path);
    }
    let by_ros = found
        .map_or_else(|_| "which are not there or do not find it".to_owned(), |found| format!("which name '{found}'"));
    Err(format!(
        "there is no such file; --package {package}=FOLDER (in a scenario: \"packages\": {{\"{package}\": FOLDER}}, in \
         code: UrdfOptions::packages) says where the package is, as does the environment variable ROS_PACKAGE_PATH \
         with the folder above it; it was looked for at '{}' and above it, in ROS_PACKAGE_PATH={ros:?} and \
         AMENT_PREFIX_PATH={ament:?}, and by the programs rospack and ros2, {by_ros}",
        absolute.display()
    ))
}
