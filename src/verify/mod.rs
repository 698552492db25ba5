//! How every derivative of this library is checked.

pub mod duals;
pub mod field;
pub mod reference;

pub use duals::{CheckOptions, check_all};
pub use field::prove;
