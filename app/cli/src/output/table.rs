//! Tables for readers.

use super::rows::cost_of;
use aghf::direct::DegreeRefinement;
use aghf::error::Result;
use aghf::model::Model;
use aghf::verify::duals::Finding;
use aghf::verify::field::Verdict;
use aghf_scenario::{
    Details, DirectDetails, FAMILIES, Feasibility, FlowDetails, HorizonBound, Quantity, RestDetails, RobotShape,
    Scenario, Summary, builtin_scenarios, generated_scenarios,
};
use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table, presets};
use std::path::Path;

/// An empty table without lines.
pub(crate) fn table() -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table
}

/// Formats a number: short, but with its order of magnitude.
pub(crate) fn short(x: f64) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { format!("{x:.4}") } else { format!("{x:.3e}") }
}

/// The number of starts whose costs are listed.
const SHOWN: usize = 16;

/// The largest number of columns of the table of a solve; longer values are wrapped.
const COLUMNS: u16 = 100;

/// Formats the result of a solve as a table: the motion, and with `verbose` the numbers of the method.
#[must_use]
pub fn summary_table(summary: &Summary, verbose: bool) -> String {
    let mut table = table();
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(COLUMNS);
    table.add_rows(if verbose { summary_rows(summary) } else { motion_rows(summary) });
    if let Some(names) = table.column_mut(0) {
        names.set_constraint(ColumnConstraint::ContentWidth);
    }
    table.trim_fmt()
}

/// The rows of the motion of a solve, then those of the method, each a name and a value.
pub(crate) fn summary_rows(summary: &Summary) -> Vec<[String; 2]> {
    let mut rows = motion_rows(summary);
    rows.extend(method_rows(summary));
    rows
}

/// The rows that a user of the motion needs.
fn motion_rows(s: &Summary) -> Vec<[String; 2]> {
    let row = |what: &str, value: String| [what.to_owned(), value];
    // A robot in a file has its path.
    let robot = Path::new(&s.robot).file_name().unwrap_or_default().to_string_lossy();
    let mut all = vec![row("scenario", format!("{} ({robot})", s.scenario)), row("verdict", s.verdict.to_string())];
    all.extend(s.failure.iter().map(|failure| row("failure", failure.clone())));
    all.push(row("duration", duration(s)));
    if let Details::Direct(d) = &s.details
        && !d.waypoint_times_s.is_empty()
    {
        let times: Vec<_> = d.waypoint_times_s.iter().map(|time| short(*time)).collect();
        all.push(row("times of the waypoints", format!("{} s", times.join(", "))));
    }
    all.push(row("control effort, int |u|^2 dt", short(s.control_effort)));
    all.extend(feasibility_rows(&s.feasibility));
    all.push(row("solve time", format!("{:.4} s", s.solve_seconds)));
    let notes = s.notes.iter().enumerate().filter(|(i, note)| !s.notes[..*i].contains(note));
    all.extend(notes.map(|(_, note)| row("note", note.clone())));
    all.extend(s.outside_limits.iter().map(|note| row("outside limits", note.clone())));
    all
}

/// The duration, with its least value if it is free.
fn duration(summary: &Summary) -> String {
    let Details::Direct(d) = &summary.details else {
        return format!("{} s", short(summary.provenance.scenario.horizon_s));
    };
    let mut duration = format!("{} s", short(d.horizon_s));
    if let Some(HorizonBound { least_s, joint, limit }) = &d.horizon_bound {
        let above = 100.0 * (d.horizon_s / least_s - 1.0);
        let least = short(*least_s);
        duration += &format!(", {above:.1} % above the {least} s that {joint} takes at its {} limit", limit.name());
    }
    duration
}

/// The rows of the method.
fn method_rows(s: &Summary) -> Vec<[String; 2]> {
    let optional = |x: Option<f64>| x.map_or_else(|| "the simulation stopped".to_owned(), short);
    let (settings, rows) = match &s.details {
        Details::Flow(d) => flow_rows(d),
        Details::Rest(d) => rest_rows(d),
        Details::Direct(d) => direct_rows(s, d),
    };
    let degree = match s.segments {
        1 => format!("degree {}", s.degree),
        segments => format!("{segments} segments of degree {}", s.degree),
    };
    let gains = format!("final error with feedback ({}, {})", s.feedback.kp, s.feedback.kv);
    let error = format!("{}, to be below {}", optional(s.final_error_inf), s.success_threshold);
    let common = [
        ("method", format!("{}, {degree}, {settings}", s.method)),
        (&*gains, error),
        ("final error open loop", optional(s.open_loop_error_inf)),
        ("dynamics defect, max |qdot - v|", short(s.dynamics_defect)),
    ];
    common.into_iter().chain(rows).map(|(what, value)| [what.to_owned(), value]).collect()
}

/// The rows of the clearance, the loads and the violated limits.
fn feasibility_rows(found: &Feasibility) -> Vec<[String; 2]> {
    let mut rows = Vec::new();
    let mut add = |what: &str, value: String| rows.push([what.to_owned(), value]);
    if let Some(clearance) = found.smallest_clearance_m {
        let pair = found.nearest.iter();
        let pair: String = pair.map(|pair| format!(", {pair}")).collect();
        add("nearest approach", format!("{} m{pair}", short(clearance)));
    }
    if !found.limit_shares.is_empty() {
        let shares = found.limit_shares.iter();
        let shares = shares.map(|of| format!("{} {:.0} %", of.limit.name(), 100.0 * of.share));
        add("shares of limits", shares.collect::<Vec<_>>().join(", "));
    }
    if let Some(acceleration) = &found.unlimited_acceleration {
        let value = acceleration.to_string();
        add("largest acceleration, not limited", value);
    }
    if let Some(passive) = found.largest_passive_torque {
        let both = format!("{} of {}", short(passive), short(found.largest_torque));
        add("largest torque of passive joints", both);
    }
    if let Some(foot) = &found.foot {
        let range = |[least, most]: [f64; 2]| format!("{} to {}", short(least), short(most));
        let force = range(foot.normal_force);
        add("normal force on the foot", format!("{force} N"));
        let (along, across) = (range(foot.along_m), range(foot.across_m));
        let centre = format!("{along} m along, {across} m across");
        add("centre of pressure", centre);
        let (friction, torsion) = (short(foot.friction), short(foot.torsion));
        let friction = format!("{friction}, torsion {torsion} m");
        add("friction of the foot", friction);
    }
    let limits = found.limit_violations.iter();
    // The torques of passive joints have their own row.
    for violation in limits.filter(|violation| violation.limit != Quantity::Passive) {
        add("limit exceeded", violation.to_string());
    }
    rows
}

/// The parameters and the results that only the published flow has.
fn flow_rows(d: &FlowDetails) -> (String, Vec<(&'static str, String)>) {
    let settings = format!(
        "jacobian {}, integrator {}, k {:e}, s_max {:e}, tolerance {:e}, guess {}",
        d.jacobian, d.integrator, d.k, d.s_max, d.tolerance, d.guess
    );
    let before = d.action_at_nodes_of_guess.map_or("-".to_owned(), short);
    let nodes = [before, short(d.action_at_nodes)];
    let work = format!(
        "{} steps ({} rejected), {} Omega, {} Jacobians, {} factorisations",
        d.steps, d.rejected_steps, d.omega_evaluations, d.jacobian_evaluations, d.factorisations
    );
    let rows =
        vec![("action", short(d.action)), ("action at the nodes, before and after", nodes.join(", ")), ("work", work)];
    (settings, rows)
}

/// The parameters and the results that only a flow to rest has.
fn rest_rows(d: &RestDetails) -> (String, Vec<(&'static str, String)>) {
    let settings = format!("k {:e}, tolerance {:e}", d.k, d.tolerance);
    let work = format!(
        "{} steps, {} factorisations, {} updates of the duals, starts: {}",
        d.steps, d.factorisations, d.dual_updates, d.starts_tried
    );
    let mut rows = vec![
        ("action", short(d.action)),
        ("gradient norm, relative", format!("{:.1e}", d.gradient_norm)),
        ("slip at the points, max |qdot - v|", short(d.slip)),
    ];
    if let Some(violation) = d.largest_violation {
        rows.push(("largest violation", short(violation)));
    }
    rows.push(("work", work));
    (settings, rows)
}

/// The parameters and the results that only a direct solve has.
fn direct_rows(summary: &Summary, d: &DirectDetails) -> (String, Vec<(&'static str, String)>) {
    let settings = format!("tolerance {:e}, starts: {}", d.tolerance, d.starts_tried.max(1));
    let all = &d.start_costs;
    let mut starts: Vec<_> = all.iter().take(SHOWN).map(|x| short(*x)).collect();
    if all.len() > SHOWN {
        starts.push(format!("and {} more", all.len() - SHOWN));
    }
    let work =
        format!("{} iterations, {} factorisations, {} points", d.iterations, d.factorisations, d.quadrature_points);
    let stopped = || "the simulation stopped".to_owned();
    let replay = d.replay_error_inf.map_or_else(stopped, short);
    let mut rows = Vec::new();
    rows.push(("cost", cost_of(summary)));
    if let Some(adapted) = &d.adapted {
        rows.push(("effort by degree", efforts_by_degree(adapted)));
    }
    rows.extend([
        ("error of an interval, torques of the nodes alone", replay),
        ("gradient norm, relative", format!("{:.1e}", d.gradient_norm)),
    ]);
    if !d.smallest_curvature.is_nan() {
        rows.push(("smallest curvature, relative", short(d.smallest_curvature)));
    }
    rows.extend([("cost of the starts at the lowest degree", starts.join(", ")), ("work", work)]);
    if let Some(end) = &d.end {
        let q: Vec<_> = end.q.iter().map(|q| short(*q)).collect();
        rows.push(("end in the goal", format!("goal {}: {}", end.goal, q.join(", "))));
        rows.push(("ends compared", format!("{} by {}; motions to {}", end.found, end.measure, end.tried)));
    }
    (settings, rows)
}

/// The change of the effort with the degree, and its comparison with the tolerance.
fn efforts_by_degree(adapted: &DegreeRefinement) -> String {
    let efforts = adapted.degrees.iter().zip(&adapted.costs);
    let efforts: Vec<_> = efforts.map(|(p, x)| format!("{} at {p}", short(*x))).collect();
    let verdict = if adapted.converged { "converged" } else { "NOT converged" };
    let tolerance = adapted.tolerance;
    format!("{}: {verdict} to {tolerance}", efforts.join(", "))
}

/// Formats the verdicts of proofs as a table.
#[must_use]
pub fn verdict_table(verdicts: &[Verdict]) -> String {
    let mut table = table();
    table.set_header(["label", "statement", "entries", "bound", ""]);
    for v in verdicts {
        table.add_row([
            v.label.clone(),
            v.statement.clone(),
            v.entries.to_string(),
            format!("{:.0e}", v.bound),
            if v.failure.is_none() { "holds" } else { "FAILS" }.to_owned(),
        ]);
    }
    table.to_string()
}

/// Formats the findings of derivative checks as a table: the worst of each quantity.
#[must_use]
pub fn check_table(findings: &[Finding]) -> String {
    let mut table = table();
    table.set_header(["quantity", "k", "worst relative error", "bound", "entry", "state", ""]);
    for f in findings {
        table.add_row([
            f.quantity.clone(),
            f.k.map_or_else(String::new, |k| format!("{k:e}")),
            format!("{:.1e}", f.error),
            format!("{:.0e}", f.bound),
            format!("({}, {})", f.entry.0, f.entry.1),
            f.sample.to_string(),
            if f.passes() { "ok" } else { "OFF" }.to_owned(),
        ]);
    }
    table.to_string()
}

/// Formats configurations of a robot, one per row.
#[must_use]
pub fn configurations_table(model: &Model, all: &[Vec<f64>]) -> String {
    let mut table = table();
    table.set_header(model.joints().iter().map(|joint| joint.name()));
    for q in all {
        table.add_row(q.iter().map(|q| format!("{q:.9}")));
    }
    table.to_string()
}

/// Formats the joints of a robot as a table.
#[must_use]
pub fn robot_table(model: &Model) -> String {
    let mut table = table();
    table.set_header(["joint", "kind", "carried by", "lower", "upper", "velocity", "effort", "mass, kg"]);
    for (joint, inertia) in model.joints().iter().zip(model.inertias()) {
        let carrier = joint.parent().map_or("base", |p| model.joints()[p].name());
        let limits = joint.limits();
        let numbers = [limits.lower, limits.upper, limits.velocity, limits.effort, inertia.mass];
        let limit = |x: f64| {
            if x.is_finite() { short(x) } else { "-".to_owned() }
        };
        let words = [joint.name(), joint.kind().name(), carrier].map(str::to_owned);
        table.add_row(words.into_iter().chain(numbers.map(limit)));
    }
    for column in table.column_iter_mut().skip(3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}

/// Formats all scenarios as a table: robot, horizon and obstacles, then the descriptions of the generated families.
///
/// # Errors
/// A scenario cannot be loaded.
pub fn scenario_table() -> Result<String> {
    let mut table = table();
    let builtin = builtin_scenarios().map(str::to_owned);
    for name in builtin.chain(generated_scenarios()) {
        let scenario = Scenario::load(&name)?;
        let (shape, bounds) = (scenario.robot_shape(), scenario.horizon_bounds());
        let Scenario { file, scene, .. } = scenario;
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for obstacle in scene.obstacles() {
            let name = obstacle.solid.shape.name();
            match counts.iter_mut().find(|(known, _)| *known == name) {
                Some((_, count)) => *count += 1,
                None => counts.push((name, 1)),
            }
        }
        let counted = counts.into_iter().map(|(name, count)| match count {
            1 => format!("1 {name}"),
            _ if name.ends_with('x') => format!("{count} {name}es"),
            _ => format!("{count} {name}s"),
        });
        let obstacles: Vec<String> = counted.collect();
        let against = match shape {
            _ if obstacles.is_empty() => String::new(),
            RobotShape::JointFrames => "joint frames".to_owned(),
            RobotShape::SweptLinks { radius_m, .. } => format!("links of radius {radius_m} m"),
            RobotShape::Collision { .. } => "collision shapes".to_owned(),
        };
        let horizon = match bounds {
            None => format!("{} s", file.horizon_s),
            Some(free) => format!("{} to {} s", free.shortest_s, free.longest_s),
        };
        table.add_row([name, file.robot, horizon, obstacles.join(", "), against]);
    }
    let families = FAMILIES.iter().map(|f| format!("{}_SEED: {}", f.name, f.about));
    let families: Vec<String> = families.collect();
    Ok(format!("{table}\n\n{}", families.join("\n")))
}
