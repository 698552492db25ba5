//! Shapes in space.

mod cover;
mod mesh;
mod shape;

pub use cover::{Ball, Cover};
pub use mesh::{Triangle, cover_triangles};
pub use shape::{Shape, Solid};
