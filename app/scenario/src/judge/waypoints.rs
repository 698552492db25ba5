//! Points on the way: whether a trajectory passes them in their order.

use super::poses::{Poses, place_of};
use super::{Check, Intervals, Row, Worst};
use crate::{PointOnTheWay, Quantity, Scenario};
use aghf::dynamics::forward_kinematics;
use aghf::error::Result;
use aghf::spatial::Placement;

/// The number of steps of the golden-section search for the nearest time, which shrink an interval below rounding.
const STEPS: usize = 60;

/// The largest deviation from a waypoint at a time after the start.
struct Passage {
    at_s: f64,
    worst: (f64, Worst, String),
}

/// The waypoints of a scenario in the motion between the samples.
struct Passages<'a> {
    scenario: &'a Scenario,
    intervals: &'a Intervals,
    placements: Vec<Placement<f64>>,
}

impl Passages<'_> {
    /// The deviation at a time after the start.
    fn at(&mut self, point: &PointOnTheWay, at_s: f64) -> Result<Passage> {
        let model = &self.scenario.model;
        let after = self.intervals.times.partition_point(|[begin, _]| *begin <= at_s);
        let k = after.saturating_sub(1);
        let [begin, interval] = self.intervals.times[k];
        let s = (at_s - begin) / interval;
        let q = self.intervals.at(0, k, s);
        let mut all = Vec::new();
        let mut add = |excess: f64, worst: Worst, place: String| all.push((excess, worst, place));
        let exactly = |value: f64, aim: f64, unit| ((value - aim).abs(), Worst::between(value, [aim; 2], unit, at_s));
        let joints = || model.joints().iter().enumerate();
        for (i, joint) in joints().filter(|_| point.q.is_some()) {
            let aim = point.q.as_ref().map_or(f64::NAN, |q| q[i]);
            let (excess, worst) = exactly(q[i], aim, Quantity::Position.unit(joint.kind()));
            add(excess, worst, super::joint_name(joint));
        }
        if let Some(poses) = &point.poses {
            forward_kinematics(model, &q, &mut self.placements)?;
            let (_, measures) = Poses::new(poses, model)?.at(&self.placements)?;
            for measure in measures {
                add(measure.excess(), measure.worst(at_s), place_of(poses, &measure));
            }
        }
        let v = self.intervals.at(1, k, s);
        for (i, joint) in joints().filter(|_| point.stop && !self.intervals.is_derived()) {
            let (excess, worst) = exactly(v[i], 0.0, Quantity::Velocity.unit(joint.kind()));
            add(excess, worst, super::joint_name(joint));
        }
        let worst = all.into_iter().max_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let none = || (f64::INFINITY, Worst::between(f64::NAN, [0.0; 2], "", at_s), String::new());
        Ok(Passage { at_s, worst: worst.unwrap_or_else(none) })
    }

    /// The first time from `from_s` on at which the deviation is within the tolerance, otherwise the time of the least
    /// deviation, among the given time, or the nearest times around each sample that is nearer than its neighbours.
    fn first(&mut self, point: &PointOnTheWay, from_s: f64, tolerance: f64) -> Result<Passage> {
        if let Some(time) = point.time_s {
            return self.at(point, time.min(self.intervals.duration()));
        }
        let ends = self.intervals.times.iter().map(|[begin, interval]| begin + interval);
        let times: Vec<_> = std::iter::once(from_s).chain(ends.filter(|end| *end > from_s)).collect();
        let mut least = self.at(point, from_s)?;
        let mut here = [f64::INFINITY, least.worst.0];
        for i in 0..times.len() {
            let next = match times.get(i + 1) {
                Some(time) => self.at(point, *time)?.worst.0,
                None => f64::INFINITY,
            };
            if here[1] <= here[0] && here[1] <= next {
                let around = [times[i.saturating_sub(1)], times[(i + 1).min(times.len() - 1)]];
                let found = self.nearest(point, around)?;
                if found.worst.0 < least.worst.0 {
                    least = found;
                }
                if least.worst.0 <= tolerance {
                    break;
                }
            }
            here = [here[1], next];
        }
        Ok(least)
    }

    /// The least deviation between two times, by golden sections.
    fn nearest(&mut self, point: &PointOnTheWay, [mut from, mut to]: [f64; 2]) -> Result<Passage> {
        let golden = 0.5 * (5_f64.sqrt() - 1.0);
        for _ in 0..STEPS {
            let way = golden * (to - from);
            let [a, b] = [self.at(point, to - way)?, self.at(point, from + way)?];
            if a.worst.0 <= b.worst.0 {
                to = b.at_s;
            } else {
                from = a.at_s;
            }
        }
        self.at(point, 0.5 * (from + to))
    }
}

/// The row of the waypoints: the first passage of each after that of the one before.
pub(super) fn passed(scenario: &Scenario, intervals: &Intervals, tolerance: f64) -> Result<Option<Row>> {
    let points = &scenario.file.waypoints;
    if points.is_empty() {
        return Ok(None);
    }
    let placements = vec![Placement::identity(); scenario.model.dof()];
    let mut passages = Passages { scenario, intervals, placements };
    let (mut row, mut from_s) = (Row::new(Check::Waypoints, tolerance), 0.0);
    for (i, point) in points.iter().enumerate() {
        if let Some(time) = point.time_s {
            let found = Worst::between(time, [from_s, intervals.duration()], "s", time);
            row.take(found, || format!("time of waypoint {i}"));
        }
        let Passage { at_s, worst } = passages.first(point, from_s, tolerance)?;
        let (_, worst, place) = worst;
        row.take(worst, || format!("{place} at waypoint {i}"));
        from_s = at_s;
    }
    if intervals.is_derived() && points.iter().any(|point| point.stop) {
        row.leave(true, from_s);
    }
    Ok(Some(row))
}
