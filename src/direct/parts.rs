//! Parts of a motion with lengths of their own.

use super::DirectSettings;
use crate::error::{Error, Result};
use crate::motion::Problem;
use crate::transcription::Horizons;

/// Checks the parts of settings.
///
/// # Errors
/// Names the part or the setting that is incompatible with them.
pub(super) fn check(settings: &DirectSettings) -> Result<()> {
    let (parts, segments) = (&settings.parts, settings.segments);
    let refuse = |element: &str, condition: &str| Err(Error::input("settings", element, condition));
    if parts.is_empty() {
        return Ok(());
    }
    if parts.len() == 1 || !segments.is_multiple_of(parts.len()) {
        let condition = format!("there are {} for {segments} segments", parts.len());
        return refuse("parts", &condition);
    }
    for (k, [shortest, longest]) in parts.iter().enumerate() {
        let element = format!("parts[{k}]");
        for length in [shortest, longest] {
            if let Err(condition) = Problem::check_horizon(*length) {
                return refuse(&element, &condition);
            }
        }
        if shortest > longest {
            let condition = format!("the shortest length {shortest} is above the longest one {longest}");
            return refuse(&element, &condition);
        }
    }
    if settings.continuous_acceleration {
        return refuse("parts", "accelerations jump where two of them meet");
    }
    if settings.waypoints.iter().any(|of| of.share.is_none()) {
        return refuse("parts", "a waypoint has an unknown time");
    }
    Ok(())
}

/// The horizons of parts within their bounds, as near as they may be to given ones, with slopes in the time of a
/// reference.
pub(super) fn horizons(parts: &[[f64; 2]], given: impl Fn(usize) -> f64, reference: f64) -> Horizons<f64> {
    let count = parts.len() as f64;
    let within = |(part, [shortest, longest]): (usize, &[f64; 2])| given(part).clamp(count * shortest, count * longest);
    Horizons::of_parts(parts.iter().enumerate().map(within).collect(), reference)
}
