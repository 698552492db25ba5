//! Certificates, and the checker that shares no code with what writes them.

#[path = "../judge/gantry.rs"]
mod gantry;

mod checker;
mod search;

use aghf::curve::{Chebyshev, Curve};
use gantry::{FROM, TO};
use nalgebra::DMatrix;
use serde_json::{Value, json};

/// The curve of a motion, given as positions and velocities of the joints, over `horizon`.
fn curve(joints: usize, degree: usize, horizon: f64, at: impl Fn(usize, f64) -> [f64; 2]) -> Curve {
    let chebyshev = Chebyshev::new(degree, horizon).expect("it is in range");
    let times = chebyshev.times().to_vec();
    let x = DMatrix::from_fn(2 * joints, degree + 1, |i, k| {
        let [q, v] = at(i % joints, times[k]);
        if i < joints { q } else { v }
    });
    Curve::new(chebyshev, x).expect("it has a column per node")
}

/// From rest to rest in 1 s by a polynomial of degree five.
fn smooth() -> Curve {
    curve(3, 8, 1.0, |i, t| {
        let way = TO[i] - FROM[i];
        let rise = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
        [FROM[i] + way * rise, way * 30.0 * (t * (1.0 - t)).powi(2)]
    })
}

/// The part of a summary that has the motion.
fn run(curve: &Curve, joints: &[&str]) -> Value {
    let segment = |e: usize| -> Vec<Vec<f64>> {
        let all = curve.coefficients(e);
        all.row_iter()
            .map(|row| row.iter().copied().collect())
            .collect()
    };
    let coefficients: Vec<_> = (0..curve.segments()).map(segment).collect();
    json!({ "curve": { "horizon_s": curve.horizon(), "joints": joints, "coefficients": coefficients } })
}
