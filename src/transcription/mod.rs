//! The transcription of a motion: quadrature, and the integrals of costs and the rows of constraints along a curve in a
//! basis, with their derivatives in the coefficients.

mod equality_gradients;
mod grid;
mod horizon;
mod horizons;
mod objective;
mod place;
mod proximity_cache;
mod rows;
mod scan;
mod segment;
mod shared;
mod state_rows;

pub use grid::Grid;
pub(crate) use grid::Grids;
pub use horizon::HorizonDerivatives;
pub use horizons::Horizons;
pub(crate) use horizons::functions_in_part;
pub use objective::{Derivatives, Objective};
pub(crate) use place::{place, points};
use proximity_cache::ProximityCache;
pub(crate) use rows::{Rows, Standing};
pub(crate) use scan::{Maximum, Scan, ScanWorkspace};
pub use shared::Shared;
pub(crate) use state_rows::RowSelection;
