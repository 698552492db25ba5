//! The phases of a walk, in each of which the robot stands on another foot.

use crate::keys::durations::check_durations;
use crate::{Continuous, Goal, Kept, PointOnTheWay, Pose, PositionBox, Scenario, ScenarioFile, Stand};
use aghf::constraint::{AnyConstraint, Constraint, Phase, StandingFoot};
use aghf::direct::Waypoint;
use aghf::error::{Error, Result};
use aghf::model::{Joint, Model};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A phase of a walk: the robot stands on a foot, and at the end another one lands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WalkPhase {
    /// The foot on which the robot stands: a link with `z` upwards, which becomes the root of the robot in this phase.
    pub stand: Stand,
    /// The pose at which another foot lands at the end, by default in the frame of the foot that stands: a position and
    /// an orientation without tolerances, which it reaches without speed. The last one may have tolerances, or the
    /// scenario `q_goal` or `goal` instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub land: Option<Goal>,
    /// The least height of that foot over the one that stands halfway through the phase, m; by default the effort
    /// decides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lift_m: Option<f64>,
    /// The shortest duration of the phase, s, beside the longest one: the duration is then an unknown. A phase without
    /// them has its share of `horizon_s`, or of a free horizon if no phase has them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_s: Option<f64>,
    /// The longest duration of the phase, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest_s: Option<f64>,
    /// The sets of poses in which frames stay in this phase, by default in the frame of the foot that stands.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keep: Vec<Goal>,
}

impl WalkPhase {
    /// A set of poses in the frame of the foot that stands, unless it is in another one.
    fn relative(&self, poses: &Goal) -> Goal {
        let relative_to = poses.relative_to.clone();
        Goal { relative_to: relative_to.or_else(|| Some(self.stand.frame.clone())), ..poses.clone() }
    }

    /// The set of poses halfway through the phase, of a foot that is lifted.
    fn lifted(&self) -> Option<Goal> {
        let (height, land) = self.lift_m.zip(self.land.as_ref())?;
        let pose = Pose { position_m: [0.0, 0.0, height + 0.5 * MAX_HEIGHT], orientation_xyzw: None };
        let size_m = [None, None, Some(MAX_HEIGHT)];
        Some(self.relative(&Goal {
            frame: land.frame.clone(),
            relative_to: land.relative_to.clone(),
            position_m: None,
            tolerance_m: None,
            within: Some(PositionBox { size_m, pose }),
            orientation_xyzw: None,
            axis: None,
            tolerance_rad: None,
        }))
    }

    /// The sets of poses on the way, each with its key and its share of phase `k`: that of a foot halfway, and where it
    /// lands unless a goal has that.
    fn sets(&self, k: usize, has_goal: bool) -> impl Iterator<Item = (String, Goal, f64)> {
        let lifted = self.lifted().map(|set| (format!("phases[{k}].lift_m"), set, 0.5));
        let land = self.land.as_ref().filter(|_| !has_goal);
        let land = land.map(|land| self.relative(land));
        let land = land.map(|land| (format!("phases[{k}].land"), land, 1.0));
        lifted.into_iter().chain(land)
    }
}

/// The height of the box of poses in which a foot is that is lifted, m: beyond the reach of any leg.
const MAX_HEIGHT: f64 = 10.0;

/// The accepted difference of a cosine from one between upright feet: 1e-4 rad, for quaternions that are rounded.
const UPRIGHT: f64 = 5e-9;

/// A phase on the robot of a walk.
#[derive(Clone, Debug)]
pub(crate) struct PhaseTerms {
    /// The robot with the foot as its root.
    pub model: Model,
    /// The joint of the walk for each joint of this robot.
    pub order: Vec<usize>,
    foot: StandingFoot,
    /// The rows of the conditions, on the robot of the walk.
    pub kept: Vec<AnyConstraint>,
}

/// Completes the keys of a walk by those of its first phase and the landing of its last one; `path` names the scenario
/// in errors.
pub(crate) fn complete(file: &mut ScenarioFile, path: &str) -> Result<()> {
    let refuse = |key: &str, condition: &str| Err(Error::input(path, key, format!("phases: {condition}")));
    let Some((first, last)) = file.phases.first().zip(file.phases.last()) else {
        return if file.periodic { refuse("periodic", "there are none") } else { Ok(()) };
    };
    for (key, given) in [
        ("waypoints", !file.waypoints.is_empty()),
        ("keep", !file.keep.is_empty()),
        ("passive", !file.passive.is_empty()),
        ("obstacles", !file.obstacles.is_empty()),
        ("mount", file.mount.is_some()),
        ("free_final_velocity", file.free_final_velocity),
        ("a_start", file.a_start.is_some()),
        ("a_goal", file.a_goal.is_some()),
        ("start_tolerance", file.start_tolerance.is_some()),
    ] {
        if given {
            return refuse(key, "a walk does not support it");
        }
    }
    if file.continuity() == Continuous::Acceleration {
        return refuse("continuity", "accelerations jump where the foot changes");
    }
    if file.objective.preset().is_none() {
        return refuse("objective", "a walk accepts named objectives only");
    }
    if last.land.is_some() && !file.periodic && file.v_goal.iter().any(|v| *v != 0.0) {
        return refuse("v_goal", "where the last foot lands it ends at rest");
    }
    if file.stand.as_ref().is_some_and(|stand| *stand != first.stand) {
        return refuse("stand", "it is not that of the first phase");
    }
    if file.root.as_ref().is_some_and(|root| *root != first.stand.frame) {
        return refuse("root", "it is not the foot of the first phase");
    }
    check_durations(file, path)?;
    let land = last.land.iter().filter(|_| !file.periodic);
    let goal: Vec<_> = land.map(|land| last.relative(land)).collect();
    match (goal.is_empty(), file.goal.is_empty(), file.q_goal.is_empty()) {
        (false, true, true) => (),
        (false, false, _) if file.goal == goal => (),
        (true, ..) => (),
        _ => {
            let condition = "the last one has one, beside another goal of the walk";
            return refuse("phases.land", condition);
        }
    }
    let (stand, root) = (first.stand.clone(), first.stand.frame.clone());
    if !goal.is_empty() {
        file.goal = goal;
    }
    (file.stand, file.root) = (Some(stand), Some(root));
    Ok(())
}

/// The scenario of one phase of this duration: the robot on its foot, with the states of the walk by the joints of the
/// walk.
pub(crate) fn of_phase(file: &ScenarioFile, phase: &WalkPhase, horizon_s: f64) -> ScenarioFile {
    let kept = phase.keep.iter().map(|poses| Kept {
        poses: Some(phase.relative(poses)),
        speed: None,
        from_s: None,
        to_s: None,
    });
    let lifted = phase.lifted().map(|poses| PointOnTheWay {
        poses: Some(poses),
        time_s: Some(0.5 * horizon_s),
        ..PointOnTheWay::default()
    });
    ScenarioFile {
        waypoints: lifted.into_iter().collect(),
        root: Some(phase.stand.frame.clone()),
        stand: Some(phase.stand.clone()),
        keep: kept.collect(),
        horizon_s,
        free_horizon: None,
        continuity: Some(Continuous::Velocity),
        objective: Default::default(),
        phases: Vec::new(),
        periodic: false,
        goal: Vec::new(),
        q_goal: file.q_start.clone(),
        v_goal: vec![0.0; file.q_start.len()],
        ..file.clone()
    }
}

/// The robot with this foot as its root, and the joint of the walk for each of its joints.
pub(crate) fn robot_of_phase(
    file: &ScenarioFile,
    model: &Model,
    stand: &Stand,
    place: (&str, &Path),
) -> Result<(Model, Vec<usize>)> {
    let phase = WalkPhase {
        stand: stand.clone(),
        land: None,
        lift_m: None,
        shortest_s: None,
        longest_s: None,
        keep: Vec::new(),
    };
    let (of, order) = scenario_of_phase(file, model, &phase, place)?;
    Ok((of.model, order))
}

/// The scenario of a phase, and the joint of the walk for each joint of its robot.
fn scenario_of_phase(
    file: &ScenarioFile,
    model: &Model,
    phase: &WalkPhase,
    (path, folder): (&str, &Path),
) -> Result<(Scenario, Vec<usize>)> {
    let horizon = file.horizon_s / file.phases.len() as f64;
    let of = Scenario::new(of_phase(file, phase, horizon), path, folder)?;
    let names = of.model.joints().iter().map(Joint::name);
    let order = names.map(|name| model.joints().iter().position(|of| of.name() == name));
    let order = order.collect::<Option<_>>().ok_or_else(|| {
        let condition = "its robot has other joints than that of the first phase";
        Error::input(path, "stand", condition)
    })?;
    Ok((of, order))
}

/// The phases of a walk on its robot; `path` names the scenario in errors, and the robot is looked for in `folder`.
pub(crate) fn phase_terms(
    file: &ScenarioFile,
    model: &Model,
    (path, folder): (&str, &Path),
) -> Result<Vec<PhaseTerms>> {
    let mut all = Vec::new();
    for (k, phase) in file.phases.iter().enumerate() {
        let key = format!("phases[{k}]");
        let (of, order) = scenario_of_phase(file, model, phase, (path, folder))
            .map_err(|e| Error::input(path, &key, e.to_string()))?;
        let Some(foot) = of.own.foot.clone() else {
            return Err(Error::input(path, key, "no foot stands"));
        };
        let mut kept = Vec::new();
        for (i, poses) in phase.keep.iter().enumerate() {
            let poses = phase.relative(poses);
            kept.extend(poses.rows(model, &format!("{key}.keep[{i}]"), path)?);
        }
        all.push(PhaseTerms { model: of.model, order, foot, kept });
    }
    Ok(all)
}

/// The points on the way of a walk, each at its share of the horizon: feet that are lifted, and the landings at the
/// ends of all phases but the last one.
pub(crate) fn points_of_walk(file: &ScenarioFile, model: &Model, path: &str) -> Result<Vec<Waypoint>> {
    let (mut all, count) = (Vec::new(), file.phases.len());
    for (k, phase) in file.phases.iter().enumerate() {
        let refuse = |key: &str, condition: &str| Err(Error::input(path, format!("phases[{k}].{key}"), condition));
        let is_last = k + 1 == count;
        let has_goal = is_last && !file.periodic;
        match (&phase.land, phase.lift_m) {
            (None, _) if !is_last => return refuse("land", "it is missing"),
            (None, Some(_)) => return refuse("lift_m", "it needs land, which names the foot"),
            (_, Some(height)) if !(0.0..=MAX_HEIGHT).contains(&height) => {
                return refuse("lift_m", "a height from 0 to 10 m is needed");
            }
            _ => (),
        }
        for (key, set, share) in phase.sets(k, has_goal) {
            let lands = share == 1.0;
            let next = file.phases.get(k + 1).map(|next| &next.stand.frame);
            if lands && next.is_some_and(|next| *next != set.frame) {
                return refuse("land.frame", "it is not the foot of the next phase");
            }
            let has_tolerance = set.tolerance_m.is_some() || set.tolerance_rad.is_some();
            if lands && (set.position_m.is_none() || set.orientation_xyzw.is_none() || has_tolerance) {
                let condition = "a position and an orientation without tolerances are needed";
                return refuse("land", condition);
            }
            if lands && !is_upright(&set) {
                return refuse("land.orientation_xyzw", "the z axis of the foot is not upwards");
            }
            all.push(Waypoint {
                constraints: set.rows(model, &key, path)?,
                lands,
                share: Some((k as f64 + share) / count as f64),
                ..Waypoint::new(file.q_start.clone())
            });
        }
    }
    Ok(all)
}

/// Returns true if the frame has its `z` axis along that of the frame in which the pose is.
fn is_upright(land: &Goal) -> bool {
    let pose = Pose { position_m: [0.0; 3], orientation_xyzw: land.orientation_xyzw };
    let up = pose.placement().map(|placement| placement.rotation[(2, 2)]);
    up.is_ok_and(|up| up > 1.0 - UPRIGHT)
}

impl Scenario {
    /// Refuses a walk, which has a scenario per phase.
    pub(crate) fn refuse_walk(&self) -> Result<()> {
        if self.phases.is_empty() {
            return Ok(());
        }
        let condition = "a walk has a scenario and a report per phase, which aghf solve and Solve::run_walk make";
        Err(Error::input(&self.name, "phases", condition))
    }

    /// The sets of poses at the points on the way, with their keys.
    pub(crate) fn sets_on_the_way(&self) -> Vec<(String, Option<Goal>)> {
        let file = &self.file;
        if file.phases.is_empty() {
            let points = file.waypoints.iter().enumerate();
            let points = points.map(|(k, of)| (format!("waypoints[{k}]"), of.poses.clone()));
            return points.collect();
        }
        let last = file.phases.len() - 1;
        let phases = file.phases.iter().enumerate();
        let sets = phases.flat_map(|(k, phase)| phase.sets(k, k == last && !file.periodic));
        sets.map(|(key, set, _)| (key, Some(set))).collect()
    }

    /// The phases as constraints, whose rows of the state begin after `first` others.
    pub(crate) fn phase_constraints(&self, first: usize) -> Vec<Phase> {
        let mut end = first;
        let phases = self.phases.iter().map(|of| {
            let start = end;
            end += of.kept.dim();
            Phase { model: of.model.clone(), order: of.order.clone(), foot: of.foot.clone(), rows: start..end }
        });
        phases.collect()
    }
}
