//! The robots with passive joints have the equations of motion of the textbooks.

use aghf::dynamics::{Data, rnea};
use aghf::urdf::builtin_robot;

/// The gravity of the robots, m/s^2.
const G: f64 = 9.81;

/// Inverse dynamics of a built-in robot.
fn torques<const N: usize>(name: &str, q: [f64; N], v: [f64; N], a: [f64; N]) -> [f64; N] {
    let model = builtin_robot(name).expect("built in");
    let mut u = [0.0; N];
    rnea(&model, &mut Data::new(&model), &q, &v, &a, &mut u).expect("lengths agree");
    u
}

fn assert_close<const N: usize>(found: [f64; N], expected: [f64; N]) {
    for (a, b) in found.iter().zip(&expected) {
        assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{found:?}, {expected:?}");
    }
}

/// Inverse dynamics, by Spong's formulas, of two rods of 1 kg, the first of 1 m, the second of this length.
fn two_rods(length: f64, q: [f64; 2], v: [f64; 2], a: [f64; 2]) -> [f64; 2] {
    let (first, half) = (0.5, 0.5 * length);
    let (inertia_1, inertia_2) = (1.0 / 12.0, length * length / 12.0);
    let (s2, c2) = q[1].sin_cos();
    let d22 = inertia_2 + half * half;
    let d12 = d22 + half * c2;
    let d11 = inertia_1 + first * first + d22 + 1.0 + 2.0 * half * c2;
    let h = half * s2;
    let both = G * half * (q[0] + q[1]).sin();
    [
        d11 * a[0] + d12 * a[1] - h * (2.0 * v[0] * v[1] + v[1] * v[1]) + G * (first + 1.0) * q[0].sin() + both,
        d12 * a[0] + d22 * a[1] + h * v[0] * v[0] + both,
    ]
}

#[test]
fn acrobot_and_pendubot_are_two_rods() {
    let (q, v, a): ([f64; 2], [f64; 2], [f64; 2]) = ([0.4, -1.1], [0.7, 1.9], [-0.3, 2.1]);
    assert_close(torques("acrobot", q, v, a), two_rods(2.0, q, v, a));
    assert_close(torques("pendubot", q, v, a), two_rods(1.0, q, v, a));
}

/// Kelly's equations of the cart-pole, the second of which is divided by the mass and the length of the pole.
#[test]
fn the_cart_pole_is_that_of_its_source() {
    let (q, v, a): ([f64; 2], [f64; 2], [f64; 2]) = ([0.3, 0.8], [1.2, -2.3], [0.9, 1.7]);
    let (cart, pole, length) = (1.0, 0.3, 0.5);
    let (s, c) = q[1].sin_cos();
    let force = (cart + pole) * a[0] + pole * length * (c * a[1] - s * v[1] * v[1]);
    let passive = length * a[1] + c * a[0] + G * s;
    assert_close(torques("cart_pole", q, v, a), [force, pole * length * passive]);
    let limits = builtin_robot("cart_pole").expect("built in").joints()[0].limits().to_owned();
    assert_eq!((limits.lower, limits.upper, limits.effort), (-2.0, 2.0, 20.0));
}

/// The lateral force is along the body's own x axis, the normal force is the thrust, and the torque of the pitch is the
/// moment of both about the origin of the base plus that of the thrusters.
#[test]
fn the_rotorcraft_floats() {
    let (q, v, a): ([f64; 3], [f64; 3], [f64; 3]) = ([0.6, 1.3, -0.7], [1.1, -0.4, 0.9], [-2.0, 0.8, 1.5]);
    let ([theta, x, z], [w, dx, dz], [dw, ddx, ddz]) = (q, v, a);
    let (mass, inertia) = (1.0, 0.02);
    // The acceleration of the centre in the axes of the body, minus that of free fall.
    let lateral = mass * (ddx + 2.0 * w * dz + dw * z - w * w * x - G * theta.sin());
    let thrust = mass * (ddz - 2.0 * w * dx - dw * x - w * w * z + G * theta.cos());
    let moment = inertia * dw;
    let expected = [moment + z * lateral - x * thrust, lateral, thrust];
    assert_close(torques("planar_rotorcraft", q, v, a), expected);
    let model = builtin_robot("planar_rotorcraft").expect("built in");
    let names: Vec<_> = model.joints().iter().map(|joint| joint.name()).collect();
    assert_eq!(names, ["pitch", "lateral", "normal"]);
}
