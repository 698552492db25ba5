//! Models with some joints locked.

use super::{Collision, Frame, JointSpec, Model};
use crate::error::{Error, Result, plain};
use crate::spatial::Placement;

/// A model with some of its joints locked.
pub struct Reduced {
    /// The model of the remaining joints.
    pub model: Model,
    /// For each body of the full model, the body of the reduced model that contains it and its placement there; `None`
    /// is the base.
    pub bodies: Vec<(Option<usize>, Placement<f64>)>,
}

impl Model<f64> {
    /// Locks some joints, given by their indices, at the given positions, in rad or m, like Pinocchio's
    /// `buildReducedModel`. A body whose joint is locked becomes part of its parent body, or of the base; the other
    /// joints keep their order and their drives, and all frames are kept. Cost O(N).
    ///
    /// # Errors
    /// A joint does not exist, is locked twice or cannot be at that position, or no joint remains. See also
    /// [`Model::check_regular`].
    pub fn with_locked_joints(&self, locked: &[(usize, f64)]) -> Result<Self> {
        Ok(self.reduced(locked)?.model)
    }

    /// Locks joints as [`Model::with_locked_joints`] does, and returns the placements of the bodies in the reduced
    /// model.
    pub fn reduced(&self, locked: &[(usize, f64)]) -> Result<Reduced> {
        let mut positions = vec![None; self.dof()];
        for (i, q) in locked {
            let Some(joint) = self.joints.get(*i) else {
                let condition = format!("there is no such joint, there are {}", self.dof());
                return Err(Error::input(&self.name, format!("joint {i}"), condition));
            };
            let refuse = |condition: String| {
                let element = format!("joint '{}'", joint.name());
                Err(Error::input(&self.name, element, condition))
            };
            let (lower, upper) = (joint.limits().lower, joint.limits().upper);
            if !(q.is_finite() && (lower..=upper).contains(q)) {
                let [q, lower, upper] = [*q, lower, upper].map(plain);
                return refuse(format!("locked at {q}, outside [{lower}, {upper}]"));
            }
            if positions[*i].replace(*q).is_some() {
                return refuse("it is locked twice".to_owned());
            }
        }
        if positions.iter().all(Option::is_some) {
            let condition = "all joints are locked, nothing is left to move";
            return Err(Error::input(&self.name, "robot", condition));
        }

        let (mut specs, mut base) = (Vec::<JointSpec<f64>>::new(), self.base_inertia);
        let mut bodies: Vec<(Option<usize>, Placement<f64>)> = Vec::with_capacity(self.dof());
        let free = positions.iter().map(Option::is_none);
        let drives = (self.drives.iter().zip(free))
            .filter_map(|(drive, free)| free.then_some(*drive))
            .collect();
        for ((joint, inertia), q) in self.joints.iter().zip(&self.inertias).zip(positions) {
            let (parent, within) = match joint.parent() {
                Some(parent) => bodies[parent],
                None => (None, Placement::identity()),
            };
            let Some(q) = q else {
                bodies.push((Some(specs.len()), Placement::identity()));
                specs.push(JointSpec {
                    name: joint.name().to_owned(),
                    kind: joint.kind(),
                    parent,
                    origin: within.compose(joint.origin()),
                    axis: *joint.axis(),
                    inertia: *inertia,
                    limits: *joint.limits(),
                });
                continue;
            };
            let placement = within.compose(&joint.placement(q));
            match parent {
                Some(parent) => specs[parent].inertia += inertia.placed(&placement),
                None => base += inertia.placed(&placement),
            }
            bodies.push((parent, placement));
        }
        let frame = |frame: &Frame<f64>| {
            let (body, within) = match frame.body {
                Some(body) => bodies[body],
                None => (None, Placement::identity()),
            };
            Frame {
                name: frame.name.clone(),
                body,
                placement: within.compose(&frame.placement),
                carrier: frame.carrier.clone(),
            }
        };
        let frames = self.frames.iter().map(frame).collect();
        let collision = |collision: &Collision| {
            let (body, within) = match collision.body {
                Some(body) => bodies[body],
                None => (None, Placement::identity()),
            };
            Collision {
                body,
                placement: within.compose(&collision.placement),
                ..collision.clone()
            }
        };
        let collisions = self.collisions.iter().map(collision).collect();
        let model = Model::from_joints(&self.name, specs)?
            .with_gravity(self.gravity)
            .with_base_inertia(base)
            .with_frames(frames)
            .with_collisions(collisions)?
            .with_drives(drives)?;
        Ok(Reduced { model, bodies })
    }
}
