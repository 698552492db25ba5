//! The collocated system.

use crate::common::{config, dual_jacobian, numbers, robot};
use aghf::curve::Chebyshev;
use aghf::flow::jacobian::{JacobianKind, NodeBlocks};
use aghf::flow::{Collocation, ControlForm, assemble_jacobian};
use nalgebra::DMatrix;
use num_dual::Dual64;
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(64))]

    /// The assembled matrix is the Jacobian of the whole collocated system, differentiated as one function.
    #[test]
    fn the_assembled_jacobian_is_that_of_the_system(
        p in 3..6_usize,
        name in prop::sample::select(vec!["pendulum_1", "pendulum_3", "kinova_gen3"]),
        values in numbers(14 * 6),
        k in prop::sample::select(vec![1.0, 1e4]),
    ) {
        let model = robot(name);
        let m = 2 * model.dof();
        let c = Chebyshev::new(p, 2.0).expect("valid");
        let (start, goal) = (&values[..m], &values[m..2 * m]);
        let unknowns: Vec<f64> = values.iter().cycle().skip(2 * m).take(m * (p - 1)).copied().collect();

        let mut collocation = Collocation::<f64, f64>::new(&c, start, goal).expect("valid");
        collocation.set(&unknowns).expect("valid");
        let size = collocation.unknowns();

        let whole = |unknowns: &[Dual64]| {
            let dual = crate::common::constants;
            let mut system = Collocation::<f64, Dual64>::new(&c, &dual(start), &dual(goal)).expect("valid");
            system.set(unknowns).expect("valid");
            let mut out = vec![Dual64::from(0.0); size];
            system.rates(&mut ControlForm::new(&model), k, &mut out).expect("valid");
            out
        };
        let truth = dual_jacobian(whole, &unknowns);
        for (name, kind) in JacobianKind::by_name() {
            let (mut assembled, mut blocks) = (DMatrix::zeros(size, size), NodeBlocks::new(model.dof()));
            let jacobian = &mut *kind.build(&model);
            assemble_jacobian(&collocation, jacobian, k, &mut blocks, &mut assembled).expect("valid");
            // Differences of numbers of the size of D^2 keep half of their digits.
            let bound = if kind == JacobianKind::Difference { 1e-5 } else { 1e-9 };
            let error = crate::common::relative_error(&assembled, &truth);
            prop_assert!(error <= bound, "{name} is off by {error:e}");
        }
    }
}
