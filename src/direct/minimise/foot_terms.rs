//! The derivatives of the weighted rows of a standing foot along a motion, side by side.

use crate::constraint::{FootDerivatives, FootWeights};
use crate::cost::{Points, PointsDerivatives};
use crate::dynamics::Data;
use crate::error::Result;
use crate::nlp::Term;
use crate::scalar::{LANES, Wide};
use crate::transcription::Standing;

/// A workspace that adds the derivatives of the rows of a foot with the weights of their terms.
#[derive(Clone, Debug)]
pub(super) struct FootTerms {
    /// The rows of the foot among all, and their factors.
    first: usize,
    scales: Vec<f64>,
    data: Data<Wide>,
    /// $[q; v; a]$, of the motion and of the robot on this foot.
    state: Vec<Wide>,
    z: Vec<Wide>,
    /// Slopes, multipliers and curvatures.
    weights: [Vec<Wide>; 3],
    out: FootDerivatives<Wide>,
}

impl FootTerms {
    /// A workspace for a foot, with the factors of all rows.
    pub fn new((first, model, foot, _): Standing<'_>, scales: &[f64]) -> Self {
        let (n, zero) = (model.dof(), Wide::splat(0.0));
        Self {
            first,
            scales: scales[first..first + foot.dim()].to_vec(),
            data: Data::new(model),
            state: vec![zero; 3 * n],
            z: vec![zero; 3 * n],
            weights: [(); 3].map(|()| vec![zero; foot.dim()]),
            out: FootDerivatives::new(n),
        }
    }

    /// Adds the derivatives at all points at which rows have terms. The joints of a phase have another order.
    pub fn add(
        &mut self,
        (_, model, foot, phase): Standing<'_>,
        points: Points<'_, f64>,
        terms: &[Vec<(usize, Term)>],
        out: &mut PointsDerivatives<f64>,
    ) -> Result<()> {
        let n = model.dof();
        for start in (0..points.count()).step_by(LANES) {
            let count = points.gather(start, &mut self.state);
            match phase {
                Some(phase) => phase.sort(&self.state, &mut self.z),
                None => self.z.clone_from(&self.state),
            }
            if !self.weigh(&terms[points.first + start..][..count]) {
                continue;
            }
            let z = [0, 1, 2].map(|part| &self.z[part * n..(part + 1) * n]);
            let [slopes, multipliers, curvatures] = &self.weights;
            let weights = FootWeights { slopes, multipliers, curvatures };
            let (data, found) = (&mut self.data, &mut self.out);
            foot.weighted_derivatives(model, data, z, weights, found)?;
            let joint = |i: usize| phase.map_or(i, |phase| phase.order[i]);
            for (i, slope) in found.gradient.iter().enumerate() {
                for lane in 0..count {
                    out.gradients[(joint(i % n), 3 * (start + lane) + i / n)] += slope.0[lane];
                }
            }
            match phase {
                Some(phase) => {
                    let hessian = phase.restored(&found.hessian);
                    out.hessians.add_wide(start, &hessian);
                }
                None => out.hessians.add_wide(start, &found.hessian),
            }
        }
        Ok(())
    }

    /// Sets the weights of the rows at points side by side; returns false if no row has a term. Lanes without a point
    /// have zeros.
    fn weigh(&mut self, terms: &[Vec<(usize, Term)>]) -> bool {
        let mut any = false;
        for weights in &mut self.weights {
            weights.fill(Wide::splat(0.0));
        }
        for (lane, terms) in terms.iter().enumerate() {
            for (row, term) in terms {
                let row = row.checked_sub(self.first);
                let Some((row, scale)) = row.and_then(|row| Some((row, *self.scales.get(row)?))) else {
                    continue;
                };
                let [slopes, multipliers, curvatures] = &mut self.weights;
                slopes[row].0[lane] = term.slope * scale;
                multipliers[row].0[lane] = term.multiplier * scale;
                curvatures[row].0[lane] = term.curvature * scale * scale;
                any = true;
            }
        }
        any
    }
}
