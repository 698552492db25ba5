//! The wrench of the root at rest, side by side, and wrong lengths. Its laws and derivatives are tested in
//! `derivatives` and by the ledger.

use crate::common::{assert_refused, config, model_and_state, robot};
use aghf::dynamics::{
    Data, RneaWeightedHessian, RootWrenchDerivatives, forward_kinematics, root_wrench, root_wrench_second_order,
};
use aghf::scalar::Wide;
use aghf::spatial::{Force, Inertia, Motion, Placement};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(64))]

    /// At rest it is the weight at the centre of mass; lanes and both functions agree.
    #[test]
    fn the_weight_of_all_bodies_holds_the_root((model, q, v, a) in model_and_state()) {
        let base = Inertia::from_com(3.0, Vector3::new(0.2, -0.4, 0.7), Matrix3::identity());
        let model = model.with_base_inertia(base);
        let n = model.dof();
        let still = vec![0.0; n];
        let found = root_wrench(&model, &mut Data::new(&model), &q, &still, &still).expect("lengths");
        let mut bodies = vec![Placement::identity(); n];
        forward_kinematics(&model, &q, &mut bodies).expect("lengths");
        let (mut mass, mut first) = (base.mass, base.first_moment);
        for (body, inertia) in bodies.iter().zip(model.inertias()) {
            mass += inertia.mass;
            first += body.rotation * inertia.first_moment + body.translation * inertia.mass;
        }
        assert_close!(&found.linear, &(-model.gravity() * mass), 1e-12);
        assert_close!(&found.angular, &-first.cross(model.gravity()), 1e-11);

        let moving = root_wrench(&model, &mut Data::new(&model), &q, &v, &a).expect("lengths");
        let wide = |x: &[f64]| x.iter().map(|x| Wide::splat(*x)).collect::<Vec<_>>();
        let (q, v, a) = (wide(&q), wide(&v), wide(&a));
        let (mut out, mut second) = (RootWrenchDerivatives::new(n), RneaWeightedHessian::new(n));
        let data = &mut Data::new(&model);
        let none = |_: &Force<Wide>| Motion::zero();
        root_wrench_second_order(&model, data, [&q, &v, &a], none, &mut out, &mut second)
            .expect("lengths");
        assert_close!(&out.wrench.linear.map(|x| x.0[3]), &moving.linear, 1e-12);
        assert_close!(&out.wrench.angular.map(|x| x.0[1]), &moving.angular, 1e-12);
    }
}

#[test]
fn wrong_lengths_are_errors() {
    let model = robot("pendulum_2");
    let (data, x) = (&mut Data::new(&model), [0.0; 2]);
    let short = root_wrench(&model, data, &x, &x[..1], &x);
    assert_refused(short, "v: expected 2 entries, found 1");
    let (mut first, mut second) = (RootWrenchDerivatives::new(1), RneaWeightedHessian::new(2));
    let still = |_: &Force<f64>| Motion::zero();
    let small = root_wrench_second_order(&model, data, [&x; 3].map(|x| &x[..]), still, &mut first, &mut second);
    assert_refused(small, "columns of jacobian: expected 6 entries, found 3");
}
