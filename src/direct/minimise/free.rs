//! The free horizons of a program.

use crate::direct::FreeHorizon;
use crate::transcription::Horizons;

/// The largest share of the range between two bounds that each of them is kept away from.
const RANGE: f64 = 0.25;

/// The horizons that are unknowns: the whole one, or those of parts.
pub(super) struct Free {
    /// The parts with unknown lengths, and the bounds of their horizons.
    pub parts: Vec<(usize, [f64; 2])>,
    /// The weight of the whole horizon per second.
    pub weight: f64,
    /// The bounds of the whole horizon, with their signs, that do not follow from those of parts.
    pub whole: Vec<(f64, f64)>,
}

impl Free {
    /// The unknowns for the bounds of a free horizon and of the lengths of parts, if there are any. A bound is kept
    /// with a `reserve`, as a share of it, like the rows of the motion, so that the horizon is within the bound itself.
    pub fn new(free: Option<FreeHorizon>, parts: &[[f64; 2]], reserve: f64) -> Self {
        let within = |[shortest, longest]: [f64; 2]| {
            let reserve = reserve.min(RANGE * (longest / shortest - 1.0));
            [shortest * (1.0 + reserve), longest * (1.0 - reserve)]
        };
        let all = match parts {
            [] => free.iter().map(|free| [free.shortest, free.longest]).collect(),
            _ => parts.to_vec(),
        };
        let count = all.len() as f64;
        let is_free = |(_, [shortest, longest]): &(usize, [f64; 2])| parts.is_empty() || shortest < longest;
        let own = all.iter().copied().enumerate().filter(is_free);
        let own = own.map(|(part, bounds)| (part, within(bounds).map(|length| count * length)));
        let [shortest, longest] = [0, 1].map(|end| all.iter().map(|of| of[end]).sum::<f64>());
        let whole = free.iter().flat_map(|free| {
            let [lower, upper] = within([free.shortest, free.longest]);
            [(lower, -1.0, free.shortest > shortest), (upper, 1.0, free.longest < longest)]
        });
        Self {
            parts: own.filter(|_| free.is_some()).collect(),
            weight: free.map_or(0.0, |free| free.weight),
            whole: whole.filter(|of| of.2).map(|(bound, sign, _)| (bound, sign)).collect(),
        }
    }

    /// Returns true if the whole horizon is an unknown: then the coefficients of given velocities follow it.
    pub fn is_whole(&self, horizons: &Horizons<f64>) -> bool {
        horizons.reference().is_none() && !self.parts.is_empty()
    }
}
