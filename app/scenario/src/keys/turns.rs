//! The way of continuous joints to positions that are the same place of their links after whole turns.

use crate::ScenarioFile;
use aghf::error::plain;
use aghf::model::{JointKind, Model};
use aghf::plan::nearest_turn;

aghf::names::named_enum! {
/// The way of continuous joints to the positions of `q_goal` and of waypoints.
pub enum Turns("turns") {
    /// Each goes to the nearest of the positions that are the same place of its links, with a note where that is
    /// another one than the given one.
    Shortest = "shortest",
    /// Each goes to the very position.
    AsGiven = "as_given",
}
}

/// The largest position, rad, at which whole turns are subtracted to 1e-9 rad.
const FARTHEST: f64 = 1e6;

/// Replaces the positions of continuous joints in the waypoints and the goal of a file by those that are the nearest
/// to the configuration before, unless they are meant as given. Returns a note on each that is replaced.
pub(crate) fn shorten_turns(file: &mut ScenarioFile, robot: &Model) -> Vec<String> {
    let mut notes = Vec::new();
    if file.turns == Turns::AsGiven || file.q_start.len() != robot.dof() {
        return notes;
    }
    let points = file.waypoints.iter_mut().enumerate();
    let mut all: Vec<_> =
        points.filter_map(|(k, point)| Some((format!("waypoints[{k}].q"), point.q.as_mut()?))).collect();
    // With `goal` it is a first guess.
    if file.goal.is_empty() {
        all.push(("q_goal".to_owned(), &mut file.q_goal));
    }
    let mut before = file.q_start.clone();
    for (key, q) in all {
        for ((joint, to), from) in robot.joints().iter().zip(q.iter_mut()).zip(&mut before) {
            let is_exact = to.abs().max(from.abs()) <= FARTHEST;
            if joint.kind() == JointKind::Continuous && is_exact {
                let nearest = nearest_turn(*to, *from, [f64::NEG_INFINITY, f64::INFINITY]);
                let [way, less] = [*to, nearest].map(|to| (to - *from).abs());
                if less < way - f64::EPSILON.sqrt() {
                    let [way, less] = [way, less].map(|x| plain((1e4 * x).round() / 1e4));
                    notes.push(format!(
                        "{key}: continuous joint '{}' goes to {}, {less} rad away, which is the same place as {}, \
                         {way} rad away; with \"turns\": \"as_given\" it goes there",
                        joint.name(),
                        plain(nearest),
                        plain(*to)
                    ));
                    *to = nearest;
                }
            }
            *from = *to;
        }
    }
    notes
}
