//! Helpers of all tests: robots, random states, comparisons and derivatives by duals.
#![allow(dead_code)] // every test file uses its own part of it

pub mod constraint;
pub mod direct;
pub mod ode;
pub mod scenario;

use aghf::dynamics::{Data, crba, rnea};
use aghf::flow::Node;
use aghf::model::{JointKind, JointSpec, Limits, Model, random_tree};
use aghf::spatial::{Inertia, Placement};
use aghf::urdf::{builtin_robot, builtin_robots};
use aghf::verify::duals::{Finding, State};
use nalgebra::{DMatrix, Matrix3, Vector3};
use num_dual::Dual64;
use proptest::prelude::*;
use proptest::test_runner::{Config, FailurePersistence, FileFailurePersistence, RngSeed};

/// Regressions of a property test in a file beside its source.
fn beside() -> Box<dyn FailurePersistence> {
    Box::new(FileFailurePersistence::WithSource("regressions"))
}

/// The settings of a property test: seeded, with `AGHF_CASES` cases if that is set.
pub fn config(cases: u32) -> Config {
    let cases =
        std::env::var("AGHF_CASES").map(|n| n.parse().expect("AGHF_CASES is a number of cases")).unwrap_or(cases);
    let default = Config::default();
    Config {
        cases,
        rng_seed: RngSeed::Fixed(20_261_121),
        // Beside the test, unless the environment says that nothing is kept.
        failure_persistence: default.failure_persistence.map(|_| beside()),
        ..default
    }
}

/// A built-in robot.
pub fn robot(name: &str) -> Model {
    builtin_robot(name).expect("it is built in")
}

/// One slider of mass `mass` along x, so without gravity: $u = m \ddot q$.
pub fn slider(mass: f64) -> Model {
    let spec = JointSpec {
        name: "slider".to_owned(),
        kind: JointKind::Prismatic,
        parent: None,
        origin: Placement::identity(),
        axis: Vector3::x(),
        inertia: Inertia::from_com(mass, Vector3::zeros(), Matrix3::identity()),
        limits: Limits::NONE,
    };
    Model::from_joints("slider", vec![spec]).expect("it is a tree")
}

/// A point of mass one on sliders along these axes, without gravity: $u = \ddot q$.
pub fn point_mass(axes: &[Vector3<f64>]) -> Model {
    let slider = |(i, axis): (usize, &Vector3<f64>)| JointSpec {
        name: format!("slider_{i}"),
        kind: JointKind::Prismatic,
        parent: i.checked_sub(1),
        origin: Placement::identity(),
        axis: *axis,
        inertia: if i + 1 == axes.len() {
            Inertia::from_com(1.0, Vector3::zeros(), Matrix3::identity())
        } else {
            Inertia::from_com(0.0, Vector3::zeros(), Matrix3::zeros())
        },
        limits: Limits::NONE,
    };
    let specs = axes.iter().enumerate().map(slider).collect();
    Model::from_joints("point mass", specs).expect("it is a tree")
}

/// All built-in robots.
pub fn robots() -> Vec<Model> {
    builtin_robots().map(robot).collect()
}

/// A random tree, every second one with drives.
pub fn tree(n: usize, seed: u64) -> Model {
    let tree = random_tree(n, seed).expect("n > 0");
    if seed & 1 == 1 { tree.with_random_drives(seed) } else { tree }
}

/// A built-in robot or, more often, a random tree.
pub fn any_model() -> impl Strategy<Value = Model> {
    prop_oneof![
        1 => (0..robots().len()).prop_map(|i| robots().swap_remove(i)),
        2 => (1..9_usize, 0..u64::MAX).prop_map(|(n, seed)| tree(n, seed)),
    ]
}

/// `count` numbers in [-3, 3], sometimes zero.
pub fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    let number = prop_oneof![1 => Just(0.0), 7 => -3.0..3.0_f64];
    prop::collection::vec(number, count)
}

/// A model and three vectors with one entry per joint: `q, v, a`.
pub fn model_and_state() -> impl Strategy<Value = (Model, Vec<f64>, Vec<f64>, Vec<f64>)> {
    any_model().prop_flat_map(|model| {
        let n = model.dof();
        (Just(model), numbers(n), numbers(n), numbers(n))
    })
}

/// A model and `x, xdot, xddot`, each with two entries per joint.
pub fn model_and_node() -> impl Strategy<Value = (Model, [Vec<f64>; 3])> {
    any_model().prop_flat_map(|model| {
        let n = 2 * model.dof();
        let node = (numbers(n), numbers(n), numbers(n)).prop_map(|(x, xd, xdd)| [x, xd, xdd]);
        (Just(model), node)
    })
}

/// The largest difference relative to the largest entry of `b`, or to one if that is larger.
pub fn relative_error<'a>(a: impl IntoIterator<Item = &'a f64>, b: impl IntoIterator<Item = &'a f64>) -> f64 {
    let (a, b): (Vec<_>, Vec<_>) = (a.into_iter().collect(), b.into_iter().collect());
    assert_eq!(a.len(), b.len(), "different sizes");
    let largest = b.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    let differences = a.iter().zip(b).map(|(a, b)| (*a - b).abs());
    // `max` would ignore a NaN.
    differences.fold(0.0, |m: f64, d| if d <= m { m } else { d }) / largest
}

/// Asserts that two sequences of numbers agree to `bound`, relative to the largest of the second.
#[macro_export]
macro_rules! assert_close {
    ($a:expr, $b:expr, $bound:expr) => {{
        let error = $crate::common::relative_error($a, $b);
        assert!(error <= $bound, "{} and {} differ by {error:e}", stringify!($a), stringify!($b));
    }};
}

/// The Jacobian of `f` at `x` by dual numbers.
pub fn dual_jacobian(f: impl Fn(&[Dual64]) -> Vec<Dual64>, x: &[f64]) -> DMatrix<f64> {
    let columns: Vec<Vec<f64>> = (0..x.len())
        .map(|j| {
            let tangent = |(i, x): (usize, &f64)| Dual64::new(*x, f64::from(u8::from(i == j)));
            let input: Vec<Dual64> = x.iter().enumerate().map(tangent).collect();
            f(&input).iter().map(|y| y.eps).collect()
        })
        .collect();
    DMatrix::from_fn(columns.first().map_or(0, Vec::len), x.len(), |i, j| columns[j][i])
}

/// The derivative of `f` at `x` along `direction` by dual numbers.
pub fn dual_rate(f: impl Fn(&[Dual64]) -> Vec<Dual64>, x: &[f64], direction: &[f64]) -> Vec<f64> {
    let input: Vec<Dual64> = x.iter().zip(direction).map(|(x, d)| Dual64::new(*x, *d)).collect();
    f(&input).iter().map(|y| y.eps).collect()
}

/// Constants as dual numbers.
pub fn constants(x: &[f64]) -> Vec<Dual64> {
    x.iter().map(|x| Dual64::from(*x)).collect()
}

/// The arguments of the flow, from `x`, `xdot` and `xddot`.
pub fn node(parts: &[Vec<f64>; 3]) -> Node<'_, f64> {
    Node { t: 0.0, x: &parts[0], xdot: &parts[1], xddot: &parts[2] }
}

/// Distinct nonzero numbers: $\sin(f)$, $\sin(2 f)$, and so on.
pub fn wave(count: usize, f: f64) -> Vec<f64> {
    (1..=count).map(|i| (f * i as f64).sin()).collect()
}

/// The torques of a robot at a state without pattern.
pub fn torques_somewhere(model: &Model) -> Vec<f64> {
    let n = model.dof();
    let [q, v, a] = [0.3, 1.7, 2.9].map(|c| Vec::from_iter((0..n).map(|i| 2.0 * (c + 1.3 * i as f64).sin())));
    let mut tau = vec![0.0; n];
    rnea(model, &mut Data::new(model), &q, &v, &a, &mut tau).expect("lengths agree");
    tau
}

/// A state of the checker from `x`, `xdot` and `xddot`.
pub fn state([x, xdot, xddot]: [Vec<f64>; 3]) -> State {
    State { t: 0.0, x, xdot, xddot }
}

/// Asserts that the checker compared something and found no error.
pub fn assert_right(model: &Model, findings: aghf::Result<Vec<Finding>>) {
    let findings = findings.expect("sizes agree");
    assert!(!findings.is_empty(), "nothing was compared");
    let off: Vec<_> = findings.iter().filter(|f| !f.passes()).collect();
    assert!(off.is_empty(), "{}: {off:#?}", model.name());
}

/// Asserts that invalid input is refused with these words in the message.
pub fn assert_refused<T: std::fmt::Debug>(result: aghf::Result<T>, words: &str) {
    let error = result.expect_err(words).to_string();
    assert!(error.contains(words), "'{error}' does not say '{words}'");
}

/// The condition number of the mass matrix at a state.
pub fn condition(model: &Model, x: &[f64]) -> f64 {
    let n = model.dof();
    let mut h = DMatrix::zeros(n, n);
    crba(model, &mut Data::new(model), &x[..n], &mut h).expect("lengths agree");
    let eigenvalues = h.symmetric_eigenvalues();
    eigenvalues.max() / eigenvalues.min()
}

/// The bound on the relative error of two solves with `H`, in addition to `rounding`: errors grow linearly with its
/// condition number, as measured for [`check_all`](aghf::verify::duals::check_all).
pub fn solve_bound(model: &Model, x: &[f64], rounding: f64) -> f64 {
    rounding + 1e-13 * condition(model, x)
}
