//! Physics identities of the dynamics.

use crate::common::{assert_refused, config, constants, dual_jacobian, dual_rate, model_and_state};
use aghf::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, aba, aba_derivatives, bias, crba, forward_kinematics,
    frame_jacobian, frame_placement, kinetic_energy, mass_matrix_and_rate, potential_energy, rnea, rnea_derivatives,
};
use aghf::model::{Frame, Model};
use aghf::scalar::AlgebraOver;
use aghf::spatial::Placement;
use nalgebra::{DMatrix, DVector, Matrix3};
use num_dual::Dual64;
use proptest::prelude::*;

fn rnea_of<S: AlgebraOver<f64>>(model: &Model, q: &[S], v: &[S], a: &[S]) -> Vec<S> {
    let mut tau = vec![S::zero(); model.dof()];
    rnea(model, &mut Data::new(model), q, v, a, &mut tau).expect("lengths agree");
    tau
}

fn aba_of<S: AlgebraOver<f64>>(model: &Model, q: &[S], v: &[S], tau: &[S]) -> Vec<S> {
    let mut a = vec![S::zero(); model.dof()];
    aba(model, &mut Data::new(model), q, v, tau, &mut a).expect("lengths agree");
    a
}

fn crba_of<S: AlgebraOver<f64>>(model: &Model, q: &[S]) -> DMatrix<S> {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h).expect("lengths agree");
    h
}

fn id_derivatives(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> InverseDynamicsDerivatives<f64> {
    let mut id = InverseDynamicsDerivatives::new(model.dof());
    rnea_derivatives(model, &mut Data::new(model), q, v, a, &mut id).expect("lengths agree");
    id
}

/// The rounding error of `H^-1`: its condition number times machine precision, with some slack for the recursion.
fn solve_bound(h: &DMatrix<f64>) -> f64 {
    let eigenvalues = h.symmetric_eigenvalues();
    1e-14 * (h.nrows() as f64) * eigenvalues.max() / eigenvalues.min() + 1e-11
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn rnea_is_mass_times_acceleration_plus_bias((model, q, v, a) in model_and_state()) {
        let mut c = vec![0.0; model.dof()];
        bias(&model, &mut Data::new(&model), &q, &v, &mut c).expect("lengths agree");
        let tau = crba_of(&model, &q) * DVector::from_vec(a.clone()) + DVector::from_vec(c);
        assert_close!(&rnea_of(&model, &q, &v, &a), &tau, 1e-11);
    }

    #[test]
    fn aba_inverts_rnea((model, q, v, a) in model_and_state()) {
        let bound = solve_bound(&crba_of(&model, &q));
        let tau = rnea_of(&model, &q, &v, &a);
        assert_close!(&aba_of(&model, &q, &v, &tau), &a, bound * tau.iter().fold(1.0, |m, t| t.abs().max(m)));
    }

    #[test]
    fn the_mass_matrix_is_symmetric_positive_definite((model, q, _, _) in model_and_state()) {
        let h = crba_of(&model, &q);
        prop_assert_eq!(&h, &h.transpose());
        // Massless links and point masses can make it singular up to rounding, but never indefinite.
        let eigenvalues = h.symmetric_eigenvalues();
        prop_assert!(eigenvalues.min() > -1e-14 * eigenvalues.max());
    }

    #[test]
    fn the_mass_matrix_is_the_derivative_of_rnea_in_a((model, q, v, a) in model_and_state()) {
        let by_duals = dual_jacobian(|a| rnea_of(&model, &constants(&q), &constants(&v), a), &a);
        assert_close!(&crba_of(&model, &q), &by_duals, 1e-11);
        assert_close!(&id_derivatives(&model, &q, &v, &a).h, &by_duals, 1e-11);
    }

    /// Without gravity, torques and losses the kinetic energy is constant; in general the rate of the energy is the
    /// power less that of the losses, which requires the skew symmetry of `Hdot - 2 C`. Losses never give power.
    #[test]
    fn power_is_the_rate_of_energy((model, q, v, a) in model_and_state()) {
        let energy = |state: &[Dual64]| {
            let (q, v) = state.split_at(model.dof());
            let mut data = Data::new(&model);
            let kinetic = kinetic_energy(&model, &mut data, q, v).expect("lengths agree");
            vec![kinetic + potential_energy(&model, &mut data, q).expect("lengths agree")]
        };
        let rate = dual_rate(energy, &[q.clone(), v.clone()].concat(), &[v.clone(), a.clone()].concat());
        let tau = rnea_of(&model, &q, &v, &a);
        let power: f64 = tau.iter().zip(&v).map(|(t, v)| t * v).sum();
        let size: f64 = tau.iter().zip(&v).map(|(t, v)| (t * v).abs()).sum();
        let losses = model.drives().iter().zip(&v).map(|(drive, v)| drive.losses(*v)[0] * v);
        let lost: f64 = losses.clone().sum();
        prop_assert!(losses.into_iter().all(|lost| lost >= 0.0));
        prop_assert!((rate[0] + lost - power).abs() <= 1e-11 * size.max(1.0), "{} {power}", rate[0]);
    }

    #[test]
    fn the_gravity_torque_is_the_gradient_of_potential_energy((model, q, _, _) in model_and_state()) {
        let potential = |q: &[Dual64]| {
            vec![potential_energy(&model, &mut Data::new(&model), q).expect("lengths agree")]
        };
        let zero = vec![0.0; model.dof()];
        assert_close!(&rnea_of(&model, &q, &zero, &zero), &dual_jacobian(potential, &q), 1e-11);
    }

    #[test]
    fn kinetic_energy_is_half_v_h_v((model, q, v, _) in model_and_state()) {
        let kinetic = kinetic_energy(&model, &mut Data::new(&model), &q, &v).expect("lengths agree");
        let vector = DVector::from_vec(v);
        let half = 0.5 * vector.dot(&(crba_of(&model, &q) * &vector));
        prop_assert!((kinetic - half).abs() <= 1e-11 * half.max(1.0));
    }

    /// The values returned with derivatives equal those of the plain functions.
    #[test]
    fn derivatives_have_the_values_beside_them((model, q, v, a) in model_and_state()) {
        let n = model.dof();
        let (h, data) = (crba_of(&model, &q), &mut Data::new(&model));
        let (mut again, mut hdot) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        mass_matrix_and_rate(&model, data, &q, &v, &mut again, &mut hdot).expect("lengths agree");
        assert_close!(&again, &h, 1e-13);
        assert_close!(&id_derivatives(&model, &q, &v, &a).tau, &rnea_of(&model, &q, &v, &a), 1e-11);
        let mut fd = ForwardDynamicsDerivatives::new(n);
        aba_derivatives(&model, data, &q, &v, &a, &mut fd).expect("lengths agree");
        assert_close!(&fd.a, &aba_of(&model, &q, &v, &a), 1e-10 + 10.0 * solve_bound(&h));
    }

    #[test]
    fn placements_are_rigid_and_move_as_the_axes_say((model, q, v, _) in model_and_state()) {
        let n = model.dof();
        let place = |q: &[Dual64]| {
            let mut placements = vec![Placement::identity(); n];
            forward_kinematics(&model, q, &mut placements).expect("lengths agree");
            placements
        };
        let moving: Vec<Dual64> = q.iter().zip(&v).map(|(q, v)| Dual64::new(*q, *v)).collect();
        // The velocity of every body as a sum over the joints before it.
        let mut velocities = vec![aghf::spatial::Motion::zero(); n];
        for (i, placement) in place(&moving).iter().enumerate() {
            let rotation = placement.rotation.map(|r| r.re);
            assert_close!(&(rotation.transpose() * rotation), &Matrix3::identity(), 1e-13);
            let at = Placement::new(rotation, placement.translation.map(|p| p.re));
            let joint = &model.joints()[i];
            velocities[i] = joint.motion_subspace(&at) * v[i];
            if let Some(parent) = joint.parent() {
                let carried = velocities[parent];
                velocities[i] += carried;
            }
            let linear = velocities[i].linear + velocities[i].angular.cross(&at.translation);
            assert_close!(&placement.translation.map(|p| p.eps), &linear, 1e-12);
            let turning = aghf::spatial::cross_matrix(&velocities[i].angular) * rotation;
            assert_close!(&placement.rotation.map(|p| p.eps), &turning, 1e-12);
        }
    }

    /// For every link and a user-defined frame, by dual numbers: the origin moves by the linear rows, the axes by the
    /// angular ones.
    #[test]
    fn frame_jacobians_are_derivatives_of_placements((model, q, _, _) in model_and_state()) {
        let n = model.dof();
        let tool = Frame::new("tool", Some(n - 1), *model.joints()[0].origin());
        for frame in model.frames().iter().chain([&tool]) {
            let mut jacobian = DMatrix::from_element(6, n, f64::NAN);
            frame_jacobian(&model, &mut Data::new(&model), &q, frame, &mut jacobian).expect("sizes agree");
            let place = |q: &[Dual64]| {
                let mut bodies = vec![Placement::identity(); n];
                forward_kinematics(&model, q, &mut bodies).expect("lengths agree");
                frame_placement(frame, &bodies).expect("its body is there")
            };
            let rotation = place(&constants(&q)).rotation.map(|r| r.re);
            let by_duals = dual_jacobian(|q| {
                let Placement { rotation: moved, translation } = place(q);
                let turning = moved * rotation.transpose().map(Dual64::from);
                vec![turning.m32, turning.m13, turning.m21, translation.x, translation.y, translation.z]
            }, &q);
            assert_close!(&jacobian, &by_duals, 1e-13);
        }
    }

    /// A workspace that was used before gives the same bits as a new one.
    #[test]
    fn a_used_workspace_gives_the_same_bits((model, q, v, a) in model_and_state()) {
        let n = model.dof();
        let run = |data: &mut Data<f64>, q: &[f64], v: &[f64], a: &[f64]| {
            let (mut tau, mut c, mut acc) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
            let (mut h, mut hdot) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
            let mut id = InverseDynamicsDerivatives::new(n);
            let mut fd = ForwardDynamicsDerivatives::new(n);
            rnea(&model, data, q, v, a, &mut tau).expect("lengths agree");
            bias(&model, data, q, v, &mut c).expect("lengths agree");
            aba(&model, data, q, v, a, &mut acc).expect("lengths agree");
            mass_matrix_and_rate(&model, data, q, v, &mut h, &mut hdot).expect("lengths agree");
            rnea_derivatives(&model, data, q, v, a, &mut id).expect("lengths agree");
            aba_derivatives(&model, data, q, v, a, &mut fd).expect("lengths agree");
            let energy = kinetic_energy(&model, data, q, v).expect("lengths agree");
            (tau, c, acc, h, hdot, id, fd, energy)
        };
        let mut used = Data::new(&model);
        run(&mut used, &a, &q, &v);
        prop_assert_eq!(run(&mut used, &q, &v, &a), run(&mut Data::new(&model), &q, &v, &a));
    }
}

/// The mass enters linearly, so the derivative of the torque with respect to a mass is known: `model.cast` must give
/// it.
#[test]
fn a_cast_model_differentiates_in_a_mass() {
    let model = crate::common::robot("pendulum_2");
    let mut heavier = model.cast::<Dual64>();
    heavier.inertias_mut()[1].mass.eps = 1.0;
    heavier.inertias_mut()[1].first_moment.x.eps = -0.5;
    heavier.inertias_mut()[1].rotational[(1, 1)].eps = 0.25;
    heavier.inertias_mut()[1].rotational[(2, 2)].eps = 0.25;
    let zero = [Dual64::from(0.0); 2];
    let mut tau = zero;
    rnea(&heavier, &mut Data::new(&heavier), &zero, &zero, &zero, &mut tau).expect("lengths agree");
    // The second mass is at x = -1.5 and -0.5 from the two axes; turning about +y lifts it.
    assert!((tau[0].eps - 1.5 * 9.81).abs() < 1e-13, "{}", tau[0]);
    assert!((tau[1].eps - 0.5 * 9.81).abs() < 1e-13, "{}", tau[1]);
}

/// The torques of a hand-computed case: a double pendulum with its first link level and the second hanging.
#[test]
fn a_double_pendulum_by_hand() {
    let model = crate::common::robot("pendulum_2");
    let tau = rnea_of(&model, &[0.0, -std::f64::consts::FRAC_PI_2], &[0.0; 2], &[0.0; 2]);
    // Masses at x = -0.5 and x = -1, which turning about +y lifts.
    assert!((tau[0] - 1.5 * 9.81).abs() < 1e-13, "{}", tau[0]);
    assert!(tau[1].abs() < 1e-13, "{}", tau[1]);
}

#[test]
fn wrong_lengths_are_errors_not_panics() {
    let model = crate::common::robot("pendulum_3");
    let mut data = Data::new(&model);
    let (good, bad) = ([0.0; 3], [0.0; 2]);
    let (mut tau, short) = ([0.0; 3], "expected 3 entries, found 2");
    for (q, v, a) in [(&bad[..], &good[..], &good[..]), (&good, &bad, &good), (&good, &good, &bad)] {
        assert_refused(rnea(&model, &mut data, q, v, a, &mut tau), short);
        assert_refused(aba(&model, &mut data, q, v, a, &mut tau), short);
    }
    let h = &mut DMatrix::zeros(3, 2);
    assert_refused(crba(&model, &mut data, &good, h), short);
    let mut of_frame = |q: &[f64], frame: &Frame<f64>, shape: (usize, usize), words: &str| {
        let jacobian = &mut DMatrix::zeros(shape.0, shape.1);
        assert_refused(frame_jacobian(&model, &mut data, q, frame, jacobian), words);
    };
    let nowhere = Frame::new("nowhere", Some(3), Placement::identity());
    let tip = &model.frames()[3];
    of_frame(&good, &nowhere, (6, 3), "expected 4 entries, found 3");
    of_frame(&bad, tip, (6, 3), short);
    of_frame(&good, tip, (3, 6), "expected 6 entries, found 3");
    let (other, h) = (crate::common::robot("pendulum_2"), &mut DMatrix::zeros(2, 2));
    let of_other = crba(&other, &mut data, &bad, h);
    assert_refused(of_other, "data: expected 2 entries, found 3");
}
