//! Models made in code.

use super::{Carrier, Frame, Joint, JointKind, Limits, Model};
use crate::error::{Error, Result};
use crate::scalar::{Ldlt, Scalar};
use crate::spatial::{Inertia, Placement};
use nalgebra::{DMatrix, Matrix3, Vector3};

/// The acceleration of gravity, m/s^2, downwards.
pub(crate) const STANDARD_GRAVITY: f64 = 9.81;

/// A joint and the body it moves, to build a [`Model`] from.
#[derive(Clone, Debug)]
pub struct JointSpec<C: Scalar> {
    /// The name of the joint. The frame of its body is called the same.
    pub name: String,
    /// What it does.
    pub kind: JointKind,
    /// The body that carries it, by the index of that body's joint; `None` is the base.
    pub parent: Option<usize>,
    /// Where it is in that body at `q = 0`.
    pub origin: Placement<C>,
    /// Its axis in its own frame, of length one.
    pub axis: Vector3<C>,
    /// The inertia of the body it moves, in the frame of the joint.
    pub inertia: Inertia<C>,
    /// Its limits.
    pub limits: Limits,
}

impl<C: Scalar> Model<C> {
    /// A model of the given joints under gravity $(0, 0, -9.81)$.
    ///
    /// # Errors
    /// There is no joint, a parent does not come before its child, or two joints share a name. Over `f64` see also
    /// [`Model::check_regular`].
    pub fn from_joints(name: &str, specs: Vec<JointSpec<C>>) -> Result<Self> {
        let mut model = Self {
            name: name.to_owned(),
            joints: Vec::with_capacity(specs.len()),
            inertias: Vec::with_capacity(specs.len()),
            frames: Vec::with_capacity(specs.len()),
            gravity: Vector3::new(C::zero(), C::zero(), C::from_f64(-STANDARD_GRAVITY)),
        };
        if specs.is_empty() {
            return Err(Error::input(name, "robot", "has no moving joint"));
        }
        for (i, spec) in specs.into_iter().enumerate() {
            let element = format!("joint '{}'", spec.name);
            if spec.parent.is_some_and(|p| p >= i) {
                return Err(Error::input(
                    name,
                    element,
                    "its parent does not come before it",
                ));
            }
            if model.joints.iter().any(|j| j.name() == spec.name) {
                return Err(Error::input(name, element, "the name occurs twice"));
            }
            model.frames.push(Frame {
                name: spec.name.clone(),
                body: Some(i),
                placement: Placement::identity(),
                carrier: Some(Carrier {
                    joint: spec.name.clone(),
                    parent: spec.parent,
                }),
            });
            model.joints.push(Joint::new(
                spec.name,
                spec.kind,
                spec.parent,
                spec.origin,
                spec.axis,
                spec.limits,
            ));
            model.inertias.push(spec.inertia);
        }
        Ok(model)
    }

    /// The same model with other frames.
    pub(super) fn with_frames(mut self, frames: Vec<Frame<C>>) -> Self {
        self.frames = frames;
        self
    }
}

impl Model<f64> {
    /// Checks that the mass matrix is regular: that no joint moves a subtree without inertia about it, and that no two
    /// joints move the same bodies in the same way.
    ///
    /// The mass matrix is looked at in one generic configuration: where it is singular there, it is everywhere, or nearly
    /// so. `file` names the model in the error. Cost O(N^3).
    ///
    /// # Errors
    /// Names the first such joint.
    pub fn check_regular(&self, file: &str) -> Result<()> {
        let n = self.dof();
        let mut placements: Vec<Placement<f64>> = Vec::with_capacity(n);
        for (i, joint) in self.joints.iter().enumerate() {
            let in_parent = joint.placement(0.7 + 0.9 * i as f64);
            let carrier = joint.parent().map(|p| placements[p]);
            placements.push(carrier.map_or(in_parent, |p| p.compose(&in_parent)));
        }
        let place = |(inertia, placement): (&Inertia<f64>, _)| inertia.placed(placement);
        let mut composite: Vec<_> = self.inertias.iter().zip(&placements).map(place).collect();
        let axis = |i: usize| self.joints[i].motion_subspace(&placements[i]);
        let mut h = DMatrix::zeros(n, n);
        for i in (0..n).rev() {
            let momentum = composite[i].apply(&axis(i));
            let mut ancestor = Some(i);
            while let Some(j) = ancestor {
                h[(i, j)] = axis(j).dot(&momentum);
                ancestor = self.joints[j].parent();
            }
            // Relative to all the inertia there is, so that rounding does not pass for inertia.
            let total = match self.joints[i].kind() {
                JointKind::Prismatic => composite[i].mass,
                JointKind::Revolute | JointKind::Continuous => composite[i].rotational.trace(),
            };
            let condition =
                "nothing that it moves has inertia about it, so the mass matrix is singular";
            self.check_pivot(i, h[(i, i)], total, file, condition)?;
            if let Some(parent) = self.joints[i].parent() {
                let carried = composite[i];
                composite[parent] += carried;
            }
        }
        let mut ldlt = Ldlt::new(n);
        ldlt.factorise(&h);
        let condition = "it moves nothing that the joints before it do not move alike, so the mass matrix is singular";
        for (i, pivot) in ldlt.pivots().enumerate() {
            self.check_pivot(i, pivot, h[(i, i)], file, condition)?;
        }
        Ok(())
    }

    /// Checks that `own` is not zero beside `total`.
    fn check_pivot(
        &self,
        i: usize,
        own: f64,
        total: f64,
        file: &str,
        condition: &str,
    ) -> Result<()> {
        if own.abs() > 1e-12 * total.abs() {
            return Ok(());
        }
        Err(Error::input(
            file,
            format!("joint '{}'", self.joints[i].name()),
            condition,
        ))
    }
}

/// A chain of `links` pendulums in the vertical plane: links of 1 m with a point mass of 1 kg at the middle and no
/// rotational inertia, axes along y, along -x at `q = 0`.
///
/// # Errors
/// `links` is zero.
pub fn pendulum(links: usize) -> Result<Model> {
    let specs = (0..links).map(|i| JointSpec {
        name: format!("joint_{}", i + 1),
        kind: JointKind::Continuous,
        parent: i.checked_sub(1),
        origin: Placement::new(
            Matrix3::identity(),
            Vector3::new(if i == 0 { 0.0 } else { -1.0 }, 0.0, 0.0),
        ),
        axis: Vector3::y(),
        inertia: Inertia::from_com(1.0, Vector3::new(-0.5, 0.0, 0.0), Matrix3::zeros()),
        limits: Limits::NONE,
    });
    Model::from_joints(&format!("pendulum_{links}"), specs.collect())
}
