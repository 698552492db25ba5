//! The data of a page.

use super::encode::of_f32;
use super::facts::SolveFacts;
use super::foot::Foot;
use super::links::tips;
use super::plots::{Axes, Line, Plot, colours, css, plot};
use super::scene::{Scene, scene_of};
use super::track::{Clearance, GHOST, MOTION, Track, placements_of, rows_of};
use aghf::curve::Curve;
use aghf::direct::LocalMinimum;
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::error::Result;
use aghf::model::JointKind;
use aghf::motion::Sample;
use aghf::spatial::Placement;
use aghf_scenario::{Details, Quantity, Record, Scenario, SolveReport, Solved, Summary};
use nalgebra::Vector3;
use serde::Serialize;

/// The largest number of ghosts next to a motion: its first guess, and other minima.
const MAX_GHOSTS: usize = 3;

/// A motion to be displayed.
pub struct Motion<'a> {
    /// Its scenario.
    pub scenario: &'a Scenario,
    /// Its curve.
    pub curve: &'a Curve,
    /// The reasons why it is not valid; `None` if it is.
    pub failure: Option<&'a str>,
    facts: SolveFacts,
    /// The report of its solve.
    outcome: Option<&'a SolveReport>,
}

impl<'a> Motion<'a> {
    /// The motion of a solve.
    #[must_use]
    pub fn of_report(scenario: &'a Scenario, outcome: &'a SolveReport) -> Self {
        let summary = &outcome.summary;
        Self {
            scenario,
            curve: &outcome.curve,
            failure: summary.failure.as_deref(),
            facts: SolveFacts::of_solve(summary),
            outcome: Some(outcome),
        }
    }

    /// The motion of a solve whose summary is in the file at `path`, without the progress of its search.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn of_solved(solved: &'a Solved, path: &str) -> Result<Self> {
        Ok(Self {
            scenario: &solved.scenario,
            curve: &solved.curve,
            failure: solved.summary.failure.as_deref(),
            facts: SolveFacts::of_file(&solved.summary, path),
            outcome: None,
        })
    }
}

#[derive(Serialize)]
struct JointData {
    name: String,
    /// "rad" or "m".
    unit: &'static str,
    color: String,
    /// The integral of the squared torque.
    effort: f64,
}

/// The passage of a waypoint.
#[derive(Serialize)]
struct Passage {
    /// The time, s.
    time: f64,
    /// The place of its frame, or of the first tip for a configuration, in the base frame, m; `None` for a landing.
    place: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct MinimumData {
    cost: f64,
    starts: usize,
    /// The index of the track, if it is shown.
    track: Option<usize>,
}

/// The data of a motion on a page.
#[derive(Serialize)]
pub(super) struct MotionData {
    name: String,
    robot: String,
    method: String,
    horizon: f64,
    verdict: String,
    failure: Option<String>,
    facts: Vec<[String; 2]>,
    commands: Vec<String>,
    made_by: String,
    joints: Vec<JointData>,
    scene: Scene,
    /// The tracks, that of the motion first.
    tracks: Vec<Track>,
    /// `q`, `v`, `a` and `u` of all joints at the times of the first track.
    values: String,
    clearance: Option<Clearance>,
    foot: Option<Foot>,
    /// The least clearance, m.
    least_clearance: Option<f64>,
    plots: Vec<Plot>,
    waypoints: Vec<Passage>,
    minima: Vec<MinimumData>,
    cost: f64,
    effort: f64,
}

impl MotionData {
    pub fn new(motion: &Motion<'_>) -> Result<Self> {
        let (scenario, model) = (motion.scenario, &motion.scenario.model);
        let rows = rows_of(model, motion.curve, MOTION)?;
        let placements = placements_of(model, &rows)?;
        let clearance = Clearance::new(scenario, &placements)?;
        let own = Track::new("motion".to_owned(), "motion", &rows, &placements);
        let (tracks, minima) = with_ghosts(own, motion)?;
        let colours = colours(model.dof());
        let efforts: Vec<f64> = (0..model.dof()).map(|i| effort_of(&rows, i)).collect();
        let joints = model.joints().iter().enumerate();
        let joints = joints.map(|(i, joint)| JointData {
            name: joint.name().to_owned(),
            unit: unit_of(joint.kind()),
            color: css(colours[i]),
            effort: efforts[i],
        });
        let values = rows.iter().flat_map(|row| {
            let all = [&row.q, &row.v, &row.a, &row.u].into_iter();
            all.flatten().copied()
        });
        let mut plots = plots_of_joints(scenario, &rows)?;
        let foot = Foot::new(scenario, &rows)?;
        if let Some(foot) = &foot {
            plots.extend(foot.plots(&rows)?);
        }
        plots.extend(plot_of_clearance(&rows, clearance.as_ref())?);
        if let Some(outcome) = motion.outcome {
            plots.extend(super::convergence::plots_of_search(outcome)?);
        }
        let at_rows = clearance.as_ref().map(Clearance::least);
        Ok(Self {
            name: scenario.name.clone(),
            robot: scenario.file.robot.clone(),
            method: motion.facts.method.clone(),
            horizon: motion.curve.horizon(),
            verdict: motion.facts.verdict.clone(),
            failure: motion.failure.map(str::to_owned),
            facts: motion.facts.facts.clone(),
            commands: motion.facts.commands.clone(),
            made_by: made_by(motion),
            joints: joints.collect(),
            scene: scene_of(scenario)?,
            tracks,
            values: of_f32(values),
            clearance,
            foot,
            least_clearance: motion.facts.least_clearance.or(at_rows),
            plots,
            waypoints: passages(motion)?,
            minima,
            cost: motion.facts.cost,
            effort: motion.facts.effort,
        })
    }
}

/// The track of a motion followed by those of its first guess and of other minima, and the minima.
fn with_ghosts(own: Track, motion: &Motion<'_>) -> Result<(Vec<Track>, Vec<MinimumData>)> {
    let (mut tracks, mut minima) = (vec![own], Vec::new());
    let Some(outcome) = motion.outcome else {
        return Ok((tracks, minima));
    };
    let model = &motion.scenario.model;
    let ghost = |name: String, kind, curve: &Curve| -> Result<Track> {
        let rows = rows_of(model, curve, GHOST)?;
        Ok(Track::new(name, kind, &rows, &placements_of(model, &rows)?))
    };
    if let Some(guess) = &outcome.trace.first_guess {
        tracks.push(ghost("first guess".to_owned(), "guess", guess)?);
    }
    for (i, LocalMinimum { cost, starts }) in minima_of(&outcome.summary).iter().enumerate() {
        let curve = outcome.trace.minima.get(i).filter(|_| i > 0);
        let mut minimum = MinimumData { cost: *cost, starts: *starts, track: (i == 0).then_some(0) };
        if let Some(curve) = curve.filter(|_| tracks.len() <= MAX_GHOSTS) {
            minimum.track = Some(tracks.len());
            tracks.push(ghost(format!("minimum {}", i + 1), "minimum", curve)?);
        }
        minima.push(minimum);
    }
    Ok((tracks, minima))
}

/// The passages of the waypoints.
fn passages(motion: &Motion<'_>) -> Result<Vec<Passage>> {
    let (scenario, model) = (motion.scenario, &motion.scenario.model);
    let tip = tips(model).into_iter().next();
    let mut placements = vec![Placement::identity(); model.dof()];
    let mut all = Vec::new();
    for (k, time) in motion.facts.waypoint_times.iter().copied().enumerate() {
        let (x, _) = motion.curve.at(time);
        forward_kinematics(model, &x.as_slice()[..model.dof()], &mut placements)?;
        let poses = scenario.file.waypoints.get(k).map(|point| point.poses.as_ref());
        let place = match poses {
            None => None,
            Some(None) => tip.as_ref().map(|tip| placements[tip.body].point(&Vector3::from(tip.point))),
            Some(Some(poses)) => {
                let frame = model.frames().iter().find(|frame| frame.name == poses.frame);
                frame.map(|frame| frame_placement(frame, &placements)).transpose()?.map(|placed| placed.translation)
            }
        };
        all.push(Passage { time, place: place.map(Into::into) });
    }
    Ok(all)
}

/// The version that solved the motion.
fn made_by(motion: &Motion<'_>) -> String {
    let provenance = motion.outcome.map(|outcome| &outcome.summary.provenance);
    match provenance {
        Some(provenance) => format!("aghf {} {}", provenance.version, provenance.commit),
        None => format!("aghf {}", env!("CARGO_PKG_VERSION")),
    }
}

fn minima_of(summary: &Summary) -> &[LocalMinimum] {
    match &summary.details {
        Details::Direct(direct) => &direct.minima,
        Details::Flow(_) | Details::Rest(_) => &[],
    }
}

fn unit_of(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Prismatic => "m",
        JointKind::Revolute | JointKind::Continuous => "rad",
    }
}

/// The integral of the squared torque of a joint, by Simpson's rule: each segment has an even number of equal
/// intervals.
fn effort_of(rows: &[Sample], joint: usize) -> f64 {
    let mut sum = 0.0;
    let mut at = 0;
    while at + 2 < rows.len() {
        let [a, b, c] = [0, 1, 2].map(|k| &rows[at + k]);
        // Two segments share a time: skip the last row of the first one.
        if b.t <= a.t {
            at += 1;
            continue;
        }
        let [x, y, z] = [a, b, c].map(|row| row.u[joint] * row.u[joint]);
        sum += (c.t - a.t) / 6.0 * (x + 4.0 * y + z);
        at += 2;
    }
    sum
}

/// Plots of positions, velocities, accelerations and torques, with strips beyond the enforced limits of each joint.
fn plots_of_joints(scenario: &Scenario, rows: &[Sample]) -> Result<Vec<Plot>> {
    let model = &scenario.model;
    let kinds = || model.joints().iter().map(|j| unit_of(j.kind()));
    let all = |unit: &str| kinds().all(|own| own == unit);
    let units = match (all("rad"), all("m")) {
        (true, _) => ["rad", "rad/s", "rad/s²", "N m"],
        (_, true) => ["m", "m/s", "m/s²", "N"],
        _ => ["rad or m", "rad/s or m/s", "rad/s² or m/s²", "N m or N"],
    };
    let quantities = [
        ("Position", Quantity::Position),
        ("Velocity", Quantity::Velocity),
        ("Acceleration", Quantity::Acceleration),
        ("Torque", Quantity::Torque),
    ];
    let colours = colours(model.dof());
    let value = |row: &Sample, what: usize, joint: usize| match what {
        0 => row.q[joint],
        1 => row.v[joint],
        2 => row.a[joint],
        _ => row.u[joint],
    };
    let mut plots = Vec::new();
    for (what, ((title, quantity), unit)) in quantities.into_iter().zip(units).enumerate() {
        let lines = (0..model.dof()).map(|i| {
            let [lower, upper] = scenario.bound(quantity, i).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            Line {
                points: rows.iter().map(|r| (r.t, value(r, what, i))).collect(),
                colour: colours[i],
                bounds: lower..upper,
            }
        });
        plots.push(plot(
            Axes { title: title.to_owned(), unit, time: true, logarithmic: false, per_joint: true, legend: Vec::new() },
            &lines.collect::<Vec<_>>(),
        )?);
    }
    Ok(plots)
}

fn plot_of_clearance(rows: &[Sample], clearance: Option<&Clearance>) -> Result<Option<Plot>> {
    let Some(clearance) = clearance else {
        return Ok(None);
    };
    let colour = colours(1)[0];
    let points = rows.iter().zip(&clearance.distances);
    let line =
        Line { points: points.map(|(row, distance)| (row.t, *distance)).collect(), colour, bounds: 0.0..f64::INFINITY };
    let axes = Axes {
        title: "Clearance".to_owned(),
        unit: "m",
        time: true,
        logarithmic: false,
        per_joint: false,
        legend: Vec::new(),
    };
    plot(axes, &[line]).map(Some)
}

/// The iterations of the start that led to the motion, and those after the starts.
pub(super) fn iterations_of(outcome: &SolveReport) -> impl Iterator<Item = &Record> {
    let best = outcome.trace.best_start;
    outcome.history.iter().filter(move |record| match record {
        Record::Direct(i) => i.start.is_none() || i.start == best,
        Record::Flow(_) | Record::Rest(_) => true,
    })
}
