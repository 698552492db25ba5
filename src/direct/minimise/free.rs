//! The free horizons of a program.

use super::program::Program;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::direct::{FreeHorizon, FreeParts};
use crate::transcription::Horizons;
use nalgebra::DVector;

/// The horizons that are unknowns: the whole one, or those of parts.
pub(super) struct Free {
    /// The parts with unknown lengths, and the bounds of their horizons.
    pub parts: Vec<(usize, [f64; 2])>,
    /// The weight of the whole horizon per second.
    pub weight: f64,
}

impl Free {
    pub fn new(whole: Option<FreeHorizon>, parts: Option<&FreeParts>) -> Self {
        if let Some(parts) = parts {
            let count = parts.bounds.len() as f64;
            let all = parts.bounds.iter().enumerate();
            let free = all.filter(|(_, [shortest, longest])| shortest < longest);
            return Self {
                parts: free
                    .map(|(part, bounds)| (part, bounds.map(|length| count * length)))
                    .collect(),
                weight: parts.weight,
            };
        }
        Self {
            parts: whole
                .iter()
                .map(|free| (0, [free.shortest, free.longest]))
                .collect(),
            weight: whole.map_or(0.0, |free| free.weight),
        }
    }

    /// Returns true if the whole horizon is an unknown: then the coefficients of given velocities follow it.
    pub fn is_whole(&self, horizons: &Horizons<f64>) -> bool {
        horizons.reference().is_none() && !self.parts.is_empty()
    }
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// The horizon of a part for unknowns.
    pub(super) fn horizon_at(&self, x: &DVector<f64>, part: usize) -> f64 {
        let free = self.free.parts.iter().position(|(of, _)| *of == part);
        match free {
            Some(k) => x[self.own() + k],
            None => self.horizons.parts()[part],
        }
    }
}
