//! A horizon that is found with the motion.

use crate::error::{Error, Result, plain};
use crate::motion::{Problem, Watch};
use crate::relax::interior_point::Candidate;
use crate::relax::transcription::{place, points};
use crate::relax::tuning::{HORIZON_SLOPE, POSSIBLE, REACH, SAME_HORIZON, SMALLEST_COST, TRIES};
use crate::relax::{Grid, PointCost, PointDerivatives};
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// A horizon that is to be found: $\int l\\, dt + w T$ is minimised over `T` as well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeHorizon {
    /// The shortest there may be, s.
    pub shortest: f64,
    /// The longest.
    pub longest: f64,
    /// $w$, what a second costs.
    pub weight: f64,
}

impl FreeHorizon {
    /// Whether bounds and weight make sense, and the horizon to begin with is between the bounds.
    ///
    /// # Errors
    /// Names the first number that does not.
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

/// The derivative of a sum over quadrature points in the horizon `T` where the curve is the same in normalised time but for boundary
/// slopes: with $z = (q, \dot q, \ddot q)$ and coefficients that move with the rates $c'$,
///
/// $$ \frac{\partial J}{\partial T} = \sum_g w_g \left( \frac{l}{T} + \frac{\partial l}{\partial z} \cdot
///    \left( \phi c',\ \dot\phi c' - \frac{\dot q}{T},\ \ddot\phi c' - \frac{2 \ddot q}{T} \right) +
///    \frac{t}{T} \frac{\partial l}{\partial t} \right). $$
///
/// At a minimum over the other coefficients it is the derivative of that minimum.
///
/// # Errors
/// The cost is for another robot.
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

/// What was found on one horizon.
#[derive(Clone, Debug)]
pub(in crate::relax) struct Tried {
    pub horizon: f64,
    pub found: Candidate,
    /// Of motion and time.
    cost: f64,
    /// Its derivative in the logarithm of the horizon.
    slope: f64,
}

impl Tried {
    /// A minimum on a horizon, whose cost is known with its slope.
    pub fn new(free: FreeHorizon, horizon: f64, found: Candidate) -> Self {
        Self {
            horizon,
            cost: found.cost + free.weight * horizon,
            slope: horizon * (found.horizon_slope + free.weight),
            found,
        }
    }

    /// Tells whether it is worth anything: where it is not the horizon is taken to be too short.
    fn sound(&self) -> bool {
        self.found.converged || self.found.kept
    }

    /// The slope, or one that asks for more time.
    fn push(&self) -> f64 {
        if self.sound() {
            self.slope
        } else {
            -self.cost.abs().max(SMALLEST_COST)
        }
    }
}

/// Looks for a horizon at which the cost is stationary, or a bound that keeps it from falling further; says whether there is one.
/// The cost is stationary where its slope in the logarithm of the horizon is small, or at most the `tolerance`, relative to the cost.
/// `attempt` solves on a horizon, from what was found on another. Where there are several it is one that is near. The best so far is not settled when
/// the search is stopped.
pub(in crate::relax) fn search(
    free: FreeHorizon,
    constrained: bool,
    tolerance: f64,
    first: Tried,
    watch: &Watch,
    mut attempt: impl FnMut(f64, &Tried) -> Result<Tried>,
) -> Result<(Tried, bool)> {
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
            return Ok((a, good));
        }
        let next = a.horizon * (-reach * push.signum()).exp();
        let next = next.clamp(free.shortest, free.longest);
        let there = attempt(next, &a)?;
        if watch.stopped().is_some() {
            return Ok((better(there, a), false));
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
            let found = better(b, a);
            let good = found.sound();
            return Ok((found, good));
        }
        let next = to - at_b * (to - from) / (at_b - at_a);
        let there = attempt(next.exp(), if b.sound() { &b } else { &a })?;
        if watch.stopped().is_some() {
            return Ok((better(there, better(b, a)), false));
        }
        if there.push() * b.push() < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        at_b = there.push();
        b = there;
    }
    Ok((b, false))
}

/// The later of two if it is worth anything, or else the earlier one.
fn better(later: Tried, earlier: Tried) -> Tried {
    if later.sound() { later } else { earlier }
}
