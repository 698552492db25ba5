//! The placement of one frame in another.

use super::{Motion, apply, apply_to_constant, cross, matrix, multiply};
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// The placement of a frame B in a frame A: $r_A = R\\, r_B + p$.
///
/// In Featherstone's notation this is ${}^A X_B$ with $R = E^T$.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement<S: Scalar> {
    /// Rotation `R`: the axes of B in the coordinates of A.
    pub rotation: Matrix3<S>,
    /// Translation `p`: the origin of B in the coordinates of A, in m.
    pub translation: Vector3<S>,
}

impl<S: Scalar> Placement<S> {
    /// A placement from its parts. `rotation` must be orthogonal with determinant one.
    #[must_use]
    pub fn new(rotation: Matrix3<S>, translation: Vector3<S>) -> Self {
        Self { rotation, translation }
    }

    /// The placement of coincident frames.
    #[must_use]
    pub fn identity() -> Self {
        Self::new(Matrix3::identity(), Vector3::zeros())
    }

    /// Computes the placement of C in A from `self`, that of B in A, and `inner`, that of C in B.
    #[inline]
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        Self::new(
            multiply(&self.rotation, &inner.rotation),
            apply(&self.rotation, &inner.translation) + self.translation,
        )
    }

    /// The position of a constant point of this frame in the reference frame.
    #[inline]
    #[must_use]
    pub fn point<C: Scalar>(&self, point: &Vector3<C>) -> Vector3<S>
    where
        S: AlgebraOver<C>,
    {
        apply_to_constant(&self.rotation, point) + self.translation
    }

    /// Computes [`compose`](Self::compose) for a constant `inner`.
    #[must_use]
    pub fn compose_constant<C: Scalar>(&self, inner: &Placement<C>) -> Self
    where
        S: AlgebraOver<C>,
    {
        let column = |j| apply_to_constant(&self.rotation, &inner.rotation.column(j).into_owned());
        let columns = [column(0), column(1), column(2)];
        Self::new(matrix(|i, j| columns[j][i]), self.point(&inner.translation))
    }

    /// Transforms a motion from B to A (2.24 in the book).
    #[must_use]
    pub fn act(&self, m: &Motion<S>) -> Motion<S> {
        let angular = apply(&self.rotation, &m.angular);
        Motion::new(angular, apply(&self.rotation, &m.linear) + cross(&self.translation, &angular))
    }
}

/// The position of a constant point of a frame with this placement in the reference frame; `None` is that frame.
#[cfg(feature = "solvers")]
#[inline(always)]
pub(crate) fn placed_point<C: Scalar, S: AlgebraOver<C>>(
    placement: Option<&Placement<S>>,
    point: &Vector3<C>,
) -> Vector3<S> {
    match placement {
        None => point.map(S::lift),
        Some(placement) => placement.point(point),
    }
}

/// The unit vector in the direction of a vector of any length; `None` if that is zero or not finite.
#[must_use]
pub fn unit_vector(v: &Vector3<f64>) -> Option<Vector3<f64>> {
    // Scaled first, so that squares neither overflow nor vanish.
    let scaled = v / v.amax();
    scaled.iter().all(|x| x.is_finite()).then(|| scaled.normalize())
}

/// A rotation that maps the `z` axis to a direction, a vector of any length but zero.
#[must_use]
pub fn rotation_of_z_to(direction: &Vector3<f64>) -> Matrix3<f64> {
    // Against the axis any half turn will do.
    let direction = unit_vector(direction).unwrap_or_else(Vector3::z);
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI));
    turn.to_rotation_matrix().into_inner()
}
