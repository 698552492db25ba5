//! The options of the interior-point method.

use super::{BarrierUpdate, Monotone};
use crate::error::{Error, Result, check_positive};
use std::sync::Arc;

/// All constants of the method, each with its reason. WB: Wächter and Biegler, 2006; NW: Nocedal and Wright, 2006.
#[derive(Clone, Debug)]
pub struct Options {
    /// The Newton decrement at the end, relative to the objective: half its square is the excess over the minimum.
    pub tolerance: f64,
    /// The size of the objective, relative to which gradients and barriers are measured; `None` for a positive
    /// objective, whose size is its value.
    pub scale: Option<f64>,
    /// The accepted violation of a row, in its unit.
    pub feasible: f64,
    /// The largest number of iterations.
    pub iterations: usize,
    /// The first barrier parameter, relative to the objective and summed over all rows: 0.1 as in WB.
    pub first_barrier: f64,
    /// The largest first barrier parameter with known multipliers: large enough for rows to move away from their
    /// bounds.
    pub warm_barrier: f64,
    /// The least one, above which it is the change of the objective that the multipliers predict.
    pub min_warm_barrier: f64,
    /// The last barrier parameter: the relative excess of the objective over its minimum.
    pub last_barrier: f64,
    /// The rule by which the barrier parameter changes.
    pub barrier: Arc<dyn BarrierUpdate>,
    /// The longest step, in the norm of steps: a radian in the mean, beyond which a robot has other minima. It may be
    /// infinite.
    pub longest_step: f64,
    /// The length, in the norm of steps, over which the change of a row counts as linear: curvature changes it by about
    /// 1e-6 of the step, rounding by less, and both are below slacks at small barrier parameters.
    pub tangent: f64,
    /// The fraction of its distance from zero by which a slack or multiplier shrinks at most in a step. WB take 0.99 or
    /// more for the smallest of all; here each row is limited by itself, and 0.9 keeps the rows central (tuned on seven
    /// problems of a seven-joint arm in clutter: 0.7 and 0.99 solve four and five of them in the time in which 0.9
    /// solves six).
    pub fraction_to_boundary: f64,
    /// The first penalty of a violation, relative to the objective: small, so that a motion may pass through an
    /// obstacle while the barrier parameter is large, and the search finds the better side.
    pub penalty: f64,
    /// The least first penalty relative to the largest known multiplier: a row whose multiplier is larger than the
    /// penalty is violated (NW 18.36), which should not happen from a start that keeps its rows. Zero if that is
    /// acceptable. Direct searches raise penalties later, so that they use the multiple per row instead; the tracker
    /// and flows to rest use both.
    pub penalty_of_multipliers: f64,
    /// The least first penalty of a row relative to its own known multiplier.
    pub row_penalty_of_multipliers: f64,
    /// The least change of an equality per change of its multiplier in the condensed equations, for an objective of the
    /// size 1, as $\delta_c$ of WB (13). Its error vanishes with the change of the multiplier. Without it rounding of
    /// large penalties hides the Hessian along the equalities, and dependent ones make steps short (of 20 problems of
    /// S2MPJ with equalities HS26 takes 602, 313, 86 and 32 iterations with 1e-9 to 1e-6, the others at most as many).
    pub compliance: f64,
    /// True if penalties are also raised after steps that hardly decrease a violation: an objective without a lower
    /// bound where rows are violated needs that.
    pub steers: bool,
    /// The factor of the penalty of a violated row whose multiplier has reached it, and that of all penalties if the
    /// violations have decreased too little since the last raise. A large penalty of a row with a small multiplier
    /// makes steps along it short, so only rows that need a large penalty have one (tuned on 103 problems of Panda and
    /// Fetch: with 1 or 10 for all penalties fewer searches end at minima).
    pub row_penalty_factor: f64,
    pub penalty_factor: f64,
    /// The largest penalty: with it a violation of 1e-9 of the scale of its row costs as much as the whole motion.
    pub largest_penalty: f64,
    /// The cost of all violations with the penalty, relative to the objective, and the fraction of them that is left
    /// since the penalty was last raised, above which the search is at a local minimum of the violation: other starts
    /// are more promising than a motion that costs that much more (tuned: starts in clutter end after fewer iterations
    /// than with 1, and with 0.1 some are given up that only touch an obstacle in one point).
    pub infeasible_cost: f64,
    pub infeasible_progress: f64,
    /// The fraction of the predicted decrease that a step achieves: 1e-4 as in NW (3.4).
    pub sufficient_decrease: f64,
    /// The number of iterates whose largest barrier function counts as the one before a step (Grippo, Lampariello and
    /// Lucidi, 1986): full steps along curved rows increase it for a while (the Maratos effect, NW 15.4).
    pub memory: usize,
    /// The factor of backtracking: 0.5 as in WB.
    pub backtracking: f64,
    /// The largest number of reductions of a step.
    pub max_backtracks: usize,
    /// The largest slack to which a row moves away from its bound with known multipliers, relative to its scale.
    pub largest_warm_slack: f64,
    /// The largest factor between a multiplier and the one that belongs to its slack: 1e10 as in WB (16).
    pub multiplier_range: f64,
    /// The first multiple of the norm that is added to an indefinite Hessian: 1e-4 as in WB.
    pub first_regularisation: f64,
    /// The factors of that multiple after a failed factorisation, the first time and later, and after a success: 100, 8
    /// and 1/3 as in WB.
    pub regularisation_factors: [f64; 3],
    /// The smallest multiple except zero, from which it grows after short fractions of steps.
    pub smallest_regularisation: f64,
    /// The fractions of a step below and above which the multiple grows and shrinks.
    pub short_fraction: f64,
    pub long_fraction: f64,
    /// The largest multiple.
    pub largest_regularisation: f64,
    /// The factors of the [weight](super::Iterate::curvature_weight) of second derivatives after a step with a multiple
    /// of the norm and after one without, and the smallest weight except zero. A body that passes around another one
    /// has negative curvature across the line between them, which makes the Hessian indefinite while multipliers are
    /// large; without it, as in the Gauss-Newton method, steps are as long as the objective allows, whereas a multiple
    /// of the norm makes all of them short (tuned on 67 problems of Fetch, UR5, Baxter and Panda: with 0.5 and 2, 0.25
    /// and 2, or 0 and 10 the gain is half as large; 57 others take a sixth fewer iterations than with all second
    /// derivatives).
    pub curvature_factors: [f64; 2],
    pub min_curvature_weight: f64,
    /// The number of successive steps with a multiple of the norm and a weight of zero after which the weight is one
    /// again: then these derivatives are not the only ones that make the Hessian indefinite, and without them steps are
    /// Gauss-Newton steps, which may take hundreds of iterations along a curved row (108 problems of Fetch, UR5, Baxter
    /// and Panda take 8 % less time than without this rule; after 5 steps they take 4 % less than after 10, but 35 of
    /// the Panda a quarter more, the slowest four times as much).
    pub max_steps_without_curvature: usize,
    /// The first length of a step along a direction of negative curvature, in the norm of steps.
    pub saddle_step: f64,
    /// The largest number of times that rows are tightened at the last barrier parameter.
    pub rounds: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            scale: None,
            feasible: 5e-7,
            iterations: 500,
            first_barrier: 0.1,
            warm_barrier: 1e-2,
            min_warm_barrier: 0.0,
            last_barrier: 1e-7,
            barrier: Arc::new(Monotone::default()),
            longest_step: 1.0,
            tangent: 1e-6,
            fraction_to_boundary: 0.9,
            penalty: 1.0,
            penalty_of_multipliers: 2.0,
            row_penalty_of_multipliers: 2.0,
            compliance: 1e-6,
            steers: false,
            row_penalty_factor: 10.0,
            penalty_factor: 4.0,
            largest_penalty: 1e9,
            infeasible_cost: 0.3,
            infeasible_progress: 0.5,
            sufficient_decrease: 1e-4,
            memory: 4,
            backtracking: 0.5,
            max_backtracks: 25,
            largest_warm_slack: 0.02,
            multiplier_range: 1e10,
            first_regularisation: 1e-4,
            regularisation_factors: [100.0, 8.0, 1.0 / 3.0],
            smallest_regularisation: 1e-3,
            short_fraction: 0.3,
            long_fraction: 0.6,
            largest_regularisation: 1e10,
            curvature_factors: [0.25, 4.0],
            min_curvature_weight: 0.1,
            max_steps_without_curvature: 10,
            saddle_step: 0.3,
            rounds: 20,
        }
    }
}

impl Options {
    /// Refuses values out of range, with which a search would not end.
    ///
    /// # Errors
    /// A value is out of range.
    pub fn check(&self) -> Result<()> {
        for (what, value) in [
            ("tolerance", self.tolerance),
            ("feasible", self.feasible),
            ("first_barrier", self.first_barrier),
            ("warm_barrier", self.warm_barrier),
            ("last_barrier", self.last_barrier),
            ("tangent", self.tangent),
            ("penalty", self.penalty),
            ("largest_penalty", self.largest_penalty),
            ("infeasible_cost", self.infeasible_cost),
            ("infeasible_progress", self.infeasible_progress),
            ("largest_warm_slack", self.largest_warm_slack),
            ("first_regularisation", self.first_regularisation),
            ("smallest_regularisation", self.smallest_regularisation),
            ("largest_regularisation", self.largest_regularisation),
            ("short_fraction", self.short_fraction),
            ("long_fraction", self.long_fraction),
            ("saddle_step", self.saddle_step),
            ("scale", self.scale.unwrap_or(1.0)),
        ] {
            check_positive("nlp", what, value)?;
        }
        // In some norms no length is too large.
        if self.longest_step != f64::INFINITY {
            check_positive("nlp", "longest_step", self.longest_step)?;
        }
        self.check_factors()
    }

    /// Refuses factors out of range.
    fn check_factors(&self) -> Result<()> {
        let [first, later, after] = self.regularisation_factors;
        let [less, more] = self.curvature_factors;
        let [for_first, for_second, for_third] = [" for the first", " for the second", " for the third"];
        let of_row = self.row_penalty_of_multipliers;
        for (what, value) in [
            ("min_warm_barrier", self.min_warm_barrier),
            ("penalty_of_multipliers", self.penalty_of_multipliers),
            ("row_penalty_of_multipliers", of_row),
            ("compliance", self.compliance),
        ] {
            let good = value >= 0.0 && value.is_finite();
            needs(what, value, good, "not negative", "")?;
        }
        for (what, value, which) in [
            ("penalty_factor", self.penalty_factor, ""),
            ("row_penalty_factor", self.row_penalty_factor, ""),
            ("multiplier_range", self.multiplier_range, ""),
            ("regularisation_factors", first, for_first),
            ("regularisation_factors", later, for_second),
            ("curvature_factors", more, for_second),
        ] {
            let good = value > 1.0 && value.is_finite();
            needs(what, value, good, "more than 1", which)?;
        }
        for (what, value, which) in [
            ("regularisation_factors", after, for_third),
            ("curvature_factors", less, for_first),
            ("min_curvature_weight", self.min_curvature_weight, ""),
            ("fraction_to_boundary", self.fraction_to_boundary, ""),
            ("sufficient_decrease", self.sufficient_decrease, ""),
            ("backtracking", self.backtracking, ""),
        ] {
            let good = value > 0.0 && value < 1.0;
            needs(what, value, good, "a number between 0 and 1", which)?;
        }
        Ok(())
    }
}

/// Refuses a value that is not acceptable.
fn needs(what: &str, value: f64, good: bool, condition: &str, which: &str) -> Result<()> {
    if good {
        return Ok(());
    }
    let condition = format!("it is {value} and must be {condition}{which}");
    Err(Error::input("nlp", what, condition))
}
