//! How every derivative, every formula and the dynamics below them are checked.
//!
//! Three kinds of witnesses check this library, and no claim rests on one of them alone. None of them uses the formulas that it is a
//! witness of: each differentiates, or computes in another way, what the fast code has in closed form.
//!
//! # Dual numbers: [`duals`]
//!
//! The code of the dynamics is generic in its numbers. Run over the dual numbers of `num-dual` it gives derivatives by automatic
//! differentiation, and [`check_all`] compares every analytic derivative with these at random states of any robot.
//!
//! - **Sees** a wrong term, sign, index or transpose in any analytic derivative, in the code that is used, in double precision
//!   with its fast paths, on the user's own robot with its own conditioning. It compares to rounding: the bounds are about 1e-9,
//!   larger where an ill-conditioned mass matrix is divided by.
//! - **Does not see** what happens at states that were not drawn; a term that is smaller than its bound beside the others; and
//!   anything that is wrong in the plain dynamics, since their derivatives are then wrong in the same way.
//!
//! # A prime field: [`field`]
//!
//! The same generic code runs over the integers modulo $2^{61} - 1$, where there is no rounding. [`prove`] evaluates both sides of
//! every numbered equation at random robots and states and compares them with `==`. A false identity passes three random instances with a
//! probability below $2 \cdot 10^{-40}$. The pages in `proofs/` state the equations, and a test ties pages, code and identities together.
//!
//! - **Sees** every error in a formula, however small the term, for trees of joints with all kinds of branching.
//! - **Does not see** what distances are, whose roots and signs are formal there, but that their derivatives are those of their values;
//!   rounding, overflow and cancellation; code that only `f64` takes, namely products of large matrices by `faer`
//!   ([`linalg`](crate::linalg)) and sines of four numbers at once by `wide` ([`Lanes`](crate::scalar::Lanes)), which the property
//!   tests `the_fast_paths_agree_with_the_generic_code` hold to the generic code; inequalities, comparisons and anything that is about
//!   order, such as whether a search ends or what it ends at; and a law that is wrong consistently.
//!
//! # Pinocchio and Parry: `tests/oracle`
//!
//! The dynamics, their first and second derivatives, Jacobians of frames, constraints, $\Omega$ and its Jacobians are compared with
//! Pinocchio on random robots and on the URDF files of two public collections, distances of balls from obstacles with Parry.
//!
//! - **Sees** what the other two cannot, because both are consistent with themselves: gravity with the wrong sign, a frame convention,
//!   a URDF that is misread.
//! - **Does not see** what Pinocchio has no function for, beyond what can be made of its functions by differences, and runs only where
//!   Pinocchio is installed: it is a test of the library and no part of it.
//!
//! # Which claim is checked by what
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
//! | gradient and Hessian of the relaxation | field; gradient also against the flow | [`prove`], [`check_relaxation`](duals::check_relaxation) |
//! | the dynamics are those of the robot in the URDF | Pinocchio | oracle |
//! | distances from boxes, cylinders, capsules and balls | Parry | oracle |
//! | their derivatives, and those of clearances | field, duals | [`check_constraints`](duals::check_constraints), [`prove`] |
//!
//! On the command line `aghf check ROBOT` is [`check_all`] and `aghf prove` is [`prove`]; `tests/run --test oracle` runs the oracle.
//! What both built-in witnesses hold the library against is written once, in [`reference`](mod@reference), over any number.
//!
//! # Checking an object of one's own
//!
//! Each page of the [guide](crate::guide) takes its own example through one of these:
//!
//! - a robot: [`check_all`] on its model, or `aghf check robot.urdf`; a new [joint](crate::guide::joint) likewise;
//! - a [Jacobian](crate::guide::jacobian): [`check_jacobian`](duals::check_jacobian);
//! - a [constraint](crate::guide::constraint): [`check_constraint`](duals::check_constraint);
//! - a [running cost](crate::guide::running_cost): [`check_running_cost`](duals::check_running_cost);
//! - a [Lagrangian, metric or drift](crate::guide::lagrangian): [`check_flow`](duals::check_flow) against a right-hand side and its
//!   Jacobian, [`prove_identities`](field::prove_identities);
//! - any other function: [`reference::jacobian`] and [`reference::gradient`] differentiate it by dual numbers, over `f64` or over
//!   the field.
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
