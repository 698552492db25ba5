//! The smallest curvature of a minimum.

use crate::nlp::{Bordered, Memory};
use nalgebra::DVector;

/// The smallest eigenvalue of the Hessian relative to the Gauss-Newton metric, by inverse iteration.
pub(super) fn smallest(hessian: &Bordered, metric: &Bordered) -> f64 {
    let (mut factor, mut memory) = (hessian.clone(), Memory::new(hessian));
    let mut shift: f64 = 0.0;
    loop {
        factor.set_sum(hessian, shift, metric);
        if factor.factorise(&mut memory) || shift > 1e12 {
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
    curvature
}
