//! Shapes in space, signed distances from them, and robots among obstacles.
//!
//! [`Shape::distance`] is the signed distance from the surface in closed form over every scalar, negative inside;
//! [`Shape::distance_derivatives`] adds its gradient and Hessian. The formulas and their proofs are in
//! `proofs/geometry.md`.
//!
//! **Outside**, the distance from a convex shape has a continuous gradient of length one, which points away from the
//! nearest point of the surface. Its Hessian jumps where the nearest point passes from a face to an edge, and is at
//! most $1 / d$ at the distance `d`. A ball with a positive radius therefore touches edges and corners where the
//! distance is smooth enough for Newton's method: curvatures are at most those of the ball.
//!
//! **Inside**, it is the negative distance from the nearest face, flat under flat faces. Where several faces are
//! equally near (the diagonals of a box, the axis of a cylinder, the centre of a ball) it has a kink, and the
//! derivatives are those of one of these faces: the first one in the order of the axes, on the positive side. A
//! direction out of the shape therefore exists everywhere.
//!
//! A [`Scene`] has the obstacles, the [`CollisionGeometry`] of the robot and the pairs that keep clear of each other,
//! and answers questions about their distances.
//!
//! A robot consists of balls, or of [`Convex`] bodies: solids, and the hulls of parts of its meshes, [`ConvexPiece`]s,
//! which contain these. The distance of two such bodies is the largest gap of a [`Plane`] between them.
//!
//! The derivatives are defined everywhere: within [`FLAT`] of a surface, and of a centre or an axis, the distance is
//! that from the tangent plane of a face, which differs by at most twice `FLAT`.

mod ball_tree;
mod collision;
mod convex;
mod corner;
mod hull;
#[cfg(feature = "solvers")]
mod partition;
mod placed;
mod plane;
#[cfg(feature = "solvers")]
mod scene;
#[cfg(feature = "solvers")]
mod separation;
mod shape;

pub use ball_tree::{BallNode, BallTree};
pub use collision::{Capsule, CollisionGeometry, CollisionSphere};
pub use convex::Convex;
#[cfg(feature = "solvers")]
pub(crate) use convex::is_nowhere_negative;
pub use corner::FLAT;
pub use hull::{ConvexPiece, PIECE_RADIUS, Triangle};
#[cfg(feature = "solvers")]
pub use partition::{convex_pieces, excess};
pub use placed::Placed;
#[cfg(feature = "solvers")]
pub(crate) use plane::WIDTHS;
pub use plane::{Plane, PlaneHint, Until};
#[cfg(feature = "solvers")]
pub use scene::{ClosestPair, Collider, Obstacle, Part, Scene};
#[cfg(feature = "solvers")]
pub use separation::{Gap, gap, gap_to};
pub use shape::{Distance, Shape, Solid, Sphere};
