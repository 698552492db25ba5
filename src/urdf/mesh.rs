//! The triangles of the meshes in a URDF.

use crate::error::{Error, Result};
use crate::geometry::Triangle;
use crate::input::read_bytes;
use mesh_loader::{Scene, obj, stl};
use nalgebra::Vector3;
use std::io;
use std::path::{Path, PathBuf};
use urdf_rs::utils::rospack_find;

/// Loads the triangles of the mesh that a URDF in `folder` calls `file`, with its axes scaled by `scale`, in m. The
/// formats are STL, binary or text, and OBJ; coordinates have about seven digits. Packages are looked up in `folder`,
/// in the folders above it, and by the programs `rospack` or `ros2 pkg`.
///
/// # Errors
/// The file does not exist, has another format or no triangles, or contains numbers that are not finite.
pub fn load_mesh(file: &str, folder: &Path, scale: &Vector3<f64>) -> Result<Vec<Triangle>> {
    let extension = Path::new(file).extension().unwrap_or_default();
    let extension = extension.to_string_lossy().to_lowercase();
    if !["stl", "obj"].contains(&extension.as_str()) {
        let condition = "only STL and OBJ can be read: convert it, or give the link spheres, boxes, cylinders or \
                         capsules instead";
        return Err(Error::input(file, "mesh", condition));
    }
    let path = find(file, folder).map_err(|e| Error::input(file, "mesh", e))?;
    let name = path.display().to_string();
    let bytes = read_bytes(&path)?;
    let scene = match extension.as_str() {
        "stl" => stl::from_slice(&bytes),
        // Materials do not matter here: an empty file stands for each.
        _ => obj::from_slice(&bytes, Some(&path), |_| -> io::Result<Vec<u8>> {
            Ok(Vec::new())
        }),
    };
    let scene = scene.map_err(|e| Error::input(&name, "mesh", e.to_string()))?;
    let triangles = triangles(&scene, scale)
        .ok_or_else(|| Error::input(&name, "mesh", "a face names a corner that is not there"))?;
    let finite = |triangle: &Triangle| triangle.iter().all(|p| p.iter().all(|x| x.is_finite()));
    if triangles.is_empty() {
        return Err(Error::input(name, "mesh", "it has no triangles"));
    }
    if !triangles.iter().all(finite) {
        let condition = "a coordinate of it is not a finite number";
        return Err(Error::input(name, "mesh", condition));
    }
    Ok(triangles)
}

/// The triangles of all meshes of a file; `None` if an index of a corner is out of range.
fn triangles(scene: &Scene, scale: &Vector3<f64>) -> Option<Vec<Triangle>> {
    let mut all = Vec::new();
    for mesh in &scene.meshes {
        for face in &mesh.faces {
            let corner = |i: u32| {
                let point = mesh.vertices.get(i as usize)?;
                Some(Vector3::from(point.map(f64::from)).component_mul(scale))
            };
            let [a, b, c] = face.map(corner);
            all.push([a?, b?, c?]);
        }
    }
    Some(all)
}

/// Finds the file that a URDF in `folder` names. `package://NAME/PATH` is `NAME/PATH` in that folder or one above it,
/// `PATH` in a folder called `NAME`, or `PATH` in the package that `rospack` or `ros2 pkg` finds, in this order; any
/// other name is a path relative to `folder`.
fn find(file: &str, folder: &Path) -> std::result::Result<PathBuf, String> {
    let missing = || format!("there is no such file at '{}'", folder.display());
    let Some(in_package) = file.strip_prefix("package://") else {
        let path = folder.join(file.strip_prefix("file://").unwrap_or(file));
        return path.is_file().then_some(path).ok_or_else(missing);
    };
    let absolute = std::path::absolute(folder).map_err(|e| e.to_string())?;
    let (package, path) = in_package.split_once('/').ok_or("it has no path")?;
    let within = |above: &Path| {
        let named = above.file_name().is_some_and(|name| name == package);
        let own = named.then(|| above.join(path));
        [Some(above.join(in_package)), own]
    };
    let mut all = absolute.ancestors().flat_map(within).flatten();
    if let Some(path) = all.find(|path| path.is_file()) {
        return Ok(path);
    }
    let above = format!("{} or above it", missing());
    let found = rospack_find(package).map_err(|e| format!("{above}, and {e}"))?;
    let path = Path::new(&found).join(path);
    (path.is_file().then_some(path)).ok_or_else(|| format!("{above}, nor in '{found}'"))
}
