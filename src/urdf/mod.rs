//! Robots from URDF: reading, checking and writing, and the built-in robots.

mod build;
mod builtin;
mod elements;
mod load;
#[cfg(feature = "output")]
mod mesh;
mod options;
mod read;
mod regularity;
mod shapes;
mod srdf;
mod tree;
#[cfg(feature = "output")]
mod visuals;
mod write;
mod write_shapes;

pub use build::build_model;
pub(crate) use builtin::builtin_robot_text;
pub use builtin::{builtin_robot, builtin_robots};
#[cfg(feature = "output")]
pub(crate) use load::RobotSource;
pub use load::{load_robot, load_robot_with};
#[cfg(feature = "output")]
pub use mesh::load_mesh;
pub use options::{LoadNote, LoadReport, Mimic, UrdfOptions, summarised};
pub use read::{load_urdf, load_urdf_with, parse_urdf, parse_urdf_with};
pub use srdf::{DisabledPair, Srdf};
#[cfg(feature = "output")]
pub(crate) use visuals::{Visual, read_visuals};
