//! The dynamics and their first and second derivatives, on robots of 2 to 128 joints.
//!
//! `cargo bench --bench dynamics` measures and prints the medians in microseconds at the end.

mod common;

use aghf::constraint::{FootDerivatives, FootWeights, StandingFoot};
use aghf::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, InverseDynamicsSecondDerivatives,
    RneaWeightedHessian, aba, aba_derivatives, crba, mass_matrix_and_rate, mass_matrix_product_derivative, rnea,
    rnea_derivatives, rnea_second_derivatives, rnea_weighted_hessian,
};
use aghf::spatial::Placement;
use common::{Times, criterion, measure, models, report, wave};
use nalgebra::DMatrix;
use std::hint::black_box;

/// Explicit tensors of third order take too much memory on larger robots to be of use.
const MAX_FOR_TENSORS: usize = 32;

/// A sole below the base.
fn sole() -> StandingFoot {
    StandingFoot {
        name: "foot".to_owned(),
        sole: Placement::identity(),
        half_length: 0.1,
        half_width: 0.05,
        friction: 0.7,
        torsion: Some(0.05),
        weight: 100.0,
    }
}

fn main() {
    let mut criterion = criterion();
    let mut times = Times::new();
    for model in &models() {
        let n = model.dof();
        let [q, v, a, w] = [0.7, 1.3, 2.1, 0.4].map(|f| wave(n, f));
        let (mut data, mut tau) = (Data::new(model), vec![0.0; n]);
        let [mut h, mut hdot] = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
        let mut id = InverseDynamicsDerivatives::new(n);
        let mut fd = ForwardDynamicsDerivatives::new(n);
        let mut hessian = RneaWeightedHessian::new(n);
        let mut time = |what: &str, call: &mut dyn FnMut() -> aghf::Result<()>| {
            measure(&mut criterion, &mut times, what, n, || {
                call().expect("lengths agree");
            });
        };
        time("rnea", &mut || rnea(model, &mut data, black_box(&q), &v, &a, &mut tau));
        time("crba", &mut || crba(model, &mut data, black_box(&q), &mut h));
        time("aba", &mut || aba(model, &mut data, black_box(&q), &v, &w, &mut tau));
        time("mass_matrix_and_rate", &mut || {
            mass_matrix_and_rate(model, &mut data, black_box(&q), &v, &mut h, &mut hdot)
        });
        time("mass_matrix_product_derivative", &mut || {
            mass_matrix_product_derivative(model, &mut data, black_box(&q), &w, &mut h)
        });
        time("rnea_derivatives", &mut || rnea_derivatives(model, &mut data, black_box(&q), &v, &a, &mut id));
        time("aba_derivatives", &mut || aba_derivatives(model, &mut data, black_box(&q), &v, &w, &mut fd));
        time("rnea_weighted_hessian", &mut || {
            rnea_weighted_hessian(model, &mut data, black_box(&q), &v, &a, &w, &mut hessian)
        });
        let (foot, mut by_z) = (sole(), FootDerivatives::new(n));
        let mut g = vec![0.0; foot.dim()];
        time("standing_foot", &mut || foot.value(model, &mut data, [black_box(&q), &v, &a], &mut g));
        let weights = FootWeights { slopes: &[1.0; 8], multipliers: &[0.5; 8], curvatures: &[2.0; 8] };
        time("standing_foot_derivatives", &mut || {
            let z = [black_box(&q[..]), &v, &a];
            foot.weighted_derivatives(model, &mut data, z, weights, &mut by_z)
        });
        if n <= MAX_FOR_TENSORS {
            let mut second = InverseDynamicsSecondDerivatives::new(n);
            time("rnea_second_derivatives", &mut || {
                rnea_second_derivatives(model, &mut data, black_box(&q), &v, &a, &mut second)
            });
        }
    }
    criterion.final_summary();
    report(&mut times);
}
