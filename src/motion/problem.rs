//! The boundary value problem and its first guess.

use crate::curve::Chebyshev;
use crate::error::{Error, Result, check_length, plain};
use crate::model::{JointKind, Model};
use nalgebra::DMatrix;

/// A trajectory optimisation problem: from one state of a robot to another in a given time.
#[derive(Clone, Debug)]
pub struct Problem<'m> {
    model: &'m Model,
    start: Vec<f64>,
    goal: Vec<f64>,
    accelerations: [Option<Vec<f64>>; 2],
    horizon: f64,
}

impl<'m> Problem<'m> {
    /// The shortest horizon, s: below it no drive can move a robot, and squared accelerations overflow.
    pub const MIN_HORIZON: f64 = 1e-6;
    /// The longest horizon, one year, s. A motion of that length is not a polynomial.
    pub const MAX_HORIZON: f64 = 31_536_000.0;

    /// Checks a horizon; the error gives the violated condition.
    pub fn check_horizon(horizon: f64) -> std::result::Result<(), String> {
        if (Self::MIN_HORIZON..=Self::MAX_HORIZON).contains(&horizon) {
            return Ok(());
        }
        let [horizon, least, most] = [horizon, Self::MIN_HORIZON, Self::MAX_HORIZON].map(plain);
        Err(format!("it is {horizon} and must be a positive time of at least {least} s and at most {most} s"))
    }

    /// The problem from state `start` to state `goal`, each $[q; v]$ with `2 N` entries, in `horizon` seconds.
    ///
    /// # Errors
    /// A state does not have `2 N` entries, a number is not finite, or the horizon is below
    /// [`MIN_HORIZON`](Self::MIN_HORIZON) or above [`MAX_HORIZON`](Self::MAX_HORIZON).
    pub fn new(model: &'m Model, start: Vec<f64>, goal: Vec<f64>, horizon: f64) -> Result<Self> {
        Self::check(model, [&start, &goal], horizon)?;
        Ok(Self { model, start, goal, accelerations: [None, None], horizon })
    }

    /// Changes the states and the horizon.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); the old ones then remain.
    pub(crate) fn set(&mut self, start: &[f64], goal: &[f64], horizon: f64) -> Result<()> {
        Self::check(self.model, [start, goal], horizon)?;
        self.start.copy_from_slice(start);
        self.goal.copy_from_slice(goal);
        self.horizon = horizon;
        Ok(())
    }

    /// Checks states and a horizon.
    fn check(model: &Model, states: [&[f64]; 2], horizon: f64) -> Result<()> {
        for (what, state) in ["start", "goal"].into_iter().zip(states) {
            Self::check_entries(model, (what, state), 2 * model.dof())?;
        }
        Self::check_horizon(horizon).map_err(|condition| Error::input(model.name(), "horizon", condition))
    }

    /// Checks the number of entries of a vector, and that they are finite.
    fn check_entries(model: &Model, (what, x): (&'static str, &[f64]), expected: usize) -> Result<()> {
        check_length(what, expected, x.len())?;
        let Some(i) = x.iter().position(|x| !x.is_finite()) else { return Ok(()) };
        Err(Error::input(model.name(), what, format!("entry {i} is not a finite number")))
    }

    /// The robot.
    #[must_use]
    pub fn model(&self) -> &'m Model {
        self.model
    }

    /// The initial state, $[q; v]$.
    #[must_use]
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// The final state, $[q; v]$.
    #[must_use]
    pub fn goal(&self) -> &[f64] {
        &self.goal
    }

    /// The given accelerations at the start and at the end, `N` entries each.
    #[must_use]
    pub fn accelerations(&self) -> &[Option<Vec<f64>>; 2] {
        &self.accelerations
    }

    /// The horizon `T`, in s.
    #[must_use]
    pub fn horizon(&self) -> f64 {
        self.horizon
    }

    /// The largest sum along the tree of the lengths of links and of the distances that joints slide from start to
    /// goal, m: a scale for distances in the problem. Zero for a robot of one body that turns about one point.
    #[must_use]
    pub fn reach(&self) -> f64 {
        let joints = 0..self.model.dof();
        joints.fold(0.0, |most, joint| self.length_to(joint).max(most))
    }

    /// The sum of these lengths from the base to a joint.
    fn length_to(&self, i: usize) -> f64 {
        let joint = &self.model.joints()[i];
        let before = joint.parent().map_or(0.0, |parent| self.length_to(parent));
        let slides = match joint.kind() {
            JointKind::Prismatic => (self.goal[i] - self.start[i]).abs(),
            _ => 0.0,
        };
        before + joint.origin().translation.norm() + slides
    }

    /// The same problem on another horizon.
    ///
    /// # Errors
    /// The horizon is out of range.
    pub fn with_horizon(&self, horizon: f64) -> Result<Self> {
        Self::check(self.model, [&self.start, &self.goal], horizon)?;
        Ok(Self { horizon, ..self.clone() })
    }

    /// The same problem with these accelerations at the start and at the end, `N` entries each, rad/s^2 or m/s^2. By
    /// default those of a motion whose accelerations are continuous are zero at an end at rest, and free at one where
    /// it moves.
    ///
    /// # Errors
    /// An acceleration does not have `N` entries, or a number is not finite.
    pub fn with_accelerations(self, accelerations: [Option<Vec<f64>>; 2]) -> Result<Self> {
        for (what, a) in ["acceleration at the start", "acceleration at the end"].into_iter().zip(&accelerations) {
            let Some(a) = a else { continue };
            Self::check_entries(self.model, (what, a), self.model.dof())?;
        }
        Ok(Self { accelerations, ..self })
    }

    /// The same problem with another configuration at its end.
    ///
    /// # Errors
    /// `q` does not have `N` entries, or a number is not finite.
    pub fn with_final_position(&self, q: &[f64]) -> Result<Self> {
        let goal = [q, &self.goal[self.model.dof()..]].concat();
        Self::check(self.model, [&self.start, &goal], self.horizon)?;
        Ok(Self { goal, ..self.clone() })
    }

    /// The initial states at the nodes, `2 N` by `p + 1`.
    #[must_use]
    pub fn guess(&self, guess: Guess, chebyshev: &Chebyshev) -> DMatrix<f64> {
        let (n, p) = (self.model.dof(), chebyshev.degree());
        DMatrix::from_fn(2 * n, p + 1, |row, node| {
            let (start, goal) = (self.start[row], self.goal[row]);
            match guess {
                _ if node == 0 => start,
                _ if node == p => goal,
                Guess::LineConfiguration if row >= n => (self.goal[row - n] - self.start[row - n]) / self.horizon,
                Guess::LineState | Guess::LineConfiguration => {
                    start + (goal - start) * chebyshev.times()[node] / self.horizon
                }
            }
        })
    }
}

crate::names::named_enum! {
/// A first guess at a trajectory. The ends are always the boundary states.
pub enum Guess("guess") {
    /// `q` linear in time and `v = D q`, its constant slope, as the paper's released code does.
    LineConfiguration = "line_configuration",
    /// `q` and `v` both linear in time, as the paper's text says.
    LineState = "line_state",
}
}
