//! The rows of constraints at times of a motion.

use crate::constraint::{ActivePair, ActivePairs, Constraint, Constraints, Evaluator, PlacedState, StageInput};
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{LANES, Lanes, Wide};
use crate::transcription::Shared;

/// All rows at all times of a segment, also those that are kept for a part of the time. Those that are maxima of many
/// functions are exact near their bounds.
pub(super) struct Rows<'a, K> {
    model: &'a Model,
    constraints: Shared<'a, Constraints<K>>,
    evaluator: Evaluator<'a, f64, Wide>,
    data: Data<Wide>,
    /// $[q; v; a]$, the torque and the rows at the times that are evaluated side by side.
    z: Vec<Wide>,
    u: Vec<Wide>,
    g: Vec<Wide>,
    /// The pairs that were near each other at the last times, and memory for others.
    active_pairs: Vec<ActivePair<Wide>>,
    active: Vec<ActivePair<Wide>>,
    /// The least value of each row: minus its cutoff divided by its scale.
    pub least: Vec<f64>,
    /// The rows without a cutoff, then those that were above their least value at one of the last times, and the number
    /// of each row among them.
    known: Vec<usize>,
    dense: usize,
    places: Vec<Option<usize>>,
    /// The values of these divided by their scales, one after the other, each over time and padded to full lanes.
    values: Vec<f64>,
    stride: usize,
}

impl<'a, K: Constraint> Rows<'a, K> {
    pub fn new(model: &'a Model, constraints: Shared<'a, Constraints<K>>, scales: &[f64]) -> Self {
        let (n, count, zero) = (model.dof(), constraints.dim(), Wide::splat(0.0));
        let states = constraints.state.dim();
        let cutoff = |row: usize| constraints.state.row_set(row).cutoff.filter(|_| row < states);
        let least = (0..count).map(|row| cutoff(row).map_or(f64::NEG_INFINITY, |cutoff| -cutoff / scales[row]));
        let least: Vec<_> = least.collect();
        let dense = (0..count).filter(|row| least[*row].is_infinite());
        let known: Vec<_> = dense.collect();
        let mut places = vec![None; count];
        for (place, row) in known.iter().enumerate() {
            places[*row] = Some(place);
        }
        Self {
            dense: known.len(),
            known,
            places,
            least,
            model,
            evaluator: Evaluator::new(model),
            data: Data::new(model),
            z: vec![zero; 4 * n],
            active_pairs: Vec::new(),
            active: Vec::new(),
            u: vec![zero; n],
            g: vec![zero; count],
            values: Vec::new(),
            stride: 0,
            constraints,
        }
    }

    /// Evaluates all rows at times of a segment, where the motion has these states, one after the other.
    pub fn evaluate(&mut self, states: &[f64], (begin, own_times): (f64, &[f64]), scales: &[f64]) -> Result<()> {
        let n = self.model.dof();
        let times = own_times.len();
        self.stride = times.next_multiple_of(LANES);
        for row in self.known.drain(self.dense..) {
            self.places[row] = None;
        }
        self.values.resize(self.dense * self.stride, 0.0);
        let constraints = self.constraints.clone();
        let Constraints { state, torque, stage } = &*constraints;
        for first in (0..times).step_by(LANES) {
            let (of_state, others) = self.g.split_at_mut(state.dim());
            let (of_torque, of_stage) = others.split_at_mut(torque.dim());
            Lanes::gather(states, first, &mut self.z);
            let placed = self.evaluator.at(&self.z[..2 * n])?;
            let at = PlacedState {
                active_pairs: Some(ActivePairs::new(&self.active_pairs).independent()),
                ..*placed.state()
            };
            self.active.clear();
            state.value_of(&at, None, of_state, Some(&mut self.active))?;
            std::mem::swap(&mut self.active_pairs, &mut self.active);
            if !(of_torque.is_empty() && stage.custom.is_empty()) {
                let [q, v, a] = [0, 1, 2].map(|part| &self.z[part * n..(part + 1) * n]);
                rnea(self.model, &mut self.data, q, v, a, &mut self.u)?;
                if !of_torque.is_empty() {
                    torque.value(&self.u, of_torque)?;
                }
            }
            for (g, rate) in of_stage.iter_mut().zip(&self.constraints.stage.rates) {
                let of_joint = self.z[rate.order * n + rate.joint];
                *g = of_joint * Wide::splat(rate.side.sign()) - Wide::splat(rate.limit);
            }
            if let Some((row, foot)) = stage.foot() {
                let z = [0, 1, 2].map(|part| &self.z[part * n..(part + 1) * n]);
                let g = &mut of_stage[row..row + foot.dim()];
                foot.value(self.model, &mut self.data, z, g)?;
            }
            for (row, other) in stage.custom_rows() {
                for lane in 0..LANES.min(times - first) {
                    let t = begin + own_times[first + lane];
                    let z: Vec<f64> = self.z.iter().chain(&self.u).map(|z| z.0[lane]).collect();
                    let [q, v, a, _, u] = [0, 1, 2, 3, 4].map(|part| &z[part * n..(part + 1) * n]);
                    let mut g = vec![0.0; other.dim()];
                    let at = StageInput { t, q, v, a, u };
                    match other.window() {
                        Some(window) => window.at_all_times(&at, &mut g)?,
                        None => other.value(&at, &mut g)?,
                    }
                    for (to, g) in of_stage[row..].iter_mut().zip(g) {
                        to.0[lane] = g;
                    }
                }
            }
            self.write(first, scales);
        }
        Ok(())
    }

    /// Writes the rows at times that were evaluated side by side, from the `first` one on.
    fn write(&mut self, first: usize, scales: &[f64]) {
        let stride = self.stride;
        for row in self.active_pairs.iter().map(|pair| pair.row) {
            if self.places[row].is_none() {
                self.places[row] = Some(self.known.len());
                self.known.push(row);
                self.values.resize(self.known.len() * stride, self.least[row]);
            }
        }
        for (row, values) in self.known.iter().zip(self.values.chunks_exact_mut(stride)) {
            let values = values[first..][..LANES].iter_mut();
            for (value, g) in values.zip(self.g[*row].0) {
                let scaled = g / scales[*row];
                // Comparisons would ignore a NaN.
                *value = if scaled.is_nan() { f64::INFINITY } else { scaled };
            }
        }
    }

    /// The values of a row at the last times; `None` if it was at its least one.
    pub fn of_row(&self, row: usize) -> Option<&[f64]> {
        let place = self.places[row]?;
        Some(&self.values[place * self.stride..][..self.stride])
    }
}
