//! Losses and rotor inertia of a joint.

use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};

/// The force of the drive of a joint beside that of rigid bodies: $D v + F(v) + I_a a$, with viscous damping $D$, dry
/// friction $F(v) = F_c\\, s(v / v_0)$ and the inertia $I_a$ of the rotor as seen at the joint. Units are those of
/// a revolute joint; a prismatic one has N for N m and m for rad.
///
/// Friction is smooth, $s(x) = x / \sqrt{1 + x^2}$, so that motions through rest have derivatives: it is within 1 % of
/// $F_c$ beyond $7.1 v_0$, and at rest it holds nothing. An odd rational function cannot saturate: it goes to zero or
/// grows without bound. A square root, which every [`Scalar`] has, makes one that does, and its derivatives are again
/// products of $s$ and that root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<C: Scalar = f64> {
    /// Viscous damping $D$, N m s/rad.
    pub damping: C,
    /// Dry friction $F_c$ at velocities far above $v_0$, N m.
    pub friction: C,
    /// The width $v_0$ of the change of sign of the friction, rad/s, not zero.
    pub friction_velocity: C,
    /// The inertia of the rotor times the square of the gear ratio, kg m^2; `armature` of Pinocchio and MuJoCo.
    pub armature: C,
}

impl<C: Scalar> Drive<C> {
    /// Computes $D v + F(v)$ and its first and second derivative in `v`: with $r = \sqrt{1 + x^2}$ and $s = x / r$,
    /// $s^{\prime} = (1 - s^2) / r$ and $s^{\prime\prime} = -3 s s^{\prime} / r$.
    #[inline]
    #[must_use]
    pub fn losses<S: AlgebraOver<C>>(&self, v: S) -> [S; 3] {
        let per_width = C::one() / self.friction_velocity;
        let (x, one) = (v.scale(per_width), S::one());
        let root = (one + x * x).sqrt();
        let s = x / root;
        let slope = (one - s * s) / root;
        let curvature = S::from_f64(-3.0) * s * slope / root;
        let steepness = self.friction * per_width;
        [
            v.scale(self.damping) + s.scale(self.friction),
            S::lift(self.damping) + slope.scale(steepness),
            curvature.scale(steepness * per_width),
        ]
    }
}

impl Drive<f64> {
    /// Converts the constants to another type.
    pub(super) fn cast<D: Scalar>(&self) -> Drive<D> {
        Drive {
            damping: D::from_f64(self.damping),
            friction: D::from_f64(self.friction),
            friction_velocity: D::from_f64(self.friction_velocity),
            armature: D::from_f64(self.armature),
        }
    }
}

impl<C: Scalar> Model<C> {
    /// The drives of the joints, `N` or none: a model without has neither losses nor rotor inertia.
    #[must_use]
    #[inline]
    pub fn drives(&self) -> &[Drive<C>] {
        &self.drives
    }

    /// Replaces the drives of the joints.
    ///
    /// # Errors
    /// There are neither `N` drives nor none.
    pub fn with_drives(mut self, drives: Vec<Drive<C>>) -> Result<Self> {
        if !drives.is_empty() {
            check_length("drives", self.dof(), drives.len())?;
        }
        self.drives = drives;
        Ok(self)
    }
}
