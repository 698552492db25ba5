//! The Jacobian of the right-hand side at one node: one file for each way to compute it, behind one trait.

mod central_difference;
mod control_form;
mod forward_dual;
pub mod theorem_b4;

pub use central_difference::CentralDifference;
pub use control_form::ControlFormJacobian;
pub use forward_dual::ForwardDual;
pub use theorem_b4::TheoremB4;

use super::{Node, Penalised, Sum};
use crate::constraint::Constraint;
use crate::dynamics::check_square;
use crate::error::Result;
use crate::model::Model;
use crate::scalar::Scalar;
use clap::ValueEnum;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// The three blocks of the Jacobian of $\Omega(x, \dot x, \ddot x, k)$, `2 N` by `2 N` each; rows are those of $\Omega$.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeBlocks<S: Scalar = f64> {
    /// $d\Omega / dx$, (B38).
    pub dx: DMatrix<S>,
    /// $d\Omega / d\dot x$, (B39).
    pub dxdot: DMatrix<S>,
    /// $d\Omega / d\ddot x$, (B40).
    pub dxddot: DMatrix<S>,
}

impl<S: Scalar> NodeBlocks<S> {
    /// Room for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zeros = || DMatrix::zeros(2 * n, 2 * n);
        Self {
            dx: zeros(),
            dxdot: zeros(),
            dxddot: zeros(),
        }
    }

    /// Checks that the blocks are those of a model with `n` joints.
    pub(crate) fn check(&self, n: usize) -> Result<()> {
        for (what, block) in [
            ("dx", &self.dx),
            ("dxdot", &self.dxdot),
            ("dxddot", &self.dxddot),
        ] {
            check_square(what, 2 * n, block)?;
        }
        Ok(())
    }
}

/// A way to compute the Jacobian of the right-hand side at one node, over the scalar `S` for a model with constants `C`.
pub trait NodeJacobian<C = f64, S: Scalar = f64> {
    /// The three blocks at `node` with penalty `k`, into `out`.
    ///
    /// # Errors
    /// `node` or `out` was made for a model of another size.
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()>;
}

impl<C, S: Scalar, J: NodeJacobian<C, S> + ?Sized> NodeJacobian<C, S> for Box<J> {
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        (**self).evaluate(node, k, out)
    }
}

/// Makes [`JacobianKind`] of the implementations: one line each, `name: type`. A type is made by `new(model)`.
macro_rules! implementations {
    ($($(#[$about:meta])* $kind:ident: $type:ident,)*) => {
        /// The implementations by name.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
        #[serde(rename_all = "kebab-case")]
        pub enum JacobianKind {
            $($(#[$about])* $kind,)*
        }

        impl JacobianKind {
            /// The implementation for `model`.
            #[must_use]
            pub fn build(self, model: &Model) -> Box<dyn NodeJacobian + '_> {
                match self {
                    $(Self::$kind => Box::new($type::new(model)),)*
                }
            }
        }
    };
}

implementations! {
    /// Analytic, by contracted second derivatives of inverse dynamics.
    #[default] ControlForm: ControlFormJacobian,
    /// Analytic, composed from explicit tensors as Theorem B4 has it: the reference.
    TheoremB4: TheoremB4,
    /// Dual numbers, eight tangents at a time.
    Dual: ForwardDual,
    /// Central differences of order four, for comparison only.
    Difference: CentralDifference,
}

impl JacobianKind {
    /// The implementation for `model` with constraints, (A4). Duals and differences see the whole right-hand side. An analytic
    /// implementation gains the analytic terms of the constraints; the control form has those of the torque in its own.
    #[must_use]
    pub fn build_constrained<'a, K: Constraint>(
        self,
        model: &'a Model,
        constraints: &'a Penalised<K>,
    ) -> Box<dyn NodeJacobian + 'a> {
        let (n, torque) = (model.dof(), constraints.torque_penalty());
        let of_state = constraints.state_penalty(model);
        match self {
            Self::Dual => Box::new(ForwardDual::of(constraints.right_hand_side(model), n)),
            Self::Difference => {
                Box::new(CentralDifference::of(constraints.right_hand_side(model), n))
            }
            Self::ControlForm => Box::new(Sum::new(
                ControlFormJacobian::with_cost(model, torque),
                of_state,
            )),
            other => {
                let of_torque = ControlFormJacobian::of_cost(model, torque);
                let paper = Sum::new(other.build(model), of_torque);
                Box::new(Sum::new(paper, of_state))
            }
        }
    }

    /// All implementations with the names by which they are chosen.
    pub fn by_name() -> impl Iterator<Item = (String, Self)> {
        Self::value_variants().iter().filter_map(|kind| {
            let name = kind.to_possible_value()?.get_name().to_owned();
            Some((name, *kind))
        })
    }
}
