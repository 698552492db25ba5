//! The limits of joints, with notes on those that mean none and those that are not kept.

use super::elements::Read;
use super::{LoadNote, LoadReport};
use crate::error::plain;
use crate::model::{JointKind, Limits};
use urdf_rs::{Joint, JointLimit};

/// Limits of this size and above, rad, m, or these per second, N m or N, mean none: exporters write the largest number
/// that there is.
const NO_LIMIT: f64 = 1e10;

/// The limits of a joint of this kind, with notes in `report`.
pub(super) fn limits_of(joint: &Joint, kind: JointKind, report: &mut LoadReport) -> Read<Limits> {
    let JointLimit { lower, upper, velocity, effort, .. } = joint.limit;
    let name = || joint.name.clone();
    let all = [lower, upper, velocity, effort];
    if all.iter().all(|x| *x == 0.0) {
        if kind != JointKind::Continuous {
            report.push(LoadNote::Unlimited { joint: name() });
        }
        report.extend(soft_limits(joint, &Limits::NONE));
        return Ok(Limits::NONE);
    }
    if all.iter().any(|x| x.is_nan()) {
        return Err("a limit is not a number".to_owned());
    }
    for (what, most) in [("velocity", velocity), ("effort", effort)] {
        if most < 0.0 {
            return Err(format!("its {what} limit is negative: {}", plain(most)));
        }
    }
    let mut known = |attribute, most: f64| {
        if most > 0.0 {
            return most;
        }
        report.push(LoadNote::ZeroLimit { joint: name(), attribute });
        f64::INFINITY
    };
    let (velocity, effort) = (known("velocity", velocity), known("effort", effort));
    let (lower, upper) = match kind {
        JointKind::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
        JointKind::Revolute | JointKind::Prismatic => (lower, upper),
    };
    let ends = [lower, upper].map(plain);
    if lower > upper {
        return Err(format!("its lower limit {} is above its upper limit {}", ends[0], ends[1]));
    }
    if lower == f64::INFINITY || upper == f64::NEG_INFINITY {
        return Err(format!("no position is within its limits {} and {}", ends[0], ends[1]));
    }
    let (limits, huge) = endless(Limits { lower, upper, velocity, effort });
    report.extend(huge.into_iter().map(|limit| LoadNote::HugeLimit { joint: name(), limit }));
    report.extend(soft_limits(joint, &limits));
    Ok(limits)
}

/// The limits with those that mean none as infinity, and the kinds of those.
fn endless(mut limits: Limits) -> (Limits, Vec<&'static str>) {
    let mut kinds = Vec::new();
    for (kind, limit, sign) in [
        ("position", &mut limits.lower, -1.0),
        ("position", &mut limits.upper, 1.0),
        ("velocity", &mut limits.velocity, 1.0),
        ("effort", &mut limits.effort, 1.0),
    ] {
        let size = sign * *limit;
        if size.is_finite() && size >= NO_LIMIT {
            *limit = sign * f64::INFINITY;
            kinds.push(kind);
        }
    }
    kinds.dedup();
    (limits, kinds)
}

/// The note on the soft limits of a joint that are within its limits. Two zeros, as two missing numbers, mean none.
fn soft_limits(joint: &Joint, limits: &Limits) -> Option<LoadNote> {
    let safety = joint.safety_controller.as_ref()?;
    let soft = [safety.soft_lower_limit, safety.soft_upper_limit];
    let [lower, upper] = soft;
    // A soft limit that is no number is within no limits, and noted too.
    if soft == [0.0, 0.0] || lower <= limits.lower && upper >= limits.upper {
        return None;
    }
    let middle = 0.5 * (limits.lower + limits.upper);
    let share = (middle - lower).min(upper - middle) / (0.5 * (limits.upper - limits.lower));
    // Rounded down, so that the share is within.
    let share = (1e3 * share.min(1.0)).floor() / 1e3;
    Some(LoadNote::SoftLimits {
        joint: joint.name.clone(),
        limits: soft.map(plain).join(" to "),
        share: (share > 0.0 && !soft.iter().any(|x| x.is_nan())).then(|| plain(share)),
    })
}
