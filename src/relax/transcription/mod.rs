//! The transcription of a motion: polynomials, quadrature, and the integrals of costs with their derivatives in the
//! coefficients.

mod effort;
mod grid;
mod horizon;
mod objective;
mod packed_hessian;
mod point_cost;
mod rows;
mod scan;

pub use effort::ControlEffort;
pub(super) use effort::alone;
pub use grid::Grid;
pub(super) use grid::Grids;
pub use horizon::HorizonDerivatives;
pub use objective::{Derivatives, Objective};
pub(super) use objective::{place, points};
pub use packed_hessian::PackedHessian;
pub use point_cost::{
    ControlDerivatives, ControlTerm, CostWithControl, Point, PointCost, PointDerivatives, Points,
    PointsDerivatives,
};
pub(super) use rows::Rows;
pub(super) use scan::{Peak, Scan};

use super::WeightedSquares;
