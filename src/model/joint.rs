//! One degree of freedom.

use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Motion, Placement, apply_to_constant, cross, cross_matrix};
use nalgebra::{Matrix3, Vector3};

/// The kind of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Rotates about its axis, within limits.
    Revolute,
    /// Rotates about its axis without limits; one degree of freedom, an unbounded angle in radians.
    Continuous,
    /// Slides along its axis.
    Prismatic,
}

impl JointKind {
    /// The joint type in a URDF.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
        }
    }
}

/// The limits of a joint, in rad or m, rad/s or m/s, N m or N. Infinite without a limit; in a URDF a velocity or effort
/// limit of zero also means no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Lower position limit.
    pub lower: f64,
    /// Upper position limit.
    pub upper: f64,
    /// Velocity limit.
    pub velocity: f64,
    /// Effort limit: torque or force.
    pub effort: f64,
}

impl Limits {
    /// No limits.
    pub const NONE: Self =
        Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY, velocity: f64::INFINITY, effort: f64::INFINITY };

    /// The position within the limits that is nearest to `q`.
    #[must_use]
    pub fn nearest(&self, q: f64) -> f64 {
        q.max(self.lower).min(self.upper)
    }
}

/// A joint with one degree of freedom about or along any axis.
#[derive(Clone, Debug)]
pub struct Joint<C: Scalar> {
    name: String,
    kind: JointKind,
    parent: Option<usize>,
    limits: Limits,
    axis: Vector3<C>,
    origin: Placement<C>,
    /// With `R_0` the rotation of the origin and `a` the axis, the rotation of the joint is
    /// `R_0 (a a^T + cos q (1 - a a^T) + sin q [a]x)`: these are the last two products.
    cosine_part: Matrix3<C>,
    sine_part: Matrix3<C>,
}

impl<C: Scalar> Joint<C> {
    /// A joint at `origin` in its parent body. `axis` is a unit vector in the frame of the joint.
    pub(crate) fn new(
        name: String,
        kind: JointKind,
        parent: Option<usize>,
        origin: Placement<C>,
        axis: Vector3<C>,
        limits: Limits,
    ) -> Self {
        let perpendicular = Matrix3::identity() - axis * axis.transpose();
        Self {
            name,
            kind,
            parent,
            limits,
            axis,
            origin,
            cosine_part: origin.rotation * perpendicular,
            sine_part: origin.rotation * cross_matrix(&axis),
        }
    }

    /// The name of the joint.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The kind of the joint.
    #[must_use]
    pub fn kind(&self) -> JointKind {
        self.kind
    }

    /// The parent body $\lambda(i)$; `None` for the base.
    #[must_use]
    pub fn parent(&self) -> Option<usize> {
        self.parent
    }

    /// The limits of the joint.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The axis, a unit vector in the frame of the joint.
    #[must_use]
    pub fn axis(&self) -> &Vector3<C> {
        &self.axis
    }

    /// The placement of the joint in its parent body at `q = 0`.
    #[must_use]
    pub fn origin(&self) -> &Placement<C> {
        &self.origin
    }

    /// Computes the placement of body `i` in its parent at position `q`: ${}^{\lambda(i)} X_i$ (4.3 in Featherstone's
    /// book).
    #[must_use]
    #[inline]
    pub fn placement<S: AlgebraOver<C>>(&self, q: S) -> Placement<S> {
        self.placement_turned(q, q.sin_cos())
    }

    /// Computes [`placement`](Self::placement) from `q`, its sine and its cosine.
    #[inline]
    pub(crate) fn placement_turned<S: AlgebraOver<C>>(&self, q: S, (sin, cos): (S, S)) -> Placement<S> {
        let lift = |v: &Vector3<C>| v.map(S::lift);
        match self.kind {
            JointKind::Revolute | JointKind::Continuous => {
                let one_less_cos = cos - S::one();
                let rotation = self.origin.rotation.zip_zip_map(&self.cosine_part, &self.sine_part, |fixed, c, s| {
                    one_less_cos.scale(c) + sin.scale(s) + S::lift(fixed)
                });
                Placement::new(rotation, lift(&self.origin.translation))
            }
            JointKind::Prismatic => {
                let direction = self.origin.rotation * self.axis;
                let translation = (self.origin.translation).zip_map(&direction, |p, d| q.scale(d) + S::lift(p));
                Placement::new(self.origin.rotation.map(S::lift), translation)
            }
        }
    }

    /// Computes the motion subspace $S_i$, the motion at unit joint velocity, in the coordinates of the frame in which
    /// the body is placed at `placement`.
    #[must_use]
    #[inline]
    pub fn motion_subspace<S: AlgebraOver<C>>(&self, placement: &Placement<S>) -> Motion<S> {
        let axis = apply_to_constant(&placement.rotation, &self.axis);
        match self.kind {
            JointKind::Revolute | JointKind::Continuous => Motion::new(axis, cross(&placement.translation, &axis)),
            JointKind::Prismatic => Motion::new(Vector3::zeros(), axis),
        }
    }
}

impl Joint<f64> {
    /// Converts the constants to another type.
    pub(crate) fn cast<D: Scalar>(&self) -> Joint<D> {
        Joint {
            name: self.name.clone(),
            kind: self.kind,
            parent: self.parent,
            limits: self.limits,
            axis: self.axis.map(D::from_f64),
            origin: Placement::new(self.origin.rotation.map(D::from_f64), self.origin.translation.map(D::from_f64)),
            cosine_part: self.cosine_part.map(D::from_f64),
            sine_part: self.sine_part.map(D::from_f64),
        }
    }
}
