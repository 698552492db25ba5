//! The rows of constraints at times of a motion.

use crate::constraint::{Constraint, Constraints, Evaluator, RateLimit, StageInput};
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{LANES, Lanes, Wide};
use crate::transcription::Shared;

/// All rows at all times of a segment.
pub(super) struct Rows<'a, K> {
    model: &'a Model,
    constraints: Shared<'a, Constraints<K>>,
    evaluator: Evaluator<'a, f64, Wide>,
    data: Data<Wide>,
    /// $[q; v; a]$, the torque and the rows at the times that are evaluated side by side.
    z: Vec<Wide>,
    u: Vec<Wide>,
    g: Vec<Wide>,
    rates: Vec<RateLimit>,
    /// The rows divided by their scales, one after the other, each over time and padded to full lanes.
    pub values: Vec<f64>,
    pub stride: usize,
}

impl<'a, K: Constraint> Rows<'a, K> {
    pub fn new(model: &'a Model, constraints: Shared<'a, Constraints<K>>) -> Self {
        let (n, count, zero) = (model.dof(), constraints.dim(), Wide::splat(0.0));
        Self {
            model,
            evaluator: Evaluator::new(model),
            data: Data::new(model),
            z: vec![zero; 4 * n],
            rates: constraints.stage.rates().collect(),
            u: vec![zero; n],
            g: vec![zero; count],
            values: Vec::new(),
            stride: 0,
            constraints,
        }
    }

    /// Evaluates all rows at times of a segment, where the motion has these states, one after the other.
    pub fn evaluate(
        &mut self,
        states: &[f64],
        (begin, own_times): (f64, &[f64]),
        scales: &[f64],
    ) -> Result<()> {
        let n = self.model.dof();
        let times = own_times.len();
        self.stride = times.next_multiple_of(LANES);
        self.values.resize(scales.len() * self.stride, 0.0);
        let Constraints {
            state,
            torque,
            stage,
        } = &*self.constraints;
        let (of_state, others) = self.g.split_at_mut(state.dim());
        let (of_torque, of_stage) = others.split_at_mut(torque.dim());
        for first in (0..times).step_by(LANES) {
            Lanes::gather(states, first, &mut self.z);
            let placed = self.evaluator.at(&self.z[..2 * n])?;
            placed.value(state, of_state)?;
            if !(of_torque.is_empty() && stage.others.is_empty()) {
                let [q, v, a] = [0, 1, 2].map(|part| &self.z[part * n..(part + 1) * n]);
                rnea(self.model, &mut self.data, q, v, a, &mut self.u)?;
                if !of_torque.is_empty() {
                    torque.value(&self.u, of_torque)?;
                }
            }
            for (g, rate) in of_stage.iter_mut().zip(&self.rates) {
                let of_joint = self.z[rate.order * n + rate.joint];
                *g = of_joint * Wide::splat(rate.sign()) - Wide::splat(rate.limit);
            }
            if let Some((row, foot)) = stage.foot() {
                let z = [0, 1, 2].map(|part| &self.z[part * n..(part + 1) * n]);
                let g = &mut of_stage[row..row + foot.dim()];
                foot.value(self.model, &mut self.data, z, g)?;
            }
            for (row, other) in stage.others() {
                for lane in 0..LANES.min(times - first) {
                    let t = begin + own_times[first + lane];
                    let z: Vec<f64> = self.z.iter().chain(&self.u).map(|z| z.0[lane]).collect();
                    let [q, v, a, _, u] = [0, 1, 2, 3, 4].map(|part| &z[part * n..(part + 1) * n]);
                    let mut g = vec![0.0; other.dim()];
                    other.value(&StageInput { t, q, v, a, u }, &mut g)?;
                    for (to, g) in of_stage[row..].iter_mut().zip(g) {
                        to.0[lane] = g;
                    }
                }
            }
            let all = of_state
                .iter()
                .chain(of_torque.iter())
                .chain(of_stage.iter())
                .zip(scales);
            for ((g, scale), values) in all.zip(self.values.chunks_exact_mut(self.stride)) {
                for (value, g) in values[first..first + LANES].iter_mut().zip(g.0) {
                    let scaled = g / scale;
                    // Comparisons would ignore a NaN.
                    *value = if scaled.is_nan() {
                        f64::INFINITY
                    } else {
                        scaled
                    };
                }
            }
        }
        Ok(())
    }
}
