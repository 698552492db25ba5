//! The use that is made of an input of each format.

use aghf::constraint::Constraint;
use aghf::dynamics::{Data, crba, rnea};
use aghf::geometry::{Capsule, convex_pieces};
use aghf::model::Model;
use aghf::motion::sample;
use aghf::urdf::{Mimic, Srdf, UrdfOptions, builtin_robot, load_mesh, load_urdf_with, parse_urdf_with, summarised};
use aghf_cli::output::{evaluate, robot_table};
use aghf_cli::sweep::Sweep;
use aghf_scenario::judge::{Tolerances, Trajectory, judge};
use aghf_scenario::{DirectOptions, MoveIt, MoveItHorizon, Preset, Scenario, ScenarioFile, Solve, Solved};
use nalgebra::{DMatrix, Vector3};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

/// Tries an input that is in the file at this path as well. The error says what is wrong with what came of it.
pub type Target = fn(&Path, &[u8]) -> Result<Outcome, String>;

/// The result of an input.
pub enum Outcome {
    Accepted,
    /// With this message.
    Refused(String),
}

/// The most joints of a scenario that is solved as well.
const SOLVED_JOINTS: usize = 3;

/// Checks that a message names the file.
fn refused(file: &str, error: &aghf::Error) -> Result<Outcome, String> {
    refused_of(&[file], error)
}

/// Checks that a message names one of the files that were read.
fn refused_of(files: &[&str], error: &aghf::Error) -> Result<Outcome, String> {
    let message = error.to_string();
    let rest = files.iter().find_map(|file| message.strip_prefix(file));
    match rest {
        Some(rest) if rest.starts_with(": ") && rest.trim_end().len() > 2 => Ok(Outcome::Refused(rest.to_owned())),
        _ => Err(format!("the message '{message}' does not begin with the file")),
    }
}

fn unexpected(what: &str) -> impl Fn(aghf::Error) -> String {
    move |error| format!("{what}: {error}")
}

/// A URDF file.
pub fn urdf(path: &Path, _: &[u8]) -> Result<Outcome, String> {
    let file = path.to_str().ok_or("the path is text")?;
    let mimic = Mimic::Independent;
    let (model, notes) = match load_urdf_with(path, UrdfOptions { mimic, ..UrdfOptions::default() }) {
        Ok(read) => read,
        Err(error) => return refused(file, &error),
    };
    let _ = (robot_table(&model), summarised(&notes));
    notes.iter().for_each(|note| drop(note.to_string()));
    let _ = Capsule::along_links(&model, 0.1);
    evaluated(&model)?;
    // What can be written reads back as it was.
    if let Ok(text) = model.to_urdf() {
        let (read, _) =
            parse_urdf_with(&text, file, UrdfOptions::default()).map_err(unexpected("what was written is refused"))?;
        if read.dof() != model.dof() {
            return Err(format!("{} joints are written", model.dof()));
        }
    }
    Ok(Outcome::Accepted)
}

/// The dynamics of a model at zero.
fn evaluated(model: &Model) -> Result<(), String> {
    let n = model.dof();
    let (zeros, mut torques, mut h) = (vec![0.0; n], vec![0.0; n], DMatrix::zeros(n, n));
    let data = &mut Data::new(model);
    let failed = unexpected("the dynamics fail");
    rnea(model, data, &zeros, &zeros, &zeros, &mut torques).map_err(&failed)?;
    crba(model, data, &zeros, &mut h).map_err(&failed)
}

/// A scenario, or the summary of a solve; a small one is solved too, as far as the first starts lead.
pub fn scenario(path: &Path, bytes: &[u8]) -> Result<Outcome, String> {
    let file = path.to_str().ok_or("the path is text")?;
    let scenario = match Scenario::load(file) {
        Ok(scenario) => scenario,
        Err(error) => return refused(file, &error),
    };
    let written = serde_json::to_string(&scenario.file).map_err(|e| e.to_string())?;
    let read: ScenarioFile = serde_json::from_str(&written).map_err(|e| e.to_string())?;
    if read != scenario.file {
        return Err(format!("it reads back otherwise: {written}"));
    }
    let _ = (summarised(&scenario.load_notes), scenario.outside_limits());
    let _ = scenario.least_horizon();
    let rows = scenario.state_constraints().dim();
    // A motion that overflows is no fault of the reader.
    if let Ok(solved) = Solved::load(file) {
        let _ = sample(&solved.scenario.model, &solved.curve, 10);
    }
    // That no motion exists is no fault of the reader, nor that a velocity overflows.
    let problem = scenario.problem().is_ok() && scenario.check_feasible().is_ok();
    if problem && scenario.model.dof() <= SOLVED_JOINTS && rows <= 100 && bytes.len().is_multiple_of(8) {
        let options = DirectOptions { degree: Some(6), time_limit_s: Some(0.0), ..DirectOptions::default() };
        // A search that fails is an answer as well.
        let _ = Solve::new(&scenario).options(options.clone()).run();
    }
    Ok(Outcome::Accepted)
}

/// A sweep.
pub fn sweep(path: &Path, _: &[u8]) -> Result<Outcome, String> {
    let file = path.to_str().ok_or("the path is text")?;
    let sweep = match Sweep::load(file) {
        Ok(sweep) => sweep,
        Err(error) => return refused(file, &error),
    };
    let _ = sweep.identity();
    if sweep.sets.len() != sweep.sets_a_scenario() * sweep.problems.len() {
        return Err(format!("{} sets", sweep.sets.len()));
    }
    for set in sweep.sets.iter().take(100) {
        let options = sweep.options(set).map_err(unexpected("a set without options"))?;
        let Ok(scenario) = sweep.scenario(set) else {
            continue;
        };
        options.check(scenario).map_err(unexpected("a set that cannot be solved"))?;
    }
    Ok(Outcome::Accepted)
}

/// The input of `aghf eval`.
pub fn eval(path: &Path, bytes: &[u8]) -> Result<Outcome, String> {
    static MODEL: OnceLock<Model> = OnceLock::new();
    let file = path.to_str().ok_or("the path is text")?;
    let model = MODEL.get_or_init(|| builtin_robot("pendulum_2").expect("it is built in"));
    match evaluate(model, &String::from_utf8_lossy(bytes), file) {
        Ok(evaluation) => serde_json::to_string(&evaluation).map(|_| Outcome::Accepted).map_err(|e| e.to_string()),
        Err(error) => refused(file, &error),
    }
}

/// The robot of the scenes, requests and SRDFs.
const ROBOT: &str = r#"<robot name="small">
  <link name="base"/>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0.3 0 0"/><geometry><cylinder radius="0.04" length="0.2"/></geometry></collision></link>
  <link name="hand"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1.5" effort="50"/></joint>
  <joint name="wrist" type="revolute"><origin xyz="0.5 0 0"/><parent link="arm"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="50"/></joint>
</robot>"#;

/// The files of a problem beside the one that is mutated.
const BESIDE: [(&str, &str); 3] = [
    ("robot.urdf", ROBOT),
    ("scene.yaml", include_str!("corpus/scene/shelf.yaml")),
    ("request.yaml", include_str!("corpus/request/to.yaml")),
];

/// A planning problem of MoveIt of which the file called `mutated` is the one at `path`.
fn moveit(path: &Path, mutated: &str) -> Result<Outcome, String> {
    let folder = path.parent().ok_or("it is in a folder")?;
    let [urdf, scene, request] =
        BESIDE.map(|(name, _)| if name == mutated { path.to_owned() } else { folder.join(name) });
    for (name, text) in BESIDE {
        std::fs::write(folder.join(name), text).map_err(|e| e.to_string())?;
    }
    let [scene_name, request_name] = [&scene, &request].map(|path| path.display().to_string());
    let files = MoveIt {
        scene,
        request,
        urdf: urdf.display().to_string(),
        packages: BTreeMap::new(),
        mimic: Mimic::Refuse,
        srdf: None,
        joint_limits: None,
        excess: 0.005,
        horizon: MoveItHorizon::Free,
        objective: Preset::Balanced,
    };
    let made = folder.join("scenario.json");
    let scenario = match files.scenario(&made.display().to_string()) {
        Ok(scenario) => scenario,
        Err(error) => return refused_of(&[&scene_name, &request_name], &error),
    };
    serde_json::to_string(&scenario.file).map_err(|e| e.to_string())?;
    Ok(Outcome::Accepted)
}

/// A planning scene.
pub fn scene(path: &Path, _: &[u8]) -> Result<Outcome, String> {
    moveit(path, "scene.yaml")
}

/// A planning request.
pub fn request(path: &Path, _: &[u8]) -> Result<Outcome, String> {
    moveit(path, "request.yaml")
}

/// An SRDF.
pub fn srdf(path: &Path, _: &[u8]) -> Result<Outcome, String> {
    let file = path.to_str().ok_or("the path is text")?;
    let (model, _) = parse_urdf_with(ROBOT, "robot.urdf", UrdfOptions::default()).map_err(unexpected("the robot"))?;
    let read = Srdf::load(path, &model).and_then(|srdf| {
        for group in &srdf.groups {
            let _ = srdf.joints_of_group(&group.name, &model, file);
        }
        for state in &srdf.states {
            let _ = srdf.positions(state, &model, file);
        }
        srdf.with_spheres(model)
    });
    match read {
        Ok(model) => evaluated(&model).map(|()| Outcome::Accepted),
        Err(error) => refused(file, &error),
    }
}

/// A table of a motion, which is judged as well.
pub fn trajectory(path: &Path, _: &[u8]) -> Result<Outcome, String> {
    static SCENARIO: OnceLock<Scenario> = OnceLock::new();
    let file = path.to_str().ok_or("the path is text")?;
    let of = || Scenario::load("pendulum_2_swingup").expect("it is built in");
    let scenario = SCENARIO.get_or_init(of);
    match Trajectory::load(path, &scenario.model) {
        // What cannot be judged, such as numbers that overflow, is an error too.
        Ok(trajectory) => {
            let _ = judge(scenario, &trajectory, Tolerances::default());
            Ok(Outcome::Accepted)
        }
        Err(error) => refused(file, &error),
    }
}

/// A mesh, in each of the formats.
pub fn mesh(path: &Path, bytes: &[u8]) -> Result<Outcome, String> {
    let folder = path.parent().ok_or("it is in a folder")?;
    let mut outcome = Outcome::Refused("none".to_owned());
    for name in ["mesh.stl", "mesh.obj"] {
        let file = folder.join(name);
        std::fs::write(&file, bytes).map_err(|e| e.to_string())?;
        match load_mesh(name, folder, &Vector3::repeat(1.0)) {
            Ok(triangles) => {
                let corners = triangles.iter().flatten();
                let largest = corners.fold(0.0, |largest, p| p.amax().max(largest));
                let _ = convex_pieces(&triangles, 0.1 * largest);
                outcome = Outcome::Accepted;
            }
            Err(error) => {
                refused(&file.display().to_string(), &error)?;
            }
        }
    }
    Ok(outcome)
}
