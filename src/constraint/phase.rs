//! The phases of a motion, in each of which the robot stands on another foot.

use super::StandingFoot;
use crate::error::{Error, Result, plain};
use crate::model::Model;
use crate::scalar::{Scalar, Wide};
use nalgebra::DMatrix;
use std::ops::Range;

/// A phase of a motion: the foot on which the robot stands is the root of its tree.
///
/// Another root changes neither the joints nor their positions, only their order
/// ([`reroot`](crate::urdf::reroot())), so phases share positions and velocities. A phase has as many segments as any
/// other, and a duration of its own where the motion has [parts](crate::direct::DirectSettings::parts).
#[derive(Clone, Debug)]
pub struct Phase {
    /// The robot with the foot as its root.
    pub model: Model,
    /// The joint of the motion for each joint of this robot.
    pub order: Vec<usize>,
    /// The foot.
    pub foot: StandingFoot,
    /// The rows of the state that are kept in this phase alone.
    pub rows: Range<usize>,
}

/// Returns true if an order has each of `n` joints once.
pub(crate) fn is_permutation(order: &[usize], n: usize) -> bool {
    let mut all = order.to_vec();
    all.sort_unstable();
    all.into_iter().eq(0..n)
}

impl Phase {
    /// Refuses a phase of a motion of `model` with other rows than those of the first `foot`.
    pub(super) fn check(&self, model: &Model, states: usize, foot: &StandingFoot) -> Result<()> {
        let refuse = |condition: String| Err(Error::input("phases", &self.foot.name, condition));
        if self.model.dof() != model.dof() || !is_permutation(&self.order, model.dof()) {
            return refuse("its joints are not those of the motion".to_owned());
        }
        if self.foot.dim() != foot.dim() {
            return refuse("its foot has more or fewer bounds than the first one".to_owned());
        }
        let off = (self.foot.weight - foot.weight).abs();
        if off > f64::EPSILON.sqrt() * foot.weight {
            let [own, first] = [self.foot.weight, foot.weight].map(plain);
            return refuse(format!("its robot weighs {own} N, the first one {first} N"));
        }
        if self.rows.end > states || self.rows.start > self.rows.end {
            let Range { start, end } = self.rows;
            return refuse(format!("it has rows {start} to {end} of {states}"));
        }
        Ok(())
    }

    /// A matrix in $[q; v; a]$ of this robot as one in that of the motion.
    pub(crate) fn restored<S: Scalar>(&self, of: &DMatrix<S>) -> DMatrix<S> {
        let n = self.order.len();
        let at = |i: usize| i - i % n + self.order[i % n];
        let mut found = of.clone();
        for j in 0..of.ncols() {
            for i in 0..of.nrows() {
                found[(at(i), at(j))] = of[(i, j)];
            }
        }
        found
    }

    /// Sorts the state $[q; v; a]$ of the motion by the joints of this robot.
    pub(crate) fn sort<S: Scalar>(&self, z: &[Wide<S>], to: &mut [Wide<S>]) {
        let n = self.order.len();
        for (i, to) in to.iter_mut().enumerate() {
            *to = z[i - i % n + self.order[i % n]];
        }
    }
}
