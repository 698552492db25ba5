//! Weighted squares of torques, velocities and accelerations.

use super::{RunningCost, StageDerivatives, StageInput};
use crate::error::{Error, Result, check_length, plain};

/// $\sum_i w^u_i u_i^2 + w^v_i v_i^2 + w^a_i a_i^2$.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedSquares {
    torque: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
}

impl WeightedSquares {
    /// Builds the cost from weights of torques, velocities and accelerations, one entry per joint. A joint with zero
    /// weights moves freely to reduce the cost of the others.
    ///
    /// # Errors
    /// A slice has another length than the others, or a weight is negative or not finite.
    pub fn new(dof: usize, torque: Vec<f64>, velocity: Vec<f64>, acceleration: Vec<f64>) -> Result<Self> {
        let refuse = |what: &str, condition: String| Err(Error::input("weights", what, condition));
        let all = [("torque", &torque), ("velocity", &velocity), ("acceleration", &acceleration)];
        for (what, weights) in all {
            if weights.len() != dof {
                let found = weights.len();
                let joints = format!("the robot has {dof} joints, but {found} values are given");
                return refuse(what, joints);
            }
            if let Some(w) = weights.iter().find(|w| !(w.is_finite() && **w >= 0.0)) {
                return refuse(what, format!("it is {}, a weight is not negative", plain(*w)));
            }
        }
        Ok(Self { torque, velocity, acceleration })
    }
}

impl WeightedSquares {
    /// The control effort $|u|^2$ of a robot with `dof` joints, as a term of a sum.
    #[must_use]
    pub fn effort(dof: usize) -> Self {
        Self { torque: vec![1.0; dof], velocity: vec![0.0; dof], acceleration: vec![0.0; dof] }
    }

    /// The torque weights $w^u$, `N` entries.
    #[must_use]
    pub fn torque(&self) -> &[f64] {
        &self.torque
    }

    /// The velocity weights $w^v$, `N` entries.
    #[must_use]
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// The acceleration weights $w^a$, `N` entries.
    #[must_use]
    pub fn acceleration(&self) -> &[f64] {
        &self.acceleration
    }

    /// Weights and values in the order of $y$ from the velocities on.
    fn terms<'a>(&'a self, at: &'a StageInput<'_, f64>) -> impl Iterator<Item = (f64, f64)> + 'a {
        let weights = [&self.velocity, &self.acceleration, &self.torque];
        let weights = weights.into_iter().flatten();
        let values = [at.v, at.a, at.u].into_iter().flatten();
        weights.copied().zip(values.copied())
    }
}

impl RunningCost for WeightedSquares {
    fn value(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        check_length("weights", at.u.len(), self.torque.len())?;
        Ok(self.terms(at).map(|(w, x)| w * x * x).sum())
    }

    fn derivatives(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> Result<f64> {
        let n = at.q.len();
        for (i, (w, x)) in self.terms(at).enumerate() {
            out.gradient[n + i] = 2.0 * w * x;
            out.hessian[(n + i, n + i)] = 2.0 * w;
        }
        self.value(at)
    }
}
