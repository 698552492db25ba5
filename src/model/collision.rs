//! The collision shapes of a robot.

use super::Model;
use crate::error::{Error, Result};
use crate::geometry::{Capsule, CollisionSphere, Shape, Solid};
use crate::scalar::Scalar;
use crate::spatial::Placement;
use nalgebra::Vector3;
use std::collections::HashSet;

/// A shape of a link, from a `<collision>` element of its URDF.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision<C: Scalar = f64> {
    /// The name of the link.
    pub link: String,
    /// The body that the link is part of; `None` is the base.
    pub body: Option<usize>,
    /// The placement of the shape in that body.
    pub placement: Placement<C>,
    /// The shape.
    pub shape: CollisionShape<C>,
}

/// The shape of a [`Collision`].
#[derive(Clone, Debug, PartialEq)]
pub enum CollisionShape<C: Scalar = f64> {
    /// A primitive shape.
    Solid(Shape<C>),
    /// A mesh in a file, which is not read with the robot.
    Mesh {
        /// The file as the URDF names it.
        file: String,
        /// The scale factors of its axes.
        scale: Vector3<C>,
    },
}

impl<C: Scalar> Collision<C> {
    /// A shape of a link, at `placement` in the frame of the link.
    ///
    /// # Errors
    /// The model has no link of that name.
    pub fn at_link(model: &Model<C>, link: &str, placement: &Placement<C>, shape: CollisionShape<C>) -> Result<Self> {
        let frame = model.frames().iter().find(|f| f.name == link);
        let Some(frame) = frame else {
            let element = format!("link '{link}'");
            return Err(Error::input(model.name(), element, model.no_link(link)));
        };
        Ok(Self { link: link.to_owned(), body: frame.body, placement: frame.placement.compose(placement), shape })
    }

    /// The shape with its placement in the body; `None` for a mesh.
    #[must_use]
    pub fn solid(&self) -> Option<Solid<C>> {
        match self.shape {
            CollisionShape::Solid(shape) => Some(Solid { placement: self.placement, shape }),
            CollisionShape::Mesh { .. } => None,
        }
    }
}

impl<C: Scalar> Model<C> {
    /// The collision shapes, in the order in which the tree is visited.
    #[must_use]
    pub fn collisions(&self) -> &[Collision<C>] {
        &self.collisions
    }

    /// Replaces the collision shapes, for example by those of [`Collision::at_link`].
    ///
    /// # Errors
    /// A shape belongs to a link that the model does not have, or not to the body of its link.
    pub fn with_collisions(mut self, collisions: Vec<Collision<C>>) -> Result<Self> {
        for Collision { link, body, .. } in &collisions {
            let same = self.frames.iter().find(|f| f.name == *link);
            if same.is_none_or(|frame| frame.body != *body) {
                let condition = "a shape is there, but no such link of this body";
                return Err(Error::input(&self.name, format!("link '{link}'"), condition));
            }
        }
        self.collisions = collisions;
        Ok(self)
    }
}

impl Collision<f64> {
    /// Converts the constants to another type.
    pub(super) fn cast<D: Scalar>(&self) -> Collision<D> {
        let vector = |v: &Vector3<f64>| v.map(D::from_f64);
        Collision {
            link: self.link.clone(),
            body: self.body,
            placement: Placement::new(self.placement.rotation.map(D::from_f64), vector(&self.placement.translation)),
            shape: match &self.shape {
                CollisionShape::Solid(shape) => CollisionShape::Solid(shape.cast()),
                CollisionShape::Mesh { file, scale } => {
                    CollisionShape::Mesh { file: file.clone(), scale: vector(scale) }
                }
            },
        }
    }
}

impl<C: Scalar> CollisionSphere<C> {
    /// The origins of all joint frames as points: the paper's collision model.
    #[must_use]
    pub fn joint_frames(model: &Model<C>) -> Vec<Self> {
        let origin = |body| Self { body: Some(body), centre: Vector3::zeros(), radius: C::zero() };
        (0..model.dof()).map(origin).collect()
    }

    /// A ball about the origin of the frame of a link.
    ///
    /// # Errors
    /// The model has no link of that name.
    pub fn at_link(model: &Model<C>, link: &str, radius: C) -> Result<Self> {
        let frame = model.frames().iter().find(|f| f.name == link);
        let frame = frame.ok_or_else(|| Error::input(model.name(), format!("link '{link}'"), model.no_link(link)))?;
        Ok(Self { body: frame.body, centre: frame.placement.translation, radius })
    }
}

impl Capsule {
    /// Capsules along the whole arm: from the origin of each joint to those of the joints and of the fixed links on its
    /// body, such as an end effector. A body without such points away from the origin of its joint gets a ball there.
    #[must_use]
    pub fn along_links(model: &Model, radius: f64) -> Vec<Self> {
        let mut capsules = Vec::new();
        for body in 0..model.dof() {
            let body = Some(body);
            let joints = model.joints().iter().filter(|j| j.parent() == body);
            let joints = joints.map(|j| j.origin().translation);
            let frames = model.frames().iter().filter(|f| f.body == body);
            let frames = frames.map(|f| f.placement.translation);
            let (mut ends, mut known) = (Vec::new(), HashSet::new());
            for end in joints.chain(frames) {
                // Zero has two signs.
                let bits: [u64; 3] = end.map(|x| (x + 0.0).to_bits()).into();
                if end != Vector3::zeros() && known.insert(bits) {
                    ends.push(end);
                }
            }
            if ends.is_empty() {
                ends.push(Vector3::zeros());
            }
            capsules.extend(ends.into_iter().map(|end| Self { body, ends: [Vector3::zeros(), end], radius }));
        }
        capsules
    }
}
