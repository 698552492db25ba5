//! The robot model: joints, the tree that they form, and builders.
//!
//! Joint `i` moves body `i` and is degree of freedom `i`; its parent body comes before it. The parent `None` is the
//! fixed base. There are no joints with several degrees of freedom and no dependent joints; see
//! [`Mimic`](crate::urdf::Mimic) for the treatment of the latter.
//!
//! # Correspondence with Pinocchio
//!
//! For a URDF that `pinocchio.buildModelFromUrdf(path)` reads with a fixed base and
//! [`load_urdf`](crate::urdf::load_urdf) reads too:
//!
//! | here | Pinocchio |
//! | --- | --- |
//! | joint `i`, depth first, the joints on a link in the order of their names (compared byte by byte) | joint `i + 1`; joint 0 is the universe |
//! | the name of a joint | the same, `names[i + 1]` |
//! | `q[i]` of a revolute or prismatic joint | `q[joints[i + 1].idx_q]` |
//! | `q[i]` of a continuous joint, an angle | two numbers, `cos q[i]` and `sin q[i]`, at `idx_q` and `idx_q + 1` |
//! | `v[i]`, `a[i]`, `tau[i]`, row or column `i` of a matrix | the same, `idx_v` is `i` |
//! | a mimic joint, with [`Mimic::Independent`](crate::urdf::Mimic::Independent) | an ordinary joint, unless `mimic=True` is passed |
//! | a [`Frame`], one per link, in the order of the visit | the frame of type `BODY` and the same name; frames of joints (`JOINT`, `FIXED_JOINT`) have no counterpart |
//! | the inertia of a body, about the origin of its joint | `inertias[i + 1]`, which is given by `mass`, `lever` and the inertia about the centre of mass |
//! | [`Model::base_inertia`], of the bodies fixed to the base | `inertias[0]`, and `inertias[1]` with a `JointModelFreeFlyer` at the root |
//! | `armature` of a [`Drive`]; damping and friction of a [`Drive`] | `armature[i]`; none: the algorithms do not read `damping` and `friction` |
//! | infinite limits if the file has none, only zeros, or a zero for velocity or effort | zeros as in the file; cosine and sine of a continuous joint have the limits 1.01 |
//! | angular part first in spatial vectors, at the origin of the base | linear part first, at the requested frame |

mod build;
mod collision;
mod drive;
mod joint;
mod lock;
mod missing;
mod random;

pub use build::{JointSpec, MAX_DOF, pendulum};
pub use collision::{Collision, CollisionShape};
pub use drive::Drive;
pub use joint::{Joint, JointKind, Limits};
pub use lock::Reduced;
pub use random::{random_chain, random_tree};

use crate::error::{Result, check_length};
use crate::scalar::Scalar;
use crate::spatial::{Inertia, Placement};
use nalgebra::Vector3;

/// A frame fixed to a body: every link of a URDF has one, merged links too.
#[derive(Clone, Debug)]
pub struct Frame<C: Scalar> {
    /// The name, which for a URDF is that of the link.
    pub name: String,
    /// The body; `None` is the base.
    pub body: Option<usize>,
    /// The placement of the frame in that body.
    pub placement: Placement<C>,
    /// The joint that carries the link; `None` for the root, and for frames that are not links.
    pub carrier: Option<Carrier>,
}

/// The joint and the parent of a link.
#[derive(Clone, Debug)]
pub struct Carrier {
    /// The name of the joint, which may be fixed.
    pub joint: String,
    /// The parent link, by the index of its frame; `None` if the base is not a link.
    pub parent: Option<usize>,
}

impl<C: Scalar> Frame<C> {
    /// A frame at `placement` in the body of joint `body`, or in the base, such as a tool or a sensor.
    #[must_use]
    pub fn new(name: &str, body: Option<usize>, placement: Placement<C>) -> Self {
        Self { name: name.to_owned(), body, placement, carrier: None }
    }
}

/// A tree of rigid bodies whose constants have the type `C`.
#[derive(Clone, Debug)]
pub struct Model<C: Scalar = f64> {
    name: String,
    joints: Vec<Joint<C>>,
    inertias: Vec<Inertia<C>>,
    base_inertia: Inertia<C>,
    frames: Vec<Frame<C>>,
    collisions: Vec<Collision<C>>,
    drives: Vec<Drive<C>>,
    gravity: Vector3<C>,
}

impl<C: Scalar> Model<C> {
    /// The name of the robot.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of joints `N`, which is also that of bodies and degrees of freedom.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// The joints; parents come before children.
    #[must_use]
    pub fn joints(&self) -> &[Joint<C>] {
        &self.joints
    }

    /// The inertias of the bodies, each in the frame of its joint.
    #[must_use]
    pub fn inertias(&self) -> &[Inertia<C>] {
        &self.inertias
    }

    /// The inertias, which may be changed, or differentiated after [`Model::cast`] to a dual number.
    pub fn inertias_mut(&mut self) -> &mut [Inertia<C>] {
        &mut self.inertias
    }

    /// The inertia of the bodies fixed to the base, in its frame. No joint feels it, but the
    /// [wrench of the root](crate::dynamics::root_wrench()) includes its weight.
    #[must_use]
    pub fn base_inertia(&self) -> &Inertia<C> {
        &self.base_inertia
    }

    /// Replaces the inertia of the base.
    #[must_use]
    pub fn with_base_inertia(mut self, inertia: Inertia<C>) -> Self {
        self.base_inertia = inertia;
        self
    }

    /// The frames of all links, in the order in which the tree is visited.
    #[must_use]
    pub fn frames(&self) -> &[Frame<C>] {
        &self.frames
    }

    /// The acceleration of gravity in the base frame, m/s^2; $(0, 0, -9.81)$ for a URDF.
    #[must_use]
    pub fn gravity(&self) -> &Vector3<C> {
        &self.gravity
    }

    /// Replaces gravity.
    #[must_use]
    pub fn with_gravity(mut self, gravity: Vector3<C>) -> Self {
        self.gravity = gravity;
        self
    }

    /// Checks that an argument has one entry per joint.
    pub(crate) fn check(&self, what: &'static str, found: usize) -> Result<()> {
        check_length(what, self.dof(), found)
    }
}

impl Model<f64> {
    /// Converts the constants to another type, like Pinocchio's `cast`: dual numbers for derivatives with respect to a
    /// mass, elements of a finite field for the proof of an identity.
    #[must_use]
    pub fn cast<D: Scalar>(&self) -> Model<D> {
        let vector = |v: &Vector3<f64>| v.map(D::from_f64);
        let placement = |p: &Placement<f64>| Placement::new(p.rotation.map(D::from_f64), vector(&p.translation));
        let inertia = |i: &Inertia<f64>| Inertia {
            mass: D::from_f64(i.mass),
            first_moment: vector(&i.first_moment),
            rotational: i.rotational.map(D::from_f64),
        };
        Model {
            name: self.name.clone(),
            joints: self.joints.iter().map(Joint::cast).collect(),
            inertias: self.inertias.iter().map(inertia).collect(),
            base_inertia: inertia(&self.base_inertia),
            frames: (self.frames.iter())
                .map(|f| Frame {
                    name: f.name.clone(),
                    body: f.body,
                    placement: placement(&f.placement),
                    carrier: f.carrier.clone(),
                })
                .collect(),
            collisions: self.collisions.iter().map(Collision::cast).collect(),
            drives: self.drives.iter().map(Drive::cast).collect(),
            gravity: vector(&self.gravity),
        }
    }

    /// The moving mass, kg. Mass fixed to the base is not included.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.inertias.iter().map(|i| i.mass).sum()
    }
}
