//! The table of a walk.

use super::{short, table};
use aghf_scenario::{Landing, SolveReport, Walk};

/// Formats the result of the solve of a walk: a row per phase, then one per landing.
#[must_use]
pub fn walk_table(walk: &Walk) -> String {
    let mut rows = table();
    rows.add_row(["phase", "verdict", "from, s", "to, s", "effort", "centre of pressure, m"]);
    let mut begin = 0.0;
    for (phase, SolveReport { summary, curve, .. }) in &walk.phases {
        let end = begin + curve.horizon();
        let load = summary.feasibility.foot.as_ref();
        let sole = load.map_or_else(String::new, |load| {
            let [along, across] = [load.along_m, load.across_m].map(|[a, b]| format!("{} to {}", short(a), short(b)));
            format!("{along} along, {across} across")
        });
        rows.add_row([
            &phase.name,
            &summary.verdict.to_string(),
            &short(begin),
            &short(end),
            &short(summary.control_effort),
            &sole,
        ]);
        begin = end;
    }
    let mut lines = vec![rows.to_string()];
    let reports = walk.phases.iter().map(|(_, report)| &report.summary);
    for summary in reports.clone() {
        let notes = summary.failure.iter().chain(&summary.notes);
        for note in notes {
            if !lines.contains(note) {
                lines.push(note.clone());
            }
        }
    }
    for Landing { time_s, frame, off, speed } in &walk.landings {
        let [time, off, speed] = [time_s, off, speed].map(|x| short(*x));
        lines.push(format!("'{frame}' lands at {time} s, {off} m or rad from its place and at {speed} m/s or rad/s"));
    }
    if let Some(summary) = reports.clone().next() {
        let effort: f64 = reports.map(|summary| summary.control_effort).sum();
        lines.push(format!("control effort {}, solved in {} s", short(effort), short(summary.solve_seconds)));
    }
    lines.join("\n")
}
