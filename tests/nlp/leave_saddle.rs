//! Ends of searches at saddles.

use crate::dense::{Dense, accurate};
use crate::problems::assert_near;
use aghf::cost::HyperDual64;
use aghf::nlp::Status;

/// $(x^2 - 1)^2 + y^2 + 1$, which has a saddle at 0.
pub fn two_wells(x: &[HyperDual64]) -> (HyperDual64, Vec<HyperDual64>) {
    let well = x[0] * x[0] - 1.0;
    (well * well + x[1] * x[1] + 1.0, Vec::new())
}

/// $y + 2$ on the unit circle.
fn circle(x: &[HyperDual64]) -> (HyperDual64, Vec<HyperDual64>) {
    (x[1] + 2.0, vec![x[0] * x[0] + x[1] * x[1] - 1.0])
}

/// A search that starts at a saddle ends at a minimum.
#[test]
fn a_saddle_is_no_minimum() {
    let end = Dense::new(two_wells, &[0.0, 0.0], 0, 0).solve(&accurate());
    assert_eq!(end.status, Status::Converged);
    assert_near("two wells", &[end.x[0].abs(), end.x[1]], &[1.0, 0.0], 1e-6);
}

/// So does one that starts at the maximum along an equality.
#[test]
fn a_maximum_along_an_equality_is_no_minimum() {
    let end = Dense::new(circle, &[0.0, 1.0], 1, 1).solve(&accurate());
    assert_eq!(end.status, Status::Converged);
    assert_near("circle", end.x.as_slice(), &[0.0, -1.0], 1e-6);
}
