//! How every derivative of this library is checked.

pub mod duals;
pub mod field;
