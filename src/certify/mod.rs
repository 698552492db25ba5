//! Bounds on a motion at all times of an interval, rounding included: the mathematics of certificates.
//!
//! A [`Motion`] is the piecewise polynomial $q(t)$ with the coefficients of a [`Curve`](crate::curve::Curve), exactly;
//! its velocity, acceleration and jerk are the derivatives of that. A [`Part`] of a segment is an interval of time, a
//! [`Piece`] the motion on it as polynomials in $s \in [-1, 1]$ with bounds on their rounding errors, and
//! [`Piece::torques`] encloses inverse dynamics there by [`TaylorModel`](crate::scalar::TaylorModel) through the
//! generic recursion. [`Bernstein`] bounds the values of a polynomial by its Bernstein coefficients.

mod bernstein;
mod motion;

pub use bernstein::{Bernstein, Range};
pub use motion::{Motion, ORDER, Part, Piece, Polynomial};
