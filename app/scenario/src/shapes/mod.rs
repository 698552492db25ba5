//! The shape of a robot among obstacles, and the pairs of links that keep clear.

pub(crate) mod never_meeting;
pub(crate) mod robot_shape;
pub(crate) mod scene;
pub(crate) mod self_collision;
