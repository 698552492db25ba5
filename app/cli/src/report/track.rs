//! A motion sampled over time: poses of the bodies, joint values, and the nearest obstacle.

use super::encode::{of_f32, of_i16};
use super::scene::pose;
use aghf::curve::Curve;
use aghf::dynamics::forward_kinematics;
use aghf::error::Result;
use aghf::model::Model;
use aghf::motion::{Sample, samples_at};
use aghf::spatial::Placement;
use aghf_scenario::Scenario;
use serde::Serialize;
use std::collections::HashMap;

/// Rows per second and the largest number of rows, of the motion and of a ghost.
pub(super) const MOTION: [f64; 2] = [120.0, 600.0];
pub(super) const GHOST: [f64; 2] = [40.0, 200.0];

/// The largest 16-bit number.
const MAX_16_BIT: f64 = 32767.0;

/// The placements of all bodies over time.
#[derive(Serialize)]
pub(super) struct Track {
    pub name: String,
    /// "motion", "guess" or "minimum".
    pub kind: &'static str,
    pub rows: usize,
    /// The times, s.
    times: String,
    /// The unit of positions, m; that of quaternions is 1 / 32767.
    unit: f64,
    /// Three numbers per body and time.
    positions: String,
    /// Four numbers `x y z w` per body and time.
    turns: String,
}

/// The clearance over time.
#[derive(Serialize)]
pub(super) struct Clearance {
    /// The clearances, m.
    values: String,
    /// The names of the nearest pairs.
    pairs: Vec<[String; 2]>,
    /// The index of the pair at each time.
    pair: Vec<usize>,
    /// The points nearest to each other, six numbers per time, m.
    points: String,
    #[serde(skip)]
    pub distances: Vec<f64>,
}

/// Samples the curve at equal distances in each segment, including both of its ends, so that jumps between segments are
/// visible. The number of intervals of a segment is even.
pub(super) fn rows_of(model: &Model, curve: &Curve, [rate, most]: [f64; 2]) -> Result<Vec<Sample>> {
    let segments = curve.segments();
    let wanted = (rate * curve.horizon()).clamp(40.0, most);
    let each = 2 * (0.5 * wanted / segments as f64).ceil().max(1.0) as usize;
    let breakpoints = curve.breakpoints();
    let times = (0..segments).flat_map(|segment| {
        let (from, to) = (breakpoints[segment], breakpoints[segment + 1]);
        (0..=each).map(move |i| (segment, from + (to - from) * i as f64 / each as f64))
    });
    samples_at(model, curve, times).collect()
}

/// The placements of the bodies at all rows.
pub(super) fn placements_of(model: &Model, rows: &[Sample]) -> Result<Vec<Vec<Placement<f64>>>> {
    let place = |row: &Sample| {
        let mut placements = vec![Placement::identity(); model.dof()];
        forward_kinematics(model, &row.q, &mut placements)?;
        Ok(placements)
    };
    rows.iter().map(place).collect()
}

impl Track {
    pub fn new(name: String, kind: &'static str, rows: &[Sample], placements: &[Vec<Placement<f64>>]) -> Self {
        let poses: Vec<[f64; 7]> = placements.iter().flatten().map(pose).collect();
        let positions = || poses.iter().flat_map(|p| p[..3].iter().copied());
        let furthest = positions().fold(1e-6, |most: f64, x| most.max(x.abs()));
        let unit = furthest / MAX_16_BIT;
        Self {
            name,
            kind,
            rows: rows.len(),
            times: of_f32(rows.iter().map(|row| row.t)),
            unit,
            positions: of_i16(positions(), unit),
            turns: of_i16(poses.iter().flat_map(|p| p[3..].iter().copied()), 1.0 / MAX_16_BIT),
        }
    }
}

impl Clearance {
    /// The least clearance, m.
    pub fn least(&self) -> f64 {
        self.distances.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Computes the clearance at these placements; `None` without obstacles or pairs of links.
    pub fn new(scenario: &Scenario, placements: &[Vec<Placement<f64>>]) -> Result<Option<Self>> {
        let mut numbers = HashMap::new();
        let mut clearance = Self {
            values: String::new(),
            pairs: Vec::new(),
            pair: Vec::new(),
            points: String::new(),
            distances: Vec::new(),
        };
        let mut points = Vec::new();
        for placements in placements {
            let Some(pair) = scenario.scene.closest_pair(placements)? else {
                return Ok(None);
            };
            let names = scenario.names_of(&pair);
            let next = numbers.len();
            let number = *numbers.entry(names).or_insert(next);
            if number == next {
                clearance.pairs.push(names.map(str::to_owned));
            }
            clearance.pair.push(number);
            clearance.distances.push(pair.distance);
            points.extend(pair.points.iter().flat_map(|p| p.iter().copied()));
        }
        clearance.values = of_f32(clearance.distances.iter().copied());
        clearance.points = of_f32(points);
        Ok(Some(clearance))
    }
}
