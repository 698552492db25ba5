//! Scratch space.

use crate::error::{Result, check_length};
use crate::linalg::Tiled;
use crate::model::Model;
use crate::scalar::Scalar;
use crate::spatial::{ArticulatedInertia, Coriolis, Force, Inertia, Motion, Placement};
use nalgebra::Vector3;

/// Scratch space for the algorithms on one model. It carries no state from one call to the next.
#[derive(Clone, Debug)]
pub struct Data<S: Scalar = f64> {
    /// Placements of the bodies in the base frame.
    pub(super) placements: Vec<Placement<S>>,
    /// Joint axes $S_i$.
    pub(super) axes: Vec<Motion<S>>,
    /// Body velocities.
    pub(super) velocities: Vec<Motion<S>>,
    /// Body accelerations, including gravity.
    pub(super) accelerations: Vec<Motion<S>>,
    /// $\ddot\Psi$ of the joints, see [`rnea_derivatives`](super::rnea_derivatives()).
    pub(super) psi_ddot: Vec<Motion<S>>,
    /// Body inertias, then those of subtrees.
    pub(super) inertias: Vec<Inertia<S>>,
    /// Body Coriolis matrices, then those of subtrees.
    pub(super) coriolis: Vec<Coriolis<S>>,
    /// Body forces, then those of subtrees.
    pub(super) forces: Vec<Force<S>>,
    /// Rates of the axes.
    pub(super) axis_rates: Vec<Motion<S>>,
    /// Virtual velocities of the bodies, at joint velocities equal to the weights of a contraction.
    pub(super) virtual_velocities: Vec<Motion<S>>,
    /// Momenta of the bodies at the virtual velocities, then those of subtrees.
    pub(super) virtual_momenta: Vec<Force<S>>,
    /// Coriolis matrices of the bodies at the virtual velocities, then those of subtrees.
    pub(super) virtual_coriolis: Vec<Coriolis<S>>,
    /// Couples: transposed Coriolis matrices times virtual velocities, then sums over subtrees.
    pub(super) virtual_couples: Vec<Vector3<S>>,
    /// The contribution of the motion of a joint to the virtual velocities of its subtree.
    pub(super) virtual_axis_rates: Vec<Motion<S>>,
    /// Articulated-body inertias.
    pub(super) articulated: Vec<ArticulatedInertia<S>>,
    /// $U_i = I^A_i S_i$, articulated-body inertias times axes.
    pub(super) articulated_axes: Vec<Force<S>>,
    /// One number per joint; after [`aba`](super::aba()) $D_i = S_i^T U_i$, plus the armature of the
    /// drive.
    pub(super) scalar_scratch: Vec<S>,
    /// The inverse of the mass matrix.
    pub(super) h_inverse: Tiled<S>,
    /// The joints on one path to the base with a given joint.
    pub(super) related: Vec<usize>,
    /// Factors of these joints.
    pub(super) factors: [Vec<S>; 2],
    /// For each joint, the largest index of a joint in its subtree.
    pub(super) last_after: Vec<usize>,
}

impl<S: Scalar> Data<S> {
    /// Scratch space for `model`.
    #[must_use]
    pub fn new<C: Scalar>(model: &Model<C>) -> Self {
        let n = model.dof();
        Self {
            placements: vec![Placement::identity(); n],
            axes: vec![Motion::zero(); n],
            velocities: vec![Motion::zero(); n],
            accelerations: vec![Motion::zero(); n],
            psi_ddot: vec![Motion::zero(); n],
            inertias: vec![Inertia::zero(); n],
            coriolis: vec![Coriolis::new(&Inertia::zero(), &Motion::zero()); n],
            forces: vec![Force::zero(); n],
            axis_rates: vec![Motion::zero(); n],
            virtual_velocities: vec![Motion::zero(); n],
            virtual_momenta: vec![Force::zero(); n],
            virtual_coriolis: vec![Coriolis::new(&Inertia::zero(), &Motion::zero()); n],
            virtual_couples: vec![Vector3::zeros(); n],
            virtual_axis_rates: vec![Motion::zero(); n],
            articulated: vec![ArticulatedInertia::new(&Inertia::zero()); n],
            articulated_axes: vec![Force::zero(); n],
            scalar_scratch: vec![S::zero(); n],
            h_inverse: Tiled::new(n),
            related: Vec::with_capacity(n),
            factors: [Vec::with_capacity(n), Vec::with_capacity(n)],
            last_after: vec![0; n],
        }
    }

    /// Checks that the scratch space was made for a model of this size.
    pub(super) fn check<C: Scalar>(&self, model: &Model<C>) -> Result<()> {
        check_length("data", model.dof(), self.placements.len())
    }
}
