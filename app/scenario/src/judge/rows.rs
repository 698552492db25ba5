//! The number of samples that the judge needs of a curve.

use super::foot::standing;
use super::{Intervals, Tolerances, Trajectory, checks, jumps};
use crate::Scenario;
use aghf::curve::Curve;
use aghf::error::Result;
use aghf::motion::sample;

/// About the fewest intervals of a table, and the number of times that they may be halved: to a quarter of a
/// millisecond for motions of three seconds.
const INTERVALS: usize = 200;
const HALVINGS: u32 = 6;

/// The number of samples at equal distances, both ends included, with which `curve` passes as many of the judge's
/// checks joint by joint and of a standing foot as it does with any number: about 201, or with intervals halved up to
/// six times. Coarse samples fail where accelerations change within an interval; the ends of segments, where
/// accelerations or jerks may jump, are always samples.
///
/// Cost O(N p) per sample.
///
/// # Errors
/// The curve has another number of joints.
pub fn sufficient_samples(scenario: &Scenario, curve: &Curve) -> Result<usize> {
    let fewest = INTERVALS.next_multiple_of(curve.segments());
    let mut best = (usize::MAX, fewest);
    for halvings in 0..=HALVINGS {
        let intervals = fewest << halvings;
        let failed = failures(scenario, curve, intervals)?;
        if failed < best.0 {
            best = (failed, intervals);
        }
        if failed == 0 {
            break;
        }
    }
    Ok(best.1 + 1)
}

/// The number of checks joint by joint and of a standing foot that a curve fails with this number of intervals.
fn failures(scenario: &Scenario, curve: &Curve, intervals: usize) -> Result<usize> {
    let trajectory = Trajectory::of_samples(sample(&scenario.model, curve, intervals)?);
    let (intervals, tolerance) = (Intervals::new(&trajectory, jumps(scenario)), Tolerances::default().tolerance);
    let mut rows = checks::by_joint(scenario, &trajectory, &intervals, tolerance)?;
    rows.extend(standing(scenario, &intervals, tolerance)?);
    Ok(rows.iter().filter(|row| !row.outcome.is_good()).count())
}
