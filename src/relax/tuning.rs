//! Every constant of the relaxation by which it could be tuned.

use super::interior_point::Stage;

/// A cost below this, in N^2 m^2 s, is rounding: gradients are not measured against less.
pub(super) const SMALLEST_COST: f64 = f64::EPSILON;

// Quadrature and rows between its points.

/// Points of the quadrature to start with per degree without and with rows.
pub(super) const POINTS: [f64; 2] = [3.0, 3.5];
/// Points with rows on several segments where no more is asked for than this tolerance.
pub(super) const ROUGH_POINTS: f64 = 1.2;
pub(super) const ROUGH: f64 = 0.01;
/// The most points per degree: beyond it the curve has corners that no quadrature of this kind sees.
pub(super) const MOST_POINTS: [usize; 2] = [16, 64];
/// The number of steps between two looks at the quadrature.
pub(super) const LOOK: usize = 6;
/// The relative difference of quadratures that is accepted where the search has not come to an end.
pub(super) const ON_THE_WAY: f64 = 0.05;
/// Intervals between two points of the quadrature at which rows are looked at.
pub(super) const SCAN: usize = 6;
/// The last look is at so many intervals at least.
pub(super) const FINE: usize = 2000;
/// Rows below this are of no interest to that look, relative to their scale.
pub(super) const FLOOR: f64 = -0.05;
/// The distance from their bounds that rows keep, relative to their scale, so that rounding does not put the end outside.
pub(super) const RESERVE: f64 = 2e-7;

/// The distance from an obstacle beyond which more of it is worth nothing, m: the barrier of a clearance is constant there.
pub(super) const FAR: f64 = 0.05;

/// The distance up to which a row is listed, beyond [`FAR`] so that the list lasts.
pub(super) const LISTED: f64 = 0.12;

// Trust region.

/// The factor by which the region grows with rows after a step that gained nearly all that was predicted.
pub(super) const GROWTH: f64 = 4.0;
/// The part of the predicted decrease that a step has to make.
pub(super) const SUFFICIENT: f64 = 1e-3;
/// The part of the cost that rounding can hide.
pub(super) const ROUNDING: f64 = 1e-13;
/// The number of times that a step is cut before the region becomes smaller.
pub(super) const CUTS: usize = 3;
/// The part of the way to its bound that a row may go in a step.
pub(super) const TO_THE_WALL: f64 = 0.995;
/// The factor by which it is cut.
pub(super) const CUT: f64 = 0.4;
/// The number of times that a step may be refused before the search is given up.
pub(super) const REFUSALS: usize = 60;
/// The first length along a direction of negative curvature, in the norm of Gauss and Newton relative to the cost.
pub(super) const LEAVE: f64 = 0.3;
/// The number of lengths that are tried there, and the factor from one to the next.
pub(super) const LEAVE_TRIES: usize = 20;
pub(super) const LEAVE_FACTOR: f64 = 0.3;
/// After so many steps at the highest degree, without and with rows, the metric of Gauss and Newton is computed anew.
pub(super) const FRESH: [usize; 2] = [60, 10];

/// The room that a row gets that has none, relative to its scale.
pub(super) const ROOM: f64 = 0.02;
/// A relaxation below this is none.
pub(super) const SMALLEST_RELAXATION: f64 = 1e-9;
/// The factor by which a multiplier may differ from the one that belongs to its row, in either direction.
pub(super) const APART: f64 = 1e4;
/// The part of the range of a multiplier that it keeps from the end that it is far from.
pub(super) const INSIDE: f64 = 1e-6;

// Barrier. All relative to the cost per second.

/// The first weight of the barriers of all rows together.
pub(super) const FIRST_BARRIER: f64 = 0.1;
/// That of a curve that was found with more in mind than its ends: a planned one, or one from another horizon.
pub(super) const STRONG_BARRIER: f64 = 1.0;
/// The last one: how far the cost may be above its minimum.
pub(super) const LAST_BARRIER: f64 = 1e-7;
/// A weight that is this factor of another is that one.
pub(super) const NEARLY: f64 = 1.01;
/// The factor from one weight to the next.
pub(super) const BARRIER_FACTOR: f64 = 0.3;
/// A weight is done with once the next step promises less than this, relative to the weight of all rows.
pub(super) const BARRIER_DONE: f64 = 0.1;
/// Below this weight of all rows margins only grow.
pub(super) const LATE: f64 = 1e-4;
/// A multiplier above this part of the price belongs to a row that may be broken.
pub(super) const AT_THE_PRICE: f64 = 0.9;
/// The first price of an excess.
pub(super) const FIRST_PRICE: f64 = 1e2;
/// The factor from one price to the next, and the largest one.
pub(super) const PRICE_FACTOR: f64 = 30.0;
pub(super) const LARGEST_PRICE: f64 = 1e9;

// Duals of equalities.

/// The first penalty of an equality and the largest, relative to the cost per second, and the factor by which it grows.
pub(super) const FIRST_PENALTY: f64 = 1e3;
pub(super) const LARGEST_PENALTY: f64 = 1e9;
pub(super) const PENALTY_FACTOR: f64 = 10.0;
/// The first penalty of the torque of a passive joint, that of a motor, whose torque costs its square; and the largest, beyond which steps
/// become short and the duals do as well.
pub(super) const MOTOR: f64 = 2.0;
pub(super) const LARGEST_MOTOR: f64 = 2e4;
/// The torque of a passive joint that is accepted between the collocated points, relative to the largest torque.
pub(super) const PASSIVE_SHARE: f64 = 5e-4;
/// The largest degree times the number of segments to which that leads.
pub(super) const LARGEST_PASSIVE_SIZE: usize = 512;
/// The part of its violation that an equality may keep from one update of the duals to the next before its penalty grows.
pub(super) const PROGRESS: f64 = 0.25;

// Starts.

/// The number of starts that are worked on side by side.
pub(super) const WAVE: usize = 8;
/// The part of a time limit for which starts are tried where a horizon or a degree is looked for after them.
pub(super) const SHARE_OF_STARTS: f64 = 0.5;
/// Those that cost more than the best one before them by more than this, relative, do not go on, by the number of rungs that are left: low
/// degrees tell little.
pub(super) const HOPELESS: [f64; 3] = [0.02, 0.1, 1.0];

/// The demands below the top without and with rows: a curve there is no more than the start of the next.
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
/// The most steps on fewer segments, where each has much to gain by the next breakpoint.
pub(super) const SEGMENT_STEPS: usize = 60;
/// The number of further starts that are tried at once while none of those that were asked for ends within the constraints.
pub(super) const MORE_STARTS: usize = 2;
/// The most starts while none of them ends within the constraints.
pub(super) const MOST_STARTS: usize = 64;
/// The least number of segments of a planned start, and their degree unless that many are asked for.
pub(super) const PLANNED_SEGMENTS: usize = 8;
pub(super) const PLANNED_DEGREE: usize = 6;
/// The factor from one horizon of a planned start to the next.
pub(super) const HORIZON_GROWTH: f64 = 1.15;
/// The most steps while rows are relaxed: another start is worth more than many steps from one.
pub(super) const CONSTRAINED_STEPS: usize = 150;
/// The lowest degree without and with rows: within limits a polynomial of a lower degree often finds no room.
pub(super) const LOWEST_DEGREE: [usize; 2] = [6, 9];
/// The costs of two minima that are one differ by less than this, relative.
pub(super) const SAME_MINIMUM: f64 = 1e-3;

// A free horizon.

/// The slope of the cost in its logarithm at which it is found, without and with rows, relative to the cost.
pub(super) const HORIZON_SLOPE: [f64; 2] = [1e-7, 1e-4];
/// Horizons that differ by less than this, relative, are one.
pub(super) const SAME_HORIZON: [f64; 2] = [1e-9, 1e-6];
/// The first step to another horizon, in its logarithm.
pub(super) const REACH: f64 = 0.25;
/// The number of horizons that are tried.
pub(super) const TRIES: usize = 60;
/// The relative exactness of the shortest horizon on which there is a motion: what is tried in vain below it takes long.
pub(super) const POSSIBLE: f64 = 1e-3;
