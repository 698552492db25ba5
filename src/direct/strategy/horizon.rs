//! A free horizon.

use crate::error::{Error, Result, plain};
use crate::motion::Problem;

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
        let Self { shortest, longest, weight } = *self;
        for (what, value) in [("shortest", shortest), ("longest", longest)] {
            if let Err(condition) = Problem::check_horizon(value) {
                return refuse(what, condition);
            }
        }
        if !(weight.is_finite() && weight >= 0.0) {
            return refuse("weight", format!("it is {}, a weight is not negative", plain(weight)));
        }
        if horizon < shortest {
            return refuse("shortest", format!("it is {shortest}, above the horizon {horizon} to begin with"));
        }
        if horizon > longest {
            return refuse("longest", format!("it is {longest}, below the horizon {horizon} to begin with"));
        }
        Ok(())
    }
}
