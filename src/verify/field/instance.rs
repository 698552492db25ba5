//! Random robots and states over the field.

use super::F;
use crate::error::Result;
use crate::flow::Node;
use crate::model::{JointKind, JointSpec, Limits, Model};
use crate::scalar::{Jet, Scalar};
use crate::spatial::{Inertia, Placement};
use nalgebra::{DVector, Matrix3, Vector3};
use num_traits::One;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The smallest robot.
const SMALLEST: usize = 5;
/// The largest robot. Identities that hold for trees of this size have met every case of branching there is in them.
const LARGEST: usize = 8;

/// A random point: a robot of five to eight joints with arbitrary branching, axes, placements, inertias and gravity, what
/// the flow reads at a node, and a penalty, all of them elements of the field.
pub struct Point {
    /// The robot.
    pub model: Model<F>,
    /// The same robot without gravity.
    pub weightless: Model<F>,
    /// $x$, `2 N` entries.
    pub x: DVector<F>,
    /// $\dot x$.
    pub xdot: DVector<F>,
    /// $\ddot x$.
    pub xddot: DVector<F>,
    /// The penalty.
    pub k: F,
    /// Weights of contractions, `N` entries.
    pub w: DVector<F>,
    /// A number for whatever else is needed, such as the constants of a constraint.
    pub extra: [F; 8],
}

impl Point {
    /// A random point.
    ///
    /// # Errors
    /// None: there is a joint, and parents come before children.
    pub fn random(rng: &mut ChaCha8Rng) -> Result<Self> {
        let n = rng.random_range(SMALLEST..=LARGEST);
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
        })
    }

    /// `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.model.dof()
    }

    /// What the flow reads.
    #[must_use]
    pub fn node(&self) -> Node<'_, F> {
        Node {
            x: self.x.as_slice(),
            xdot: self.xdot.as_slice(),
            xddot: self.xddot.as_slice(),
        }
    }
}

/// Numbers that move along a direction, as dual numbers.
pub(crate) fn moving<S: Scalar>(x: &[S], direction: &[S]) -> Vec<Jet<S, 1>> {
    x.iter()
        .zip(direction)
        .map(|(x, d)| Jet::new(*x, [*d]))
        .collect()
}

/// A random element.
fn number(rng: &mut ChaCha8Rng) -> F {
    F::new(rng.random_range(0..F::ORDER))
}

fn vector(rng: &mut ChaCha8Rng) -> Vector3<F> {
    Vector3::from_fn(|_, _| number(rng))
}

/// A vector of length one: a rational point of the sphere, by stereographic projection.
fn axis(rng: &mut ChaCha8Rng) -> Vector3<F> {
    let (a, b) = (number(rng), number(rng));
    let inverse = (F::one() + a * a + b * b).inverse();
    Vector3::new(a + a, b + b, F::one() - a * a - b * b) * inverse
}

/// An orthogonal matrix with determinant one: the rotation of a rational quaternion.
fn rotation(rng: &mut ChaCha8Rng) -> Matrix3<F> {
    let (w, v) = (number(rng), vector(rng));
    let inverse = (w * w + v.dot(&v)).inverse();
    let cross = crate::spatial::cross_matrix(&v);
    let two = F::one() + F::one();
    Matrix3::identity() + (cross * w + cross * cross) * (two * inverse)
}

/// The first three joints are a chain that turns, the fourth slides on the second body beside the third: so every term of
/// every equation is there, and nothing holds because it is zero. The other joints are what and where they happen to be.
fn robot(n: usize, rng: &mut ChaCha8Rng) -> Result<Model<F>> {
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
        let half = vector(rng);
        let off = vector(rng);
        specs.push(JointSpec {
            name: format!("joint_{i}"),
            kind: if slides {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            },
            parent,
            origin: Placement::new(rotation(rng), vector(rng)),
            axis: axis(rng),
            inertia: Inertia {
                mass: number(rng),
                first_moment: vector(rng),
                rotational: Matrix3::new(
                    half.x, off.x, off.y, off.x, half.y, off.z, off.y, off.z, half.z,
                ),
            },
            limits: Limits::NONE,
        });
    }
    Ok(Model::from_joints("random robot over the field", specs)?.with_gravity(vector(rng)))
}
