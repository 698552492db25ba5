//! The examination of the file of a robot: faults that prevent its use.

mod contacts;
mod elements;
mod inertia;
mod notes;
mod page;
mod shapes;

use aghf::error::{Error, Result};
use aghf::model::Model;
use aghf::urdf::{Elements, Follower, LoadReport, Mimic, RobotSource, Srdf, UrdfOptions, build_model, followers};
use contacts::pairs_and_states;
pub use contacts::{Contact, State};
use elements::{kinds, of_joints, of_links, without};
use inertia::of_inertias;
use notes::of_notes;
pub use page::page;
use serde::Serialize;
use shapes::convex;
pub use shapes::{LinkShape, Shapes};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use urdf_rs::{JointType, Robot};

/// The files and the options of an examination.
#[derive(Clone, Debug)]
pub struct Examination {
    /// The name of a built-in robot, or the path of a URDF file.
    pub robot: String,
    /// The SRDF, with disabled pairs of links and named states.
    pub srdf: Option<PathBuf>,
    /// The folders of packages by their names.
    pub packages: BTreeMap<String, PathBuf>,
    /// The distance by which convex pieces may extend beyond a mesh, m; by default that of scenarios.
    pub excess: Option<f64>,
}

/// The findings about a robot.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// The name of the robot as it was given.
    pub robot: String,
    /// Whether motions can be planned for it.
    pub plannable: Plannable,
    /// The number of links.
    pub links: usize,
    /// The number of joints of each kind.
    pub joints: BTreeMap<&'static str, usize>,
    /// The moving mass, kg, if the dynamics could be built.
    pub mass_kg: Option<f64>,
    /// The pairs that keep clear of each other unless a scenario says otherwise.
    pub kept_clear: &'static str,
    /// The collision shapes, if the dynamics could be built.
    pub shapes: Shapes,
    /// The configurations that were examined: zero, and the named states of the SRDF.
    pub states: Vec<State>,
    /// The findings that matter to a user.
    pub findings: Vec<Finding>,
}

/// Whether motions can be planned for a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Plannable {
    /// As it is.
    Yes,
    /// With the keys that findings name.
    WithKeys,
    /// Only after a change of the file.
    No,
}

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The robot is refused whatever the keys.
    Refused,
    /// The robot is refused without a key or an option.
    NeedsKey,
    /// Motions may not be those of the real robot, or may touch obstacles or links.
    Note,
}

/// Something about a file that matters to a user.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// The kind of the elements, such as `joint`.
    pub kind: &'static str,
    /// Their names.
    pub names: Vec<String>,
    /// The fault.
    pub condition: String,
    /// The key, the option or the change of the file that remedies it; empty if there is nothing to remedy.
    pub remedy: String,
}

impl Finding {
    /// The finding about some elements; `None` if there are none.
    fn about(
        severity: Severity,
        kind: &'static str,
        names: impl IntoIterator<Item = String>,
        [condition, remedy]: [&str; 2],
    ) -> Option<Self> {
        let names: Vec<_> = names.into_iter().collect();
        (!names.is_empty()).then(|| Self {
            severity,
            kind,
            names,
            condition: condition.to_owned(),
            remedy: remedy.to_owned(),
        })
    }

    /// The finding of an error.
    fn of_error(error: Error, severity: Severity, remedy: &str) -> Self {
        let (kind, name, condition) = match error {
            Error::Input { file, element, condition } => ("file", file, format!("{element}: {condition}")),
            other => ("file", String::new(), other.to_string()),
        };
        Self { severity, kind, names: vec![name], condition, remedy: remedy.to_owned() }
    }
}

/// Examines a robot. Faults for which the reader refuses the robot are findings, and the rest is examined without them.
///
/// # Errors
/// The excess is not positive, a file cannot be read, or the robot is no URDF.
pub fn examine(examination: &Examination) -> Result<Diagnosis> {
    let is_good = |excess: &f64| excess.is_finite() && *excess > 0.0;
    if let Some(excess) = examination.excess.filter(|excess| !is_good(excess)) {
        let condition = format!("it is {excess} and must be a positive number");
        return Err(Error::input("options", "excess", condition));
    }
    let source = RobotSource::find(&examination.robot, Path::new(""))?;
    let read = Elements::read(&source.text, &source.name())?;
    let robot = &read.robot;
    let mut findings = of_joints(robot);
    findings.extend(of_links(robot));
    findings.extend(of_notes(&read.notes));
    findings.extend(read.faults.into_iter().map(refused));
    let mut diagnosis = Diagnosis {
        robot: examination.robot.clone(),
        plannable: Plannable::Yes,
        links: robot.links.len(),
        joints: kinds(robot),
        mass_kg: None,
        kept_clear: if robot.links.iter().any(|link| !link.collision.is_empty()) {
            "collision shapes of obstacles, and of each other but for neighbours"
        } else {
            "origins of joint frames of obstacles, links not of each other"
        },
        shapes: Shapes::default(),
        states: Vec::new(),
        findings,
    };
    if let Some((examined, model, notes)) = diagnosis.built(robot, &source, examination) {
        let findings = &mut diagnosis.findings;
        findings.extend(of_notes(&notes));
        findings.extend(of_model(&model, robot)?);
        diagnosis.mass_kg = Some(model.mass());
        let followers = followers(&examined, &model, &source.name());
        let followers = followers.unwrap_or_else(|error| {
            let remedy = "the mimic element in the file";
            findings.push(Finding::of_error(error, Severity::Note, remedy));
            Vec::new()
        });
        let bodies = (&model, followers.as_slice(), &examined);
        diagnosis.of_shapes(bodies, source.folder(), examination)?;
    }
    diagnosis.findings.sort_by_key(|finding| finding.severity);
    diagnosis.plannable = match diagnosis.findings.first().map(|first| first.severity) {
        Some(Severity::Refused) => Plannable::No,
        Some(Severity::NeedsKey) => Plannable::WithKeys,
        Some(Severity::Note) | None => Plannable::Yes,
    };
    Ok(diagnosis)
}

/// The finding of an element for which the robot is refused, or of the robot as a whole.
fn refused(error: Error) -> Finding {
    let remedy = match &error {
        Error::Input { element, .. } if element != "robot" => {
            "the element has to be changed in the file; the rest is examined without it"
        }
        _ => "the file has to be changed",
    };
    Finding::of_error(error, Severity::Refused, remedy)
}

impl Diagnosis {
    /// Builds the model, without links and joints for which it is refused: each is a finding. `None` if nothing is left
    /// that can be built.
    fn built(
        &mut self,
        robot: &Robot,
        source: &RobotSource,
        given: &Examination,
    ) -> Option<(Robot, Model, LoadReport)> {
        let options = UrdfOptions {
            mimic: Mimic::Independent,
            hold: true,
            singular: true,
            packages: given.packages.clone(),
            ..UrdfOptions::default()
        };
        let (mut examined, mut removed) = (robot.clone(), BTreeSet::new());
        loop {
            let error = match build_model(&examined, &source.name(), options.clone()) {
                Ok((model, notes)) => return Some((examined, model, notes)),
                Err(error) => error,
            };
            let is_new = match &error {
                Error::Input { element, .. } => removed.insert(element.clone()),
                _ => true,
            };
            let less = match &error {
                Error::Input { element, .. } if is_new => without(&examined, element),
                _ => None,
            };
            // Without the elements with faults there may be no joint that moves, which is no fault of its own.
            let is_first = self.findings.iter().all(|f| f.severity > Severity::Refused);
            let mut joints = examined.joints.iter();
            let moves = joints.any(|joint| joint.joint_type != JointType::Fixed);
            if is_new && (is_first || moves) {
                self.findings.push(refused(error));
            }
            examined = less?;
        }
    }

    /// Adds the shapes of the links and those that overlap.
    fn of_shapes(
        &mut self,
        (model, followers, robot): (&Model, &[Follower], &Robot),
        folder: &Path,
        given: &Examination,
    ) -> Result<()> {
        let srdf = match &given.srdf {
            None => None,
            Some(path) => match Srdf::load(path, model) {
                Ok(srdf) => Some((srdf, path.display().to_string())),
                Err(error @ Error::Io { .. }) => return Err(error),
                Err(error) => {
                    let remedy = "the SRDF has to be changed; it is not used in what follows";
                    (self.findings).push(Finding::of_error(error, Severity::Note, remedy));
                    None
                }
            },
        };
        let unknown = srdf.iter().flat_map(|(srdf, _)| srdf.unknown_links.iter().cloned());
        let words = [
            "the SRDF has a pair of links with it, and the robot does not have it",
            "no action needed, unless the name is misspelt",
        ];
        self.findings.extend(Finding::about(Severity::Note, "link", unknown, words));
        let with_spheres = match &srdf {
            Some((srdf, _)) => srdf.with_spheres(model.clone())?,
            None => model.clone(),
        };
        let (shapes, geometry, found) = convex(&with_spheres, folder, given.excess);
        self.findings.extend(found);
        self.findings.extend(of_inertias(robot, model, &geometry));
        let excess = shapes.excess_of_links();
        let srdf = srdf.as_ref().map(|(srdf, file)| (srdf, file.as_str()));
        let (states, found) = pairs_and_states((model, followers), srdf, &geometry, &excess, &given.robot)?;
        self.findings.extend(found);
        self.shapes = shapes;
        self.states = states;
        Ok(())
    }
}

/// The findings about the dynamics.
fn of_model(model: &Model, robot: &Robot) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let singular = model.singular_joints()?;
    if let Some((_, condition)) = singular.first() {
        let names = singular.iter().map(|(i, _)| model.joints()[*i].name().to_owned());
        let rotor = "planned with a rotor inertia that stands in for it; \"losses\": {\"armature\": {JOINT: KG_M2}} \
                     sets another";
        let alike = "\"losses\": {\"armature\": {JOINT: KG_M2}}, \"locked_joints\": {JOINT: POSITION}, or a \
                     \"group\" without it";
        let (severity, remedy) =
            if model.substitute_rotors()?.is_empty() { (Severity::NeedsKey, alike) } else { (Severity::Note, rotor) };
        let (reason, _) = condition.split_once(';').unwrap_or((condition, ""));
        (findings).extend(Finding::about(severity, "joint", names, [reason, remedy]));
    }
    if robot.links.iter().all(|link| link.collision.is_empty()) {
        let condition = "no link has a collision element, so obstacles keep clear of joint frames alone";
        let remedy = "\"robot_shape\": {\"swept_links\": {\"radius_m\": R}}, or --srdf with spheres";
        findings.extend(Finding::about(Severity::Note, "robot", [robot.name.clone()], [condition, remedy]));
    }
    Ok(findings)
}
