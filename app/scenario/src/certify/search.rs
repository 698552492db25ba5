//! Adaptive subdivision of the horizon.

use super::clearance::{Balls, Least, Model, Pair, pairs};
use super::document::FORMAT;
use super::points::{Points, broken_ends};
use super::rows::{Nearest, OTHER_ERRORS, Row, Rows};
use super::scope::{has_balls, keys, meshes};
use super::shapes::{self, Parts, Shapes};
use super::{Certificate, Certification, Direction, Failure, Interval, LEFT_OUT, Passage, Piece, TOLERANCE, Texts};
use crate::{CurveFile, Quantity, Scenario, promise_in_words, sha256};
use aghf::certify::{self, Bernstein, Motion, ORDER, Part};
use aghf::dynamics::forward_kinematics;
use aghf::error::Result;
use aghf::geometry::ConvexPiece;
use aghf::spatial::Placement;

/// The fewest intervals of a motion.
const MIN_INTERVALS: usize = 16;

/// The largest number of intervals, and the smallest half width of one: beyond, a promise is not provable.
const MAX_INTERVALS: usize = 4000;
const MIN_HALF_WIDTH: f64 = 1.0 / (1 << 24) as f64;

/// The share of a proved reserve that is claimed: with the arithmetic of the checkers the reserve is smaller by up to
/// about 1e-4 of it.
const CLAIMED: f64 = 0.99;

/// The number of decimals of a claimed reserve.
const DECIMALS: f64 = 1e9;

/// The largest error of an entry of a placement, m, with which claims are made.
const MAX_ERROR: f64 = 1e-4;

/// The half width of the parts on which the joints move very little but rounding is still small.
const NARROW: f64 = 1.0 / (1 << 10) as f64;

/// The largest reserve of a row that is claimed.
const MAX_CLAIM: f64 = 1.0;

/// The share of a segment by which intervals reach beyond the times of a condition, more than rounding of times.
const OVERLAP: f64 = 1.0 / (1_u64 << 39) as f64;

/// The proof under construction.
struct Search<'a> {
    scenario: &'a Scenario,
    motion: &'a Motion,
    /// The largest deviation of a position from the motion, rad or m.
    tracking_error: f64,
    rows: Rows<'a>,
    promises: Vec<Quantity>,
    pairs: Vec<Vec<Pair>>,
    /// The shapes of the robot, unless it consists of balls.
    shapes: Option<Parts>,
    failures: Vec<Failure>,
}

/// The claims on an interval and the directions that separate shapes there.
type Claims = (Vec<f64>, Vec<Direction>);

/// The least reserve of the pairs of a promise and the directions that separate shapes.
type Reserve = (Least, Vec<Direction>);

/// Proves the promises of a scenario for a motion that passes the waypoints at these times, s.
pub(super) fn certification(
    scenario: &Scenario,
    curve: &CurveFile,
    texts: Texts,
    times: &[f64],
    tracking_error: f64,
) -> Result<Certification> {
    let motion = Motion::new(curve.horizon_s, &curve.positions())?;
    let rows = Rows::new(scenario, &motion)?;
    let mut search = Search::new(scenario, &motion, rows, tracking_error)?;
    for failure in broken_ends(scenario, curve, &motion)? {
        search.fail(failure);
    }
    let (goal, waypoints) = search.points(times)?;
    let intervals = search.intervals()?;
    let (promises, failures, shapes) = (search.promises, search.failures, search.shapes);
    if !failures.is_empty() {
        return Ok(Certification { certificate: None, failures });
    }
    let keys = keys(scenario, shapes.is_some())?;
    let hash = |text: &&str| sha256(text.as_bytes());
    let certificate = Certificate {
        format: FORMAT.to_owned(),
        scenario: scenario.name.clone(),
        robot_sha256: scenario.robot_sha256.clone(),
        scenario_sha256: texts.scenario.iter().map(hash).collect(),
        run_sha256: hash(&texts.run),
        meshes: meshes(scenario)?,
        pieces: shapes.map(|shapes| shapes.pieces).unwrap_or_default().iter().map(|all| of_mesh(all)).collect(),
        complete: !keys.values().any(|outcome| outcome.starts_with(LEFT_OUT)),
        keys,
        tracking_error,
        goal,
        waypoints,
        promises,
        intervals,
    };
    Ok(Certification { certificate: Some(certificate), failures })
}

/// The pieces of a mesh as they are written.
fn of_mesh(pieces: &[ConvexPiece]) -> Vec<Piece> {
    let corners = |piece: &ConvexPiece| piece.corners.iter().map(|corner| (*corner).into()).collect();
    pieces.iter().map(|piece| Piece(corners(piece), piece.faces.clone())).collect()
}

/// A claim rounded down to [`DECIMALS`].
fn floor(claim: f64) -> f64 {
    (claim * DECIMALS).floor() / DECIMALS
}

impl Failure {
    /// A row at a time, s.
    fn of(promise: String, row: &Row, nearest: &Nearest, at_s: f64, is_broken: bool) -> Self {
        Self {
            promise,
            place: row.place.clone(),
            at_s,
            value: if is_broken { nearest.value } else { nearest.not_excluded(row) },
            bound: nearest.bound,
            is_broken,
        }
    }
}

impl<'a> Search<'a> {
    fn new(scenario: &'a Scenario, motion: &'a Motion, rows: Rows<'a>, tracking_error: f64) -> Result<Self> {
        let mut promises: Vec<_> = rows.all.iter().map(|row| row.promise).collect();
        promises.dedup();
        let (shapes, mut all) = (shapes::parts(scenario)?, Vec::new());
        for promise in [Quantity::Obstacles, Quantity::SelfCollision] {
            let own = match &shapes {
                Some(parts) => shapes::pairs(scenario, &parts.all, promise)?,
                None if has_balls(scenario) => pairs(scenario, promise)?,
                None => Vec::new(),
            };
            if !own.is_empty() {
                promises.push(promise);
                all.push(own);
            }
        }
        Ok(Self { scenario, motion, tracking_error, rows, promises, pairs: all, shapes, failures: Vec::new() })
    }

    /// Adds a failure unless one of the same row is known.
    fn fail(&mut self, failure: Failure) {
        let same = |f: &Failure| f.promise == failure.promise && f.place == failure.place;
        match self.failures.iter_mut().find(|f| same(f)) {
            None => self.failures.push(failure),
            Some(known) => {
                let beyond = |f: &Failure| (f.value - f.bound).abs();
                if failure.is_broken && (!known.is_broken || beyond(&failure) > beyond(known)) {
                    *known = failure;
                }
            }
        }
    }

    /// Checks the goal, if it is a set of poses, and the waypoints, which the motion passes at these times, s.
    fn points(&mut self, times: &[f64]) -> Result<(Option<f64>, Vec<Passage>)> {
        let points = Points { scenario: self.scenario, motion: self.motion, rows: &self.rows };
        let goal = points.goal()?;
        let mut passages = Vec::new();
        let mut worst = vec![("goal".to_owned(), goal, self.motion.horizon())];
        for (k, time) in times.iter().enumerate() {
            let (Passage(segment, x, reserve), row) = points.waypoint(k, *time)?;
            passages.push(Passage(segment, x, floor(reserve)));
            worst.push((format!("waypoints[{k}]"), row, *time));
        }
        let reserve = worst[0].1.as_ref().map(|(_, nearest)| floor(nearest.claim));
        for (promise, worst, at_s) in worst {
            if let Some((row, nearest)) = worst.filter(|(_, nearest)| !nearest.holds()) {
                let is_broken = nearest.is_beyond(&row);
                self.fail(Failure::of(promise, &row, &nearest, at_s, is_broken));
            }
        }
        Ok((reserve, passages))
    }

    /// The segments, cut at the times between which conditions are kept, and at least [`MIN_INTERVALS`] parts.
    fn parts(&self) -> Vec<Part> {
        let segments = self.motion.segments();
        let mut parts: Vec<Part> = (0..segments).map(Part::whole).collect();
        for [from, to] in self.rows.all.iter().map(|row| row.times) {
            for (time, out) in [(from, -OVERLAP), (to, OVERLAP)] {
                let place = time / self.motion.horizon() * segments as f64 + out;
                let x = 2.0 * place.fract() - 1.0;
                let cut = |part: Part| {
                    let [begin, end] = part.ends();
                    // Two conditions from the same time on cut once.
                    let is_inside = (x - begin).min(end - x) > OVERLAP;
                    if part.segment as f64 == place.floor() && is_inside { part.split(x).to_vec() } else { vec![part] }
                };
                parts = parts.into_iter().flat_map(cut).collect();
            }
        }
        while parts.len() < MIN_INTERVALS {
            parts = parts.into_iter().flat_map(|part| part.split(part.middle)).collect();
        }
        parts
    }

    /// The intervals with the claims on each, those without a failure.
    fn intervals(&mut self) -> Result<Vec<Interval>> {
        let mut open = self.parts();
        open.reverse();
        let basis = Bernstein::new(ORDER - 1);
        let mut found = Vec::new();
        while let Some(part) = open.pop() {
            let can_halve = part.half > MIN_HALF_WIDTH && found.len() + open.len() < MAX_INTERVALS;
            match self.claims(part, &basis, can_halve)? {
                Some((claims, directions)) => {
                    let [from, to] = part.ends();
                    let claims = claims.into_iter().map(|claim| self.claimed(claim)).collect();
                    found.push(Interval(part.segment, from, to, claims, directions));
                }
                None if self.fails_in_middle(part, &basis)? => {}
                None => open.extend(part.split(part.middle).into_iter().rev()),
            }
        }
        Ok(found)
    }

    /// A claim as it is written. No reserve beside a tube is claimed, because it depends on the arithmetic.
    fn claimed(&self, claim: f64) -> f64 {
        match self.tracking_error > 0.0 && claim > 0.0 {
            true => 0.0,
            false if claim > 0.0 => floor(CLAIMED * claim),
            false => floor(claim),
        }
    }

    /// Returns true if promises cannot be proved even at the middle of a part, where only the tube counts.
    fn fails_in_middle(&mut self, part: Part, basis: &Bernstein) -> Result<bool> {
        if self.tracking_error == 0.0 {
            return Ok(false);
        }
        let half = part.half.min(NARROW);
        let claims = self.claims(Part { half, ..part }, basis, false)?;
        let is_accepted = |claim: &f64| *claim >= -TOLERANCE;
        Ok(claims.is_none_or(|(claims, _)| !claims.iter().all(is_accepted)))
    }

    /// The claims of each promise on a part; `None` if it is to be halved.
    fn claims(&mut self, part: Part, basis: &Bernstein, can_halve: bool) -> Result<Option<Claims>> {
        let alone = self.motion.piece(part);
        let tube = (self.tracking_error > 0.0).then(|| alone.widened(self.tracking_error));
        let mut claims = vec![MAX_CLAIM; self.promises.len()];
        let mut failures = Vec::new();
        let mut nearest = self.rows.nearest(&alone)?;
        if let Some(tube) = &tube {
            let wide = self.rows.nearest(tube)?.into_iter().zip(&nearest);
            nearest = wide.map(|(wide, alone)| wide.in_tube(alone)).collect();
        }
        for (row, nearest) in self.rows.all.iter().zip(&nearest) {
            if !row.is_kept(self.motion, part) {
                continue;
            }
            let is_broken = !nearest.holds() && nearest.is_beyond(row);
            if !nearest.holds() && !is_broken && can_halve {
                return Ok(None);
            }
            if !nearest.holds() {
                let at_s = self.motion.time(part, nearest.place);
                let promise = promise_in_words(row.promise).to_owned();
                failures.push(Failure::of(promise, row, nearest, at_s, is_broken));
            }
            let of = self.promises.iter().position(|p| *p == row.promise);
            let of = of.unwrap_or_default();
            claims[of] = claims[of].min(nearest.claim);
        }
        let mut directions = Vec::new();
        let Some(clearances) = self.clearances(&alone, tube.as_ref(), basis, can_halve)? else {
            return Ok(None);
        };
        let first = self.promises.len() - self.pairs.len();
        for (of, (least, own)) in clearances.into_iter().enumerate() {
            let holds = least.claim >= -TOLERANCE;
            // Far beyond the errors of distances in the middle.
            let is_broken = !holds && least.middle < -2.0 * TOLERANCE;
            if !holds && !is_broken && can_halve {
                return Ok(None);
            }
            if !holds {
                failures.push(Failure {
                    promise: promise_in_words(self.promises[first + of]).to_owned(),
                    place: least.place,
                    at_s: self.motion.time(part, 0.0),
                    value: if is_broken { least.middle } else { least.claim },
                    bound: 0.0,
                    is_broken,
                });
            }
            claims[first + of] = least.claim;
            directions.extend(own);
        }
        for failure in failures {
            self.fail(failure);
        }
        Ok(Some((claims, directions)))
    }

    /// The least reserves of the promises of clearances on a piece, alone and with the tube; `None` if it is to be
    /// halved.
    fn clearances(
        &self,
        alone: &certify::Piece,
        tube: Option<&certify::Piece>,
        basis: &Bernstein,
        can_halve: bool,
    ) -> Result<Option<Vec<Reserve>>> {
        if self.pairs.is_empty() {
            return Ok(Some(Vec::new()));
        }
        let (mut bodies, error) = self.bodies(alone)?;
        if error > MAX_ERROR && can_halve {
            return Ok(None);
        }
        let mut left = OTHER_ERRORS;
        if let Some(tube) = tube {
            let (wide, all) = self.bodies(tube)?;
            (bodies, left) = (wide, left * error / all);
        }
        let pairs = self.pairs.iter();
        Ok(Some(match &self.shapes {
            Some(parts) => {
                let shapes = Shapes::new(self.scenario, &parts.all, basis, &bodies, left);
                pairs.map(|pairs| shapes.least(pairs)).collect()
            }
            None => {
                let balls = Balls::new(self.scenario, basis, &bodies, left);
                pairs.map(|pairs| (balls.least(pairs), Vec::new())).collect()
            }
        }))
    }

    /// The placements of the bodies on a piece, and the largest bound on the errors of their entries.
    fn bodies(&self, piece: &certify::Piece) -> Result<(Vec<Placement<Model>>, f64)> {
        let [q, _, _] = piece.models();
        let mut bodies = vec![Placement::identity(); q.len()];
        forward_kinematics(&self.scenario.model, &q, &mut bodies)?;
        let entries = |at: &Placement<Model>| at.rotation.iter().chain(&at.translation).map(Model::radius).collect();
        let radii = bodies.iter().flat_map(|at| -> Vec<f64> { entries(at) });
        // An error of NaN stays NaN.
        let most = radii.fold(f64::MIN_POSITIVE, |most, r| if r <= most { most } else { r });
        Ok((bodies, most))
    }
}
