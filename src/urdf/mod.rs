//! Robots from URDF: reading, checking and writing, and the built-in robots.

mod build;
mod builtin;
mod collada;
mod elements;
mod group;
mod limits;
mod load;
mod losses;
mod mesh;
mod mimic;
mod options;
mod read;
mod regularity;
mod reroot;
mod shapes;
mod srdf;
mod tree;
mod visuals;
mod write;
mod write_shapes;
mod xml;

pub use build::{build_model, impossible_inertia};
pub use builtin::builtin_robot_text;
pub use builtin::{builtin_robot, builtin_robots};
pub use elements::{Elements, read_robot};
pub use group::{Group, GroupMember, GroupState};
pub use load::RobotSource;
pub use load::{load_robot, load_robot_with};
pub use losses::{FRICTION_VELOCITY, Losses, PerJoint};
pub use mesh::{load_mesh, mesh_path};
pub use mimic::{Follower, followers};
pub use options::{LoadNote, LoadReport, Mimic, UrdfOptions, summarised};
pub use read::{load_urdf, load_urdf_with, parse_urdf, parse_urdf_with};
pub use reroot::reroot;
pub use srdf::{DisabledPair, Srdf};
pub use visuals::{Visual, read_visuals};
