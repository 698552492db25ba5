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
        let positions = self.locked_positions(locked)?;
        self.rebuilt(positions, &Placement::identity())
    }

    /// The model with its base at this placement in the world, such as a wall or a ceiling; everything in the base
    /// frame, gravity among it, is then in the world. Cost O(N).
    ///
    /// # Errors
    /// As [`Model::from_joints`].
    pub fn mounted(&self, mount: &Placement<f64>) -> Result<Self> {
        Ok(self.rebuilt(vec![None; self.dof()], mount)?.model)
    }

    /// The model with the joints locked that have a position, and its base at a placement.
    fn rebuilt(&self, positions: Vec<Option<f64>>, mount: &Placement<f64>) -> Result<Reduced> {
        let mut specs = Vec::<JointSpec<f64>>::new();
        let mut base = self.base_inertia.placed(mount);
        let placed =
            |bodies: &[(Option<usize>, Placement<f64>)], body: Option<usize>, within: &Placement<f64>| match body {
                Some(body) => (bodies[body].0, bodies[body].1.compose(within)),
                None => (None, mount.compose(within)),
            };
        let mut bodies: Vec<(Option<usize>, Placement<f64>)> = Vec::with_capacity(self.dof());
        let free = positions.iter().map(Option::is_none);
        let drives = (self.drives.iter().zip(free)).filter_map(|(drive, free)| free.then_some(*drive)).collect();
        for ((joint, inertia), q) in self.joints.iter().zip(&self.inertias).zip(positions) {
            let (parent, within) = placed(&bodies, joint.parent(), joint.origin());
            let Some(q) = q else {
                bodies.push((Some(specs.len()), Placement::identity()));
                specs.push(JointSpec {
                    name: joint.name().to_owned(),
                    kind: joint.kind(),
                    parent,
                    origin: within,
                    axis: *joint.axis(),
                    inertia: *inertia,
                    limits: *joint.limits(),
                });
                continue;
            };
            let (_, placement) = placed(&bodies, joint.parent(), &joint.placement(q));
            match parent {
                Some(parent) => specs[parent].inertia += inertia.placed(&placement),
                None => base += inertia.placed(&placement),
            }
            bodies.push((parent, placement));
        }
        let frame = |frame: &Frame<f64>| {
            let (body, placement) = placed(&bodies, frame.body, &frame.placement);
            Frame { body, placement, ..frame.clone() }
        };
        let frames = self.frames.iter().map(frame).collect();
        let collision = |collision: &Collision| {
            let (body, placement) = placed(&bodies, collision.body, &collision.placement);
            Collision { body, placement, ..collision.clone() }
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

    /// The positions of all joints, `None` for those that are not locked.
    fn locked_positions(&self, locked: &[(usize, f64)]) -> Result<Vec<Option<f64>>> {
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
        Ok(positions)
    }
}
