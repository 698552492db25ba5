//! The feasibility of a motion: its clearance, and the limits that it violates.

use crate::{FootLoad, PASSIVE_TORQUE_SHARE, Scenario};
use aghf::constraint::{Constraint, Constraints, Quantity, RowLabel};
use aghf::curve::Curve;
use aghf::direct::DirectSettings;
use aghf::error::Result;
use aghf::motion::{Sample, Violation, largest_torques, sample, violations};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The smallest number of time intervals on which a motion is checked.
const INTERVALS: usize = 2000;

/// The number of time intervals for accelerations, on which no bound depends.
const COARSE: usize = 200;

/// The number of violations that a sentence names.
const NAMED: usize = 3;

/// A report on whether a motion can be carried out.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Feasibility {
    /// The smallest distance of the robot's shape from an obstacle at 2001 times, m; negative in a collision, `None`
    /// without obstacles. The constraints act on shapes that contain it, so they are stricter.
    pub smallest_clearance_m: Option<f64>,
    /// The two objects with that distance, and its time; `None` without obstacles or pairs of links.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<Nearest>,
    /// The violations, however small, of everything that the scenario enforces and of all limits of the robot: the
    /// worst one per kind of limit and joint, and per pair of a link and an obstacle. Violations of enforced limits
    /// come first.
    pub limit_violations: Vec<LimitViolation>,
    /// The largest absolute torque of any joint, N m or N.
    pub largest_torque: f64,
    /// The largest absolute torque of a passive joint; `None` without passive joints.
    pub largest_passive_torque: Option<f64>,
    /// The largest acceleration at 201 times that the scenario does not limit; `None` if it limits all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unlimited_acceleration: Option<Acceleration>,
    /// The largest share of each enforced limit of the joints, at 201 times.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limit_shares: Vec<LimitShare>,
    /// The force of the ground on a standing foot, at 2001 times; `None` without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foot: Option<FootLoad>,
}

/// The share of an enforced limit that a motion uses: the largest distance from the middle of its bounds, relative to
/// half of their difference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitShare {
    /// The limited quantity.
    pub limit: Quantity,
    /// The joint with the largest share.
    pub joint: String,
    /// The share; 1 at a bound.
    pub share: f64,
}

/// The absolute acceleration of a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Acceleration {
    /// The joint.
    pub joint: String,
    /// The acceleration.
    pub value: f64,
    /// Its unit: rad/s^2 or m/s^2.
    pub unit: String,
    /// The time, s.
    pub at_s: f64,
}

impl fmt::Display for Acceleration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, at) = (three_digits(self.value, f64::round), time(self.at_s));
        write!(f, "{value} {} of '{}' at {at} s", self.unit, self.joint)
    }
}

/// The pair with the smallest clearance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Nearest {
    /// A part of the robot, and an obstacle or another part.
    pub between: [String; 2],
    /// The time, s.
    pub at_s: f64,
}

impl fmt::Display for Nearest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = &self.between;
        write!(f, "'{a}' and '{b}' at {} s", time(self.at_s))
    }
}

/// A violated limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitViolation {
    /// The joint, for a limit of a joint.
    pub joint: Option<String>,
    /// The limited quantity.
    pub limit: Quantity,
    /// The limit in words.
    pub name: String,
    /// The largest excess over the limit, or over the enforced share of it, see [`Constraints::excess`].
    pub by: f64,
    /// The unit of the excess: rad or m, rad/s or m/s, N m or N.
    pub unit: String,
    /// The time of the largest excess, s.
    pub at_s: f64,
    /// `true` if the scenario enforces the limit.
    pub enforced: bool,
}

impl fmt::Display for LimitViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, unit, at_s, .. } = self;
        let by = three_digits(self.by, f64::round);
        let space = if unit.is_empty() { "" } else { " " };
        write!(f, "{name} by {by}{space}{unit} at {} s", time(*at_s))
    }
}

/// Formats a time with three significant digits, and with three decimals from 1 s on.
fn time(t: f64) -> String {
    if t == 0.0 || (1.0..1e6).contains(&t) { format!("{t:.3}") } else { three_digits(t, f64::round) }
}

/// Formats a positive number with three significant digits, or as an integer from 1000 on, rounded by `round`.
pub(crate) fn three_digits(x: f64, round: fn(f64) -> f64) -> String {
    let digits = (2.0 - x.log10().floor()).max(0.0);
    let scale = 10_f64.powf(digits);
    // Zero, subnormal and infinite numbers have no scale.
    let x = if scale.is_normal() { round(x * scale) / scale } else { x };
    if (1e-3..1e4).contains(&x) { format!("{x:.*}", digits as usize) } else { format!("{x:.2e}") }
}

impl Feasibility {
    /// Checks a motion by [`violations`] at no fewer than 2001 times.
    ///
    /// # Errors
    /// The robot of the curve has another number of joints, or a torque limit is negative.
    pub fn of(scenario: &Scenario, curve: &Curve) -> Result<Self> {
        let model = &scenario.model;
        let enforced = scenario.constraints();
        let mut limit_violations = Vec::new();
        add(scenario, curve, &enforced, true, &mut limit_violations)?;
        let others = scenario.other_limits();
        add(scenario, curve, &others, false, &mut limit_violations)?;
        add_goal(scenario, curve, &mut limit_violations)?;
        let samples = if scenario.scene.is_empty() { Vec::new() } else { sample(model, curve, INTERVALS)? };
        let torques = largest_torques(model, curve, INTERVALS.div_ceil(curve.segments()))?;
        let largest = |torques: &mut dyn Iterator<Item = f64>| torques.max_by(f64::total_cmp);
        let passive = scenario.passive();
        let coarse = sample(model, curve, COARSE)?;
        let found = scenario.nearest(samples.iter().map(|s| s.q.as_slice()))?;
        let smallest_clearance_m = found.as_ref().map(|(.., distance)| *distance);
        let nearest = found.map(|(k, between, _)| Nearest { between, at_s: samples[k].t });
        Ok(Self {
            smallest_clearance_m,
            nearest,
            limit_violations,
            largest_torque: largest(&mut torques.iter().copied()).unwrap_or(0.0),
            largest_passive_torque: largest(&mut passive.into_iter().map(|i| torques[i])),
            unlimited_acceleration: unlimited_acceleration(scenario, &coarse),
            limit_shares: limit_shares(scenario, &coarse),
            foot: scenario.foot_load(curve, INTERVALS)?,
        })
    }

    /// Returns true if everything that the scenario enforces is satisfied within `tolerance`, in the unit of each
    /// quantity. The torques of passive joints may reach `tolerance` or, if that is larger, [`PASSIVE_TORQUE_SHARE`] of
    /// the largest torque: a polynomial cannot keep them at exactly zero between its points.
    #[must_use]
    pub fn holds(&self, tolerance: f64) -> bool {
        self.beyond(tolerance).next().is_none()
    }

    /// The enforced limits that are violated by more than `tolerance`, in words, the worst first, each compared with
    /// the allowed violation; `None` if [all are satisfied](Self::holds).
    #[must_use]
    pub fn reason(&self, tolerance: f64) -> Option<String> {
        let in_words = |violation: &LimitViolation| match violation.limit {
            Quantity::Passive => {
                let largest = three_digits(self.largest_torque, f64::round);
                format!("{violation}, above {PASSIVE_TORQUE_SHARE} of the largest torque, {largest}")
            }
            _ => violation.to_string(),
        };
        let mut named: Vec<_> = self.beyond(tolerance).collect();
        let share = |violation: &LimitViolation| violation.by / self.allowed(violation.limit, tolerance);
        named.sort_by(|a, b| share(b).total_cmp(&share(a)));
        let named: Vec<_> = named.into_iter().map(in_words).collect();
        let (first, more) = named.split_at(NAMED.min(named.len()));
        let more = match more.len() {
            0 => String::new(),
            more => format!("; and {more} more"),
        };
        (!first.is_empty()).then(|| format!("violated: {}{more}", first.join("; ")))
    }

    /// The violations of enforced rows beyond the allowed ones.
    fn beyond(&self, tolerance: f64) -> impl Iterator<Item = &LimitViolation> {
        let all = self.limit_violations.iter().filter(|each| each.enforced);
        all.filter(move |each| each.by > self.allowed(each.limit, tolerance))
    }

    /// The allowed violation of a kind of limit.
    fn allowed(&self, limit: Quantity, tolerance: f64) -> f64 {
        match limit {
            Quantity::Passive => tolerance.max(PASSIVE_TORQUE_SHARE * self.largest_torque),
            _ => tolerance,
        }
    }
}

/// Adds the violations of a goal that is a set, and of the bounds of a free horizon.
fn add_goal(scenario: &Scenario, curve: &Curve, found: &mut Vec<LimitViolation>) -> Result<()> {
    let last = curve.x().column(curve.x().ncols() - 1);
    let off = scenario.off_goal(&last.as_slice()[..curve.dof()])?;
    let off = off.into_iter().chain(scenario.off_horizon(curve.horizon()));
    // An equality is met to rounding at best.
    let off = off.filter(|(by, _)| *by > 0.1 * DirectSettings::FEASIBLE);
    found.extend(off.map(|(by, RowLabel { name, unit, .. })| LimitViolation {
        joint: None,
        limit: Quantity::Other,
        name,
        by,
        unit: unit.to_owned(),
        at_s: curve.horizon(),
        enforced: true,
    }));
    Ok(())
}

/// The largest acceleration of the joints for which the scenario has no limit of it.
fn unlimited_acceleration(scenario: &Scenario, samples: &[Sample]) -> Option<Acceleration> {
    let (model, limit) = (&scenario.model, Quantity::Acceleration);
    let is_free = |i: &usize| scenario.bound(limit, *i).is_none();
    let joints: Vec<_> = (0..model.dof()).filter(is_free).collect();
    let all = samples.iter().flat_map(|at| joints.iter().map(move |i| (at, *i)));
    let largest = all.max_by(|(a, i), (b, j)| a.a[*i].abs().total_cmp(&b.a[*j].abs()));
    largest.map(|(at, i)| {
        let joint = &model.joints()[i];
        let (unit, joint) = (limit.unit(joint.kind()).to_owned(), joint.name().to_owned());
        let (value, at_s) = (at.a[i].abs(), at.t);
        Acceleration { joint, value, unit, at_s }
    })
}

/// The largest share of the enforced limits of positions, velocities, accelerations and torques.
fn limit_shares(scenario: &Scenario, samples: &[Sample]) -> Vec<LimitShare> {
    type Values = fn(&Sample) -> &[f64];
    let values: [(Quantity, Values); 4] = [
        (Quantity::Position, |at| &at.q),
        (Quantity::Velocity, |at| &at.v),
        (Quantity::Acceleration, |at| &at.a),
        (Quantity::Torque, |at| &at.u),
    ];
    let largest = values.into_iter().filter_map(|(limit, values)| {
        let shares = scenario.model.joints().iter().enumerate().filter_map(|(i, joint)| {
            let [lower, upper] = scenario.bound(limit, i)?;
            let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
            let most = samples.iter().map(|at| (values(at)[i] - middle).abs()).fold(0.0, f64::max);
            let share = LimitShare { limit, joint: joint.name().to_owned(), share: most / half };
            (half > 0.0 && half.is_finite()).then_some(share)
        });
        shares.max_by(|a, b| a.share.total_cmp(&b.share))
    });
    largest.collect()
}

/// Adds the violations of `constraints`: the worst per kind of limit and joint, or per name for rows without a joint.
fn add<K: Constraint>(
    scenario: &Scenario,
    curve: &Curve,
    constraints: &Constraints<K>,
    enforced: bool,
    found: &mut Vec<LimitViolation>,
) -> Result<()> {
    let model = &scenario.model;
    let intervals = INTERVALS.div_ceil(curve.segments());
    let first = found.len();
    for Violation { row, by, at_s } in violations(model, curve, constraints, intervals)? {
        // Angles are less exact than their cosines.
        if by <= 0.0 || constraints.excess(row, by, model) <= 0.0 {
            continue;
        }
        let RowLabel { name, unit, quantity: limit, joint, .. } = constraints.label(row, model);
        let by = constraints.excess(row, by, model);
        let joint = joint.and_then(|i| model.joints().get(i)).map(|joint| joint.name().to_owned());
        let new = LimitViolation { joint, limit, name, by, unit: unit.to_owned(), at_s, enforced };
        let same = |old: &&mut LimitViolation| {
            old.limit == new.limit && old.joint == new.joint && (new.joint.is_some() || old.name == new.name)
        };
        match found[first..].iter_mut().find(same) {
            Some(old) if old.by < new.by => *old = new,
            Some(_) => {}
            None => found.push(new),
        }
    }
    Ok(())
}
