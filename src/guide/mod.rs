//! A book in pages: how to begin, and how to extend the mathematics.
//!
//! To begin with: [the two methods](methods), [the notation](notation) of the paper, the code and Pinocchio,
//! [motions that are replanned](tracker), [performance], [the limits of the library](limitations). First motions, all
//! that a scenario can ask for (limits, objectives, goals, a standing foot, certificates) and the variants of the flow
//! are pages of the package `aghf-scenario`; the command line, robots of one's own, exports and sweeps are pages of
//! `aghf-cli`.
//!
//! To extend: one page for each thing that a user can replace, with an example that is compiled and run as a test. Each
//! of these has the same shape: the requirements of the trait, an object of one's own, its check by
//! [`verify`](crate::verify), its use, and its limits.
//!
//! | to replace | implement | verified by |
//! | --- | --- | --- |
//! | the [Lagrangian, metric or drift](lagrangian) of the flow | [`Lagrangian`](crate::flow::Lagrangian), [`Metric`](crate::flow::Metric), [`Drift`](crate::flow::Drift) | dual numbers, the field |
//! | a [constraint](mod@constraint) | [`Constraint`](crate::constraint::Constraint) | dual numbers |
//! | the [Jacobian](jacobian) of the flow | [`NodeJacobian`](crate::flow::jacobian::NodeJacobian) | dual numbers |
//! | the [running cost](mod@running_cost) of the direct method | a closure, or [`RunningCost`](crate::cost::RunningCost) | dual numbers |
//! | the [optimiser](mod@optimiser): its barrier rule, its constants, its basis | [`BarrierUpdate`](crate::nlp::BarrierUpdate) | the same minimum |
//! | the [scalar](mod@scalar) | [`Scalar`](crate::scalar::Scalar) | the laws of a field, and derivatives |
//! | the [integrator](mod@integrator) | [`Integrator`](crate::ode::Integrator) | its order on a known solution |
//! | the kind of [joint](mod@joint) | an edit in this crate | dual numbers and the field |
//!
//! [A crate of your own](your_crate) has the contents of its `Cargo.toml`, above all a profile for debug builds, and
//! lists examples to begin with.

#[doc = include_str!("methods.md")]
#[doc = include_str!("pictures/methods.svg")]
pub mod methods {}

#[doc = include_str!("notation.md")]
pub mod notation {}

#[doc = include_str!("your_crate.md")]
pub mod your_crate {}

#[doc = include_str!("lagrangian.md")]
pub mod lagrangian {}

#[doc = include_str!("constraint.md")]
pub mod constraint {}

#[doc = include_str!("jacobian.md")]
pub mod jacobian {}

#[doc = include_str!("running_cost.md")]
pub mod running_cost {}

#[doc = include_str!("optimiser.md")]
pub mod optimiser {}

#[doc = include_str!("scalar.md")]
pub mod scalar {}

#[doc = include_str!("integrator.md")]
pub mod integrator {}

#[doc = include_str!("joint.md")]
pub mod joint {}

#[doc = include_str!("performance.md")]
#[doc = include_str!("pictures/degree.svg")]
pub mod performance {}

#[doc = include_str!("tracker.md")]
pub mod tracker {}

#[doc = include_str!("limitations.md")]
pub mod limitations {}
