//! Joints, the tree they form, and where models come from: URDF files and builders.
//!
//! Joint `i` moves body `i`; its parent body comes before it. `None` as a parent is the fixed base. Joints are numbered as
//! Pinocchio numbers them: depth first, the children of a link in the alphabetical order of their joints' names.

mod build;
mod builtin;
mod joint;
mod random;
mod urdf;
mod urdf_text;
mod urdf_tree;

pub use build::{JointSpec, pendulum};
pub(crate) use builtin::builtin_robot_text;
pub use builtin::{builtin_robot, builtin_robots};
pub use joint::{Joint, JointKind, Limits};
pub use random::{random_chain, random_tree};
pub use urdf::{LoadNote, LoadReport, load_urdf, parse_urdf};

use crate::error::{Result, check_length};
use crate::scalar::Scalar;
use crate::spatial::{Inertia, Placement};
use nalgebra::Vector3;

/// A point and a set of axes fixed to a body: every link of a URDF has one, those of merged links too.
#[derive(Clone, Debug)]
pub struct Frame<C: Scalar> {
    /// The name of the link.
    pub name: String,
    /// The body it is fixed to; `None` is the base.
    pub body: Option<usize>,
    /// Where it is in that body.
    pub placement: Placement<C>,
}

/// A tree of rigid bodies whose constants have the type `C`.
#[derive(Clone, Debug)]
pub struct Model<C: Scalar = f64> {
    name: String,
    joints: Vec<Joint<C>>,
    inertias: Vec<Inertia<C>>,
    frames: Vec<Frame<C>>,
    gravity: Vector3<C>,
}

impl<C: Scalar> Model<C> {
    /// The name of the robot.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// `N`: how many joints, bodies and degrees of freedom there are.
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

    /// The inertias, to change or to differentiate with respect to them (after [`Model::cast`] to a dual number).
    pub fn inertias_mut(&mut self) -> &mut [Inertia<C>] {
        &mut self.inertias
    }

    /// The frames of all links, in the order in which the tree is walked.
    #[must_use]
    pub fn frames(&self) -> &[Frame<C>] {
        &self.frames
    }

    /// The acceleration of gravity in the base frame, m/s^2; $(0, 0, -9.81)$ for a URDF.
    #[must_use]
    pub fn gravity(&self) -> &Vector3<C> {
        &self.gravity
    }

    /// The same model under another gravity.
    #[must_use]
    pub fn with_gravity(mut self, gravity: Vector3<C>) -> Self {
        self.gravity = gravity;
        self
    }

    /// Checks that an argument has one entry a joint.
    pub(crate) fn check(&self, what: &'static str, found: usize) -> Result<()> {
        check_length(what, self.dof(), found)
    }
}

impl Model<f64> {
    /// The same model with constants of another type, as Pinocchio's `cast`: dual numbers to differentiate with respect
    /// to a mass, elements of a field to prove an identity.
    #[must_use]
    pub fn cast<D: Scalar>(&self) -> Model<D> {
        let vector = |v: &Vector3<f64>| v.map(D::from_f64);
        let placement = |p: &Placement<f64>| {
            Placement::new(p.rotation.map(D::from_f64), vector(&p.translation))
        };
        Model {
            name: self.name.clone(),
            joints: self.joints.iter().map(Joint::cast).collect(),
            inertias: (self.inertias.iter())
                .map(|i| Inertia {
                    mass: D::from_f64(i.mass),
                    first_moment: vector(&i.first_moment),
                    rotational: i.rotational.map(D::from_f64),
                })
                .collect(),
            frames: (self.frames.iter())
                .map(|f| Frame {
                    name: f.name.clone(),
                    body: f.body,
                    placement: placement(&f.placement),
                })
                .collect(),
            gravity: vector(&self.gravity),
        }
    }

    /// The mass that the joints move, kg. What is fixed to the base does not count.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.inertias.iter().map(|i| i.mass).sum()
    }
}
