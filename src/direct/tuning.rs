//! The tuning constants of the direct method.

use super::minimise::Stage;

// Quadrature and rows between its points.

/// The initial number of quadrature points per degree.
pub(crate) const POINTS: f64 = 3.5;
/// The same on several segments, which are shorter: the same costs in two thirds of the time on planned starts and
/// underactuated swing-ups.
pub(crate) const POINTS_OF_SEGMENTS: f64 = 2.5;
/// The largest number of points per degree: beyond it the curve has corners that no quadrature of this kind resolves.
pub(crate) const MOST_POINTS: usize = 64;
/// The accepted relative difference of quadratures before the end of the search.
pub(crate) const ON_THE_WAY: f64 = 0.05;
/// The number of intervals per quadrature point at which rows are scanned.
pub(super) const SCAN: usize = 6;
/// The smallest number of intervals of the last scan.
pub(crate) const FINE: usize = 2000;
/// The value below which the last scan ignores rows, relative to their scale.
pub(super) const FLOOR: f64 = -0.05;
/// The number of times that margins are set anew at the end of the search before they only grow, so that it terminates.
pub(crate) const EXACT_MARGINS: usize = 4;
/// The distance that rows keep from their bounds, relative to their scale, against rounding at the end.
pub(crate) const RESERVE: f64 = 2e-7;

/// The distance from its bound up to which a clearance is in the working set, relative to the reach of the
/// problem: a few steps near the end are shorter.
pub(crate) const NEAR: f64 = 0.05;
/// The same relative to the distance from which on a row is constant, beyond which a step should not end.
pub(crate) const SHARE_OF_CUTOFF: f64 = 0.5;

// Barrier. All relative to the cost per second.

/// The last weight: the accepted relative excess of the cost over its minimum.
pub(crate) const LAST_BARRIER: f64 = 1e-7;
/// The last weight if only the horizon has bounds, which are cheap to approach.
pub(super) const LAST_BARRIER_OF_BOUNDS: f64 = 1e-12;

// Equalities.

/// The first penalty of the torque of a passive joint, that of a motor, whose torque costs its square: no other start
/// is as easy.
pub(crate) const MOTOR: f64 = 2.0;
/// The first penalty of other equalities, relative to the cost per second.
pub(crate) const EQUALITY_PENALTY: f64 = 1e3;

/// The accepted torque of a passive joint between the collocated points, relative to the largest torque.
pub(crate) const PASSIVE_SHARE: f64 = 5e-4;
/// The largest product of degree and number of segments when these are increased for passive joints.
pub(super) const LARGEST_PASSIVE_SIZE: usize = 512;

// Starts.

/// The number of starts that are processed in parallel.
pub(super) const WAVE: usize = 8;
/// The fraction of a time limit spent on starts if a horizon or a degree is searched after them.
pub(super) const SHARE_OF_STARTS: f64 = 0.5;
/// The relative excess over the cost of the best start before it beyond which a start is dropped, by the number of
/// remaining bases: low degrees are a poor indicator.
pub(super) const HOPELESS: [f64; 2] = [0.1, 1.0];

/// The termination criteria below the last basis: a curve there is only the start of the next.
pub(super) const LOWER: Stage = Stage {
    tolerance: 0.1,
    iterations: 30,
    quadrature_tolerance: 0.05,
    last_barrier: 1e-2,
    feasible: 1e-2,
    last: false,
};
/// The largest number of steps on fewer segments, where the next breakpoints will reduce the cost further.
pub(super) const SEGMENT_STEPS: usize = 60;
/// The number of further starts that are tried at once while none of the requested ones ends within the constraints.
pub(super) const MORE_STARTS: usize = 2;
/// The largest number of starts while none of them ends within the constraints.
pub(super) const MOST_STARTS: usize = 64;
/// The smallest number of segments of a planned start, and their degree unless that many are requested.
pub(super) const PLANNED_SEGMENTS: usize = 8;
pub(super) const PLANNED_DEGREE: usize = 6;
/// The first penalty of a violation from a planned start, relative to the cost: a start that keeps all rows stays
/// inside.
pub(super) const PLANNED_PENALTY: f64 = 10.0;
/// The number of checked configurations after which a path no longer keeps a margin: a tenth of a second.
pub(super) const MARGIN_CHECKS: usize = 25_000;
/// The factor between successive horizons of a planned start.
pub(super) const HORIZON_GROWTH: f64 = 1.15;
/// The relative difference below which the costs of two minima count as equal.
pub(super) const SAME_MINIMUM: f64 = 1e-3;
