//! Spatial algebra: invariance under a change of frame, and the products as rates of change.

use crate::common::{config, numbers};
use aghf::spatial::{ArticulatedInertia, Coriolis, Force, Inertia, Motion, Placement};
use nalgebra::{Matrix3, Rotation3, Vector3};
use num_dual::Dual64;
use proptest::prelude::*;

fn vector(x: &[f64]) -> Vector3<f64> {
    Vector3::from_column_slice(&x[..3])
}

fn motion(x: &[f64]) -> Motion<f64> {
    Motion::new(vector(x), vector(&x[3..]))
}

fn placement(x: &[f64]) -> Placement<f64> {
    Placement::new(Rotation3::new(vector(x)).into_inner(), vector(&x[3..]))
}

/// A body of four particles, and the particles.
fn particles(x: &[f64]) -> Vec<(f64, Vector3<f64>)> {
    x.chunks(4).map(|p| (p[0].abs() + 0.1, vector(&p[1..]))).collect()
}

/// The inertia of particles, summed from that of each.
fn body(particles: &[(f64, Vector3<f64>)]) -> Inertia<f64> {
    let one = |(mass, r): &(f64, Vector3<f64>)| Inertia::from_com(*mass, *r, Matrix3::zeros());
    particles.iter().map(one).fold(Inertia::zero(), |sum, i| sum + i)
}

fn close(a: Force<f64>, b: Force<f64>) {
    let size = 1.0 + b.angular.amax() + b.linear.amax();
    let difference = a - b;
    let error = difference.angular.amax().max(difference.linear.amax());
    assert!(error <= 1e-12 * size, "{a:?} {b:?}");
}

/// The placement of a frame that moves from `at` with spatial velocity `v`, as a dual number in time.
fn moving(at: &Placement<f64>, v: &Motion<f64>) -> Placement<Dual64> {
    let rotation_rate = aghf::spatial::cross_matrix(&v.angular) * at.rotation;
    let translation_rate = v.linear + v.angular.cross(&at.translation);
    Placement::new(
        at.rotation.zip_map(&rotation_rate, Dual64::new),
        at.translation.zip_map(&translation_rate, Dual64::new),
    )
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn inertia_is_that_of_the_particles(x in numbers(16), v in numbers(6)) {
        let (particles, v) = (particles(&x), motion(&v));
        let by_hand = particles.iter().fold(Force::zero(), |sum, (mass, r)| {
            let momentum = (v.linear + v.angular.cross(r)) * *mass;
            sum + Force::new(r.cross(&momentum), momentum)
        });
        close(body(&particles).apply(&v), by_hand);
        let six = body(&particles).to_matrix() * nalgebra::Vector6::from_iterator(
            v.angular.iter().chain(v.linear.iter()).copied());
        close(Force::new(six.fixed_rows::<3>(0).into(), six.fixed_rows::<3>(3).into()), by_hand);
    }

    #[test]
    fn a_placed_inertia_is_that_of_the_placed_particles(x in numbers(16), at in numbers(6), v in numbers(6)) {
        let (at, v) = (placement(&at), motion(&v));
        let place = |(mass, r): &(f64, Vector3<f64>)| (*mass, at.rotation * r + at.translation);
        let placed: Vec<_> = particles(&x).iter().map(place).collect();
        close(body(&particles(&x)).placed(&at).apply(&v), body(&placed).apply(&v));
    }

    #[test]
    fn placements_compose(a in numbers(6), b in numbers(6), m in numbers(6)) {
        let (a, b, m) = (placement(&a), placement(&b), motion(&m));
        let (once, twice) = (a.compose(&b).act(&m), a.act(&b.act(&m)));
        prop_assert!((once - twice).angular.amax() < 1e-12 && (once - twice).linear.amax() < 1e-11);
        prop_assert_eq!(a.compose(&b), a.compose_constant(&b));
    }

    /// `v x m` is the rate of change of a motion that is fixed to a moving frame.
    #[test]
    fn the_motion_product_is_a_rate(at in numbers(6), v in numbers(6), m in numbers(6)) {
        let (at, v, m) = (placement(&at), motion(&v), motion(&m));
        let lift = |x: &Vector3<f64>| x.map(Dual64::from);
        let carried = moving(&at, &v).act(&Motion::new(lift(&m.angular), lift(&m.linear)));
        let rate = Motion::new(carried.angular.map(|x| x.eps), carried.linear.map(|x| x.eps));
        let product = v.cross(&at.act(&m));
        prop_assert!((rate - product).angular.amax() < 1e-11 && (rate - product).linear.amax() < 1e-10);
    }

    /// The force product is dual to the motion product: `(v x m) . f + m . (v x* f) = 0`.
    #[test]
    fn the_two_products_are_dual(v in numbers(6), m in numbers(6), f in numbers(6)) {
        let (v, m, f) = (motion(&v), motion(&m), Force::new(vector(&f), vector(&f[3..])));
        prop_assert!((v.cross(&m).dot(&f) + m.dot(&v.cross_force(&f))).abs() < 1e-11);
    }

    #[test]
    fn the_coriolis_matrix_is_its_definition(x in numbers(16), v in numbers(6), m in numbers(6)) {
        let (inertia, v, m) = (body(&particles(&x)), motion(&v), motion(&m));
        let coriolis = Coriolis::new(&inertia, &v);
        let twice = v.cross_force(&inertia.apply(&m)) - inertia.apply(&v.cross(&m))
            + m.cross_force(&inertia.apply(&v));
        close(coriolis.apply(&m) * 2.0, twice);
        close(coriolis.apply(&v), v.cross_force(&inertia.apply(&v)));
    }

    /// The inertia of a moving body changes by `B + B^T`.
    #[test]
    fn the_coriolis_matrix_gives_the_rate_of_inertia(x in numbers(16), at in numbers(6), v in numbers(6),
        m in numbers(6)) {
        let (at, v, m) = (placement(&at), motion(&v), motion(&m));
        let inertia = body(&particles(&x));
        let lift = |x: &Vector3<f64>| x.map(Dual64::from);
        let momentum = inertia.placed(&moving(&at, &v)).apply(&Motion::new(lift(&m.angular), lift(&m.linear)));
        let rate = Force::new(momentum.angular.map(|x| x.eps), momentum.linear.map(|x| x.eps));
        let coriolis = Coriolis::new(&inertia.placed(&at), &v);
        let transposed = Force::couple(coriolis.apply_transpose(&m));
        close(coriolis.apply(&m) + transposed, rate);
    }

    /// Moving a moving body with `s` adds the velocity of `s` to all its particles, and rotates their own velocities.
    #[test]
    fn a_coriolis_matrix_is_carried_along(x in numbers(16), v in numbers(6), s in numbers(6), m in numbers(6)) {
        let (inertia, v, s, m) = (body(&particles(&x)), motion(&v), motion(&s), motion(&m));
        let coriolis = Coriolis::new(&inertia, &v);
        let rate = s.cross_force(&coriolis.apply(&m)) - coriolis.apply(&s.cross(&m));
        close(coriolis.carried(&s).apply(&m), rate);
    }

    /// Beyond a free joint an acceleration along its axis requires no force, and no other acceleration requires a force
    /// along it.
    #[test]
    fn an_articulated_body_gives_way_along_the_axis(x in numbers(16), s in numbers(6), t in numbers(6),
        m in numbers(6)) {
        let (inertia, s, t, m) = (body(&particles(&x)), motion(&s), motion(&t), motion(&m));
        let mut articulated = ArticulatedInertia::new(&inertia);
        close(articulated.apply(&m), inertia.apply(&m));
        // Applied twice, so that it is no longer the inertia of a rigid body.
        let other = articulated.apply(&t);
        articulated += articulated.without(&other, 1.0 / t.dot(&other));
        let u = articulated.apply(&s);
        let apparent = articulated.without(&u, 1.0 / s.dot(&u));
        let expected = articulated.apply(&m) - u * (m.dot(&u) / s.dot(&u));
        close(apparent.apply(&m), expected);
        let size = 1.0 + u.angular.amax() + u.linear.amax();
        let left = apparent.apply(&s);
        prop_assert!(left.angular.amax().max(left.linear.amax()) < 1e-11 * size);
    }
}
