//! The claims on each interval.

use crate::arithmetic::{Bernstein, Tm};
use crate::distance::{Distances, keeps};
use crate::json::{array, list, number, require};
use crate::motion::{Motion, Polynomial, cut};
use crate::robot::Robot;
use crate::scenario::{Limit, Obstacle, Pair, obstacles, pairs};
use crate::{Checked, TOLERANCE};
use serde_json::Value;

/// The kinds of limits.
const KINDS: [&str; 5] = ["position", "velocity", "acceleration", "jerk", "torque"];

/// The promises of a scenario, and the motion that keeps them at all times.
pub(crate) struct Promised {
    robot: Robot,
    motion: Motion,
    limits: Vec<Limit>,
    obstacles: Vec<Obstacle>,
    /// The names of the promises of clearances, and their pairs.
    clear: Vec<(&'static str, Vec<Pair>)>,
    /// Of the degree of the motion, and of that of torques and distances.
    bases: [Bernstein; 2],
}

impl Promised {
    pub(crate) fn new(
        scenario: &Value,
        certificate: &Value,
        robot: Robot,
        limits: Vec<Limit>,
        motion: Motion,
    ) -> Checked<Self> {
        let obstacles = obstacles(scenario)?;
        let pairs = pairs(scenario, certificate, &robot, &obstacles)?;
        let clear = ["obstacles", "self_collision"].into_iter().zip(pairs).filter(|(_, pairs)| !pairs.is_empty());
        let bases = [Bernstein::new(motion.degree()), Bernstein::new(Tm::new(0.0).c.len() - 1)];
        Ok(Self { clear: clear.collect(), robot, motion, limits, obstacles, bases })
    }

    /// The names of the promises, in the order of the claims.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let limits = KINDS.into_iter().filter(|kind| self.limits.iter().any(|limit| limit.0 == *kind));
        limits.chain(self.clear.iter().map(|(name, _)| *name)).collect()
    }

    /// Checks that the intervals cover all segments, one after the other, and the claims on each.
    pub(crate) fn check(&self, intervals: &[Value]) -> Checked<()> {
        let segments = self.motion.segments();
        let not_covered = "the intervals do not cover the horizon";
        let (mut segment, mut from) = (0, -1.0);
        for interval in intervals {
            let [own, begin, end, claims] = array(interval)?.as_slice() else {
                return Err("an interval has four entries".to_owned());
            };
            let (begin, end, claims) = (number(begin)?, number(end)?, list(claims)?);
            if from == 1.0 {
                (segment, from) = (segment + 1, -1.0);
            }
            // A middle and a half width that stand for both ends exactly.
            let (m, w) = (0.5 * (begin + end), 0.5 * (end - begin));
            let exact = m - w == begin && m + w == end && w > 0.0 && end <= 1.0;
            require(*own == segment && segment < segments && begin == from && exact, not_covered)?;
            let all = claims.len() == self.names().len() && claims.iter().all(|c| *c >= -TOLERANCE);
            require(all, "a reserve is negative or missing")?;
            from = end;
            let proved = self.prove(segment, [m, w], &claims);
            proved.map_err(|what| format!("segment {segment} from {begin} to {end}: {what} is not proved"))?;
        }
        require(segment == segments - 1 && from == 1.0, not_covered)
    }

    /// Proves the claims on an interval; the error is what is not proved.
    fn prove(&self, segment: usize, part: [f64; 2], claims: &[f64]) -> Checked<()> {
        let [q, v, a, jerk] = self.motion.expand(segment, part);
        let models = |all: &[Polynomial]| -> Vec<Tm> { all.iter().map(cut).collect() };
        let places = models(&q);
        let mut torques = Vec::new();
        if self.limits.iter().any(|limit| limit.0 == "torque") {
            let all = self.robot.torques(&places, &models(&v), &models(&a));
            torques = all.iter().map(|torque| (torque.c.to_vec(), torque.r)).collect();
        }
        let all = [q, v, a, jerk, torques];
        let names = self.names();
        for Limit(kind, joint, bounds) in &self.limits {
            let claim = names.iter().zip(claims).find(|(name, _)| *name == kind).map_or(f64::NAN, |(_, claim)| *claim);
            let at = KINDS.iter().position(|known| known == kind).ok_or("a limit of an unknown kind")?;
            let ((c, r), basis) = (&all[at][*joint], &self.bases[usize::from(*kind == "torque")]);
            let scale = bounds.iter().filter(|b| b.is_finite()).fold(0.0_f64, |scale, b| scale.max(b.abs()));
            let reserve = claim * if scale > 0.0 { scale } else { 1.0 };
            let negative: Vec<f64> = c.iter().map(|c| -c).collect();
            let is_above =
                |c: &[f64], bound: f64| !bound.is_finite() || basis.least(c, *r, bound, 1e-13 * scale) >= bound;
            let kept = is_above(c, bounds[0] + reserve) && is_above(&negative, reserve - bounds[1]);
            require(kept, format!("{kind} of joint '{}'", self.robot.joints[*joint].name))?;
        }
        if self.clear.is_empty() {
            return Ok(());
        }
        let (centres, by) = (self.robot.centres(&places), Distances(&self.bases[1]));
        let first = claims.len() - self.clear.len();
        for ((name, pairs), claim) in self.clear.iter().zip(&claims[first..]) {
            require(keeps(*claim, pairs, &self.robot, &self.obstacles, &centres, &by), *name)?;
        }
        Ok(())
    }
}
