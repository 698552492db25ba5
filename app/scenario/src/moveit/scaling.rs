//! The limits of a planning request, and the times of its motion within them.

use super::constraints::Target;
use super::messages::Request;
use super::states::Joints;
use crate::keys::joint_limits::JointLimitsFile;
use crate::solve::preflight::slowest;
use crate::{Enforced, EnforcedLimits, Kept, Quantity, RateLimits};
use aghf::error::{Error, Result, plain};
use aghf::model::{JointKind, Model};
use aghf::urdf::LoadReport;
use std::f64::consts::PI;
use std::path::Path;

/// The limits of the joints that move, and the speed of a link.
pub(super) struct Scaled {
    pub enforced: EnforcedLimits,
    /// The velocities, rad/s or m/s, and the accelerations per s^2; infinite without a limit.
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    /// The length of the way of the link for each rad or m of a joint at most, relative to its speed, s.
    slowness: Vec<f64>,
}

/// The factor of a request, if it has one: MoveIt reads zero as none.
fn factor_of(factor: f64, key: &str, file: &str) -> Result<Option<f64>> {
    if (0.0..=1.0).contains(&factor) {
        return Ok((factor > 0.0).then_some(factor));
    }
    let condition = format!("it is {}, a factor is above 0 and at most 1; 0 or none means 1", plain(factor));
    Err(Error::input(file, key, condition))
}

/// Refuses a factor of a request if a joint has no limit to which it could apply. The place is the file and the key.
fn check_known(factor: Option<f64>, limits: &[f64], joints: &Joints<'_>, [file, key]: [&str; 2]) -> Result<()> {
    let without = limits.iter().position(|most| most.is_infinite());
    let (Some(factor), Some(joint)) = (factor.filter(|factor| *factor < 1.0), without) else {
        return Ok(());
    };
    let (factor, joint) = (plain(factor), joints.moving[joint].name());
    let condition = format!(
        "it is {factor}, but joint '{joint}' has no known limit that it could scale; --joint-limits names a \
         joint_limits.yaml with limits of all joints that move, or set it to 1"
    );
    Err(Error::input(file, key, condition))
}

impl Scaled {
    /// The limits of the robot and of a `joint_limits.yaml`, times the factors of a request; without these, times those
    /// of the file. `file` names the request in errors, `kept` the speed that it limits.
    pub fn of(
        (request, file): (&Request, &str),
        limits: Option<&Path>,
        (joints, model): (&Joints<'_>, &Model),
        kept: Option<&Kept>,
        notes: &mut LoadReport,
    ) -> Result<Self> {
        let keys = ["max_velocity_scaling_factor", "max_acceleration_scaling_factor"];
        let velocity = factor_of(request.max_velocity_scaling_factor, keys[0], file)?;
        let acceleration = factor_of(request.max_acceleration_scaling_factor, keys[1], file)?;
        let limits = limits.map(|path| JointLimitsFile::load(path, &joints.moving));
        let limits = limits.transpose()?;
        let mut numbers = |limit, factor: Option<f64>| match &limits {
            Some(limits) => {
                let factor = factor.map_or_else(|| limits.factor(limit), Ok)?;
                Ok((factor, limits.limits(limit, &joints.moving, factor, notes)?))
            }
            None => Ok((factor.unwrap_or(1.0), vec![None; joints.moving.len()])),
        };
        let (share, velocities) = numbers(Quantity::Velocity, velocity)?;
        let (_, accelerations) = numbers(Quantity::Acceleration, acceleration)?;
        let (_, jerks) = numbers(Quantity::Jerk, None)?;
        let or_none = |most: &Option<f64>| most.unwrap_or(f64::INFINITY);
        let of_robot = joints.moving.iter().map(|joint| joint.limits().velocity);
        let both = of_robot.zip(&velocities);
        let fastest: Vec<_> = both.map(|(of_robot, most)| (share * of_robot).min(or_none(most))).collect();
        let hardest: Vec<_> = accelerations.iter().map(or_none).collect();
        check_known(velocity, &fastest, joints, [file, keys[0]])?;
        check_known(acceleration, &hardest, joints, [file, keys[1]])?;
        Ok(Self {
            velocity: fastest,
            acceleration: hardest,
            slowness: slowness(joints, model, kept),
            enforced: EnforcedLimits {
                velocity: Enforced::Share { share, joints: None },
                max_velocity: each(velocities),
                acceleration: each(accelerations),
                jerk: each(jerks),
                ..EnforcedLimits::default()
            },
        })
    }

    /// The least time in which the joints get to the goal, and about the time that they take, both in s. For a goal by
    /// pose half a turn stands for the motion of each joint.
    pub fn times(&self, target: &Target, joints: &Joints<'_>) -> [f64; 2] {
        let n = joints.moving.len();
        let (start, goal) = match target {
            Target::Joints(_) => (&joints.q_start, &joints.q_goal),
            Target::Poses(_) => (&vec![0.0; n], &vec![PI; n]),
        };
        let least = slowest(start, goal, |i| self.velocity[i]).map_or(0.0, |(_, time)| time);
        let ways = start.iter().zip(goal).map(|(start, goal)| (goal - start).abs());
        let (mut of_link, mut to_and_from_rest) = (0.0, 0.0_f64);
        for (i, way) in ways.enumerate() {
            of_link += way * self.slowness[i];
            to_and_from_rest = to_and_from_rest.max(2.0 * (way / self.acceleration[i]).sqrt());
        }
        [least, least.max(of_link).max(to_and_from_rest)]
    }
}

/// A limit for each joint, if any has one.
fn each(numbers: Vec<Option<f64>>) -> Option<RateLimits> {
    let any = numbers.iter().any(Option::is_some);
    any.then_some(RateLimits::Each(numbers))
}

/// The time that a rad or m of each joint takes at most at the kept speed of a link, s; zero if none is kept.
fn slowness(joints: &Joints<'_>, model: &Model, kept: Option<&Kept>) -> Vec<f64> {
    let Some(speed) = kept.and_then(|kept| kept.speed.as_ref()) else {
        return vec![0.0; joints.moving.len()];
    };
    let frame = model.frames().iter().find(|frame| frame.name == speed.frame);
    let lengths = model.joints().iter().map(|joint| {
        let slides = joint.kind() == JointKind::Prismatic;
        let ends = [joint.limits().lower, joint.limits().upper].map(f64::abs);
        let farthest = ends.into_iter().filter(|_| slides).filter(|end| end.is_finite());
        joint.origin().translation.norm() + farthest.fold(0.0, f64::max)
    });
    let reach = lengths.sum::<f64>() + frame.map_or(0.0, |frame| frame.placement.translation.norm());
    let of = |joint: &&aghf::model::Joint<f64>| match joint.kind() {
        JointKind::Prismatic => 1.0 / speed.most_m_s,
        JointKind::Revolute | JointKind::Continuous => reach / speed.most_m_s,
    };
    joints.moving.iter().map(of).collect()
}
