//! Limits on the power of the motors: values and derivatives are those of the product, by duals.

use crate::common::robot;
use aghf::constraint::{PowerLimits, Quantity, StageConstraint, StageInput, StageRows};
use nalgebra::DMatrix;
use proptest::prelude::*;

const LIMITS: [Option<f64>; 3] = [Some(2.0), None, Some(0.5)];

proptest! {
    #[test]
    fn derivatives_are_those_of_the_product(
        y in prop::collection::vec(-3.0..3.0, 12),
        weights in prop::array::uniform4(-2.0..2.0),
    ) {
        let parts: [&[f64]; 4] = std::array::from_fn(|k| &y[3 * k..3 * k + 3]);
        let [q, v, a, u] = parts;
        let at = StageInput { t: 0.0, q, v, a, u };
        let own = PowerLimits(LIMITS.to_vec());
        let product = StageRows::new("product", vec![2.0, 2.0, 0.5, 0.5], |at, g| {
            let rows = [(0, 1.0, 2.0), (0, -1.0, 2.0), (2, 1.0, 0.5), (2, -1.0, 0.5)];
            for (g, (joint, sign, limit)) in g.iter_mut().zip(rows) {
                *g = at.u[joint] * at.v[joint] * sign - limit;
            }
        });
        let found = [&own as &dyn StageConstraint, &product].map(|rows| {
            let mut g = vec![0.0; 4];
            let (mut gradients, mut hessian) = (DMatrix::zeros(12, 4), DMatrix::zeros(12, 12));
            rows.value(&at, &mut g).expect("three joints");
            rows.derivatives(&at, &weights, &mut gradients, &mut hessian).expect("three joints");
            let scales: Vec<f64> = (0..rows.dim()).map(|row| rows.scale(row)).collect();
            (DMatrix::from_vec(4, 1, g), gradients, hessian, scales)
        });
        let [(g, gradients, hessian, scales), expected] = found;
        assert_close!(&g, &expected.0, 1e-14);
        assert_close!(&gradients, &expected.1, 1e-14);
        assert_close!(&hessian, &expected.2, 1e-14);
        prop_assert_eq!(scales, expected.3);
    }
}

#[test]
fn rows_have_names_and_units() {
    let model = robot("pendulum_3");
    let label = PowerLimits(LIMITS.to_vec()).label(3, &model);
    assert_eq!((label.unit, label.quantity, label.joint), ("W", Quantity::Power, Some(2)));
    assert_eq!(label.name, format!("lower power limit of joint '{}'", model.joints()[2].name()));
}
