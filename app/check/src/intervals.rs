//! The claims on each interval and at single places.

use crate::Checked;
use crate::arithmetic::{Bernstein, Tm, UP};
use crate::distance::{Clearances, Directions, Distances};
use crate::json::{entries, list, number, number_or, option, require, three};
use crate::motion::{Motion, cut, middle};
use crate::robot::Robot;
use crate::rows::{Row, State};
use crate::scenario::{KINDS, Limit, Obstacle, Pair, obstacles, pairs};
use serde_json::Value;

/// The accepted difference of times, of the horizon: more than rounding.
const SAME_TIME: f64 = 1e-12;

/// The promises of a scenario, and the motion that keeps them at all times.
pub(crate) struct Promised<'a> {
    scenario: &'a Value,
    robot: Robot,
    motion: Motion,
    /// The largest deviation of a position from the motion.
    pub(crate) tube: f64,
    limits: Vec<Limit>,
    /// The conditions along the way.
    kept: &'a [Value],
    obstacles: Vec<Obstacle>,
    /// The names of the promises of clearances, and their pairs.
    clear: Vec<(&'static str, Vec<Pair>)>,
    /// The bases of the degree of the motion, and of the degree of all other polynomials.
    bases: [Bernstein; 2],
}

impl<'a> Promised<'a> {
    pub(crate) fn new(
        scenario: &'a Value,
        certificate: &Value,
        robot: Robot,
        limits: Vec<Limit>,
        motion: Motion,
    ) -> Checked<Self> {
        let obstacles = obstacles(scenario)?;
        let pairs = pairs(scenario, &robot, &obstacles)?;
        let clear = ["obstacles", "self_collision"].into_iter().zip(pairs).filter(|(_, pairs)| !pairs.is_empty());
        let bases = [Bernstein::new(motion.degree()), Bernstein::new(Tm::new(0.0).c.len() - 1)];
        let kept = entries(scenario, "keep");
        for (i, [from, to]) in kept.iter().map(window).enumerate() {
            let is_met = from < to && from < motion.horizon;
            require(is_met, format!("keep[{i}] from {from} to {to} s is at no time of the motion"))?;
        }
        let back = option(scenario, "start_tolerance").map_or(0.0, |start| number_or(start, "back_s", 0.25));
        require(motion.horizon >= back, "the motion ends before start_tolerance.back_s")?;
        let tube = number(&certificate["tracking_error"]);
        Ok(Self { scenario, clear: clear.collect(), robot, motion, tube, limits, kept, obstacles, bases })
    }

    /// The names of the promises, in the order of the claims.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let limits = KINDS.into_iter().filter(|kind| self.limits.iter().any(|limit| limit.0 == *kind));
        let keep = (!self.kept.is_empty()).then_some("keep");
        let stand = option(self.scenario, "stand").map(|_| "stand");
        limits.chain(keep).chain(stand).chain(self.clear.iter().map(|(name, _)| *name)).collect()
    }

    /// Proves the claim on a row.
    fn prove_row(&self, row: &Row, claim: f64) -> Checked<()> {
        let (c, r) = &row.value;
        let basis = &self.bases[usize::from(c.len() <= Tm::new(0.0).c.len())];
        let reserve = claim * row.scale;
        let negative: Vec<f64> = c.iter().map(|c| -c).collect();
        // No bound is one of the row, before a reserve is added to it, which must not overflow.
        let is_above = |c: &[f64], bound: f64| {
            let wanted = bound + reserve;
            bound == f64::NEG_INFINITY || wanted.is_finite() && basis.least(c, *r, wanted, 1e-13 * row.scale) >= wanted
        };
        let kept = row.scale > 0.0 && is_above(c, row.bounds[0]) && is_above(&negative, -row.bounds[1]);
        require(kept, row.name.as_str())
    }

    /// Proves the claims on the goal, if it is a set of poses, and on the waypoints.
    pub(crate) fn check_places(&self, certificate: &Value) -> Checked<()> {
        let (last, goals) = (self.motion.segments() - 1, entries(self.scenario, "goal"));
        if !goals.is_empty() {
            let claim = option(certificate, "goal").map(number).ok_or("'goal' is missing")?;
            let state = self.state_at(last as f64, 1.0)?;
            let sets = goals.iter().map(|goal| state.poses(goal)).collect::<Checked<Vec<_>>>()?;
            let is_in = |rows: &Vec<Row>| rows.iter().all(|row| self.prove_row(row, claim).is_ok());
            require(sets.iter().any(is_in), "the goal is not proved")?;
        }
        let (points, places) = (entries(self.scenario, "waypoints"), entries(certificate, "waypoints"));
        require(points.len() == places.len(), "the waypoints are not those of the scenario")?;
        let mut before = [0.0, -1.0];
        for (i, (point, place)) in points.iter().zip(places).enumerate() {
            let fault = |what: String| format!("waypoint {i}: {what}");
            let [segment, x, claim] = three(place);
            let rows = self.state_at(segment, x).and_then(|state| state.waypoint(point)).map_err(fault)?;
            rows.iter().try_for_each(|row| self.prove_row(row, claim)).map_err(fault)?;
            let time = option(point, "time_s").map(number);
            let off = time.map_or(0.0, |time| (self.motion.time(segment as usize, x) - time).abs());
            require(off <= SAME_TIME * self.motion.horizon, fault("it has another time".to_owned()))?;
            require(before <= [segment, x], fault("it is before another one".to_owned()))?;
            before = [segment, x];
        }
        Ok(())
    }

    /// The state at a place: a segment and x in it.
    fn state_at(&self, segment: f64, x: f64) -> Checked<State<'_>> {
        let known = segment.fract() == 0.0 && (0.0..self.motion.segments() as f64).contains(&segment);
        require(known, "the place is not in the motion")?;
        let [q, v, ..] = self.motion.expand(segment as usize, [x, 1.0 / f64::from(1 << 20)]);
        let [q, v] = [q, v].map(|all| all.iter().map(middle).collect());
        Ok(State::new(&self.robot, q, v))
    }

    /// Checks that the intervals cover all segments, one after the other, and the claims on each.
    pub(crate) fn check(&self, intervals: &[Value]) -> Checked<()> {
        let segments = self.motion.segments();
        let not_covered = "the intervals do not cover the horizon";
        let (mut segment, mut from) = (0, -1.0);
        for interval in intervals {
            let [own, begin, end] = three(interval);
            let directions = interval[4].as_array().into_iter().flatten().map(direction).collect();
            let claims = list(&interval[3]);
            if from == 1.0 {
                (segment, from) = (segment + 1, -1.0);
            }
            // A middle and a half width that represent both ends exactly.
            let (m, w) = (0.5 * (begin + end), 0.5 * (end - begin));
            let exact = m - w == begin && m + w == end && w > 0.0 && end <= 1.0;
            require(own == segment as f64 && segment < segments && begin == from && exact, not_covered)?;
            require(claims.len() == self.names().len(), "a reserve is missing")?;
            from = end;
            let proved = self.prove(segment, [m, w], &claims, directions);
            proved.map_err(|what| format!("segment {segment} from {begin} to {end}: {what} is not proved"))?;
        }
        require(segment == segments - 1 && from == 1.0, not_covered)
    }

    /// Proves the claims on an interval; the error names the claim that is not proved.
    fn prove(&self, segment: usize, [m, w]: [f64; 2], claims: &[f64], directions: Directions) -> Checked<()> {
        let [mut q, v, a, jerk] = self.motion.expand(segment, [m, w]);
        q.iter_mut().for_each(|(_, radius)| *radius = (*radius + self.tube) * UP);
        let [qs, vs, accelerations] = [&q, &v, &a].map(|all| all.iter().map(cut).collect::<Vec<Tm>>());
        let (mut torques, mut foot) = (Vec::new(), Vec::new());
        let stand = option(self.scenario, "stand");
        let loads = if stand.is_some() || self.limits.iter().any(|limit| matches!(limit.0, "torque" | "power")) {
            Some(self.robot.torques(&qs, &vs, &accelerations))
        } else {
            None
        };
        let state = State::new(&self.robot, qs, vs);
        if let Some((all, ground)) = loads {
            torques = all;
            foot = stand.map_or(Ok(Vec::new()), |stand| state.foot(stand, ground))?;
        }
        let mut kept = Vec::new();
        let [begin, end] = [m - w, m + w].map(|x| self.motion.time(segment, x));
        let rounding = 1e-15 * self.motion.horizon;
        for condition in self.kept {
            let [from, to] = window(condition);
            if end + rounding > from && begin - rounding < to {
                kept.extend(state.kept(condition)?);
            }
        }
        let derivatives = [q, v, a, jerk];
        let limit = |Limit(kind, joint, bounds, _): &Limit| {
            let polynomial = |x: Tm| (x.c.to_vec(), x.r);
            let value = match KINDS.iter().zip(&derivatives).find(|(known, _)| *known == kind) {
                Some((_, all)) => all[*joint].clone(),
                None if *kind == "torque" => polynomial(torques[*joint]),
                None if *kind == "power" => polynomial(torques[*joint] * state.v[*joint]),
                None => return Err("a limit of an unknown kind".to_owned()),
            };
            let scale = bounds.iter().filter(|b| b.is_finite()).fold(0.0_f64, |scale, b| scale.max(b.abs()));
            let scale = if scale > 0.0 { scale } else { 1.0 };
            let name = format!("{kind} of joint '{}'", self.robot.joints[*joint].name);
            Ok((*kind, Row { name, value, bounds: *bounds, scale }))
        };
        let limits = self.limits.iter().filter(|limit| end + rounding > limit.3).map(limit);
        let limits = limits.collect::<Checked<Vec<_>>>()?;
        let conditions = kept.into_iter().map(|row| ("keep", row)).chain(foot.into_iter().map(|row| ("stand", row)));
        let names = self.names();
        for (promise, row) in limits.into_iter().chain(conditions) {
            let claim = names.iter().zip(claims).find(|(name, _)| **name == promise).map_or(f64::NAN, |(_, c)| *c);
            self.prove_row(&row, claim)?;
        }
        if self.clear.is_empty() {
            return Ok(());
        }
        let (robot, obstacles) = (&self.robot, self.obstacles.as_slice());
        let (placed, by) = (robot.placed(&state.places), Distances(&self.bases[1]));
        let clearances = Clearances { robot, obstacles, placed, directions, by };
        let first = claims.len() - self.clear.len();
        for ((name, pairs), claim) in self.clear.iter().zip(&claims[first..]) {
            require(clearances.keep(*claim, pairs), *name)?;
        }
        Ok(())
    }
}

/// The times between which a condition along the way is kept, s.
fn window(condition: &Value) -> [f64; 2] {
    [number_or(condition, "from_s", f64::NEG_INFINITY), number_or(condition, "to_s", f64::INFINITY)]
}

/// A direction and the pair of shapes that it separates.
fn direction(value: &Value) -> ([usize; 2], [f64; 3]) {
    ([0, 1].map(|i| number(&value[i]) as usize), three(&value[2]))
}
