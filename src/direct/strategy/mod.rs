//! The strategy: from several starts at a low degree to the best curve at a high one.

mod degree;
mod horizon;
mod multistart;
mod passive;
mod planned;
mod through;

pub use degree::DegreeRefinement;
pub(super) use degree::refine;
pub use horizon::FreeHorizon;
pub use multistart::LocalMinimum;
pub(super) use multistart::{MultistartOutcome, multistart};
pub(super) use passive::minimise_to_the_end;
pub(super) use planned::Planned;
pub(super) use through::nearest_times;
