//! Checks, before any search, for conditions that no motion can meet.

use crate::results::feasibility::three_digits;
use crate::{Continuous, HorizonBounds, Quantity, Scenario};
use aghf::direct::DirectSettings;
use aghf::dynamics::{Data, forward_kinematics, rnea};
use aghf::error::{Error, Result, check_length, plain};
use aghf::geometry::{ClosestPair, Collider, Part};
use aghf::model::Model;
use aghf::spatial::Placement;
use std::f64::consts::TAU;

/// The largest accepted violation of a constraint, in its own unit, as in the search.
const TOLERANCE: f64 = DirectSettings::FEASIBLE;

/// The joint that takes longest from `start` to `goal`, `N` entries each, at the velocity limits of `model`, and its
/// duration, s: the shortest horizon of any motion between them within these limits. `None` if no joint with a velocity
/// limit moves. Cost O(N).
///
/// # Errors
/// A slice does not have `N` entries.
pub fn least_horizon(model: &Model, start: &[f64], goal: &[f64]) -> Result<Option<(usize, f64)>> {
    check_length("start", model.dof(), start.len())?;
    check_length("goal", model.dof(), goal.len())?;
    let speed = |i: usize| model.joints()[i].limits().velocity;
    Ok(slowest(start, goal, speed))
}

/// The joint that takes longest at these speeds, and its duration.
pub(crate) fn slowest(start: &[f64], goal: &[f64], speed: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
    let ways = start.iter().zip(goal).map(|(start, goal)| (goal - start).abs());
    let times = ways.enumerate().map(|(i, way)| (i, way / speed(i)));
    // A joint that does not move takes no time, even at a velocity limit of zero.
    let moving = times.filter(|(_, time)| *time > 0.0);
    moving.max_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// Returns true if all velocities are zero.
fn rests(v: &[f64]) -> bool {
    v.iter().all(|v| *v == 0.0)
}

/// The largest accepted excess of a boundary state over a limit of its joint, rad or m: what the search accepts for a
/// whole motion leaves it nothing to move with.
const TOLERANCE_OF_ENDS: f64 = 0.5 * TOLERANCE;

/// The largest distance from a limit for which the message about a start suggests a tolerance, rad or m.
const MAX_SUGGESTED: f64 = 0.05;

/// One boundary state of a motion.
struct End<'a> {
    /// The keys of its position, its velocity and its acceleration.
    keys: [&'a str; 3],
    q: &'a [f64],
    /// The velocity; `None` if it is free.
    v: Option<&'a [f64]>,
    /// The acceleration, if it is given.
    a: Option<&'a [f64]>,
}

impl Scenario {
    /// The joint that takes longest at the enforced limits of velocity, acceleration and jerk, the limit, and its
    /// duration, s: no motion is shorter. Each joint takes at least the time of its way $d$ by the waypoints at its
    /// velocity; from rest to rest $2 \sqrt{d / \bar a}$, or $d / \bar v + \bar v / \bar a$ if it reaches its velocity,
    /// and $(32 d / \bar\jmath)^{1/3}$. `None` if no joint with such a limit moves; a goal that is a set has no part.
    #[must_use]
    pub fn least_horizon(&self) -> Option<(usize, Quantity, f64)> {
        self.least_horizon_to(self.known_goal())
    }

    /// The same with another final configuration, or without one.
    pub(crate) fn least_horizon_to(&self, goal: Option<&[f64]>) -> Option<(usize, Quantity, f64)> {
        let file = &self.file;
        let is_pushed = [&file.a_start, &file.a_goal].into_iter().flatten().any(|a| !rests(a));
        let at_rest = rests(&file.v_start) && rests(&file.v_goal) && !file.free_final_velocity && !is_pushed;
        let times = (0..self.model.dof()).flat_map(|i| {
            let most = |limit| self.bound(limit, i).map_or(f64::INFINITY, |[_, most]| most);
            let way = self.way_of(i, goal);
            let (v, a, j) = (most(Quantity::Velocity), most(Quantity::Acceleration), most(Quantity::Jerk));
            let accelerated = if way * a > v * v { way / v + v / a } else { 2.0 * (way / a).sqrt() };
            let of_rest = [(Quantity::Acceleration, a, accelerated), (Quantity::Jerk, j, (32.0 * way / j).cbrt())];
            let of_rest = of_rest.into_iter().filter(move |(_, most, _)| at_rest && most.is_finite());
            let of_rest = of_rest.map(move |(limit, _, time)| (i, limit, time));
            of_rest.chain([(i, Quantity::Velocity, way / v)])
        });
        // A joint that does not move takes no time, even at a velocity limit of zero.
        let moving = times.filter(|(.., time)| *time > 0.0);
        moving.max_by(|(.., a), (.., b)| a.total_cmp(b))
    }

    /// Checks that the scenario does not rule out every motion for a reason visible without a search: a boundary state
    /// beyond a limit, in collision or against a user-defined constraint; a horizon too short for a joint; or a state
    /// at rest that the torques cannot hold, or the foot on which the robot stands. Only constraints of the scenario
    /// count, each within the tolerance of the search, [`DirectSettings::FEASIBLE`]; a free final velocity is not
    /// checked, nor a first guess of the end.
    ///
    /// # Errors
    /// Names the key, the joint or the obstacle, the value and the limit.
    pub fn check_feasible(&self) -> Result<()> {
        let file = &self.file;
        let keys = ["q_start", "v_start", "a_start"];
        let start = End { keys, q: &file.q_start, v: Some(&file.v_start), a: file.a_start.as_deref() };
        let ends = [start, self.end_at(&file.q_goal)];
        let ends = match (&self.period, &self.goal) {
            (Some(_), _) => &[],
            (None, Some(_)) => &ends[..1],
            (None, None) => &ends[..],
        };
        for end in ends {
            self.check_state(end)?;
        }
        self.check_horizon()?;
        for end in ends {
            self.check_configuration(end)?;
        }
        Ok(())
    }

    /// The boundary positions outside the limits of their joints, in words. They are reported rather than refused,
    /// because the paper's Digit scenarios have some.
    #[must_use]
    pub fn outside_limits(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for (key, q) in [("q_start", &self.file.q_start), ("q_goal", &self.file.q_goal)] {
            for (i, (joint, q)) in self.model.joints().iter().zip(q).enumerate() {
                let (lower, upper) = (joint.limits().lower, joint.limits().upper);
                let returns = key == "q_start" && self.bound_when_back(i).is_some();
                if !(lower..=upper).contains(q) && !returns {
                    let (name, [q, lower, upper]) = (joint.name(), [*q, lower, upper].map(plain));
                    notes.push(format!("{key}: joint '{name}' at {q} is outside [{lower}, {upper}]"));
                }
            }
        }
        notes
    }

    /// A configuration as the end of the motion.
    fn end_at<'a>(&'a self, q: &'a [f64]) -> End<'a> {
        let file = &self.file;
        let v = (!file.free_final_velocity).then_some(&file.v_goal[..]);
        End { keys: ["q_goal", "v_goal", "a_goal"], q, v, a: file.a_goal.as_deref() }
    }

    /// Checks a configuration as [`check_feasible`](Self::check_feasible) does with that at the end.
    pub(crate) fn check_end(&self, q: &[f64]) -> Result<()> {
        let end = self.end_at(q);
        self.check_state(&end)?;
        self.check_configuration(&end)
    }

    /// Checks a configuration on the way, named by a key: limits of positions, and collisions.
    pub(crate) fn check_on_the_way(&self, key: &str, q: &[f64]) -> Result<()> {
        self.check_bounds(Quantity::Position, key, q)?;
        self.check_clear(&End { keys: [key; 3], q, v: None, a: None })
    }

    /// Refuses a boundary state beyond a limit of a joint.
    fn check_state(&self, end: &End<'_>) -> Result<()> {
        let [q_key, v_key, a_key] = end.keys;
        self.check_bounds(Quantity::Position, q_key, end.q)?;
        if let Some(a) = end.a {
            self.check_bounds(Quantity::Acceleration, a_key, a)?;
        }
        if q_key == "q_start" {
            self.check_way_back()?;
        }
        let Some(v) = end.v else {
            return Ok(());
        };
        self.check_bounds(Quantity::Velocity, v_key, v)?;
        self.check_stopping(v_key, (end.q, v), v_key == "v_start")
    }

    /// Refuses a boundary state in collision, against a user-defined constraint, or at rest beyond the torques.
    fn check_configuration(&self, end: &End<'_>) -> Result<()> {
        self.check_clear(end)?;
        if let Some(v) = end.v {
            self.check_own_constraints(end.keys[0], end.q, v)?;
        }
        self.check_torques(end)?;
        let is_smooth = self.file.continuity() == Continuous::Acceleration;
        if is_smooth && end.v.is_some_and(rests) && end.a.is_none_or(rests) {
            self.check_balance(end.keys[0], end.q)?;
        }
        Ok(())
    }

    /// Refuses an entry of `x` beyond the limit of its joint.
    fn check_bounds(&self, limit: Quantity, key: &str, x: &[f64]) -> Result<()> {
        for (i, (joint, x)) in self.model.joints().iter().zip(x).enumerate() {
            let bound = if key == "q_start" { self.bound_throughout(limit, i) } else { self.bound(limit, i) };
            let Some([lower, upper]) = bound else {
                continue;
            };
            if *x < lower - TOLERANCE_OF_ENDS || *x > upper + TOLERANCE_OF_ENDS {
                let (name, what, unit) = (joint.name(), limit.name(), limit.unit(joint.kind()));
                let in_degrees = x.abs() > TAU && (lower..=upper).contains(&x.to_radians());
                let units = match unit {
                    "rad" if in_degrees => "; angles are in radians, are these degrees?",
                    _ => "",
                };
                let off = (lower - x).max(x - upper);
                let back = if key == "q_start" && off < MAX_SUGGESTED && self.file.phases.is_empty() {
                    format!("; a start_tolerance.position of {} accepts it", three_digits(off, f64::ceil))
                } else {
                    String::new()
                };
                let [x, lower, upper] = [*x, lower, upper].map(plain);
                let condition = format!(
                    "joint '{name}' has {x} {unit}, its enforced {what} limits are [{lower}, {upper}] \
                     {unit}{units}{back}"
                );
                return self.refuse(key, condition);
            }
        }
        Ok(())
    }

    /// The advice where no configuration at the end is given, from which a horizon that is too short would be known.
    pub(crate) fn fixed_horizon(&self) -> Option<String> {
        (self.goal.is_some() && self.horizon_bounds().is_none()).then(|| {
            let horizon = plain(self.file.horizon_s);
            format!("the horizon is fixed: a horizon_s of more than {horizon} s or free_horizon may help")
        })
    }

    /// Refuses a horizon that is too short for a joint.
    fn check_horizon(&self) -> Result<()> {
        let file = &self.file;
        let (key, horizon) = match self.horizon_bounds() {
            Some(HorizonBounds { longest_s, .. }) => ("free_horizon.longest_s", longest_s),
            None => ("horizon_s", file.horizon_s),
        };
        let Some((i, limit, least)) = self.least_horizon() else {
            return Ok(());
        };
        let [_, most] = self.bound(limit, i).unwrap_or([f64::INFINITY; 2]);
        // A limit may be exceeded by the tolerance. Times are proportional to its inverse, or to the square or cube
        // root of that.
        if least * most <= (most + TOLERANCE) * horizon {
            return Ok(());
        }
        let joint = &self.model.joints()[i];
        let (name, what, unit) = (joint.name(), limit.name(), limit.unit(joint.kind()));
        let (least, most) = (three_digits(least, f64::ceil), three_digits(most, f64::round));
        let horizon = plain(horizon);
        let condition = format!(
            "it is {horizon} s, but joint '{name}' needs at least {least} s at its {what} limit of {most} {unit}, the \
             others less"
        );
        self.refuse(key, condition)
    }

    /// Refuses a boundary state at which a ball of the robot overlaps an obstacle.
    fn check_clear(&self, end: &End<'_>) -> Result<()> {
        let mut placements = vec![Placement::identity(); self.model.dof()];
        forward_kinematics(&self.model, end.q, &mut placements)?;
        let deepest = self.scene.deepest_contact(&placements)?;
        let Some(contact) = deepest.filter(|contact| -contact.distance > TOLERANCE) else {
            return Ok(());
        };
        // The first frame of a body is that of the link on its joint. Several links may be locked to the base, so it
        // has none.
        let (Part { body, link }, depth) = (contact.part, -contact.distance);
        let mut frames = self.model.frames().iter();
        let frame = frames.find(|f| f.body == body && body.is_some());
        let link = link.or_else(|| frame.map(|f| f.name.as_str()));
        let link = link.map_or_else(|| "a link that is locked to the base".to_owned(), |link| format!("link '{link}'"));
        let [_, other] = self.names_of(&contact);
        let margin = contact.margin;
        let is_inside = depth >= margin;
        let remedy = remedy(&contact, is_inside);
        let what = match contact.other {
            Collider::Robot(_) => "link ",
            Collider::Obstacle(_) => "",
        };
        let mut condition = if is_inside {
            let depth = depth - margin;
            format!("{link} is {depth:.3e} m inside {what}'{other}'{remedy}")
        } else {
            let distance = margin - depth;
            format!("{link} is {distance:.3e} m from {what}'{other}', its clearance_m is {margin} m{remedy}")
        };
        let clear = self.scene.clearance(&placements)?;
        if margin == 0.0 && clear >= 0.0 {
            condition += &format!(
                " by the balls that cover it, though {clear:.3e} m clear itself; \
                 a smaller robot_shape.swept_links.spacing_m makes them smaller"
            );
        }
        self.refuse(end.keys[0], condition)
    }

    /// Refuses a boundary state at rest, or with a given acceleration, that the torques cannot hold.
    fn check_torques(&self, end: &End<'_>) -> Result<()> {
        let n = self.model.dof();
        let (zeros, mut torques) = (vec![0.0; n], vec![0.0; n]);
        let data = &mut Data::new(&self.model);
        let [q_key, _, a_key] = end.keys;
        let (v, a, key, task) = match (end.v, end.a) {
            (Some(v), Some(a)) if !rests(v) || !rests(a) => (v, a, a_key, "for the given acceleration"),
            (Some(v), _) if rests(v) => (v, &zeros[..], q_key, "to hold the robot at rest"),
            _ => return Ok(()),
        };
        rnea(&self.model, data, end.q, v, a, &mut torques)?;
        for (i, (joint, torque)) in self.model.joints().iter().zip(torques).enumerate() {
            let Some([_, most]) = self.bound(Quantity::Torque, i) else {
                continue;
            };
            if torque.abs() > most + TOLERANCE {
                let (name, unit) = (joint.name(), Quantity::Torque.unit(joint.kind()));
                let (torque, most) = (three_digits(torque.abs(), f64::ceil), plain(most));
                let but = if self.is_passive(i) {
                    "it is passive".to_owned()
                } else {
                    format!("its enforced torque limit is {most} {unit}")
                };
                let condition = format!("joint '{name}' needs {torque} {unit} {task}, {but}");
                return self.refuse(key, condition);
            }
        }
        Ok(())
    }

    fn refuse(&self, key: &str, condition: String) -> Result<()> {
        Err(Error::input(&self.name, key, condition))
    }
}

/// The keys that help against a contact at an end, an overlap or a distance below the margin.
fn remedy(contact: &ClosestPair<'_>, is_inside: bool) -> &'static str {
    match (contact.other, is_inside, contact.part.body) {
        (Collider::Robot(_), true, _) => {
            "; if they may touch, self_collision.ignored_pairs has to name them, and with a smaller \
             robot_shape.collision.excess_m meshes have finer pieces"
        }
        (Collider::Robot(_), false, _) => {
            "; clearance_m.obstacles is the distance from obstacles alone, clearance_m.pairs that of two links"
        }
        (Collider::Obstacle(_), true, None) => {
            "; that link does not move: the obstacle has to be elsewhere, or robot_shape.collision.excess_m smaller"
        }
        (Collider::Obstacle(_), false, None) => {
            "; that link does not move: the clearance_m of the obstacle has to be smaller"
        }
        (Collider::Obstacle(_), _, Some(_)) => "",
    }
}
