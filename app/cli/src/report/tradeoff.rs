//! The page of a trade-off between duration and effort.

use super::data::MotionData;
use super::{Group, Motion, SCRIPT, Scatter, escaped, filled};
use crate::output::short;
use aghf::error::Result;
use aghf_scenario::{Scenario, SolveReport};
use serde::Serialize;

/// Builds the page of a trade-off: the curve of duration against effort, on which a click chooses the motion.
///
/// # Errors
/// Those of [`page`](super::page).
pub fn tradeoff_page(found: &[(Scenario, SolveReport)]) -> Result<String> {
    let motions = found.iter().map(|(of, report)| Motion::of_report(of, report));
    let motions = motions.map(|motion| MotionData::new(&motion));
    let data = Tradeoff { plot: efforts(found), motions: motions.collect::<Result<_>>()? };
    let name = found.first().map_or("", |(of, _)| of.name.as_str());
    let mut script = SCRIPT.to_vec();
    script.insert(script.len() - 1, include_str!("page/scatter.js"));
    filled(&data, &script, &escaped(name))
}

/// The data of the page of a trade-off.
#[derive(Serialize)]
struct Tradeoff {
    plot: Scatter,
    motions: Vec<MotionData>,
}

/// The points of the curve, valid and not.
fn efforts(found: &[(Scenario, SolveReport)]) -> Scatter {
    let groups = [("valid", true), ("not valid", false)].into_iter().enumerate();
    let groups = groups.map(|(index, (name, valid))| {
        let own = found.iter().filter(|(_, report)| report.summary.success == valid);
        let points = own.map(|(_, report)| {
            let (duration, effort) = (report.curve.horizon(), report.summary.control_effort);
            let name = format!("{} s, effort {}", short(duration), short(effort));
            (duration, effort, name)
        });
        Group::new(name.to_owned(), index, !valid, points.collect())
    });
    Scatter {
        title: "A point for each motion".to_owned(),
        x: "duration, s".to_owned(),
        y: "effort, ∫|u|² dt".to_owned(),
        groups: groups.filter(|group| !group.is_empty()).collect(),
    }
}
