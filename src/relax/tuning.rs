//! The tuning constants of the relaxation.

use super::interior_point::Stage;

/// The cost below which a value is rounding error, in N^2 m^2 s; gradients are not measured relative to less.
pub(super) const SMALLEST_COST: f64 = f64::EPSILON;

// Quadrature and rows between its points.

/// The initial number of quadrature points per degree, without and with rows.
pub(super) const POINTS: [f64; 2] = [3.0, 3.5];
/// The initial number per degree with rows on several segments, if the tolerance is `ROUGH` or larger.
pub(super) const ROUGH_POINTS: f64 = 1.2;
pub(super) const ROUGH: f64 = 0.01;
/// The largest number of points per degree: beyond it the curve has corners that no quadrature of this kind resolves.
pub(super) const MOST_POINTS: [usize; 2] = [16, 64];
/// The number of steps between two checks of the quadrature.
pub(super) const LOOK: usize = 6;
/// The accepted relative difference of quadratures before the end of the search.
pub(super) const ON_THE_WAY: f64 = 0.05;
/// The number of intervals per quadrature point at which rows are scanned.
pub(super) const SCAN: usize = 6;
/// The smallest number of intervals of the last scan.
pub(super) const FINE: usize = 2000;
/// The value below which the last scan ignores rows, relative to their scale.
pub(super) const FLOOR: f64 = -0.05;
/// The distance that rows keep from their bounds, relative to their scale, against rounding at the end.
pub(super) const RESERVE: f64 = 2e-7;

/// The distance from an obstacle beyond which the barrier of a clearance is constant, m.
pub(super) const FAR: f64 = 0.05;

/// The distance up to which a row is listed, larger than [`FAR`] so that the list remains valid for several steps.
pub(super) const LISTED: f64 = 0.12;

// Trust region.

/// The factor by which the trust region grows with rows after a step that achieved nearly all of the predicted
/// decrease.
pub(super) const GROWTH: f64 = 4.0;
/// The fraction of the predicted decrease that a step must achieve.
pub(super) const SUFFICIENT: f64 = 1e-3;
/// The relative part of the cost that rounding can hide.
pub(super) const ROUNDING: f64 = 1e-13;
/// The number of cuts of a step before the trust region shrinks.
pub(super) const CUTS: usize = 3;
/// The fraction of the distance to its bound that a row may use in a step.
pub(super) const TO_THE_WALL: f64 = 0.995;
/// The factor of a cut.
pub(super) const CUT: f64 = 0.4;
/// The number of rejected steps before the search gives up.
pub(super) const REFUSALS: usize = 60;
/// The first length along a direction of negative curvature, in the Gauss-Newton norm relative to the cost.
pub(super) const LEAVE: f64 = 0.3;
/// The number of lengths tried there, and the factor between them.
pub(super) const LEAVE_TRIES: usize = 20;
pub(super) const LEAVE_FACTOR: f64 = 0.3;
/// The number of steps at the highest degree, without and with rows, after which the Gauss-Newton metric is recomputed.
pub(super) const FRESH: [usize; 2] = [60, 10];

/// The slack given to a row that has none, relative to its scale.
pub(super) const ROOM: f64 = 0.02;
/// The relaxation below which a row counts as not relaxed.
pub(super) const SMALLEST_RELAXATION: f64 = 1e-9;
/// The largest factor between a multiplier and the one that belongs to its row, in either direction.
pub(super) const APART: f64 = 1e4;
/// The fraction of the range of a multiplier that it keeps from the far end.
pub(super) const INSIDE: f64 = 1e-6;

// Barrier. All relative to the cost per second.

/// The first weight of the barriers of all rows together.
pub(super) const FIRST_BARRIER: f64 = 0.1;
/// The first weight for a curve that is more than an interpolation of its ends: a planned one, or one from another
/// horizon.
pub(super) const STRONG_BARRIER: f64 = 1.0;
/// The last weight: the accepted relative excess of the cost over its minimum.
pub(super) const LAST_BARRIER: f64 = 1e-7;
/// The factor within which two weights count as equal.
pub(super) const NEARLY: f64 = 1.01;
/// The factor from one weight to the next.
pub(super) const BARRIER_FACTOR: f64 = 0.3;
/// The predicted decrease of the next step, relative to the weight of all rows, below which the weight is reduced.
pub(super) const BARRIER_DONE: f64 = 0.1;
/// The weight of all rows below which margins only grow.
pub(super) const LATE: f64 = 1e-4;
/// The fraction of the price above which a multiplier indicates that its row may be violated.
pub(super) const AT_THE_PRICE: f64 = 0.9;
/// The first price of an excess.
pub(super) const FIRST_PRICE: f64 = 1e2;
/// The factor from one price to the next, and the largest one.
pub(super) const PRICE_FACTOR: f64 = 30.0;
pub(super) const LARGEST_PRICE: f64 = 1e9;

// Duals of equalities.

/// The first and the largest penalty of an equality, relative to the cost per second, and its growth factor.
pub(super) const FIRST_PENALTY: f64 = 1e3;
pub(super) const LARGEST_PENALTY: f64 = 1e9;
pub(super) const PENALTY_FACTOR: f64 = 10.0;
/// The first penalty of the torque of a passive joint, that of a motor, whose torque costs its square; and the largest,
/// beyond which steps become short and the duals suffice.
pub(super) const MOTOR: f64 = 2.0;
pub(super) const LARGEST_MOTOR: f64 = 2e4;
/// The accepted torque of a passive joint between the collocated points, relative to the largest torque.
pub(super) const PASSIVE_SHARE: f64 = 5e-4;
/// The largest product of degree and number of segments when these are increased for passive joints.
pub(super) const LARGEST_PASSIVE_SIZE: usize = 512;
/// The fraction of its violation that an equality may keep from one dual update to the next before its penalty grows.
pub(super) const PROGRESS: f64 = 0.25;

// Starts.

/// The number of starts that are processed in parallel.
pub(super) const WAVE: usize = 8;
/// The fraction of a time limit spent on starts if a horizon or a degree is searched after them.
pub(super) const SHARE_OF_STARTS: f64 = 0.5;
/// The relative excess over the cost of the best start before it beyond which a start is dropped, by the number of
/// remaining bases: low degrees are a poor indicator.
pub(super) const HOPELESS: [f64; 3] = [0.02, 0.1, 1.0];

/// The termination criteria below the last basis, without and with rows: a curve there is only the start of the next.
pub(super) const LOWER: [Stage; 2] = [
    Stage {
        tolerance: 0.1,
        iterations: 12,
        fresh: 1,
        quadrature_tolerance: 0.02,
        last_barrier: 1e-2,
        feasible: 1e-2,
        slope: false,
        last: false,
    },
    Stage {
        tolerance: 0.1,
        iterations: 30,
        fresh: 5,
        quadrature_tolerance: 0.05,
        last_barrier: 1e-2,
        feasible: 1e-2,
        slope: false,
        last: false,
    },
];
/// The largest number of steps on fewer segments, where the next breakpoints will reduce the cost further.
pub(super) const SEGMENT_STEPS: usize = 60;
/// The number of further starts that are tried at once while none of the requested ones ends within the constraints.
pub(super) const MORE_STARTS: usize = 2;
/// The largest number of starts while none of them ends within the constraints.
pub(super) const MOST_STARTS: usize = 64;
/// The smallest number of segments of a planned start, and their degree unless that many are requested.
pub(super) const PLANNED_SEGMENTS: usize = 8;
pub(super) const PLANNED_DEGREE: usize = 6;
/// The factor between successive horizons of a planned start.
pub(super) const HORIZON_GROWTH: f64 = 1.15;
/// The largest number of steps while rows are relaxed: another start is worth more than many steps from one.
pub(super) const CONSTRAINED_STEPS: usize = 150;
/// The lowest degree without and with rows: within limits a polynomial of a lower degree often has no feasible
/// solution.
pub(super) const LOWEST_DEGREE: [usize; 2] = [6, 9];
/// The relative difference below which the costs of two minima count as equal.
pub(super) const SAME_MINIMUM: f64 = 1e-3;

// A free horizon.

/// The slope of the cost in the logarithm of the horizon at which the search ends, without and with rows, relative to
/// the cost.
pub(super) const HORIZON_SLOPE: [f64; 2] = [1e-7, 1e-4];
/// The relative difference below which two horizons count as equal.
pub(super) const SAME_HORIZON: [f64; 2] = [1e-9, 1e-6];
/// The first step to another horizon, in its logarithm.
pub(super) const REACH: f64 = 0.25;
/// The largest number of horizons.
pub(super) const TRIES: usize = 60;
/// The relative accuracy of the shortest feasible horizon: failed attempts below it take long.
pub(super) const POSSIBLE: f64 = 1e-3;
