//! A free horizon, and free lengths of its parts.

use crate::error::{Error, Result, plain};
use crate::motion::Problem;
use crate::transcription::Horizons;

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

/// The bounds of the lengths of parts of a motion, which are unknowns, and the weight of their sum `T`:
/// $\int l\\, dt + w T$ is minimised over the lengths as well.
///
/// The segments of the motion belong to as many parts as there are bounds, each with as many segments as any other.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeParts {
    /// The shortest and the longest length of each part, s; equal ones for a part of given length.
    pub bounds: Vec<[f64; 2]>,
    /// The weight $w$ per second.
    pub weight: f64,
}

impl FreeParts {
    /// Checks the bounds and the weight, and that the parts share the segments of a motion.
    ///
    /// # Errors
    /// Names the first invalid number.
    pub fn check(&self, segments: usize) -> Result<()> {
        let refuse = |element: String, condition: String| {
            let element = format!("parts.{element}");
            Err(Error::input("settings", element, condition))
        };
        let count = self.bounds.len();
        if count == 0 || !segments.is_multiple_of(count) {
            let condition = format!("there are {count} for {segments} segments");
            return refuse("bounds".to_owned(), condition);
        }
        for (k, [shortest, longest]) in self.bounds.iter().enumerate() {
            for length in [shortest, longest] {
                if let Err(condition) = Problem::check_horizon(*length) {
                    return refuse(format!("bounds[{k}]"), condition);
                }
            }
            if shortest > longest {
                let condition =
                    format!("the shortest length {shortest} is above the longest one {longest}");
                return refuse(format!("bounds[{k}]"), condition);
            }
        }
        if !(self.weight.is_finite() && self.weight >= 0.0) {
            let condition = format!("it is {}, a weight is not negative", plain(self.weight));
            return refuse("weight".to_owned(), condition);
        }
        Ok(())
    }

    /// The horizons of parts that would all last as long as one, within their bounds, with the slopes of that.
    pub(crate) fn horizons(&self, horizon: f64) -> Horizons<f64> {
        let count = self.bounds.len() as f64;
        let bounds = self.bounds.iter();
        let parts =
            bounds.map(|[shortest, longest]| horizon.clamp(count * shortest, count * longest));
        Horizons::of_parts(parts.collect(), horizon)
    }
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
