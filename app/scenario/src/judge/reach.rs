//! Bounds on the motion of the balls of a robot.

use aghf::constraint::CollisionSphere;
use aghf::dynamics::forward_kinematics;
use aghf::error::Result;
use aghf::geometry::{Convex, Placed};
use aghf::model::{JointKind, Model};
use aghf::spatial::Placement;
use nalgebra::Vector3;

/// A robot in one configuration, with a bound on the distance of a ball from its position there in other
/// configurations.
///
/// Let joint `i` move by at most $\delta_i$. Move the joints that carry a ball one after the other, from the base on.
/// When joint `i` moves, the joints beyond it have not moved, and those before it have moved its axis and the ball as
/// one body. The distance $d_i$ of the ball from the axis is therefore that of this configuration, independent of the
/// other joints, and because an arc is longer than its chord,
///
/// $$ |p(q + \delta) - p(q)| \le \sum_i d_i |\delta_i|, $$
///
/// with $d_i = 1$ for a prismatic joint.
#[derive(Clone, Debug)]
pub struct Reach<'m> {
    model: &'m Model,
    placements: Vec<Placement<f64>>,
    /// The directions of the axes in the base frame.
    axes: Vec<Vector3<f64>>,
}

impl<'m> Reach<'m> {
    /// Allocates a robot without a configuration.
    #[must_use]
    pub fn new(model: &'m Model) -> Self {
        Self { model, placements: vec![Placement::identity(); model.dof()], axes: vec![Vector3::zeros(); model.dof()] }
    }

    /// Places the robot in configuration `q`, `N` entries. Cost O(N).
    ///
    /// # Errors
    /// `q` does not have `N` entries.
    pub fn place(&mut self, q: &[f64]) -> Result<()> {
        forward_kinematics(self.model, q, &mut self.placements)?;
        for (i, joint) in self.model.joints().iter().enumerate() {
            self.axes[i] = self.placements[i].rotation * joint.axis();
        }
        Ok(())
    }

    /// The centre of a ball in the base frame, m.
    #[must_use]
    pub fn centre(&self, ball: &CollisionSphere) -> Vector3<f64> {
        match ball.body {
            Some(body) => self.placements[body].rotation * ball.centre + self.placements[body].translation,
            None => ball.centre,
        }
    }

    /// The placements of the bodies.
    pub(super) fn placements(&self) -> &[Placement<f64>] {
        &self.placements
    }

    /// A bound on the displacement of a ball with this centre, m, when joint `i` moves by at most `ways[i]`, rad or m.
    /// Only the joints of `path` count: those that carry the ball, from its body on, all of them or those beyond a
    /// common body.
    #[must_use]
    pub fn way(&self, centre: &Vector3<f64>, path: &[usize], ways: &[f64]) -> f64 {
        let one = |i: &usize| match self.model.joints()[*i].kind() {
            JointKind::Revolute | JointKind::Continuous => {
                let arm = centre - self.placements[*i].translation;
                self.axes[*i].cross(&arm).norm() * ways[*i]
            }
            JointKind::Prismatic => ways[*i],
        };
        path.iter().map(one).sum()
    }

    /// The same of all points of a body that the ball contains, which turns with it.
    #[must_use]
    pub(crate) fn way_within(&self, ball: &CollisionSphere, path: &[usize], ways: &[f64]) -> f64 {
        let turns = path.iter().filter(|i| self.model.joints()[**i].kind() != JointKind::Prismatic);
        let turned: f64 = turns.map(|i| ways[*i]).sum();
        self.way(&self.centre(ball), path, ways) + ball.radius * turned
    }

    /// A convex part of the robot in the base frame.
    pub(crate) fn placed<'a>(&'a self, body: Option<usize>, convex: &'a Convex) -> Placed<'a, f64, f64> {
        Placed { convex, placement: body.map(|body| &self.placements[body]) }
    }
}

/// The joints that carry body `body`, from it to the base.
#[must_use]
pub fn carriers(model: &Model, body: Option<usize>) -> Vec<usize> {
    std::iter::successors(body, |i| model.joints()[*i].parent()).collect()
}
