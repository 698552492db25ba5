//! Adaptive subdivision of the horizon.

use super::clearance::{Balls, Least, Pair, pairs};
use super::points::{Points, deviations};
use super::rows::{Nearest, Row, Rows, limits};
use super::scope::{has_balls, may_overlap, not_certified};
use super::shapes::{self, Part as ShapePart, Shapes};
use super::{Certificate, Deviations, Direction, Interval, Passage, Promise, TOLERANCE};
use crate::Scenario;
use aghf::certify::{Bernstein, Motion, ORDER, Part, Piece};
use aghf::curve::Curve;
use aghf::error::Result;
use aghf::linalg::rows as rows_of;

/// The fewest intervals of a motion.
const FEWEST: usize = 16;

/// The largest number of intervals, and the smallest half width of one: beyond, a promise is not provable.
const MOST: usize = 4000;
const SMALLEST: f64 = 1.0 / (1 << 24) as f64;

/// The accepted deviation of states at the ends and between segments, and of accelerations there.
const STATE: f64 = 1e-9;
const ACCELERATION: f64 = 1e-6;

/// The number of decimals of a claimed reserve.
const DECIMALS: f64 = 1e9;

/// A larger reserve of a row is claimed as this.
const ENOUGH: f64 = 1.0;

/// The share of a segment by which intervals reach beyond the times of a condition, more than rounding of times.
const BEYOND: f64 = 1.0 / (1_u64 << 39) as f64;

/// The result of a certification.
#[derive(Clone, Debug, PartialEq)]
pub struct Certification {
    /// The certificate; `None` if a promise was not proved.
    pub certificate: Option<Certificate>,
    /// The first place of each row that was not proved.
    pub failures: Vec<Failure>,
}

/// A row that is broken, or could not be proved.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// The promise in words.
    pub promise: String,
    /// The joint, or the names of a pair.
    pub place: String,
    /// The time, s.
    pub at_s: f64,
    /// A value, in the unit of the row.
    pub value: f64,
    /// Its bound.
    pub bound: f64,
    /// True if the value is proved to be beyond the bound.
    pub is_broken: bool,
}

/// The proof under construction.
struct Search<'a> {
    scenario: &'a Scenario,
    motion: &'a Motion,
    rows: Rows<'a>,
    promises: Vec<Promise>,
    pairs: Vec<Vec<Pair>>,
    /// The shapes of the robot, unless it consists of balls.
    shapes: Option<Vec<ShapePart>>,
    failures: Vec<Failure>,
}

/// The claims on an interval and the directions that separate shapes there.
type Claims = (Vec<f64>, Vec<Direction>);

/// The least reserve of the pairs of a promise and the directions that separate shapes.
type Reserve = (Least, Vec<Direction>);

/// Proves what a scenario promises of a motion that passes the waypoints at these times, s.
pub(super) fn certification(
    scenario: &Scenario,
    curve: &Curve,
    times: &[f64],
) -> Result<Certification> {
    let (motion, limits) = (Motion::of_curve(curve), limits(scenario));
    let mut search = Search::new(scenario, &motion, Rows::new(scenario, &limits, &motion)?)?;
    let deviations = deviations(scenario, &motion);
    search.check(&deviations);
    let (goal, waypoints) = search.points(times)?;
    let intervals = search.intervals()?;
    let (promises, failures) = (search.promises, search.failures);
    if !failures.is_empty() {
        return Ok(Certification {
            certificate: None,
            failures,
        });
    }
    let n = curve.dof();
    let positions = |e| rows_of(&curve.coefficients(e).rows(0, n).into_owned());
    let not_certified = not_certified(scenario)?;
    let joints = scenario.model.joints().iter();
    let certificate = Certificate {
        format: "aghf-certificate-2".to_owned(),
        scenario: scenario.name.clone(),
        robot_xxh64: scenario.robot_xxh64.clone(),
        complete: not_certified.is_empty(),
        not_certified,
        tolerance: TOLERANCE,
        limits,
        may_overlap: may_overlap(scenario),
        deviations,
        goal,
        waypoints,
        promises,
        intervals,
        horizon_s: curve.horizon(),
        joints: joints.map(|j| j.name().to_owned()).collect(),
        coefficients: (0..curve.segments()).map(positions).collect(),
    };
    Ok(Certification {
        certificate: Some(certificate),
        failures,
    })
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
            value: nearest.value,
            bound: nearest.bound,
            is_broken,
        }
    }
}

impl<'a> Search<'a> {
    fn new(scenario: &'a Scenario, motion: &'a Motion, rows: Rows<'a>) -> Result<Self> {
        let mut promises: Vec<_> = rows.all.iter().map(|row| row.promise).collect();
        promises.dedup();
        let (shapes, mut all) = (shapes::parts(scenario)?, Vec::new());
        for promise in [Promise::Obstacles, Promise::SelfCollision] {
            let own = match &shapes {
                Some(parts) => shapes::pairs(scenario, parts, promise),
                None if has_balls(scenario) => pairs(scenario, promise),
                None => Vec::new(),
            };
            if !own.is_empty() {
                promises.push(promise);
                all.push(own);
            }
        }
        Ok(Self {
            scenario,
            motion,
            rows,
            promises,
            pairs: all,
            shapes,
            failures: Vec::new(),
        })
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

    /// Checks the states at the ends and between segments, and the horizon.
    fn check(&mut self, found: &Deviations) {
        let horizon = self.motion.horizon();
        let states = [
            ("start position", found.start_position, STATE, 0.0),
            ("start velocity", found.start_velocity, STATE, 0.0),
            ("goal position", found.goal_position, STATE, horizon),
            ("goal velocity", found.goal_velocity, STATE, horizon),
            (
                "continuity of positions",
                found.jump_position,
                STATE,
                f64::NAN,
            ),
            (
                "continuity of velocities",
                found.jump_velocity,
                STATE,
                f64::NAN,
            ),
            (
                "continuity of accelerations",
                found.jump_acceleration,
                ACCELERATION,
                f64::NAN,
            ),
        ];
        for (promise, value, bound, at_s) in states {
            let Some(value) = value else { continue };
            let holds = value <= bound;
            if !holds {
                self.fail(Failure {
                    promise: promise.to_owned(),
                    place: String::new(),
                    at_s,
                    value,
                    bound,
                    is_broken: true,
                });
            }
        }
        let file = &self.scenario.file;
        let [shortest, longest] = match file.free_horizon {
            Some(free) => [free.shortest_s, free.longest_s],
            None => [file.horizon_s; 2],
        };
        if !(shortest..=longest).contains(&horizon) {
            self.fail(Failure {
                promise: "horizon".to_owned(),
                place: String::new(),
                at_s: horizon,
                value: horizon,
                bound: if horizon < shortest {
                    shortest
                } else {
                    longest
                },
                is_broken: true,
            });
        }
    }

    /// Checks the goal, if it is a set of poses, and the waypoints, which the motion passes at these times, s.
    fn points(&mut self, times: &[f64]) -> Result<(Option<f64>, Vec<Passage>)> {
        let points = Points {
            scenario: self.scenario,
            motion: self.motion,
            rows: &self.rows,
        };
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

    /// The segments, cut at the times between which conditions are kept, and at least [`FEWEST`] parts.
    fn parts(&self) -> Vec<Part> {
        let segments = self.motion.segments();
        let mut parts: Vec<Part> = (0..segments).map(Part::whole).collect();
        for [from, to] in self.rows.all.iter().map(|row| row.times) {
            for (time, out) in [(from, -BEYOND), (to, BEYOND)] {
                let place = time / self.motion.horizon() * segments as f64 + out;
                let x = 2.0 * place.fract() - 1.0;
                let cut = |part: Part| {
                    let [begin, end] = part.ends();
                    if part.segment as f64 == place.floor() && begin < x && x < end {
                        part.split(x).to_vec()
                    } else {
                        vec![part]
                    }
                };
                parts = parts.into_iter().flat_map(cut).collect();
            }
        }
        while parts.len() < FEWEST {
            parts = parts
                .into_iter()
                .flat_map(|part| part.split(part.middle))
                .collect();
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
            let can_halve = part.half > SMALLEST && found.len() + open.len() < MOST;
            match self.claims(part, &basis, can_halve)? {
                Some((claims, directions)) => {
                    let [from, to] = part.ends();
                    let claims = claims.into_iter().map(floor).collect();
                    found.push(Interval(part.segment, from, to, claims, directions));
                }
                None => open.extend(part.split(part.middle).into_iter().rev()),
            }
        }
        Ok(found)
    }

    /// The claims of each promise on a part; `None` if it is to be halved.
    fn claims(&mut self, part: Part, basis: &Bernstein, can_halve: bool) -> Result<Option<Claims>> {
        let piece = self.motion.piece(part);
        let mut claims = vec![ENOUGH; self.promises.len()];
        let mut failures = Vec::new();
        let nearest = self.rows.nearest(&piece)?;
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
                let promise = row.promise.name().to_owned();
                failures.push(Failure::of(promise, row, nearest, at_s, is_broken));
            }
            let of = self.promises.iter().position(|p| *p == row.promise);
            let of = of.unwrap_or_default();
            claims[of] = claims[of].min(nearest.claim);
        }
        let mut directions = Vec::new();
        let Some(clearances) = self.clearances(&piece, basis, can_halve)? else {
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
                    promise: self.promises[first + of].name().to_owned(),
                    place: least.place,
                    at_s: self.motion.time(part, 0.0),
                    value: least.middle,
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

    /// The least reserves of the promises of clearances on a piece; `None` if it is to be halved.
    fn clearances(
        &self,
        piece: &Piece,
        basis: &Bernstein,
        can_halve: bool,
    ) -> Result<Option<Vec<Reserve>>> {
        if self.pairs.is_empty() {
            return Ok(Some(Vec::new()));
        }
        let pairs = self.pairs.iter();
        if let Some(parts) = &self.shapes {
            let shapes = Shapes::new(self.scenario, parts, basis, piece)?;
            return Ok(Some(pairs.map(|pairs| shapes.least(pairs)).collect()));
        }
        let balls = Balls::new(self.scenario, basis, piece)?;
        let all = pairs.map(|pairs| (balls.least(pairs), Vec::new()));
        Ok((balls.are_known() || !can_halve).then(|| all.collect()))
    }
}
