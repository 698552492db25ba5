//! Jacobians by name, built-in and user-defined.

use super::{CentralDifference, ControlFormJacobian, ForwardDual, NodeJacobian, TheoremB4};
use crate::constraint::Constraint;
use crate::error::{Error, Result};
use crate::flow::{Penalised, Sum, foot_penalty};
use crate::model::Model;
use crate::names::none_of;
use std::fmt;

crate::names::named_enum! {
/// The built-in implementations.
pub enum JacobianKind("jacobian") {
    /// Analytic, by contracted second derivatives of inverse dynamics.
    ControlForm = "control_form",
    /// Analytic, composed from explicit tensors as Theorem B4 has it: the reference.
    TheoremB4 = "theorem_b4",
    /// Dual numbers, eight tangents at a time.
    Dual = "dual",
    /// Central differences of order four, for comparison only.
    Difference = "difference",
}
}

impl JacobianKind {
    /// Builds the implementation for `model`.
    #[must_use]
    pub fn build(self, model: &Model) -> Box<dyn NodeJacobian + '_> {
        match self {
            Self::ControlForm => Box::new(ControlFormJacobian::new(model)),
            Self::TheoremB4 => Box::new(TheoremB4::new(model)),
            Self::Dual => Box::new(ForwardDual::new(model)),
            Self::Difference => Box::new(CentralDifference::new(model)),
        }
    }

    /// Builds the implementation for `model` with constraints, (A4). Dual numbers and differences act on the whole
    /// right-hand side; the control form includes the torque terms, and the state terms are added to it; Theorem B4
    /// applies only to the paper's Lagrangian, and both are added as [`Penalised::with_penalties`] does. Those of a
    /// standing foot are added to each, by dual numbers or differences.
    #[must_use]
    pub fn build_constrained<'a, K: Constraint>(
        self,
        model: &'a Model,
        constraints: &'a Penalised<K>,
    ) -> Box<dyn NodeJacobian + 'a> {
        let n = model.dof();
        let own: Box<dyn NodeJacobian + 'a> = match self {
            Self::ControlForm => Box::new(Sum::new(
                ControlFormJacobian::with_cost(model, constraints.torque_penalty()),
                constraints.state_penalty(model),
            )),
            Self::TheoremB4 => Box::new(constraints.with_penalties(model, TheoremB4::<f64, f64>::new(model))),
            Self::Dual => Box::new(ForwardDual::of(constraints.right_hand_side(model), n)),
            Self::Difference => Box::new(CentralDifference::of(constraints.right_hand_side(model), n)),
        };
        match &constraints.constraints.stage.foot {
            None => own,
            Some(foot) => {
                let of_foot = (foot, constraints.weights.torque);
                Box::new(Sum::new(own, foot_penalty::jacobian(self, model, of_foot)))
            }
        }
    }
}

/// A function that builds an implementation for a model.
type Constructor = Box<dyn for<'m> Fn(&'m Model) -> Box<dyn NodeJacobian + 'm> + Send + Sync>;

/// Implementations of the Jacobian by name, in the order in which they were registered.
///
/// [`verify::duals::check_jacobians`](crate::verify::duals::check_jacobians) checks all of them, and
/// [`Flow::jacobian`](crate::flow::Flow::jacobian) accepts the result of [`build`](Self::build).
pub struct Jacobians {
    entries: Vec<(String, Constructor)>,
}

impl Jacobians {
    /// The registry of the built-in implementations, under the names of [`JacobianKind`].
    #[must_use]
    pub fn built_in() -> Self {
        let entry = |(name, kind): (&str, JacobianKind)| {
            let build: Constructor = Box::new(move |model| kind.build(model));
            (name.to_owned(), build)
        };
        Self { entries: JacobianKind::by_name().map(entry).collect() }
    }

    /// Adds an implementation under a new name.
    ///
    /// # Errors
    /// The name is in use.
    pub fn register(
        &mut self,
        name: &str,
        build: impl for<'m> Fn(&'m Model) -> Box<dyn NodeJacobian + 'm> + Send + Sync + 'static,
    ) -> Result<()> {
        if self.names().any(|own| own == name) {
            let condition = format!("'{name}' is taken");
            return Err(Error::input("options", "jacobian", condition));
        }
        self.entries.push((name.to_owned(), Box::new(build)));
        Ok(())
    }

    /// The registered names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|(name, _)| name.as_str())
    }

    /// Builds the implementation of this name for `model`.
    ///
    /// # Errors
    /// The name is not registered; the error lists the names.
    pub fn build<'m>(&self, name: &str, model: &'m Model) -> Result<Box<dyn NodeJacobian + 'm>> {
        match self.entries.iter().find(|(own, _)| own == name) {
            Some((_, build)) => Ok(build(model)),
            None => Err(none_of("jacobian", name, self.names())),
        }
    }
}

impl Default for Jacobians {
    fn default() -> Self {
        Self::built_in()
    }
}

impl fmt::Debug for Jacobians {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}
