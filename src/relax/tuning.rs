//! Every constant of the relaxation, in the order in which the algorithm meets them.

/// A cost below this, in N^2 m^2 s, is rounding: gradients are not measured against less.
pub(super) const SMALLEST_COST: f64 = f64::EPSILON;

// Quadrature and rows between its points.

/// Points of the quadrature to start with per degree without and with rows.
pub(super) const POINTS: [f64; 2] = [3.0, 3.5];
/// The most points per degree: beyond it the curve has corners that no quadrature of this kind sees.
pub(super) const MOST_POINTS: [usize; 2] = [16, 64];
/// How many steps are made between two looks at the quadrature.
pub(super) const LOOK: usize = 6;
/// How well quadratures have to agree where the search has not come to an end.
pub(super) const ON_THE_WAY: f64 = 0.05;
/// Intervals between two points of the quadrature at which rows are looked at.
pub(super) const SCAN: usize = 6;
/// The last look is at so many intervals at least.
pub(super) const FINE: usize = 2000;
/// Rows below this are of no interest to that look, relative to their scale.
pub(super) const FLOOR: f64 = -0.05;
/// How far the rows are kept on the safe side, relative to their scale, so that rounding does not put the end outside.
pub(super) const RESERVE: f64 = 2e-7;

// Trust region.

/// The part of the predicted decrease that a step has to make.
pub(super) const SUFFICIENT: f64 = 1e-3;
/// What rounding can hide of the cost.
pub(super) const ROUNDING: f64 = 1e-13;
/// How often a step is cut before the region becomes smaller.
pub(super) const CUTS: usize = 3;
/// The part of the way to its bound that a row may go in a step.
pub(super) const TO_THE_WALL: f64 = 0.995;
/// How often a step may be refused before the search is given up.
pub(super) const REFUSALS: usize = 60;
/// How far along a direction of negative curvature to look first, in the norm of Gauss and Newton relative to the cost.
pub(super) const LEAVE: f64 = 0.3;

/// How much room a row gets that has none, relative to its scale.
pub(super) const ROOM: f64 = 0.02;
/// A relaxation below this is none.
pub(super) const SMALLEST_RELAXATION: f64 = 1e-9;

// Barrier. All relative to the cost per second.

/// The first weight of the barriers of all rows together.
pub(super) const FIRST_BARRIER: f64 = 0.1;
/// The last one: how far the cost may be above its minimum.
pub(super) const LAST_BARRIER: f64 = 1e-7;
/// The factor from one weight to the next.
pub(super) const BARRIER_FACTOR: f64 = 0.1;
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

// Starts.

/// How far starts are bent, in turn, relative to the amplitude of the settings.
pub(super) const START_SIZES: [f64; 4] = [1.0, 0.5, 1.5, 1.0];
/// How many starts are worked on side by side.
pub(super) const WAVE: usize = 8;
/// Those that cost more than the best one before them by more than this, relative, do not go on, by the number of rungs that are left: low
/// degrees tell little.
pub(super) const HOPELESS: [f64; 4] = [0.02, 0.02, 0.1, 1.0];

/// How many more starts are tried at once while none of those that were asked for ends within the constraints.
pub(super) const MORE_STARTS: usize = 2;
/// How many starts there are at most while none of them ends within the constraints.
pub(super) const MOST_STARTS: usize = 64;
/// The most steps while rows are relaxed: another start is worth more than many steps from one.
pub(super) const CONSTRAINED_STEPS: usize = 150;
/// The lowest degree without and with rows: within limits a polynomial of a lower degree often finds no room.
pub(super) const LOWEST_DEGREE: [usize; 2] = [6, 9];
/// The costs of two minima that are one differ by less than this, relative.
pub(super) const SAME_MINIMUM: f64 = 1e-3;

// A free horizon.

/// How exactly it is found without and with rows: the slope of the cost in its logarithm, relative to the cost.
pub(super) const HORIZON_SLOPE: [f64; 2] = [1e-7, 1e-4];
/// Horizons that differ by less than this, relative, are one.
pub(super) const SAME_HORIZON: [f64; 2] = [1e-9, 1e-6];
/// The first step to another horizon, in its logarithm.
pub(super) const REACH: f64 = 0.25;
/// How many horizons are tried.
pub(super) const TRIES: usize = 60;
/// How exactly, relative, the shortest horizon is found on which there is a motion: what is tried in vain below it takes long.
pub(super) const POSSIBLE: f64 = 1e-3;
