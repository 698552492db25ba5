//! Velocities at the ends of a motion with which no motion stays within the limits of positions.

use crate::results::feasibility::three_digits;
use crate::{Quantity, Scenario};
use aghf::direct::DirectSettings;
use aghf::error::{Error, Result, plain};

/// The tolerance of velocities and distances, as in the search.
const TOLERANCE: f64 = DirectSettings::FEASIBLE;

impl Scenario {
    /// Refuses velocities `v` at the start with which a joint cannot stop before a limit of its position: outwards at
    /// the limit, or with a distance $v^2 / (2 \bar a)$ at the limit of acceleration beyond what is left; and velocities
    /// at the end that a joint cannot have reached, the same backwards in time.
    pub(crate) fn check_stopping(&self, v_key: &str, (q, v): (&[f64], &[f64]), is_start: bool) -> Result<()> {
        for (i, joint) in self.model.joints().iter().enumerate() {
            let Some([lower, upper]) = self.bound(Quantity::Position, i) else {
                continue;
            };
            let is_upwards = (v[i] > 0.0) == is_start;
            let (left, bound, side) =
                if is_upwards { (upper - q[i], upper, "upper") } else { (q[i] - lower, lower, "lower") };
            let most = self.bound(Quantity::Acceleration, i).map_or(f64::INFINITY, |[_, most]| most);
            let distance = v[i].powi(2) / (2.0 * most);
            if v[i].abs() <= TOLERANCE || (left > TOLERANCE && distance <= left + TOLERANCE) {
                continue;
            }
            let unit = Quantity::Position.unit(joint.kind());
            let (name, [q, v, bound]) = (joint.name(), [q[i], v[i], bound].map(plain));
            let lacks = if most.is_finite() {
                let [distance, left] = [distance, left.max(0.0)].map(|x| three_digits(x, f64::round));
                format!("it needs {distance} {unit} at its enforced acceleration limit, {left} {unit} are left")
            } else {
                "no motion stays within it".to_owned()
            };
            let does = if is_start { "moves towards" } else { "comes from" };
            let speed = Quantity::Velocity.unit(joint.kind());
            let condition = format!(
                "joint '{name}' at {q} {unit} with {v} {speed} {does} its {side} position limit of {bound} {unit}: \
                 {lacks}"
            );
            return Err(Error::input(&self.name, v_key, condition));
        }
        Ok(())
    }
}
