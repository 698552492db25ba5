//! The smallest curvature of a minimum.

use crate::transcription::Derivatives;
use nalgebra::DVector;

/// The smallest eigenvalue of the Hessian relative to the Gauss-Newton metric, and its eigenvector, by inverse
/// iteration.
pub(super) fn smallest(derivatives: &Derivatives<f64>) -> (f64, DVector<f64>) {
    let Derivatives {
        hessian, metric, ..
    } = derivatives;
    let mut factor = hessian.clone();
    let mut shift: f64 = 0.0;
    loop {
        factor.set_sum(hessian, shift, metric);
        if factor.factorise() || shift > 1e12 {
            break;
        }
        shift = (4.0 * shift).max(0.1);
    }
    let mut x = DVector::from_fn(hessian.order(), |i, _| (1.0 + i as f64).sin());
    let mut curvature = f64::INFINITY;
    for _ in 0..100 {
        let mut y = metric.product(&x);
        factor.solve(&mut y);
        let norm = y.dot(&metric.product(&y)).sqrt();
        x = y / norm;
        let now = x.dot(&hessian.product(&x));
        let settled = (curvature - now).abs() <= 1e-3 * (now + shift).abs();
        curvature = now;
        if settled {
            break;
        }
    }
    (curvature, x)
}
