//! Random robots and states over the field.

use super::Gf;
use crate::error::Result;
use crate::flow::Node;
use crate::model::{Drive, JointKind, JointSpec, Limits, Model};
use crate::spatial::{Inertia, Placement};
use crate::verify::reference::At;
use nalgebra::{DVector, Matrix3, Vector3};
use num_traits::One;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The smallest robot.
const MIN_JOINTS: usize = 5;
/// The largest robot. Trees of this size contain every case of branching.
const MAX_JOINTS: usize = 8;

/// A random instance: a robot of five to eight joints with arbitrary branching, axes, placements, inertias, drives and
/// gravity, the input of the flow at a node, and a penalty, all of them random elements of the field.
pub struct RandomInstance {
    /// The robot.
    pub model: Model<Gf>,
    /// The same robot without gravity.
    pub weightless: Model<Gf>,
    /// The time.
    pub t: Gf,
    /// The state $x$, `2 N` entries.
    pub x: DVector<Gf>,
    /// The rate $\dot x$, `2 N` entries.
    pub xdot: DVector<Gf>,
    /// The second derivative $\ddot x$, `2 N` entries.
    pub xddot: DVector<Gf>,
    /// The penalty.
    pub k: Gf,
    /// Weights of contractions, `N` entries.
    pub w: DVector<Gf>,
    /// Further random numbers, such as the constants of a constraint.
    pub extra: [Gf; 8],
}

impl RandomInstance {
    /// Draws a random instance; the same state of the generator gives the same one.
    ///
    /// # Errors
    /// None: there is at least one joint, and parents come before children.
    pub fn random(rng: &mut ChaCha8Rng) -> Result<Self> {
        let n = rng.random_range(MIN_JOINTS..=MAX_JOINTS);
        let model = robot(n, rng)?;
        let mut numbers = |count: usize| DVector::from_fn(count, |_, _| number(rng));
        Ok(Self {
            weightless: model.clone().with_gravity(Vector3::zeros()),
            model,
            x: numbers(2 * n),
            xdot: numbers(2 * n),
            xddot: numbers(2 * n),
            w: numbers(n),
            k: numbers(1)[0],
            extra: std::array::from_fn(|_| numbers(1)[0]),
            t: numbers(1)[0],
        })
    }

    /// The number of joints `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.model.dof()
    }

    /// The time, the state and its derivatives as the input of the flow.
    #[must_use]
    pub fn node(&self) -> Node<'_, Gf> {
        Node { t: self.t, x: self.x.as_slice(), xdot: self.xdot.as_slice(), xddot: self.xddot.as_slice() }
    }

    /// The robot, the input of the flow, and the penalty.
    pub(super) fn at(&self) -> At<'_, Gf, Gf> {
        At { model: &self.model, node: self.node(), k: self.k }
    }

    /// $[x; \dot x; \ddot x]$.
    pub(super) fn z(&self) -> Vec<Gf> {
        let node = self.node();
        [node.x, node.xdot, node.xddot].concat()
    }
}

/// A random element.
fn number(rng: &mut ChaCha8Rng) -> Gf {
    Gf::new(rng.random_range(0..Gf::ORDER))
}

fn vector(rng: &mut ChaCha8Rng) -> Vector3<Gf> {
    Vector3::from_fn(|_, _| number(rng))
}

/// A random unit vector: a rational point of the sphere, by stereographic projection.
fn axis(rng: &mut ChaCha8Rng) -> Vector3<Gf> {
    let (a, b) = (number(rng), number(rng));
    let inverse = (Gf::one() + a * a + b * b).inverse();
    Vector3::new(a + a, b + b, Gf::one() - a * a - b * b) * inverse
}

fn inertia(rng: &mut ChaCha8Rng) -> Inertia<Gf> {
    let (half, off) = (vector(rng), vector(rng));
    Inertia {
        mass: number(rng),
        first_moment: vector(rng),
        rotational: Matrix3::new(half.x, off.x, off.y, off.x, half.y, off.z, off.y, off.z, half.z),
    }
}

/// A random orthogonal matrix with determinant one: the rotation of a rational quaternion.
fn rotation(rng: &mut ChaCha8Rng) -> Matrix3<Gf> {
    let (w, v) = (number(rng), vector(rng));
    let inverse = (w * w + v.dot(&v)).inverse();
    let cross = crate::spatial::cross_matrix(&v);
    let two = Gf::one() + Gf::one();
    Matrix3::identity() + (cross * w + cross * cross) * (two * inverse)
}

/// The first three joints are a revolute chain, the fourth is prismatic on the second body next to the third: no term
/// of any equation vanishes, and no identity holds only because it is zero. The other joints are random.
fn robot(n: usize, rng: &mut ChaCha8Rng) -> Result<Model<Gf>> {
    let mut specs = Vec::with_capacity(n);
    for i in 0..n {
        let (slides, parent) = match i {
            0 => (false, None),
            1 | 2 => (false, Some(i - 1)),
            3 => (true, Some(1)),
            _ => {
                let carried = rng.random_bool(0.9);
                let parent = carried.then(|| rng.random_range(i.saturating_sub(4)..i));
                (rng.random_bool(0.3), parent)
            }
        };
        specs.push(JointSpec {
            name: format!("joint_{i}"),
            kind: if slides { JointKind::Prismatic } else { JointKind::Revolute },
            parent,
            origin: Placement::new(rotation(rng), vector(rng)),
            axis: axis(rng),
            inertia: inertia(rng),
            limits: Limits::NONE,
        });
    }
    let drives = (0..n).map(|_| Drive {
        damping: number(rng),
        friction: number(rng),
        friction_velocity: number(rng),
        armature: number(rng),
    });
    let drives = drives.collect();
    let model = Model::from_joints("random robot over the field", specs)?;
    let model = model.with_base_inertia(inertia(rng));
    model.with_gravity(vector(rng)).with_drives(drives)
}
