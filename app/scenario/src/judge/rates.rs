//! Rates of positions that are given alone, and how well the samples determine them.

/// The number of neighbouring samples through which a polynomial is differentiated.
const NEIGHBOURS: usize = 5;

/// The rates of one quantity at the samples.
///
/// A deviation that alternates between $\pm A$ from sample to sample may be part of the motion or not: a polynomial
/// through five samples averages it out. The fourth divided difference of five samples, divided by the sum of the
/// magnitudes of its weights, is the `A` of an alternating deviation that explains it; it is zero only on a cubic. A
/// derivative of order `m` is therefore uncertain by $A (2 / h)^m$, with the shortest interval `h` of these samples.
pub(super) struct Rates {
    /// The first and second derivatives at each sample, of the polynomial of degree four through [`NEIGHBOURS`] of
    /// them.
    pub derivatives: Vec<[f64; 2]>,
    /// For each interval the largest `A` of the windows of five samples that contain one of its ends, infinite if there
    /// are fewer samples, and the largest $2 / h$.
    uncertain: Vec<[f64; 2]>,
}

impl Rates {
    /// Differentiates samples at ascending times. Cost O(1) per sample.
    pub fn new(times: &[f64], samples: &[f64]) -> Self {
        let (count, all) = (NEIGHBOURS.min(times.len()), times.len());
        let first = |k: usize| k.saturating_sub(count / 2).min(all - count);
        let derivatives = (0..all).map(|k| {
            let window = first(k)..first(k) + count;
            let weights = derivative_weights(&times[window.clone()], k - window.start);
            let mut found = [0.0; 2];
            for (weights, x) in weights.iter().zip(&samples[window]) {
                found[0] += weights[0] * x;
                found[1] += weights[1] * x;
            }
            found
        });
        let windows = all.saturating_sub(NEIGHBOURS - 1);
        let amplitudes: Vec<f64> =
            (0..windows).map(|k| amplitude(&times[k..k + NEIGHBOURS], &samples[k..k + NEIGHBOURS])).collect();
        let uncertain = (0..all - 1).map(|k| {
            // The windows with sample k or k + 1, and all samples in them.
            let from = (k + 1).saturating_sub(NEIGHBOURS);
            let own = &amplitudes[from.min(windows)..(k + 2).min(windows)];
            let steps = times[from..all.min(k + 1 + NEIGHBOURS)].windows(2);
            let shortest = steps.map(|t| t[1] - t[0]).fold(f64::INFINITY, f64::min);
            let largest = own.iter().copied().reduce(f64::max);
            [largest.unwrap_or(f64::INFINITY), 2.0 / shortest]
        });
        Self { derivatives: derivatives.collect(), uncertain: uncertain.collect() }
    }

    /// The uncertainty of the derivative of this order on interval `k`.
    pub fn error(&self, k: usize, order: usize) -> f64 {
        let [amplitude, rate] = self.uncertain[k];
        amplitude * rate.powi(order as i32)
    }
}

/// The amplitude of the alternating deviation that has the same fourth divided difference.
fn amplitude(times: &[f64], samples: &[f64]) -> f64 {
    let weight = |j: usize| -> f64 {
        let others = (0..times.len()).filter(|m| *m != j);
        others.map(|m| times[j] - times[m]).product::<f64>().recip()
    };
    let weights = (0..times.len()).map(weight);
    let (mut difference, mut sum) = (0.0, 0.0);
    for (weight, x) in weights.zip(samples) {
        difference += weight * x;
        sum += weight.abs();
    }
    difference.abs() / sum
}

/// The divided differences of these samples times the factorial of the `order`, with the index of their first sample:
/// any motion through the samples has this mean of its derivative of that order, and therefore exceeds it somewhere
/// between the first and the last of its samples, or has it everywhere.
pub(super) fn means(times: &[f64], samples: &[f64], order: usize) -> Vec<f64> {
    let mut means = samples.to_vec();
    for m in 1..=order.min(times.len() - 1) {
        for k in 0..times.len() - m {
            means[k] = m as f64 * (means[k + 1] - means[k]) / (times[k + m] - times[k]);
        }
        means.pop();
    }
    if order < times.len() { means } else { Vec::new() }
}

/// The weights of the values at `times` in the first and second derivatives of the polynomial through them at time `k`.
fn derivative_weights(times: &[f64], k: usize) -> Vec<[f64; 2]> {
    let others = |j: usize| (0..times.len()).filter(move |m| *m != j);
    let own: f64 = others(k).map(|m| (times[k] - times[m]).recip()).sum();
    let weight = |j: usize| {
        let product: f64 =
            others(j).filter(|m| *m != k).map(|m| (times[k] - times[m]) / (times[j] - times[m])).product();
        let first = product / (times[j] - times[k]);
        // Welfert, Generation of pseudospectral differentiation matrices I, 1997, eq. 5.
        [first, 2.0 * first * (own - (times[k] - times[j]).recip())]
    };
    let mut weights: Vec<[f64; 2]> = (0..times.len()).map(|j| if j == k { [own, 0.0] } else { weight(j) }).collect();
    weights[k][1] = -weights.iter().map(|weight| weight[1]).sum::<f64>();
    weights
}
