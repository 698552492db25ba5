//! Models, URDF files and geometry.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod build;
mod builtin;
mod collada;
mod elements;
mod group;
mod limits;
#[cfg(unix)]
mod load;
mod losses;
mod mesh;
mod mimic;
mod options;
mod read;
mod refused;
mod reroot;
mod several_arms;
mod shapes;
mod srdf;
mod tree;
mod underactuated;
mod write;
mod xml;

#[path = "../geometry"]
mod geometry {
    mod ball_tree;
    mod collision;
    mod convex;
    mod hull;
    mod partition;
    mod plane;
    mod separation;
}

#[path = "../model"]
mod model {
    mod build;
    mod drive;
    mod lock;
    mod missing;
    mod random;
}
