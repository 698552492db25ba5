//! Verification of every derivative, every formula and the underlying dynamics.
//!
//! Three kinds of witnesses check this library, and no claim rests on one of them alone. No witness uses the formulas
//! that it checks: each computes by differentiation, or by another method, the quantities that the fast code has in
//! closed form.
//!
//! # Dual numbers: [`duals`]
//!
//! The code of the dynamics is generic in its number type. Over the dual numbers of `num-dual` it gives derivatives by
//! automatic differentiation, and [`check_all`] compares every analytic derivative with these at random states of any
//! robot.
//!
//! - **Sees** a wrong term, sign, index or transpose in any analytic derivative, in the code that is used, in double
//!   precision with its fast paths, on the user's own robot with its conditioning. The bounds are those of rounding:
//!   about 1e-9, larger for divisions by an ill-conditioned mass matrix.
//! - **Does not see** errors at states that were not drawn; a term that is smaller than its bound relative to the
//!   others; and errors in the plain dynamics, because their derivatives are then wrong in the same way.
//!
//! # A prime field: [`field`]
//!
//! The same generic code runs over the integers modulo $2^{61} - 1$, where there is no rounding. [`prove`] evaluates
//! both sides of every numbered equation at random robots and states and compares them with `==`. A false identity
//! passes three random instances with a probability below $2 \cdot 10^{-40}$. The pages in `proofs/` state the
//! equations, and a test ties pages, code and identities together.
//!
//! - **Sees** every error in a formula, however small the term, for trees of joints with all kinds of branching.
//! - **Does not see** the values of distances, because roots and signs are formal over the field, only that their
//!   derivatives match; rounding, overflow and cancellation; code that only `f64` uses, namely products of large
//!   matrices by `faer` ([`linalg`](crate::linalg)) and sines of four numbers at once by `wide`
//!   ([`Lanes`](crate::scalar::Lanes)), which the property tests `the_fast_paths_agree_with_the_generic_code` compare
//!   with the generic code; inequalities, comparisons and everything else about order, such as the termination and the
//!   result of a search; and a law that is consistently wrong.
//!
//! # Pinocchio and Parry: `tests/oracle`
//!
//! The dynamics, their first and second derivatives, Jacobians of frames, constraints, $\Omega$ and its Jacobians are
//! compared with Pinocchio on random robots and on the URDF files of two public collections, distances of balls from
//! obstacles with Parry.
//!
//! - **Sees** errors that the other two cannot see, because both are consistent with themselves: gravity with the wrong
//!   sign, a frame convention, a URDF that is misread.
//! - **Does not see** quantities for which Pinocchio has no function, except by differences of its functions, and runs
//!   only where Pinocchio is installed: it is a test of the library and not part of it.
//!
//! # Claims and their witnesses
//!
//! | claim | witness | where |
//! | --- | --- | --- |
//! | first and second derivatives of the dynamics | all three | [`check_dynamics`](duals::check_dynamics), [`prove`], oracle |
//! | the forms of $\Omega$ agree with its definition | all three | [`check_dynamics`](duals::check_dynamics), [`prove`], oracle |
//! | Theorem B3, Theorem B4 and their proofs, label by label | field; B4 also by duals | [`prove`] |
//! | every Jacobian of the flow | all three | [`check_jacobian`](duals::check_jacobian), [`prove`], oracle |
//! | the flow of any Lagrangian in any metric, with weights, duals and running costs | field, duals | [`check_flow`](duals::check_flow), [`check_general_flow`](duals::check_general_flow), [`prove`] |
//! | the Lagrangian of the weak form of the flow and its metric; the derivatives of the action of a curve | field; the Lagrangian also by duals | [`check_weak_form`](duals::check_weak_form), [`prove`] |
//! | weighted derivatives of constraints, the constrained flow | all three | [`check_constraints`](duals::check_constraints), [`prove`], oracle |
//! | gradient and Hessian of the direct method | field; gradient also against the flow | [`prove`], [`check_direct`](duals::check_direct) |
//! | the dynamics are those of the robot in the URDF | Pinocchio | oracle |
//! | distances from boxes, cylinders, capsules and balls | Parry | oracle |
//! | their derivatives, and those of clearances | field, duals | [`check_constraints`](duals::check_constraints), [`prove`] |
//!
//! On the command line `aghf check ROBOT` is [`check_all`] and `aghf prove` is [`prove`]; `tests/run --test oracle`
//! runs the oracle. The reference formulas of both built-in witnesses are written once, generic in the number type, in
//! [`reference`](mod@reference).
//!
//! # Checking a user-defined object
//!
//! Each page of the [guide](crate::guide) checks its own example by one of these:
//!
//! - a robot: [`check_all`] on its model, or `aghf check robot.urdf`; in the same way for a new
//!   [joint](crate::guide::joint);
//! - a [Jacobian](crate::guide::jacobian): [`check_jacobian`](duals::check_jacobian);
//! - a [constraint](crate::guide::constraint): [`check_constraint`](duals::check_constraint);
//! - a [running cost](crate::guide::running_cost): [`check_running_cost`](duals::check_running_cost);
//! - a [Lagrangian, metric or drift](crate::guide::lagrangian): [`check_flow`](duals::check_flow) against a right-hand
//!   side and its Jacobian, [`prove_identities`](field::prove_identities);
//! - any other function: [`reference::jacobian`] and [`reference::gradient`] differentiate it by dual numbers, over
//!   `f64` or over the field.
//!
//! ```
//! use aghf::urdf::builtin_robot;
//! use aghf::verify::{CheckOptions, check_all};
//!
//! let model = builtin_robot("pendulum_2")?;
//! let options = CheckOptions { samples: 2, ..CheckOptions::default() };
//! for finding in check_all(&model, &options)? {
//!     assert!(finding.passes(), "{}: {:e}", finding.quantity, finding.error);
//! }
//! # aghf::Result::Ok(())
//! ```

pub mod duals;
pub mod field;
pub mod reference;

pub use duals::{CheckOptions, check_all};
pub use field::prove;
