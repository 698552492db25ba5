//! Models made in code.

use super::{Carrier, Frame, Joint, JointKind, Limits, Model};
use crate::error::{Error, Result};
use crate::scalar::Scalar;
use crate::spatial::{Inertia, Placement};
use nalgebra::{Matrix3, Vector3};

/// The acceleration of gravity, m/s^2, downwards.
pub(crate) const STANDARD_GRAVITY: f64 = 9.81;

/// The largest number of joints of a model. At this size one tensor of second derivatives, `N x N x N`, takes 134 MB,
/// and several are needed; the largest humanoids have about 100 joints.
pub const MAX_DOF: usize = 256;

/// The specification of a joint and its body, from which a [`Model`] is built.
#[derive(Clone, Debug)]
pub struct JointSpec<C: Scalar> {
    /// The name of the joint. The frame of its body is called the same.
    pub name: String,
    /// The kind of the joint.
    pub kind: JointKind,
    /// The parent body, by the index of its joint; `None` is the base.
    pub parent: Option<usize>,
    /// The placement of the joint in the parent body at `q = 0`.
    pub origin: Placement<C>,
    /// The axis, a unit vector in the frame of the joint.
    pub axis: Vector3<C>,
    /// The inertia of the body, in the frame of the joint.
    pub inertia: Inertia<C>,
    /// The limits of the joint.
    pub limits: Limits,
}

impl<C: Scalar> Model<C> {
    /// Builds a model of the given joints under gravity $(0, 0, -9.81)$.
    ///
    /// # Errors
    /// There is no joint or more than [`MAX_DOF`], a parent does not come before its child, or two joints have the
    /// same name. Over `f64` see also [`Model::check_regular`].
    pub fn from_joints(name: &str, specs: Vec<JointSpec<C>>) -> Result<Self> {
        let mut model = Self {
            name: name.to_owned(),
            joints: Vec::with_capacity(specs.len()),
            inertias: Vec::with_capacity(specs.len()),
            base_inertia: Inertia::zero(),
            frames: Vec::with_capacity(specs.len()),
            collisions: Vec::new(),
            drives: Vec::new(),
            gravity: Vector3::new(C::zero(), C::zero(), C::from_f64(-STANDARD_GRAVITY)),
        };
        if specs.is_empty() {
            return Err(Error::input(name, "robot", "has no moving joint"));
        }
        let (found, most) = (specs.len(), MAX_DOF);
        if found > most {
            let condition = format!("has {found} moving joints, at most {most} are supported");
            return Err(Error::input(name, "robot", condition));
        }
        for (i, spec) in specs.into_iter().enumerate() {
            let element = format!("joint '{}'", spec.name);
            if spec.parent.is_some_and(|p| p >= i) {
                return Err(Error::input(name, element, "its parent does not come before it"));
            }
            if model.joints.iter().any(|j| j.name() == spec.name) {
                return Err(Error::input(name, element, "the name occurs twice"));
            }
            model.frames.push(Frame {
                name: spec.name.clone(),
                body: Some(i),
                placement: Placement::identity(),
                carrier: Some(Carrier { joint: spec.name.clone(), parent: spec.parent }),
            });
            model.joints.push(Joint::new(spec.name, spec.kind, spec.parent, spec.origin, spec.axis, spec.limits));
            model.inertias.push(spec.inertia);
        }
        Ok(model)
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// The body does not exist, or another frame has the same name.
    pub fn add_frame(&mut self, frame: Frame<C>) -> Result<()> {
        let refused = |condition: &str| Error::input(&self.name, format!("frame '{}'", frame.name), condition);
        if frame.body.is_some_and(|body| body >= self.dof()) {
            return Err(refused("there is no such body"));
        }
        if self.frames.iter().any(|other| other.name == frame.name) {
            return Err(refused("the name occurs twice"));
        }
        self.frames.push(frame);
        Ok(())
    }

    /// Replaces the frames.
    pub(crate) fn with_frames(mut self, frames: Vec<Frame<C>>) -> Self {
        self.frames = frames;
        self
    }
}

/// A planar chain of `links` pendulums: links of 1 m with a point mass of 1 kg at the middle and no rotational inertia,
/// axes along y; the links point along -x at `q = 0`.
///
/// # Errors
/// `links` is zero.
pub fn pendulum(links: usize) -> Result<Model> {
    let specs = (0..links).map(|i| JointSpec {
        name: format!("joint_{}", i + 1),
        kind: JointKind::Continuous,
        parent: i.checked_sub(1),
        origin: Placement::new(Matrix3::identity(), Vector3::new(if i == 0 { 0.0 } else { -1.0 }, 0.0, 0.0)),
        axis: Vector3::y(),
        inertia: Inertia::from_com(1.0, Vector3::new(-0.5, 0.0, 0.0), Matrix3::zeros()),
        limits: Limits::NONE,
    });
    Model::from_joints(&format!("pendulum_{links}"), specs.collect())
}
