//! Shorter paths with rounder corners.

use super::tree::step;
use super::{Checker, PlanSettings, between, distance};
use crate::constraint::Constraint;
use crate::error::Result;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The number of edges into which a path is cut before its corners are rounded.
const EDGES: usize = 24;

/// Removes waypoints, takes shortcuts and rounds corners, until it is interrupted.
pub(super) fn shorten<K: Constraint + ?Sized>(
    checker: &mut Checker<'_, K>,
    path: &mut Vec<Vec<f64>>,
    settings: &PlanSettings,
    rng: &mut ChaCha8Rng,
    stopped: &dyn Fn() -> bool,
) -> Result<()> {
    let projected = checker.is_projected();
    if !projected {
        leave_out(checker, path)?;
    }
    for _ in 0..settings.shortcuts {
        if path.len() == 2 || stopped() {
            return Ok(());
        }
        shortcut(checker, path, settings.range, rng)?;
    }
    // Lines between distant configurations leave the sets with equalities, and so do rounded corners.
    if projected {
        return Ok(());
    }
    leave_out(checker, path)?;
    if path.len() > 2 && settings.roundings > 0 {
        cut(path);
        for _ in 0..settings.roundings {
            if stopped() {
                return Ok(());
            }
            round(checker, path)?;
        }
    }
    Ok(())
}

/// Joins each waypoint to the last one that it reaches by a free line.
fn leave_out<K: Constraint + ?Sized>(checker: &mut Checker<'_, K>, path: &mut Vec<Vec<f64>>) -> Result<()> {
    let mut from = 0;
    while from + 2 < path.len() {
        for to in (from + 2..path.len()).rev() {
            if checker.is_line_free(&path[from], &path[to])? {
                path.drain(from + 1..to);
                break;
            }
        }
        from += 1;
    }
    Ok(())
}

/// Joins two random points of the path by a line if the line is free; with sets with equalities by steps within them,
/// if they are shorter.
fn shortcut<K: Constraint + ?Sized>(
    checker: &mut Checker<'_, K>,
    path: &mut Vec<Vec<f64>>,
    range: f64,
    rng: &mut ChaCha8Rng,
) -> Result<()> {
    let along = Along::new(path);
    let [a, b] = [(); 2].map(|()| along.length() * rng.random::<f64>());
    let (first, from) = along.at(path, a.min(b));
    let (last, to) = along.at(path, a.max(b));
    if first >= last {
        return Ok(());
    }
    if !checker.is_projected() {
        if checker.is_line_free(&from, &to)? {
            path.splice(first + 1..=last, [from, to]);
        }
        return Ok(());
    }
    let mut way = Vec::new();
    for end in [&from, &to] {
        let Some(end) = checker.projected(end.clone())? else {
            return Ok(());
        };
        way.push(end);
    }
    let Some(end) = way.pop() else {
        return Ok(());
    };
    while way[way.len() - 1] != end {
        let Some(next) = step(checker, &way[way.len() - 1], &end, range)? else {
            return Ok(());
        };
        way.push(next);
    }
    let ends = [path[first].clone(), path[last + 1].clone()];
    let beside = distance(&ends[0], &way[0]) + distance(&end, &ends[1]);
    let old = along.between(first, last + 1);
    if beside + Along::new(&way).length() < old
        && checker.is_line_free(&ends[0], &way[0])?
        && checker.is_line_free(&end, &ends[1])?
    {
        path.splice(first + 1..=last, way);
    }
    Ok(())
}

/// Adds waypoints on long edges.
fn cut(path: &mut Vec<Vec<f64>>) {
    let longest = Along::new(path).length() / EDGES as f64;
    let mut fine = vec![path[0].clone()];
    for edge in path.windows(2) {
        let parts = (distance(&edge[0], &edge[1]) / longest).ceil().max(1.0) as usize;
        let shares = (1..=parts).map(|k| k as f64 / parts as f64);
        fine.extend(shares.map(|share| between(&edge[0], &edge[1], share)));
    }
    *path = fine;
}

/// Moves every waypoint halfway to the middle of its neighbours if both of its edges stay free.
fn round<K: Constraint + ?Sized>(checker: &mut Checker<'_, K>, path: &mut [Vec<f64>]) -> Result<()> {
    for i in 1..path.len() - 1 {
        let middle = between(&path[i - 1], &path[i + 1], 0.5);
        let moved = between(&path[i], &middle, 0.5);
        if checker.is_line_free(&path[i - 1], &moved)? && checker.is_line_free(&moved, &path[i + 1])? {
            path[i] = moved;
        }
    }
    Ok(())
}

/// The length of a path up to each of its waypoints.
pub(super) struct Along(Vec<f64>);

impl Along {
    /// The lengths along a path of at least one waypoint.
    pub fn new(path: &[Vec<f64>]) -> Self {
        let mut lengths = vec![0.0];
        for edge in path.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + distance(&edge[0], &edge[1]));
        }
        Self(lengths)
    }

    /// The length between two waypoints.
    fn between(&self, from: usize, to: usize) -> f64 {
        self.0[to] - self.0[from]
    }

    pub fn length(&self) -> f64 {
        self.0[self.0.len() - 1]
    }

    /// The point at this length from the start, and the index of the waypoint at or before it; the last edge includes
    /// its end.
    pub fn at(&self, path: &[Vec<f64>], length: f64) -> (usize, Vec<f64>) {
        let last = path.len().saturating_sub(2);
        let edge = self.0.partition_point(|end| *end <= length);
        let edge = edge.saturating_sub(1).min(last);
        let Some(next) = path.get(edge + 1) else {
            return (0, path[0].clone());
        };
        let span = self.0[edge + 1] - self.0[edge];
        let share = if span > 0.0 { (length - self.0[edge]) / span } else { 0.0 };
        (edge, between(&path[edge], next, share))
    }
}
