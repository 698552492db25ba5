//! Random configurations for the trees.

use super::distance;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// The configurations among which trees between two ends sample.
#[derive(Clone, Debug)]
pub struct Sampler<'a> {
    /// The first and the last configuration of a path.
    pub ends: [&'a [f64]; 2],
    /// The least and the largest position per joint; both ends are within.
    pub ranges: Vec<[f64; 2]>,
    /// The length of the shortest path that is known: only configurations on shorter ones are sampled.
    pub shortest: Option<f64>,
}

impl Sampler<'_> {
    /// Samples a configuration of `N` entries, as many as each end has. Cost: O(N).
    pub fn sample(&self, q: &mut [f64], rng: &mut ChaCha8Rng) {
        match self.shortest {
            Some(length) => self.within(length, q, rng),
            None => {
                for (q, [least, most]) in q.iter_mut().zip(&self.ranges) {
                    *q = least + (most - least) * rng.random::<f64>();
                }
            }
        }
    }

    /// Samples evenly among the configurations on paths of at most this length, a spheroid with the ends as its foci
    /// (Gammell, Srinivasa and Barfoot, *Informed RRT\**, IROS 2014, Algorithm 2). Those outside the ranges are taken
    /// to their bounds, which brings them no farther from either end.
    fn within(&self, length: f64, q: &mut [f64], rng: &mut ChaCha8Rng) {
        let [from, to] = self.ends;
        let (n, far) = (q.len(), distance(from, to));
        // Normally distributed numbers, by the method of Box and Muller, have all directions alike.
        for q in q.iter_mut() {
            let [u, turn] = [(); 2].map(|()| rng.random::<f64>());
            *q = (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * turn).cos();
        }
        let norm = q.iter().map(|q| q * q).sum::<f64>().sqrt();
        let radius = rng.random::<f64>().powf(1.0 / n as f64);
        let semi_axis = |square: f64| 0.5 * square.sqrt() * radius / norm;
        let along = semi_axis(length * length);
        let across = semi_axis(length * length - far * far);
        let dot: f64 = (0..n).map(|i| q[i] * (to[i] - from[i])).sum();
        for (i, q) in q.iter_mut().enumerate() {
            let (centre, chord) = (0.5 * (from[i] + to[i]), to[i] - from[i]);
            let [least, most] = self.ranges[i];
            *q = centre + across * *q + (along - across) * dot / (far * far) * chord;
            *q = q.clamp(least, most);
        }
    }
}
