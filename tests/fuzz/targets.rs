//! The use that is made of an input of each format.

use aghf::constraint::{Capsule, Constraint};
use aghf::dynamics::{Data, crba, rnea};
use aghf::experiments::sweep::Sweep;
use aghf::model::Model;
use aghf::motion::sample;
use aghf::output::{evaluate, robot_table};
use aghf::scenario::{Scenario, ScenarioFile, SolveOptions, Solved, solve};
use aghf::urdf::{Mimic, UrdfOptions, builtin_robot, load_urdf_with, parse_urdf_with, summarised};
use nalgebra::DMatrix;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

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
    let message = error.to_string();
    match message.strip_prefix(file) {
        Some(rest) if rest.starts_with(": ") && rest.trim_end().len() > 2 => {
            Ok(Outcome::Refused(rest.to_owned()))
        }
        _ => Err(format!(
            "the message '{message}' does not begin with the file"
        )),
    }
}

fn unexpected(what: &str) -> impl Fn(aghf::Error) -> String {
    move |error| format!("{what}: {error}")
}

/// A URDF file.
pub fn urdf(path: &Path, _: &[u8]) -> Result<Outcome, String> {
    let file = path.to_str().ok_or("the path is text")?;
    let mimic = Mimic::Independent;
    let (model, notes) = match load_urdf_with(path, UrdfOptions { mimic }) {
        Ok(read) => read,
        Err(error) => return refused(file, &error),
    };
    let _ = (robot_table(&model), summarised(&notes));
    notes.iter().for_each(|note| drop(note.to_string()));
    let _ = Capsule::along_links(&model, 0.1);
    evaluated(&model)?;
    // What can be written reads back as it was.
    if let Ok(text) = model.to_urdf() {
        let (read, _) = parse_urdf_with(&text, file, UrdfOptions::default())
            .map_err(unexpected("what was written is refused"))?;
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
    let failed = unexpected("what was accepted cannot be used");
    let written = serde_json::to_string(&scenario.file).map_err(|e| e.to_string())?;
    let read: ScenarioFile = serde_json::from_str(&written).map_err(|e| e.to_string())?;
    if read != scenario.file {
        return Err(format!("it reads back otherwise: {written}"));
    }
    let _ = (summarised(&scenario.load_notes), scenario.outside_limits());
    let _ = scenario.least_horizon();
    let rows = scenario.state_constraints().map_err(&failed)?.dim();
    // A motion that overflows is no fault of the reader.
    if let Ok(solved) = Solved::load(file) {
        let _ = sample(&solved.scenario.model, &solved.curve, 10);
    }
    // That no motion exists is no fault of the reader, nor that a velocity overflows.
    let problem = scenario.problem().is_ok() && scenario.check_feasible().is_ok();
    if problem
        && scenario.model.dof() <= SOLVED_JOINTS
        && rows <= 100
        && bytes.len().is_multiple_of(8)
    {
        let options = SolveOptions {
            degree: Some(6),
            time_limit: Some(Duration::ZERO),
            ..SolveOptions::default()
        };
        // A search that fails is an answer as well.
        let _ = solve(&scenario, &options, &mut |_| {});
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
    sweep.identity().map_err(unexpected("it has no identity"))?;
    if sweep.sets.len() != sweep.sets_a_scenario() * sweep.scenarios.len() {
        return Err(format!("{} sets", sweep.sets.len()));
    }
    for set in sweep.sets.iter().take(100) {
        let _ = sweep.options(&set.parameters);
    }
    Ok(Outcome::Accepted)
}

/// The input of `aghf eval`.
pub fn eval(path: &Path, bytes: &[u8]) -> Result<Outcome, String> {
    static MODEL: OnceLock<Model> = OnceLock::new();
    let file = path.to_str().ok_or("the path is text")?;
    let model = MODEL.get_or_init(|| builtin_robot("pendulum_2").expect("it is built in"));
    match evaluate(model, &String::from_utf8_lossy(bytes), file) {
        Ok(evaluation) => serde_json::to_string(&evaluation)
            .map(|_| Outcome::Accepted)
            .map_err(|e| e.to_string()),
        Err(error) => refused(file, &error),
    }
}
