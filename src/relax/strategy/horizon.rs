//! A free horizon.

use crate::error::{Error, Result, plain};
use crate::motion::{Problem, Watch};
use crate::relax::interior_point::Candidate;
use crate::relax::transcription::{place, points};
use crate::relax::tuning::{HORIZON_SLOPE, POSSIBLE, REACH, SAME_HORIZON, SMALLEST_COST, TRIES};
use crate::relax::{Grid, PointCost, PointDerivatives};
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// The bounds and the weight of a free horizon `T`: $\int l\\, dt + w T$ is minimised over `T` as well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeHorizon {
    /// The shortest horizon, s.
    pub shortest: f64,
    /// The longest horizon, s.
    pub longest: f64,
    /// The weight $w$ per second.
    pub weight: f64,
}

impl FreeHorizon {
    /// Checks the bounds and the weight, and that the initial horizon is between the bounds.
    ///
    /// # Errors
    /// Names the first invalid number.
    pub fn check(&self, horizon: f64) -> Result<()> {
        let refuse = |what: &str, condition: String| {
            let what = format!("free_horizon.{what}");
            Err(Error::input("settings", what, condition))
        };
        let Self {
            shortest,
            longest,
            weight,
        } = *self;
        for (what, value) in [("shortest", shortest), ("longest", longest)] {
            if let Err(condition) = Problem::check_horizon(value) {
                return refuse(what, condition);
            }
        }
        if !(weight.is_finite() && weight >= 0.0) {
            return refuse(
                "weight",
                format!("it is {}, a weight is not negative", plain(weight)),
            );
        }
        if horizon < shortest {
            return refuse(
                "shortest",
                format!("it is {shortest}, above the horizon {horizon} to begin with"),
            );
        }
        if horizon > longest {
            return refuse(
                "longest",
                format!("it is {longest}, below the horizon {horizon} to begin with"),
            );
        }
        Ok(())
    }
}

/// Computes the derivative of a sum over quadrature points in the horizon `T` for a curve that is fixed in normalised
/// time except for its boundary slopes: with $z = (q, \dot q, \ddot q)$ and coefficients that change at the rates $c'$,
///
/// $$ \frac{\partial J}{\partial T} = \sum_g w_g \left( \frac{l}{T} + \frac{\partial l}{\partial z} \cdot
///    \left( \phi c',\ \dot\phi c' - \frac{\dot q}{T},\ \ddot\phi c' - \frac{2 \ddot q}{T} \right) +
///    \frac{t}{T} \frac{\partial l}{\partial t} \right). $$
///
/// At a minimum over the other coefficients it is the derivative of that minimum.
///
/// # Errors
/// The cost has another number of joints.
pub(crate) fn horizon_slope<S: Scalar, P: PointCost<S>>(
    grid: &Grid<S>,
    cost: &mut P,
    coefficients: &DMatrix<S>,
    rates: &DMatrix<S>,
    horizon: S,
) -> Result<S> {
    let n = coefficients.nrows();
    let mut states = DMatrix::zeros(n, grid.table.ncols());
    let (mut moving, mut out) = (states.clone(), PointDerivatives::new(n));
    let (rate, two) = (S::one() / horizon, S::from_f64(2.0));
    let mut slope = S::zero();
    for e in 0..grid.segments {
        for (from, to) in [(coefficients, &mut states), (rates, &mut moving)] {
            place(from, grid.first(e), &grid.table, to);
        }
        for (g, weight) in grid.weights.iter().enumerate() {
            let at = points(grid, &states, e).point(g);
            let value = cost.derivatives(at, &mut out)?;
            let mut sum = rate * (value + at.time * cost.time_rate(at)?);
            let own = &moving.as_slice()[3 * g * n..(3 * g + 3) * n];
            for (i, by) in out.gradient.iter().enumerate() {
                let shrinks = match i / n {
                    0 => S::zero(),
                    1 => rate * at.v[i - n],
                    _ => two * rate * at.a[i - 2 * n],
                };
                sum += *by * (own[i] - shrinks);
            }
            slope += *weight * sum;
        }
    }
    Ok(slope)
}

/// The result on one horizon.
#[derive(Clone, Debug)]
pub(in crate::relax) struct Tried {
    pub horizon: f64,
    pub found: Candidate,
    /// The cost of motion and time.
    cost: f64,
    /// The derivative of the cost in the logarithm of the horizon.
    slope: f64,
}

impl Tried {
    /// The result of a minimisation on a horizon, with known cost and slope.
    pub fn new(free: FreeHorizon, horizon: f64, found: Candidate) -> Self {
        Self {
            horizon,
            cost: found.cost + free.weight * horizon,
            slope: horizon * (found.horizon_slope + free.weight),
            found,
        }
    }

    /// Returns true if the solve was successful. Otherwise the horizon is treated as too short.
    fn sound(&self) -> bool {
        self.found.converged || self.found.kept
    }

    /// The slope, or for an unsuccessful solve one that lengthens the horizon.
    fn push(&self) -> f64 {
        if self.sound() {
            self.slope
        } else {
            -self.cost.abs().max(SMALLEST_COST)
        }
    }
}

/// The result of a search for a horizon.
pub(in crate::relax) struct Searched {
    pub best: Tried,
    /// True if the search ended by itself with a successful solve.
    pub settled: bool,
    /// True if the cost falls towards horizons on which no solve was successful.
    pub limited: bool,
}

impl Searched {
    fn new(best: Tried, settled: bool) -> Self {
        Self {
            best,
            settled,
            limited: false,
        }
    }
}

/// Finds a nearby horizon at which the cost is stationary, or a bound that keeps it from falling further, or the last
/// horizon with a successful solve before that. The cost is stationary if its slope in the logarithm of the horizon is
/// small, or at most `tolerance`, relative to the cost. `attempt` solves on a horizon, from the result on another.
pub(in crate::relax) fn search(
    free: FreeHorizon,
    constrained: bool,
    tolerance: f64,
    first: Tried,
    watch: &Watch,
    mut attempt: impl FnMut(f64, &Tried) -> Result<Tried>,
) -> Result<Searched> {
    let kind = usize::from(constrained);
    let settled = |tried: &Tried| {
        let most = HORIZON_SLOPE[kind].max(tolerance) * tried.cost.abs().max(SMALLEST_COST);
        tried.sound() && tried.slope.abs() <= most
    };
    // Away from where it begins, until the slope changes its sign.
    let (mut a, mut reach) = (first, REACH);
    let mut b = loop {
        let push = a.push();
        let bound = if push > 0.0 {
            free.shortest
        } else {
            free.longest
        };
        if settled(&a) || a.horizon == bound || !push.is_finite() {
            let good = a.sound() && push.is_finite();
            return Ok(Searched::new(a, good));
        }
        let next = a.horizon * (-reach * push.signum()).exp();
        let next = next.clamp(free.shortest, free.longest);
        let there = attempt(next, &a)?;
        if watch.stopped().is_some() {
            return Ok(Searched::new(better(there, a), false));
        }
        if there.push() * push <= 0.0 {
            break there;
        }
        (a, reach) = (there, 2.0 * reach);
    };
    // The rule of false position, as in Illinois: an end that stays counts half.
    let (mut at_a, mut at_b) = (a.push(), b.push());
    for _ in 0..TRIES {
        let (from, to) = (a.horizon.ln(), b.horizon.ln());
        let least = if a.sound() && b.sound() {
            SAME_HORIZON[kind]
        } else {
            POSSIBLE
        };
        let close = (from - to).abs() <= least;
        if settled(&b) || close {
            // A jump of the quadrature, or the limit of what is possible.
            let both = a.sound() && b.sound();
            let best = better(b, a);
            return Ok(Searched {
                settled: best.sound(),
                limited: !both && !settled(&best),
                best,
            });
        }
        let next = to - at_b * (to - from) / (at_b - at_a);
        let there = attempt(next.exp(), if b.sound() { &b } else { &a })?;
        if watch.stopped().is_some() {
            return Ok(Searched::new(better(there, better(b, a)), false));
        }
        if there.push() * b.push() < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        at_b = there.push();
        b = there;
    }
    Ok(Searched::new(b, false))
}

/// The later of two results if it was successful, otherwise the earlier one.
fn better(later: Tried, earlier: Tried) -> Tried {
    if later.sound() { later } else { earlier }
}
