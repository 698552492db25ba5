//! Regularity of the mass matrix of a robot.

use crate::dynamics::{Data, crba, forward_kinematics};
use crate::error::{Error, Result};
use crate::linalg::Ldlt;
use crate::model::{Joint, JointKind, Model};
use crate::spatial::Placement;
use nalgebra::DMatrix;

/// The mass matrix in a generic configuration.
struct Generic {
    h: DMatrix<f64>,
    /// The joints without inertia about them, from the last to the first.
    massless: Vec<usize>,
}

/// Returns true if an inertia counts beside a total one, and is no rounding error.
fn counts(own: f64, total: f64) -> bool {
    own.abs() > 1e-12 * total.abs()
}

impl Model<f64> {
    /// Checks that the mass matrix is regular: that every joint has rotor inertia or moves a subtree with inertia about
    /// it, and otherwise than the joints before it do.
    ///
    /// The mass matrix is tested in one generic configuration: if it is singular there, it is singular everywhere, or
    /// nearly so. `file` names the model in the error. Cost O(N^3).
    ///
    /// # Errors
    /// Names the first faulty joint.
    pub fn check_regular(&self, file: &str) -> Result<()> {
        match self.singular_joints()?.first() {
            None => Ok(()),
            Some((i, condition)) => {
                let joint = format!("joint '{}'", self.joints()[*i].name());
                Err(Error::input(file, joint, *condition))
            }
        }
    }

    /// The joints that make the mass matrix singular, each with the reason, by the test of
    /// [`check_regular`](Self::check_regular): those that move nothing with inertia about them from the last to the
    /// first, otherwise the first that moves nothing otherwise than those before it. Cost O(N^3).
    ///
    /// # Errors
    /// None on a model that was built.
    pub fn singular_joints(&self) -> Result<Vec<(usize, &'static str)>> {
        let Generic { h, massless } = self.generic()?;
        let condition = "nothing that it moves has inertia about it, so the mass matrix is singular; rotor inertia \
            (in a scenario: \"losses\": {\"armature\": ...}) would make it regular, and so would a joint that does not \
            move (\"locked_joints\", \"group\")";
        if !massless.is_empty() {
            return Ok(massless.into_iter().map(|i| (i, condition)).collect());
        }
        let mut ldlt = Ldlt::new(self.dof());
        ldlt.factorise(&h);
        let condition = "it moves nothing that the joints before it do not move alike, so the mass matrix is singular";
        let mut pivots = ldlt.pivots().enumerate();
        let alike = pivots.find(|(i, pivot)| !counts(*pivot, h[(*i, *i)]));
        Ok(alike.map(|(i, _)| (i, condition)).into_iter().collect())
    }

    /// Rotor inertias for the joints that move nothing with inertia about them, kg m^2 or kg, with which those joints
    /// count as much as the lightest other joint of their kind: its inertia in a generic configuration. Without another
    /// joint of their kind they have unit inertia, with which the effort is the squared acceleration. Cost O(N^2).
    ///
    /// # Errors
    /// None on a model that was built.
    pub fn substitute_rotors(&self) -> Result<Vec<(usize, f64)>> {
        let Generic { h, massless } = self.generic()?;
        let slides = |i: usize| self.joints()[i].kind() == JointKind::Prismatic;
        let rotor = |of: usize| {
            let others = (0..self.dof()).filter(|i| !massless.contains(i) && slides(*i) == slides(of));
            let lightest = others.map(|i| h[(i, i)]).min_by(f64::total_cmp);
            lightest.unwrap_or(1.0)
        };
        Ok(massless.iter().map(|i| (*i, rotor(*i))).collect())
    }

    /// Computes the mass matrix and finds the joints without inertia. Cost O(N^2).
    fn generic(&self) -> Result<Generic> {
        let n = self.dof();
        let q: Vec<f64> = (0..n).map(|i| 0.7 + 0.9 * i as f64).collect();
        let mut h = DMatrix::zeros(n, n);
        crba(self, &mut Data::new(self), &q, &mut h)?;
        let totals = self.subtree_inertias(&q)?;
        let massless = (0..n).rev().filter(|i| !counts(h[(*i, *i)], totals[*i]));
        Ok(Generic { massless: massless.collect(), h })
    }

    /// Per joint, the mass of its subtree if it is prismatic, otherwise the trace of the rotational inertia of its
    /// subtree about the origin of the base frame.
    fn subtree_inertias(&self, q: &[f64]) -> Result<Vec<f64>> {
        let n = self.dof();
        let mut placements = vec![Placement::identity(); n];
        forward_kinematics(self, q, &mut placements)?;
        let mut sums: Vec<[f64; 2]> = (self.inertias().iter().zip(&placements))
            .map(|(inertia, placement)| [inertia.mass, inertia.placed(placement).rotational.trace()])
            .collect();
        for (i, joint) in self.joints().iter().enumerate().rev() {
            if let Some(parent) = joint.parent() {
                let [mass, trace] = sums[i];
                sums[parent][0] += mass;
                sums[parent][1] += trace;
            }
        }
        let total = |(joint, [mass, trace]): (&Joint<f64>, [f64; 2])| match joint.kind() {
            JointKind::Prismatic => mass,
            JointKind::Revolute | JointKind::Continuous => trace,
        };
        Ok(self.joints().iter().zip(sums).map(total).collect())
    }
}
