//! The problems of a benchmark.

use aghf::error::{Error, Result};
use aghf::input::{entries, name_of};
use aghf::urdf::Mimic;
use aghf_scenario::{MoveIt, MoveItHorizon, Preset, Scenario};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The distance by which convex pieces may extend beyond a mesh, m.
const EXCESS: f64 = 0.005;

/// A problem of a benchmark.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its family.
    pub family: String,
    /// Its unique name.
    pub name: String,
    files: Files,
}

/// The files of a problem.
#[derive(Clone, Debug)]
enum Files {
    Scenario(PathBuf),
    MoveIt(Box<MoveIt>),
}

impl Problem {
    /// Loads the scenario of the problem.
    ///
    /// # Errors
    /// Names the file and the fault.
    pub fn load(&self) -> Result<Scenario> {
        match &self.files {
            Files::Scenario(path) => Scenario::load(&path.display().to_string()),
            Files::MoveIt(files) => files.scenario(&self.name),
        }
    }
}

/// Finds the problems in `folder`, by family and name.
///
/// The folder contains scenarios, `FAMILY_NUMBER.json`; or, directly or in `problems`, one folder per family, `FAMILY`
/// or `FAMILY_ROBOT`, with MoveIt's scenes and requests, `sceneNUMBER.yaml` and `requestNUMBER.yaml`, and next to them
/// the SRDF `ROBOT.srdf`. `robot` is a built-in name or the path of a URDF file
/// with meshes in `packages`; scenarios name their robot.
///
/// # Errors
/// The folder cannot be read, or contains neither.
pub fn problems(folder: &Path, robot: &str, packages: &BTreeMap<String, PathBuf>) -> Result<Vec<Problem>> {
    let mut found = Vec::new();
    for path in entries(folder)? {
        if path.extension().is_some_and(|ending| ending == "json") {
            let name = name_of(&path.to_string_lossy());
            let family = name.rsplit_once('_').map_or(name.as_str(), |(family, _)| family);
            found.push(Problem { family: family.to_owned(), files: Files::Scenario(path), name });
        }
    }
    if found.is_empty() {
        let srdf = folder.join(format!("{}.srdf", name_of(robot)));
        let inner = folder.join("problems");
        let of_families = if inner.is_dir() { inner } else { folder.to_owned() };
        for family in entries(&of_families)? {
            if family.is_dir() {
                found.extend(of_moveit(&family, (robot, packages), &srdf)?);
            }
        }
    }
    if found.is_empty() {
        let condition = "it has neither scenarios nor folders of scenes and requests";
        return Err(Error::input(folder.display().to_string(), "folder", condition));
    }
    Ok(found)
}

/// The problems of a family in MoveIt's files.
fn of_moveit(
    folder: &Path,
    (robot, packages): (&str, &BTreeMap<String, PathBuf>),
    srdf: &Path,
) -> Result<Vec<Problem>> {
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = name.unwrap_or_default();
    let suffix = format!("_{}", name_of(robot));
    let family = name.strip_suffix(&suffix).unwrap_or(&name);
    let mut found = Vec::new();
    for scene in entries(folder)? {
        let stem = name_of(&scene.to_string_lossy());
        let Some(number) = stem.strip_prefix("scene") else {
            continue;
        };
        let request = folder.join(format!("request{number}.yaml"));
        let files = MoveIt {
            scene,
            request,
            urdf: robot.to_owned(),
            packages: packages.clone(),
            mimic: Mimic::default(),
            srdf: srdf.is_file().then(|| srdf.to_owned()),
            joint_limits: None,
            excess: EXCESS,
            horizon: MoveItHorizon::Free,
            objective: Preset::Balanced,
        };
        found.push(Problem {
            family: family.to_owned(),
            name: format!("{family}_{number}"),
            files: Files::MoveIt(Box::new(files)),
        });
    }
    Ok(found)
}
