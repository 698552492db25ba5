//! Random robots for tests and benches.

use super::{Drive, Joint, JointKind, JointSpec, Limits, Model};
use crate::error::Result;
use crate::spatial::{Inertia, Placement};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

impl Model {
    /// Draws positions of all joints within their limits, uniformly; where a limit is missing, within one turn or 2 pi
    /// metres.
    pub fn random_configuration(&self, rng: &mut impl Rng) -> Vec<f64> {
        let draw = |joint: &Joint<f64>| {
            let Limits { lower, upper, .. } = *joint.limits();
            let lower = if lower.is_finite() { lower } else { upper.min(PI) - 2.0 * PI };
            let upper = if upper.is_finite() { upper } else { lower + 2.0 * PI };
            lower + (upper - lower) * rng.random::<f64>()
        };
        self.joints.iter().map(draw).collect()
    }

    /// The same robot with random drives: damping, friction and rotor inertia at every joint, of the order of the
    /// forces and inertias of a [`random_tree`]. The same seed gives the same drives.
    #[must_use]
    pub fn with_random_drives(mut self, seed: u64) -> Self {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        self.drives = (0..self.dof())
            .map(|_| Drive {
                damping: rng.random_range(0.0..2.0),
                friction: rng.random_range(0.0..2.0),
                friction_velocity: rng.random_range(0.2..2.0),
                armature: rng.random_range(0.0..0.5),
            })
            .collect();
        self
    }
}

/// A random vector in the cube of side two about the origin.
fn vector(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

/// A random unit vector, including negative and oblique ones, sometimes along a coordinate axis.
fn axis(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    if rng.random_bool(0.25) {
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        return Vector3::ith(rng.random_range(0..3), sign);
    }
    loop {
        let v = vector(rng);
        if v.norm() > 0.1 {
            return v.normalize();
        }
    }
}

/// A random tree of `n` joints of all kinds: arbitrary branching, axes, placements and physically consistent inertias.
/// The same `n` and `seed` give the same robot.
///
/// # Errors
/// `n` is zero.
pub fn random_tree(n: usize, seed: u64) -> Result<Model> {
    // Sometimes the base, otherwise any earlier body, most often a recent one.
    let parent = |i: usize, rng: &mut ChaCha8Rng| {
        (i > 0 && rng.random_bool(0.9)).then(|| rng.random_range(i.saturating_sub(4)..i.max(1)))
    };
    random_robot(&format!("random_tree_{n}_{seed}"), n, seed, parent)
}

/// A random chain of `n` joints, otherwise like [`random_tree`]: the deepest tree of that size.
///
/// # Errors
/// `n` is zero.
pub fn random_chain(n: usize, seed: u64) -> Result<Model> {
    let name = format!("random_chain_{n}_{seed}");
    random_robot(&name, n, seed, |i, _| i.checked_sub(1))
}

/// A random robot in which `parent(i)` is the parent of joint `i`.
fn random_robot(
    name: &str,
    n: usize,
    seed: u64,
    parent: impl Fn(usize, &mut ChaCha8Rng) -> Option<usize>,
) -> Result<Model> {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let mut specs = Vec::with_capacity(n);
    for i in 0..n {
        let kind = match rng.random_range(0..4) {
            0 => JointKind::Prismatic,
            1 => JointKind::Continuous,
            _ => JointKind::Revolute,
        };
        let parent = parent(i, rng);
        let rotation = Rotation3::new(vector(rng) * 3.0).into_inner();
        let mass = rng.random_range(0.2..3.0);
        // Moments of inertia from positive second moments satisfy the triangle inequality.
        let frame = Rotation3::new(vector(rng) * 3.0).into_inner();
        let second = Vector3::from_fn(|_, _| rng.random_range(0.01..0.3));
        let moments = Vector3::from_element(second.sum()) - second;
        specs.push(JointSpec {
            name: format!("joint_{i}"),
            kind,
            parent,
            origin: Placement::new(rotation, vector(rng)),
            axis: axis(rng),
            inertia: Inertia::from_com(
                mass,
                vector(rng) * 0.5,
                frame * Matrix3::from_diagonal(&moments) * frame.transpose(),
            ),
            limits: Limits::NONE,
        });
    }
    Model::from_joints(name, specs)
}
