//! Shapes in space.

mod shape;

pub use shape::{Shape, Solid};
