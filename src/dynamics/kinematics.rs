//! Placements, velocities and accelerations of the bodies.

use super::Data;
use crate::error::{Error, Result};
use crate::model::{Frame, Model};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Motion, Placement};

/// Computes the placements of all bodies in the base frame.
///
/// * `q`: `N` entries, rad or m
/// * `placements`: `N` entries, overwritten
///
/// # Errors
/// `q` or `placements` does not have `N` entries.
///
/// # Cost
/// O(N).
pub fn forward_kinematics<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    q: &[S],
    placements: &mut [Placement<S>],
) -> Result<()> {
    model.check("q", q.len())?;
    model.check("placements", placements.len())?;
    let mut turns = [(S::zero(), S::one()); 4];
    for (i, joint) in model.joints().iter().enumerate() {
        if i % 4 == 0 {
            let angles = &q[i..q.len().min(i + 4)];
            S::sin_cos_of_several(angles, &mut turns[..angles.len()]);
        }
        let in_parent = joint.placement_turned(q[i], turns[i % 4]);
        placements[i] = match joint.parent() {
            Some(parent) => placements[parent].compose(&in_parent),
            None => in_parent,
        };
    }
    Ok(())
}

/// Computes the placement of a frame in the base frame, from those of the bodies by [`forward_kinematics`].
///
/// # Errors
/// `placements` is too short for the body of the frame.
///
/// # Cost
/// O(1).
pub fn frame_placement<C: Scalar, S: AlgebraOver<C>>(
    frame: &Frame<C>,
    placements: &[Placement<S>],
) -> Result<Placement<S>> {
    let Some(body) = frame.body else {
        return Ok(Placement::identity().compose_constant(&frame.placement));
    };
    let body = placements.get(body).ok_or(Error::Length {
        what: "placements",
        expected: body + 1,
        found: placements.len(),
    })?;
    Ok(body.compose_constant(&frame.placement))
}

impl<S: Scalar> Data<S> {
    /// Placements, axes and inertias of the bodies at `q`.
    pub(super) fn place<C: Scalar>(&mut self, model: &Model<C>, q: &[S]) -> Result<()>
    where
        S: AlgebraOver<C>,
    {
        self.check(model)?;
        forward_kinematics(model, q, &mut self.placements)?;
        for (i, joint) in model.joints().iter().enumerate() {
            let placement = &self.placements[i];
            self.axes[i] = joint.motion_subspace(placement);
            self.inertias[i] = model.inertias()[i].placed(placement);
        }
        Ok(())
    }

    /// Velocities of the bodies and rates $\dot S_i = v_i \times S_i$ of the axes, after [`place`](Self::place).
    pub(super) fn add_velocities<C: Scalar>(&mut self, model: &Model<C>, v: &[S]) -> Result<()> {
        model.check("v", v.len())?;
        for (i, joint) in model.joints().iter().enumerate() {
            let own = self.axes[i] * v[i];
            self.velocities[i] = match joint.parent() {
                Some(parent) => self.velocities[parent] + own,
                None => own,
            };
            self.axis_rates[i] = self.velocities[i].cross(&self.axes[i]);
        }
        Ok(())
    }

    /// Accelerations of the bodies, the base accelerating against gravity, after
    /// [`add_velocities`](Self::add_velocities).
    pub(super) fn add_accelerations<C: Scalar>(&mut self, model: &Model<C>, v: &[S], a: &[S]) -> Result<()>
    where
        S: AlgebraOver<C>,
    {
        model.check("a", a.len())?;
        let base = base_acceleration(model);
        for (i, joint) in model.joints().iter().enumerate() {
            let before = joint.parent().map_or(base, |p| self.accelerations[p]);
            self.accelerations[i] = before + self.axes[i] * a[i] + self.axis_rates[i] * v[i];
        }
        Ok(())
    }
}

/// The acceleration of the base that is equivalent to gravity: $-a_g$.
pub(super) fn base_acceleration<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>) -> Motion<S> {
    Motion { linear: model.gravity().map(|g| -S::lift(g)), ..Motion::zero() }
}
