//! Adaptive subdivision of the horizon.

use super::clearance::{Balls, Pair, pairs};
use super::limits::{Bounds, LIMITS, deviations, rows};
use super::{Certificate, Deviations, Interval, LimitRow, NotCertified, Promise, TOLERANCE};
use crate::{ObstacleShape, RobotShape, Scenario};
use aghf::certify::{Bernstein, Motion, ORDER, Part};
use aghf::curve::Curve;
use aghf::error::Result;
use aghf::geometry::Shape;
use aghf::linalg::rows as rows_of;
use aghf::model::{Collision, CollisionShape};

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
pub(super) struct Search<'a> {
    scenario: &'a Scenario,
    curve: &'a Curve,
    motion: Motion,
    rows: Vec<LimitRow>,
    promises: Vec<Promise>,
    pairs: Vec<Vec<Pair>>,
    failures: Vec<Failure>,
}

impl<'a> Search<'a> {
    pub(super) fn new(scenario: &'a Scenario, curve: &'a Curve) -> Self {
        let rows = rows(scenario);
        let of_limits = LIMITS.iter().map(|(promise, _)| *promise);
        let mut promises: Vec<_> = of_limits
            .filter(|p| rows.iter().any(|r| r.promise == *p))
            .collect();
        let mut all = Vec::new();
        for promise in [Promise::Obstacles, Promise::SelfCollision] {
            let own = pairs(scenario, promise);
            if has_balls(scenario) && !own.is_empty() {
                promises.push(promise);
                all.push(own);
            }
        }
        Self {
            scenario,
            curve,
            motion: Motion::of_curve(curve),
            rows,
            promises,
            pairs: all,
            failures: Vec::new(),
        }
    }

    pub(super) fn run(mut self) -> Result<Certification> {
        let deviations = deviations(self.scenario, &self.motion);
        self.check(&deviations);
        let intervals = self.intervals()?;
        if !self.failures.is_empty() {
            return Ok(Certification {
                certificate: None,
                failures: self.failures,
            });
        }
        let curve = self.curve;
        let n = curve.dof();
        let positions = |e| rows_of(&curve.coefficients(e).rows(0, n).into_owned());
        let not_certified = not_certified(self.scenario);
        let certificate = Certificate {
            format: "aghf-certificate-1".to_owned(),
            scenario: self.scenario.name.clone(),
            robot_xxh64: self.scenario.robot_xxh64.clone(),
            complete: not_certified.is_empty(),
            not_certified,
            tolerance: TOLERANCE,
            limits: self.rows,
            may_overlap: may_overlap(self.scenario),
            deviations,
            promises: self.promises,
            intervals,
            horizon_s: curve.horizon(),
            joints: self
                .scenario
                .model
                .joints()
                .iter()
                .map(|j| j.name().to_owned())
                .collect(),
            coefficients: (0..curve.segments()).map(positions).collect(),
        };
        Ok(Certification {
            certificate: Some(certificate),
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

    /// The intervals with the claims on each, those without a failure.
    fn intervals(&mut self) -> Result<Vec<Interval>> {
        let mut open: Vec<Part> = (0..self.motion.segments()).rev().map(Part::whole).collect();
        while open.len() < FEWEST {
            open = open
                .into_iter()
                .flat_map(|part| part.halves().into_iter().rev())
                .collect();
        }
        let (mut bounds, basis) = (
            Bounds::new(self.scenario, &self.motion),
            Bernstein::new(ORDER - 1),
        );
        let mut found = Vec::new();
        while let Some(part) = open.pop() {
            let can_halve = part.half > SMALLEST && found.len() + open.len() < MOST;
            match self.claims(part, &mut bounds, &basis, can_halve)? {
                Some(claims) => {
                    let [from, to] = part.ends();
                    let floor = |claim: &f64| (claim * DECIMALS).floor() / DECIMALS;
                    found.push(Interval(
                        part.segment,
                        from,
                        to,
                        claims.iter().map(floor).collect(),
                    ));
                }
                None => open.extend(part.halves().into_iter().rev()),
            }
        }
        Ok(found)
    }

    /// The claims of each promise on a part; `None` if it is to be halved.
    fn claims(
        &mut self,
        part: Part,
        bounds: &mut Bounds,
        basis: &Bernstein,
        can_halve: bool,
    ) -> Result<Option<Vec<f64>>> {
        let piece = self.motion.piece(part);
        let mut claims = vec![f64::INFINITY; self.promises.len()];
        let mut failures = Vec::new();
        let nearest = bounds.nearest(self.scenario, &self.rows, &piece)?;
        for (row, nearest) in self.rows.iter().zip(&nearest) {
            let of = self
                .promises
                .iter()
                .position(|p| *p == row.promise)
                .unwrap_or_default();
            let holds = nearest.claim >= -TOLERANCE && nearest.is_known;
            let is_broken = !holds && nearest.is_beyond(row);
            if !holds && !is_broken && can_halve {
                return Ok(None);
            }
            if !holds {
                failures.push(Failure {
                    promise: row.promise.name().to_owned(),
                    place: format!("joint '{}'", self.scenario.model.joints()[row.joint].name()),
                    at_s: self.motion.time(part, nearest.place),
                    value: nearest.value,
                    bound: nearest.bound,
                    is_broken,
                });
            }
            claims[of] = claims[of].min(nearest.claim);
        }
        if !self.pairs.is_empty() {
            let balls = Balls::new(self.scenario, basis, &piece)?;
            if !balls.are_known() && can_halve {
                return Ok(None);
            }
            let first = self.promises.len() - self.pairs.len();
            for (of, pairs) in self.pairs.iter().enumerate() {
                let least = balls.least(pairs);
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
            }
        }
        for failure in failures {
            self.fail(failure);
        }
        Ok(Some(claims))
    }
}

/// The parts of a scenario without proofs.
fn not_certified(scenario: &Scenario) -> Vec<NotCertified> {
    let mut all = Vec::new();
    let mut add = |promise: &str, reason: &str| {
        all.push(NotCertified {
            promise: promise.to_owned(),
            reason: reason.to_owned(),
        });
    };
    if !scenario.passive().is_empty() {
        add(
            "passive_joints",
            "a polynomial keeps their torques at zero at finitely many times only",
        );
    }
    if !scenario.file.goal.is_empty() {
        add("goal", "poses at the end are not bounded yet");
    }
    if !has_balls(scenario) {
        let reason = "a shape of the robot is no ball, and the balls that cover it are not those of the checkers";
        if !scenario.file.obstacles.is_empty() {
            add("obstacles", reason);
        }
        if scenario.keeps_links_clear() {
            add("self_collision", reason);
        }
    }
    if !scenario.file.keep.is_empty() {
        add("keep", "conditions along the way are not bounded yet");
    }
    if !scenario.file.waypoints.is_empty() {
        add("waypoints", "points on the way are not bounded yet");
    }
    all
}

/// True if the robot and its load consist of balls, or of points or balls along its links.
fn has_balls(scenario: &Scenario) -> bool {
    let payload = scenario
        .file
        .payload
        .as_ref()
        .and_then(|payload| payload.shape);
    let load = payload.is_none_or(|shape| matches!(shape, ObstacleShape::Sphere { .. }));
    let by_shapes = matches!(scenario.robot_shape(), RobotShape::Collision { .. });
    let is_ball = |c: &Collision| matches!(c.shape, CollisionShape::Solid(Shape::Sphere { .. }));
    load && (!by_shapes || scenario.model.collisions().iter().all(is_ball))
}

/// The pairs of links on different bodies that do not keep clear of each other.
fn may_overlap(scenario: &Scenario) -> Vec<[String; 2]> {
    let scene = &scenario.scene;
    if scene.tree_pairs().is_empty() {
        return Vec::new();
    }
    let trees = scene.trees();
    let link = |i: usize| {
        scene
            .robot()
            .link_of(&trees[i])
            .unwrap_or_default()
            .to_owned()
    };
    let mut all = Vec::new();
    for i in 0..trees.len() {
        for j in i + 1..trees.len() {
            let kept = scene
                .tree_pairs()
                .iter()
                .any(|p| *p == [i, j] || *p == [j, i]);
            if !kept && trees[i].body != trees[j].body && link(i) != link(j) {
                all.push([link(i), link(j)]);
            }
        }
    }
    all
}
